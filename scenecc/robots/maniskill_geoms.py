"""Geoms of an MJCF with their meshes, materials and textures, as ManiSkill's loader passes them to its builders.
Assets that no geom uses are not read.
"""

from __future__ import annotations

import math
import posixpath
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.geometry.rotations import IDENTITY, IDENTITY_POSE
from scenecc.plan.geometry import LYING_SOLIDS
from scenecc.plan.properties import FLOAT32_MIN, round_to_float32
from scenecc.robots.description import (
    DescribedCollision,
    DescribedMaterial,
    DescribedVisual,
    Geometry,
    MeshGeometry,
    SolidGeometry,
)
from scenecc.robots.maniskill_attributes import IGNORED_CLASS, ORIENTATION_ATTRIBUTES, ClassScope
from scenecc.robots.poses import (
    compose_poses,
    from_axis_angle,
    from_rpy,
    pose_numbers,
    read_rotation,
    shortest_rotation,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.geometry.rotations import Pose7
    from scenecc.robots.description import DescribedFile
    from scenecc.robots.maniskill_attributes import CompilerSettings, DefaultClasses, MjcfAttributes
    from scenecc.robots.mjcf_files import MjcfFiles, MjcfReport
    from scenecc.robots.poses import Symmetry
    from scenecc.robots.xml import SourceElement


ASSET_ATTRIBUTES: dict[str, frozenset[str]] = {
    "mesh": frozenset({"name", "file", "scale", "refpos", "refquat"}),
    "material": frozenset({"name", "texture", "rgba", "emission", "specular", "shininess", "reflectance"}),
    "texture": frozenset({"name", "file", "type"}),
}
"""The attributes that are read, by type of asset."""

_GLOBAL_SCOPE = ClassScope()


@dataclass(slots=True)
class MjcfAssets:
    """The assets of a file."""

    compiler: CompilerSettings
    classes: DefaultClasses
    files: MjcfFiles
    report: MjcfReport
    _found: dict[tuple[str, str], SourceElement] = field(default_factory=dict[tuple[str, str], "SourceElement"])
    _looks: dict[tuple[str, tuple[float, ...] | None], DescribedMaterial | None] = field(
        default_factory=dict[tuple[str, "tuple[float, ...] | None"], "DescribedMaterial | None"]
    )

    def read(self, sections: Iterable[SourceElement]) -> None:
        """Records the assets of the sections `asset` by name, or by file name if they have none."""
        for section in sections:
            for element in section.children:
                if element.tag not in ASSET_ATTRIBUTES:
                    self.report.unread_element(element)
                    continue
                name, file = element.attributes.get("name"), element.attributes.get("file")
                if name is None and file is not None:
                    name = posixpath.splitext(posixpath.basename(file))[0]
                if name is None:
                    # A skybox may have no name; nothing uses an asset without a name.
                    self.report.unread_attributes(element, ASSET_ATTRIBUTES[element.tag] | {"class"})
                    continue
                first = self._found.setdefault((element.tag, name), element)
                if first is not element:
                    self.report.error("SC486", f"the {element.tag} `{cut(name)}` is defined twice", element.at("name"))

    def report_unread(self) -> None:
        """Reports unread attributes, also of unused assets."""
        for (tag, _), element in self._found.items():
            self.report.unread_attributes(element, ASSET_ATTRIBUTES[tag] | {"class"})
            for child in element.children:
                self.report.unread_element(child)

    def mesh(self, geom: MjcfAttributes) -> MeshGeometry | None:
        """The mesh of a geom; None after an error."""
        element = self._named("mesh", geom.text("mesh"), geom, "mesh")
        if element is None:
            return None
        given = self.classes.attributes(element, _GLOBAL_SCOPE, ASSET_ATTRIBUTES["mesh"])
        scale = given.singles("scale", (1.0, 1.0, 1.0))
        if min(map(abs, scale)) < FLOAT32_MIN:
            given.wrong("scale", "holds 0, which leaves nothing of the mesh")
            return None
        if any(given.numbers("refpos", (0.0, 0.0, 0.0))) or self._is_turned(given):
            self.report.error(
                "SC483",
                "a mesh that is moved or turned by `refpos` and `refquat` is not built",
                given.at("refpos" if "refpos" in given else "refquat"),
                "save the mesh as it is meant, or move and turn the geom",
            )
            return None
        if "file" not in given:
            self.report.error(
                "SC483", "a mesh without a file is not built", element.location, "save the vertices as OBJ or STL"
            )
            return None
        if "scale" in given and "scale" not in element.attributes:
            self.report.differs(
                "mesh class", "`scale` of a mesh is its class's; ManiSkill's loader takes 1", given.at("scale")
            )
        file = self._file(self.compiler.mesh_folder, given)
        return None if file is None else MeshGeometry(file.uri, file.path, (scale[0], scale[1], scale[2]))

    def look(self, name: str, geom: MjcfAttributes, rgba: tuple[float, ...] | None) -> DescribedMaterial | None:
        """A material by name; None after an error.

        Args:
            name: of the material.
            geom: what names it, in `material`.
            rgba: replaces its colour; None: keeps it.
        """
        key = (name, rgba)
        if key not in self._looks:
            self._looks[key] = self._look(name, geom, rgba)
        return self._looks[key]

    def _look(self, name: str, geom: MjcfAttributes, rgba: tuple[float, ...] | None) -> DescribedMaterial | None:
        element = self._named("material", name, geom, "material")
        if element is None:
            return None
        given = self.classes.attributes(element, _GLOBAL_SCOPE, ASSET_ATTRIBUTES["material"])
        own = read_rgba(given, (1.0, 1.0, 1.0, 1.0))
        if (
            given.given.keys()
            & {"rgba", "emission", "specular", "shininess", "reflectance"} - element.attributes.keys()
        ):
            self.report.differs(
                "material class",
                "a material has what its class says; ManiSkill's loader leaves that out",
                element.location,
            )
        base = own if rgba is None else rgba
        emission = np.float32(given.number("emission", 0.0, 0.0))
        glow = [float(np.float32(part) * emission) for part in base[:3]]
        texture = self._texture(given)
        return DescribedMaterial(
            base_color=(base[0], base[1], base[2], base[3]),
            texture=None if texture is None else texture.path,
            texture_uri=None if texture is None else texture.uri,
            emission=(glow[0], glow[1], glow[2], 1.0),
            specular=given.number("specular", 0.0, 0.0, 1.0),
            roughness=1 - given.number("reflectance", 0.0, 0.0, 1.0),
            metallic=given.number("shininess", 0.5, 0.0, 1.0),
        )

    def _texture(self, material: MjcfAttributes) -> DescribedFile | None:
        if "texture" not in material:
            return None
        element = self._named("texture", material.text("texture"), material, "texture")
        if element is None:
            return None
        given = self.classes.attributes(element, _GLOBAL_SCOPE, ASSET_ATTRIBUTES["texture"])
        if "file" not in given:
            self.report.left_out(
                "texture file",
                f"the texture `{cut(material.text('texture'))}` has no file and is not shown",
                element.location,
                "paint it into a file",
            )
            return None
        if given.text("type", "cube") != "2d":
            self.report.left_out(
                "texture type", "a texture of a cube is laid on as a flat one", given.at("type"), 'write `type="2d"`'
            )
        if self.compiler.texture_folder != self.compiler.mesh_folder:
            self.report.differs(
                "texture folder",
                "textures are in `texturedir`; ManiSkill's loader looks in `meshdir`",
                given.at("file"),
            )
        return self._file(self.compiler.texture_folder, given)

    def _named(self, tag: str, name: str, user: MjcfAttributes, attribute: str) -> SourceElement | None:
        found = self._found.get((tag, name)) or self._by_path(tag, name)
        if found is None:
            names = (name for kind, name in self._found if kind == tag)
            hint = suggest_name(name, names, self.report.findings.sink)
            self.report.error("SC482", f"there is no {tag} `{cut(name)}`", user.at(attribute), hint)
        return found

    def _by_path(self, tag: str, name: str) -> SourceElement | None:
        """An asset that has no name of its own, by the one of ManiSkill's loader: its path without a suffix."""
        found = self._found.get((tag, posixpath.basename(name)))
        if found is None or "name" in found.attributes:
            return None
        return found if posixpath.splitext(found.attributes["file"])[0] == name else None

    def _file(self, folder: str, given: MjcfAttributes) -> DescribedFile | None:
        written = given.text("file")
        if self.compiler.strip_path:
            written = posixpath.basename(written)
        return self.files.find(folder, written, given.at("file"))

    def _is_turned(self, given: MjcfAttributes) -> bool:
        if "refquat" not in given:
            return False
        w, x, y, z = given.numbers("refquat", IDENTITY)
        return any((x, y, z)) or not w


def read_rgba(given: MjcfAttributes, default: tuple[float, ...]) -> tuple[float, ...]:
    """The `rgba` of an element, in single precision; all four between 0 and 1."""
    rgba = given.singles("rgba", default)
    if not all(0 <= part <= 1 for part in rgba):
        given.wrong("rgba", "holds a number that is not between 0 and 1")
        return default
    return rgba


GEOM_ATTRIBUTES = frozenset(
    {
        "name",
        "class",
        "type",
        "pos",
        *ORIENTATION_ATTRIBUTES,
        "size",
        "fromto",
        "mesh",
        "material",
        "rgba",
        "density",
        "condim",
    }
    | {"friction", "group", "contype", "conaffinity"}
)
"""The attributes that are read."""

_VISIBLE_GROUPS = (0, 2)

_GEOM_TYPES = ("sphere", "capsule", "cylinder", "box", "mesh", "plane", "ellipsoid", "hfield", "sdf")

_UNSUPPORTED_HINTS = {
    "plane": "declare it as a `plane` of the scene, or build a ground",
    "ellipsoid": "use a capsule or a mesh",
}

_DEFAULT_RGBA = (0.5, 0.5, 0.5, 1.0)

_Z_TO_X_POSE = pose_numbers((0.0, 0.0, 0.0), from_rpy(0.0, math.pi / 2, 0.0))
"""From SAPIEN's lying solids to MJCF's, which stand along z."""

GeomShapes = tuple[list[DescribedVisual], list[DescribedCollision]]


@dataclass(frozen=True, slots=True)
class GeomReader:
    """Makes shapes of geoms. `assets`: the meshes and materials that they name."""

    assets: MjcfAssets

    def make(self, element: SourceElement, scope: ClassScope, around: Pose7) -> GeomShapes:
        """The visual and the collision shapes of a geom, at most one of each.

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
        geom = self.assets.classes.attributes(element, scope, GEOM_ATTRIBUTES)
        kind = self._kind(geom)
        if kind is None:
            return [], []
        shape = self._shape(kind, geom)
        if shape is None:
            return [], []
        geometry, pose = shape
        pose = pose if around == IDENTITY_POSE else compose_poses(around, pose)
        look = self._look(geom)
        friction = _read_friction(geom)
        density = geom.number("density", 1000.0, 0.0)
        place = geom.at("mesh") if kind == "mesh" else element.location
        visuals: list[DescribedVisual] = []
        if _is_visible(geom):
            name = "" if kind in {"sphere", "mesh"} else geom.text("name")
            visuals.append(DescribedVisual(geometry, pose, place, name, look))
        collisions: list[DescribedCollision] = []
        if _collides(geom):
            collisions.append(DescribedCollision(geometry, pose, place, friction, density))
        return visuals, collisions

    def _kind(self, geom: MjcfAttributes) -> str | None:
        """The shape type of a geom; None if it is not built, which is reported."""
        report = self.assets.report
        kind = geom.word("type", _GEOM_TYPES, "sphere")
        if "mesh" in geom and kind != "mesh":
            if "type" in geom and kind != "sdf":
                what = f"a {kind} is not fitted to a mesh; the mesh itself is built, as ManiSkill's loader has it"
                report.left_out("fitted", what, geom.at("type"), 'write `type="mesh"`')
            return "mesh"
        if kind in _UNSUPPORTED_HINTS:
            what = f"geoms of type `{kind}` are not built, as ManiSkill's loader has it"
            report.not_built(kind, what, geom.at("type"), _UNSUPPORTED_HINTS[kind])
            return None
        if kind in {"hfield", "sdf"}:
            report.error("SC483", f"geoms of type `{kind}` cannot be built", geom.at("type"), "save it as a mesh")
            return None
        if kind == "mesh" and "mesh" not in geom:
            geom.wrong("type", "is `mesh`, and no `mesh` says which")
            return None
        return kind

    def _shape(self, kind: str, geom: MjcfAttributes) -> tuple[Geometry, Pose7] | None:
        """A geom's geometry and pose; None after an error."""
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

    def _upright(self, kind: str, geom: MjcfAttributes, size: tuple[float, ...]) -> tuple[Geometry, Pose7]:
        """A geom at its own pose."""
        solid = SolidGeometry(kind, size)
        if kind in LYING_SOLIDS:
            return solid, compose_poses(self._pose(geom, "axis"), _Z_TO_X_POSE)
        return solid, self._pose(geom, "point" if kind == "sphere" else "none")

    def _size(self, kind: str, geom: MjcfAttributes) -> tuple[float, ...] | None:
        """A geom's size with the required count of numbers; None after an error."""
        if "size" not in geom:
            geom.report.error("SC481", f"`<geom>` of type `{kind}` has no `size`", geom.element.location)
            return None
        wrong = (math.nan,) * 3
        read = geom.numbers("size", wrong, least=1)
        if read is wrong:
            return None
        size = tuple(map(round_to_float32, read))
        wanted = {"sphere": 1, "box": 3}.get(kind, 2) if "fromto" not in geom else 1
        if len(size) < wanted:
            geom.wrong("size", f"of a {kind} is {wanted} numbers, not {len(size)}")
        elif not all(part >= FLOAT32_MIN for part in size[:wanted]):
            geom.wrong("size", f"holds {min(size[:wanted]):g}, which is not above 0")
        else:
            return size[:wanted]
        return None

    def _pose(self, geom: MjcfAttributes, symmetry: Symmetry) -> Pose7:
        p = geom.singles("pos", (0.0, 0.0, 0.0))
        turn = read_rotation(geom, self.assets.compiler, symmetry)
        return pose_numbers((p[0], p[1], p[2]), turn)

    def _between(self, kind: str, geom: MjcfAttributes, radius: float) -> tuple[Geometry, Pose7] | None:
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
            return SolidGeometry(kind, (radius, radius, half)), pose_numbers(
                p, shortest_rotation((start - end).tolist())
            )
        along = (end - start) / length
        x = np.array([1.0, 0.0, 0.0])
        angle = math.acos(min(1.0, max(-1.0, float(np.dot(along, x)))))
        axis = np.cross(along, x)
        across = np.linalg.norm(axis)
        axis = np.array([1, 0, 0]) if across < 1e-3 else axis / across
        return SolidGeometry(kind, (radius, half)), pose_numbers(p, from_axis_angle(axis, -angle))

    def _look(self, geom: MjcfAttributes) -> DescribedMaterial | None:
        if "material" not in geom:
            rgba = read_rgba(geom, _DEFAULT_RGBA)
            return DescribedMaterial(base_color=(rgba[0], rgba[1], rgba[2], rgba[3]))
        rgba = read_rgba(geom, _DEFAULT_RGBA)
        if rgba == _DEFAULT_RGBA:
            return self.assets.look(geom.text("material"), geom, None)
        geom.report.differs(
            "rgba", "`rgba` takes the place of the material's colour; ManiSkill's loader leaves it out", geom.at("rgba")
        )
        return self.assets.look(geom.text("material"), geom, rgba)


def _read_friction(geom: MjcfAttributes) -> tuple[float, float, float] | None:
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


def _is_visible(geom: MjcfAttributes) -> bool:
    group = geom.integer("group", 0)
    if group == 1:
        what = "geoms of group 1 are not shown, as ManiSkill's loader has it; MuJoCo shows them"
        geom.report.left_out("group 1", what, geom.at("group"))
    return group in _VISIBLE_GROUPS


def _collides(geom: MjcfAttributes) -> bool:
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
