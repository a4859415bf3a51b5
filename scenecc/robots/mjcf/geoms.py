"""Geoms of an MJCF: the shapes that collide and are seen, as ManiSkill's loader gives them to its builders."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scenecc.robots.description import (
    BoxGeometry,
    CapsuleGeometry,
    CylinderGeometry,
    DescribedCollision,
    DescribedVisual,
    Geometry,
    Look,
    SphereGeometry,
)
from scenecc.robots.mjcf.assets import colour
from scenecc.robots.mjcf.attributes import ORIENTATIONS, single
from scenecc.robots.mjcf.classes import IGNORED_CLASS
from scenecc.robots.mjcf.rotations import axis_angle, fixed_axes, rotation, shortest
from scenecc.robots.pose32 import IDENTITY, compose, pose_numbers
from scenecc.robots.reading import SMALLEST

if TYPE_CHECKING:
    from scenecc.robots.description import PoseNumbers
    from scenecc.robots.mjcf.assets import Assets
    from scenecc.robots.mjcf.attributes import Attributes
    from scenecc.robots.mjcf.classes import Scope
    from scenecc.robots.mjcf.rotations import Symmetry
    from scenecc.robots.xml import Element

READ = frozenset(
    {"name", "class", "type", "pos", *ORIENTATIONS, "size", "fromto", "mesh", "material", "rgba", "density", "condim"}
    | {"friction", "group", "contype", "conaffinity"}
)
"""The attributes that are heeded."""

_SHOWN_GROUPS = (0, 2)
_TYPES = ("sphere", "capsule", "cylinder", "box", "mesh", "plane", "ellipsoid", "hfield", "sdf")
_LEFT_OUT = {"plane": "declare it as a `plane` of the scene, or build a ground", "ellipsoid": "use a capsule or a mesh"}
_COLOUR = (0.5, 0.5, 0.5, 1.0)
_FROM_Z = pose_numbers((0.0, 0.0, 0.0), fixed_axes(0.0, math.pi / 2, 0.0))
"""From SAPIEN's capsules and cylinders, which lie along x, to MJCF's, which stand along z."""

Made = tuple[list[DescribedVisual], list[DescribedCollision]]


@dataclass(frozen=True, slots=True)
class Geoms:
    """Makes shapes of geoms. `assets`: the meshes and materials that they name."""

    assets: Assets

    def make(self, element: Element, scope: Scope, around: PoseNumbers) -> Made:
        """The shapes of a geom: those that are seen and those that collide, one or none of each.

        Args:
            element: a `geom`.
            scope: where it stands.
            around: pose of its body in what is built.
        """
        report = self.assets.report
        named = element.attributes.get("class", "")
        if named.startswith(IGNORED_CLASS):
            what = f"geoms whose class begins with `{IGNORED_CLASS}` are not built, as ManiSkill's loader has it"
            report.not_built("motor geoms", what, element.at("class"))
            return [], []
        geom = self.assets.classes.attributes(element, scope, READ)
        kind = self._kind(geom)
        if kind is None:
            return [], []
        shape = self._shape(kind, geom)
        if shape is None:
            return [], []
        geometry, pose = shape
        pose = pose if around == IDENTITY else compose(around, pose)
        look = self._look(geom)
        friction = _friction(geom)
        density = geom.number("density", 1000.0, 0.0)
        place = geom.at("mesh") if kind == "mesh" else element.location
        visuals: list[DescribedVisual] = []
        if _is_shown(geom):
            name = "" if kind in {"sphere", "mesh"} else geom.text("name")
            visuals.append(DescribedVisual(geometry, pose, place, name, look))
        collisions: list[DescribedCollision] = []
        if _collides(geom):
            collisions.append(DescribedCollision(geometry, pose, place, friction, density))
        return visuals, collisions

    def _kind(self, geom: Attributes) -> str | None:
        """What shape a geom is; None: one that is not built, which is told."""
        report = self.assets.report
        kind = geom.word("type", _TYPES, "sphere")
        if "mesh" in geom and kind != "mesh":
            if "type" in geom and kind != "sdf":
                what = f"a {kind} is not fitted to a mesh; the mesh itself is built, as ManiSkill's loader has it"
                report.left_out("fitted", what, geom.at("type"), 'write `type="mesh"`')
            return "mesh"
        if kind in _LEFT_OUT:
            what = f"geoms of type `{kind}` are not built, as ManiSkill's loader has it"
            report.not_built(kind, what, geom.at("type"), _LEFT_OUT[kind])
            return None
        if kind in {"hfield", "sdf"}:
            report.error("SC483", f"geoms of type `{kind}` cannot be built", geom.at("type"), "save it as a mesh")
            return None
        if kind == "mesh" and "mesh" not in geom:
            geom.wrong("type", "is `mesh`, and no `mesh` says which")
            return None
        return kind

    def _shape(self, kind: str, geom: Attributes) -> tuple[Geometry, PoseNumbers] | None:
        """A geom's geometry and pose; None, reported, where they are wrong."""
        if "fromto" in geom and kind in {"sphere", "mesh"}:
            geom.wrong("fromto", f"says nothing of a {kind}")
            return None
        if kind == "mesh":
            mesh = self.assets.mesh(geom)
            return None if mesh is None else (mesh, self._pose(geom, "none"))
        size = self._size(kind, geom)
        if size is None:
            return None
        if "fromto" in geom:
            return self._between(kind, geom, size[0])
        return self._upright(kind, geom, size)

    def _upright(self, kind: str, geom: Attributes, size: tuple[float, ...]) -> tuple[Geometry, PoseNumbers]:
        """A geom that stands where its pose says."""
        if kind == "sphere":
            return SphereGeometry(size[0]), self._pose(geom, "point")
        if kind == "box":
            return BoxGeometry((size[0], size[1], size[2])), self._pose(geom, "none")
        made = CapsuleGeometry if kind == "capsule" else CylinderGeometry
        return made(size[0], size[1]), compose(self._pose(geom, "axis"), _FROM_Z)

    def _size(self, kind: str, geom: Attributes) -> tuple[float, ...] | None:
        """A geom's size, of as many numbers as it needs at least; None, reported, where it is wrong."""
        if "size" not in geom:
            geom.report.error("SC481", f"`<geom>` of type `{kind}` has no `size`", geom.element.location)
            return None
        wrong = (math.nan,) * 3
        read = geom.numbers("size", wrong, least=1)
        if read is wrong:
            return None
        size = tuple(map(single, read))
        wanted = {"sphere": 1, "box": 3}.get(kind, 2) if "fromto" not in geom else 1
        if len(size) < wanted:
            geom.wrong("size", f"of a {kind} is {wanted} numbers, not {len(size)}")
        elif not all(part >= SMALLEST for part in size[:wanted]):
            geom.wrong("size", f"holds {min(size[:wanted]):g}, which is not above 0")
        else:
            return size
        return None

    def _pose(self, geom: Attributes, symmetry: Symmetry) -> PoseNumbers:
        p = geom.singles("pos", (0.0, 0.0, 0.0))
        turn = rotation(geom, self.assets.compiler, symmetry)
        return pose_numbers((p[0], p[1], p[2]), turn)

    def _between(self, kind: str, geom: Attributes, radius: float) -> tuple[Geometry, PoseNumbers] | None:
        """A geom from one point to another; in single precision up to the direction, as the loader has it."""
        ends = np.array(geom.numbers("fromto", (0.0, 0.0, 0.0, 1.0, 0.0, 0.0)), np.float32)
        start, end = ends[:3], ends[3:]
        length = np.linalg.norm(end - start)
        if not 1e-10 < length < math.inf:
            geom.wrong("fromto", "leads from a point to itself, or beyond all bounds")
            return None
        middle = (start + end) * np.float32(0.5)
        p = (float(middle[0]), float(middle[1]), float(middle[2]))
        half = float(length * np.float32(0.5))
        if kind == "box":
            geom.report.differs(
                "box fromto",
                "a box that reaches from one point to another is square across and as long as their distance; "
                "ManiSkill's loader takes its `size` as it stands",
                geom.at("fromto"),
            )
            return BoxGeometry((radius, radius, half)), pose_numbers(p, shortest((start - end).tolist()))
        along = (end - start) / length
        x = np.array([1.0, 0.0, 0.0])
        angle = math.acos(min(1.0, max(-1.0, float(np.dot(along, x)))))
        axis = np.cross(along, x)
        across = np.linalg.norm(axis)
        axis = np.array([1, 0, 0]) if across < 1e-3 else axis / across
        made = CapsuleGeometry if kind == "capsule" else CylinderGeometry
        return made(radius, half), pose_numbers(p, axis_angle(axis, -angle))

    def _look(self, geom: Attributes) -> Look | None:
        if "material" not in geom:
            rgba = colour(geom, _COLOUR)
            return Look(base_color=(rgba[0], rgba[1], rgba[2], rgba[3]))
        rgba = colour(geom, _COLOUR)
        if rgba == _COLOUR:
            return self.assets.look(geom.text("material"), geom, None)
        geom.report.differs(
            "rgba", "`rgba` takes the place of the material's colour; ManiSkill's loader leaves it out", geom.at("rgba")
        )
        return self.assets.look(geom.text("material"), geom, rgba)


