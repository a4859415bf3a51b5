"""`describe_scene`: what is in one built scene, for a reader who cannot see it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import repeat
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from typing_extensions import Unpack

from scenecc.colors import color_name
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import chain_of
from scenecc.errors import SceneError
from scenecc.geometry.rotation_arrays import pose_matrix
from scenecc.geometry.rotations import to_rpy
from scenecc.inspect.entities import measure_extents, measured_size, shape_bounds
from scenecc.options import CompileOptions, Options, check_keywords, integer
from scenecc.pipeline import CompileResult, Source, compile_or_raise, select_scenes
from scenecc.plan import ArticulationStructure, BodyStructure, Heightfield, Plane
from scenecc.plan.constraint import is_ball
from scenecc.plan.geometry import Primitive
from scenecc.plan.rendering import Perspective
from scenecc.plan.schema import type_name
from scenecc.simulation.bodies import up_of
from scenecc.simulation.description_text import description_text
from scenecc.simulation.reach import gripper_of, reach_of
from scenecc.simulation.relations import TOUCH, Neighbours, find_neighbours
from scenecc.simulation.sight import View, view_of
from scenecc.simulation.start import articulation_names

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan import Constraint, Entity
    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredScene

    Floats = NDArray[np.float64]

_ROBOT_JOINTS: Final = 3
"""Moving joints in a row from which an articulation is called a robot."""

_INSIDE: Final = 0.005
"""Minimum depth of a body below the rim of what it is in [m]."""

_SIDES: Final = 3
"""Minimum number of the four sides that must be closed around a body that is in another."""


@dataclass(frozen=True)
class SceneDescription:
    """What is in one scene.

    Attributes:
        data: the content of `scenecc describe --format json`, without its diagnostics.
        diagnostics: warnings and notes of the compilation.
    """

    data: Mapping[str, Any]
    diagnostics: list[Diagnostic]

    @property
    def text(self) -> str:
        """The same for people, as `scenecc describe` prints it."""
        return description_text(self.data)


class DescribeArguments(CompileOptions, total=False):
    """The arguments of `describe_scene`."""

    scene: int
    progress: Callable[[int, int], None] | None


def describe_scene(source: Source, **given: Unpack[DescribeArguments]) -> SceneDescription:
    """Builds one scene and returns what is in it: objects, where they are, and what stands on what.

    Args:
        source: as for `validate`.
        given: `scene`: index of the scene, default 0; `progress`: called with (done, total); fields of
            `CompileOptions`.

    Raises:
        SceneError: the scene has errors, its index does not exist, or the engine or machine failed.
        ValueError: an argument is out of range.
    """
    check_keywords(describe_scene, given, DescribeArguments)
    asked = Options.of_call(describe_scene, given, DescribeArguments)
    scene, sink = integer(given.get("scene", 0), "scene", 0), Sink()
    done = compile_or_raise(source, asked, sink)
    if select_scenes(str(scene), done.plan.num_scenes, sink, "scene") is None:
        raise SceneError(sink.diagnostics())
    from scenecc.backends.sapien.measure import measure_bodies  # noqa: PLC0415 - it loads the engine

    neighbours, measured = find_neighbours(done.plan, scene, measure_bodies, given.get("progress"))
    return SceneDescription(_Describer(done, sink, neighbours, measured.scenes[0]).data(), sink.diagnostics())


@dataclass(frozen=True)
class _Solid:
    """Bounding boxes of an entity in the world.

    Attributes:
        low, high: corners of its bounding box (3,) [m]; None if it is infinite or unknown.
        parts: bounding boxes of its convex parts, and of the triangles of its meshes (N, 2, 3).
        collides: whether it has collision shapes.
        height: of a horizontal plane [m].
    """

    low: Floats | None
    high: Floats | None
    parts: Floats
    collides: bool
    height: float | None = None

    def tops(self) -> Floats:
        """Returns the boxes (N, 2, 3) on which something may stand: a plane is a box without a lower end."""
        plane = [] if self.height is None else [[[-np.inf] * 3, [np.inf, np.inf, self.height]]]
        return np.concatenate([self.parts[: len(self.parts) * self.collides], np.reshape(plane, (-1, 2, 3))])


class _Describer:
    def __init__(
        self, done: CompileResult, sink: Sink, neighbours: Mapping[str, Neighbours], scene: MeasuredScene
    ) -> None:
        self._done, self._sink, self._plan = done, sink, done.plan
        self._neighbours = neighbours
        self._scene = scene
        self._planned = {one.name: one for one in done.plan.entities}
        self._solids = {one.entity.name: _solid(one) for one in scene.entities}
        tops = [one.tops() for one in self._solids.values()]
        self._tops = np.concatenate([np.zeros((0, 2, 3)), *tops])
        self._top_owners = np.repeat(np.arange(len(tops)), [len(one) for one in tops])
        up = up_of(done.plan)
        self._up = np.array([0.0, 0.0, 1.0]) if up is None else up
        self._constraints = [one for one in self._plan.constraints if scene.index in one.scene_idxs]
        self._attached = {name: self._find_attached(name) for name in self._solids}
        self._held = self._find_held()
        self._articulations = articulation_names(done.plan)
        self._carried: dict[str, list[str]] = {name: [] for name in self._solids}
        for name in self._solids:
            for other in neighbours[name].stands_on():
                self._carried[other].append(name)

    def _find_attached(self, name: str) -> list[str]:
        """Returns what constraints connect an entity to, which may be `world`."""
        others = (_other(one, name) for one in self._constraints)
        return list(dict.fromkeys(one for one in others if one is not None))

    def _find_held(self) -> set[str]:
        """Returns the entities that do not fall: immovable, or on or attached to one that does not fall."""
        held = {one.entity.name for one in self._scene.entities if not self._falls_free(one)} | {"world"}
        last = 0
        while len(held) > last:
            last = len(held)
            held |= {
                name
                for name, near in self._neighbours.items()
                if name in self._attached and not held.isdisjoint([*near.stands_on(), *self._attached[name]])
            }
        return held

    def _falls_free(self, one: MeasuredEntity) -> bool:
        structure = self._planned[one.entity.name].structure(one.row)
        floats = [body.disable_gravity for body in structure.bodies]
        weightless = all(each is not None and bool(each.row(one.row)) for each in floats)
        return _moves(structure) and not weightless and up_of(self._plan) is not None

    def _is_above(self, other: str, name: str) -> bool:
        """Returns whether the middle of an entity is above that of another. The world is."""
        if other == "world":
            return True
        (low, high), (own_low, own_high) = ((one.low, one.high) for one in (self._solids[other], self._solids[name]))
        if low is None or high is None or own_low is None or own_high is None:
            return True
        return float((low + high - own_low - own_high) @ self._up) > 0

    def data(self) -> dict[str, Any]:
        """Returns the description as plain data."""
        objects = [self._object(one) for one in self._scene.entities]
        return {
            "name": self._plan.name,
            "description": self._plan.description or "",
            "file": self._done.document and self._done.document.name,
            "scene": self._scene.index,
            "num_scenes": self._plan.num_scenes,
            "seed": self._plan.seed,
            "up": _rounded(self._up),
            "touch_m": TOUCH,
            "objects": objects,
            "constraints": [self._constraint(one) for one in self._constraints],
            "lights": [one.name for one in self._plan.lights if self._scene.index in one.scene_idxs],
            "cameras": list(self._cameras()),
        }

    def _object(self, one: MeasuredEntity) -> dict[str, Any]:
        name, planned = one.entity.name, self._planned[one.entity.name]
        structure, solid = planned.structure(one.row), self._solids[one.entity.name]
        pose = one.bodies[0].pose
        masses = [body.mass.mass for body in one.bodies if body.mass is not None and _is_solid(body)]
        found: dict[str, Any] = {
            "name": name,
            "kind": _kind(structure),
            **self._place(planned),
            "position_m": _rounded(pose[:3]),
            "quaternion_wxyz": _rounded(pose[3:]),
            "rpy_deg": _rounded(map(math.degrees, to_rpy(pose[3:])), 2),
            "size_m": _sizes(one, structure),
            "box_m": None if solid.low is None else {"low": _rounded(solid.low), "high": _rounded(solid.high)},
            "plane_height_m": solid.height if solid.height is None else round(solid.height, 6),
            "mass_kg": round(sum(masses), 6) if masses and _has_mass(structure) else None,
            "color": self._color(structure, one.row),
            "hidden": planned.hidden,
            **self._relations(name, moves=_moves(structure)),
        }
        if isinstance(structure, ArticulationStructure):
            found["links"] = len(structure.links)
            found["joints"] = [
                _joint(body) for body in one.bodies if body.joint is not None and body.joint.type != "fixed"
            ]
            found["base"] = "fixed" if structure.fix_root_link else "free"
            found["gripper"] = grip = gripper_of(one)
            if grip or max(map(_joints_above, one.bodies, repeat(one.bodies))) >= _ROBOT_JOINTS:
                found |= {"kind": "robot", "reach_m": reach_of(one, grip["link"] if grip else None)}
        return found

    def _place(self, entity: Entity) -> dict[str, Any]:
        """Returns where the entity is written, and the prefab that it comes from."""
        chain = list(chain_of(entity.origin and self._sink.trace(entity.origin)))
        written = [number for number, one in enumerate(chain) if one.path[:1] == ("entities",)]
        if not written:
            return {"file": None, "line": None, "prefab": None}
        # The outermost node of an entity; what is outside of it includes its file.
        where = self._sink.locate(chain[written[-1]], "key")
        return {"file": where.file, "line": where.line, "prefab": chain[written[-2]].file if written[1:] else None}

    def _color(self, structure: Any, row: int) -> str | None:
        """Returns the name of the first colour of a body; None if it has none."""
        bodies = structure.bodies
        for visual in (shape for body in bodies for shape in body.visuals):
            if visual.material is None:
                continue
            material = self._plan.visual_materials[int(visual.material.row(row))]
            if material.base_color_texture is not None:
                return "textured"
            if material.base_color is not None:
                color = material.base_color.row(row).tolist()
                return color_name(color) + (", transparent" if color[3] < 0.95 else "")
        return None

    def _relations(self, name: str, *, moves: bool) -> dict[str, Any]:
        near = self._neighbours[name]
        stands = near.stands_on()
        attached = self._attached[name]
        above = None if stands or (name in self._articulations and not moves) else self._above(name, near)
        carries = self._carried[name]
        return {
            "stands_on": list(stands),
            "is_in": [other for other in self._supports(name) if self._is_in(name, other)],
            "hangs_on": [one for one in attached if self._is_above(one, name)] if not stands and moves else [],
            "attached_to": attached,
            "touches": [other for other in near.touches() if other not in carries],
            "overlaps": [{"name": other, "depth_m": round(depth, 5)} for other, depth in near.overlaps().items()],
            "above": above,
            "carries": carries,
            "falls": name not in self._held,
        }

    def _supports(self, name: str) -> list[str]:
        """Returns everything below an entity that carries it, directly or through others."""
        found: dict[str, None] = {}
        left = [name]
        while left:
            for other in self._neighbours[left.pop()].stands_on():
                if other not in found and other != name:
                    found[other] = None
                    left.append(other)
        return list(found)

    def _is_in(self, name: str, other: str) -> bool:
        """Returns whether at least three sides of an entity are closed by another, which carries it."""
        own, around = self._solids[name], self._solids[other]
        if own.low is None or own.high is None or around.low is None or around.high is None:
            return False
        middle, height = (own.low + own.high) / 2, own.low[2] + _INSIDE
        if height > around.high[2] or not len(around.parts):
            return False
        parts = around.parts[(around.parts[:, 0, 2] <= height) & (around.parts[:, 1, 2] >= height)]
        closed = 0
        for axis, across in ((0, 1), (1, 0)):
            beside = parts[(parts[:, 0, across] <= middle[across]) & (parts[:, 1, across] >= middle[across])]
            closed += bool((beside[:, 1, axis] > middle[axis]).any()) + bool((beside[:, 0, axis] < middle[axis]).any())
        return closed >= _SIDES

    def _above(self, name: str, near: Neighbours) -> dict[str, Any] | None:
        """Returns what is below an entity that stands on nothing, and the gap: exact where contact points show it, and
        otherwise by bounding boxes.
        """
        gaps = {other: gap for other, gap in near.below.items() if gap > TOUCH}
        if gaps:
            other = min(gaps, key=lambda one: gaps[one])
            return {"name": other, "gap_m": round(gaps[other], 5), "by": "contact"}
        own = self._solids[name]
        if own.low is None or own.high is None or self._up[2] < 0.999:
            return None
        low, high = self._tops[:, 0], self._tops[:, 1]
        over = (low[:, :2] <= own.high[:2]).all(axis=1) & (high[:, :2] >= own.low[:2]).all(axis=1)
        over &= (high[:, 2] <= own.low[2] + TOUCH) & (self._top_owners != list(self._solids).index(name))
        if not over.any():
            return None
        best = np.flatnonzero(over)[high[over, 2].argmax()]
        gap = round(max(0.0, float(own.low[2] - high[best, 2])), 5)
        return {"name": list(self._solids)[self._top_owners[best]], "gap_m": gap, "by": "boxes"}

    def _constraint(self, one: Constraint) -> dict[str, Any]:
        kind = "ball" if is_ball(one.joint) else type_name(type(one.joint))
        return {"name": one.name, "type": kind, "between": [str(one.parent or "world"), str(one.child)]}

    def _cameras(self) -> Iterator[dict[str, Any]]:
        bodies = {
            (one.entity.name, body.name if isinstance(one.structure, ArticulationStructure) else None): body.pose
            for one in self._scene.entities
            for body in one.bodies
        }
        for camera in self._plan.cameras:
            if self._scene.index not in camera.scene_idxs:
                continue
            row = camera.scene_idxs.index(self._scene.index)
            frame = pose_matrix(camera.pose.row(row))
            if camera.mount is not None:
                frame = pose_matrix(bodies[camera.mount.entity, camera.mount.link]) @ frame
            view: View = view_of(camera, row, frame)
            corners = {name: _corners(solid) for name, solid in self._solids.items()}
            lens = camera.lens
            yield {
                "name": camera.name,
                "mount": None if camera.mount is None else str(camera.mount),
                "position_m": _rounded(frame[:3, 3]),
                "direction": _rounded(frame[:3, 0], 4),
                "size_px": [camera.width, camera.height],
                "fovy_deg": round(math.degrees(view.fovy), 2) if isinstance(lens, Perspective) else None,
                "frames": [name for name, found in corners.items() if len(found) and view.sees(found)],
                "cuts": [name for name, found in corners.items() if len(found) and view.cuts(found)],
            }


def _solid(one: MeasuredEntity) -> _Solid:
    """Returns the bounding boxes of an entity: of its collision shapes, or of its visual shapes if it has none."""
    parts: list[Floats] = []
    whole, height = True, None
    for body in one.bodies:
        frame = pose_matrix(body.pose)
        for shape in body.shapes:
            place = frame @ pose_matrix(shape.pose)
            points = shape_bounds(shape, place)
            if points is None:
                whole = False
                height = float(place[2, 3]) if place[2, 0] > 0.999 else height
            elif shape.kind == "triangle_mesh" and shape.mesh is not None:
                corners = points[shape.mesh.triangles]
                parts += [*np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1)]
            else:
                parts.append(np.stack([points.min(axis=0), points.max(axis=0)]))
        if not any(each.shapes for each in one.bodies):
            for visual in body.body.visuals:
                if isinstance(visual.geometry, Primitive) and not isinstance(visual.geometry, Plane | Heightfield):
                    pose = frame if visual.pose is None else frame @ pose_matrix(visual.pose.row(one.row))
                    bounds = visual.geometry.bounds(pose[:3, :3], *visual.geometry.sizes(one.row))
                    parts.append(np.array([pose[:3, 3] + corner for corner in bounds]))
    boxes, collides = np.array(parts, np.float64).reshape(-1, 2, 3), any(each.shapes for each in one.bodies)
    if not len(boxes) or not whole:
        return _Solid(None, None, boxes, collides, height)
    return _Solid(boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0), boxes, collides, height)


def _corners(solid: _Solid) -> Floats:
    """Returns the centre and the eight corners of a bounding box (9, 3); none if there is no box."""
    if solid.low is None or solid.high is None:
        return np.zeros((0, 3))
    ends = np.array([solid.low, solid.high])
    corners = [[ends[x, 0], ends[y, 1], ends[z, 2]] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    return np.array([ends.mean(axis=0), *corners])


def _sizes(one: MeasuredEntity, structure: Any) -> list[float] | None:
    """Returns the extents along the axes of the (root) body's own frame."""
    size = measure_extents(structure, one.row) if isinstance(structure, BodyStructure) else None
    size = size or measured_size(one.bodies)
    return None if size is None else _rounded(size)