def _friction(geom: Attributes) -> tuple[float, float, float] | None:
    """Static and dynamic friction, and restitution; None: the scene's default material."""
    condim = geom.integer("condim", 3)
    if condim not in {1, 3, 4, 6}:
        geom.wrong("condim", f"is 1, 3, 4 or 6, not {condim}")
    if condim == 1:
        return 0.0, 0.0, 0.0
    if condim != 3:
        what = f"of `condim` {condim}, no friction is read, as ManiSkill's loader has it: it is the default material's"
        geom.report.left_out("condim", what, geom.at("condim"), "give a `material` under `links`")
        return None
    # Torsional and rolling friction, the second and third number, take no part at this `condim`.
    sliding = geom.singles("friction", (0.3, 0.005, 0.0001), least=1)[0]
    if sliding < 0:
        geom.wrong("friction", f"holds {sliding:g}, which is below 0")
    return sliding, sliding, 0.0


def _is_shown(geom: Attributes) -> bool:
    group = geom.integer("group", 0)
    if group == 1:
        what = "geoms of group 1 are not shown, as ManiSkill's loader has it; MuJoCo shows them"
        geom.report.left_out("group 1", what, geom.at("group"))
    return group in _SHOWN_GROUPS


def _collides(geom: Attributes) -> bool:
    """Whether a geom collides: whatever its bits, ManiSkill's loader asks whether `contype` is 0."""
    kind, affinity = geom.integer("contype", 1), geom.integer("conaffinity", 1)
    hint = "say under `collision_groups` and `links` what ignores what"
    if kind == 0 and affinity != 0:
        what = (
            f"a geom with `contype` 0 does not collide, as ManiSkill's loader has it; in MuJoCo it would by its "
            f"`conaffinity` {affinity}"
        )
        geom.report.left_out("contype 0", what, geom.at("contype"), 'write `conaffinity="0"`, too')
    elif kind != 0 and (kind, affinity) != (1, 1):
        name = "contype" if kind != 1 else "conaffinity"
        what = f"what collides collides with all, as ManiSkill's loader has it: the bits of `{name}` are not read"
        geom.report.left_out("bits", what, geom.at(name), hint)
    return kind != 0