def _is_solid(body: MeasuredBody) -> bool:
    return bool(body.shapes) or body.body.inertial is not None


def _kind(structure: BodyStructure | ArticulationStructure) -> str:
    if isinstance(structure, ArticulationStructure):
        return "articulation"
    return "visual" if structure.body_type == "none" else structure.body_type


def _moves(structure: BodyStructure | ArticulationStructure) -> bool:
    """Returns whether a body moves freely."""
    if isinstance(structure, ArticulationStructure):
        return not structure.fix_root_link
    return structure.body_type == "dynamic"


def _has_mass(structure: BodyStructure | ArticulationStructure) -> bool:
    return isinstance(structure, ArticulationStructure) or structure.body_type == "dynamic"


def _joints_above(body: MeasuredBody, bodies: Sequence[MeasuredBody]) -> int:
    """Returns the number of moving joints between a link and its root."""
    own = body.joint is not None and body.joint.type != "fixed"
    return own + (0 if body.parent is None else _joints_above(bodies[body.parent], bodies))


def _joint(body: MeasuredBody) -> dict[str, Any]:
    joint = body.joint
    assert joint is not None
    unit, scale = ("m", 1.0) if joint.type == "prismatic" else ("deg", 180 / math.pi)
    limits = [round(end * scale, 4) if math.isfinite(end) else None for end in joint.limits]
    return {
        "name": joint.name,
        "type": joint.type,
        "unit": unit,
        "position": round(joint.qpos * scale, 4),
        "limits": limits,
    }


def _other(constraint: Constraint, name: str) -> str | None:
    """Returns what a constraint connects an entity to; None if it is about others."""
    ends = [constraint.child.entity, "world" if constraint.parent is None else constraint.parent.entity]
    return ends[1 - ends.index(name)] if name in ends and ends[0] != ends[1] else None


def _rounded(numbers: Any, digits: int = 6) -> list[float]:
    return [round(float(one), digits) + 0.0 for one in numbers]
