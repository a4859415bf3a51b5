"""`describe_scene`: what is in one built scene, for a reader who cannot see it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from typing_extensions import Unpack

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import chain_of
from scenecc.errors import SceneError
from scenecc.geometry.rotation_arrays import pose_matrix
from scenecc.geometry.rotations import to_rpy
from scenecc.inspect.entities import measure_extents, measured_size, shape_bounds
from scenecc.options import CompileOptions, Options, check_keywords, integer
from scenecc.pipeline import CompileResult, Source, compile_or_raise, select_scenes
from scenecc.plan import ArticulationStructure, BodyStructure
from scenecc.simulation.bodies import up_of
from scenecc.simulation.description_text import description_text
from scenecc.simulation.relations import TOUCH, Neighbours, find_neighbours, moves_freely
from scenecc.simulation.start import articulation_names

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan import Constraint, Entity
    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredScene

    Floats = NDArray[np.float64]

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
    """Bounding boxes of the collision shapes of an entity.

    Attributes:
        low, high: corners of its bounding box in the world (3,) [m]; None if it is infinite or has no shapes.
        frame: pose of its (root) body in the world (4, 4).
        parts: boxes in that frame of its convex parts, and of the triangles of its meshes (N, 2, 3).
        height: of a horizontal plane [m].
    """

    low: Floats | None
    high: Floats | None
    frame: Floats
    parts: Floats
    height: float | None = None


class _Describer:
    def __init__(
        self, done: CompileResult, sink: Sink, neighbours: Mapping[str, Neighbours], scene: MeasuredScene
    ) -> None:
        self._done, self._sink, self._plan = done, sink, done.plan
        self._neighbours = neighbours
        self._scene = scene
        self._planned = {one.name: one for one in done.plan.entities}
        self._solids = {one.entity.name: _solid(one) for one in scene.entities}
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
        return moves_freely(structure) and not weightless and up_of(self._plan) is not None

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
        }

    def _object(self, one: MeasuredEntity) -> dict[str, Any]:
        name, planned = one.entity.name, self._planned[one.entity.name]
        structure, solid = planned.structure(one.row), self._solids[one.entity.name]
        pose = one.bodies[0].pose
        masses = [body.mass.mass for body in one.bodies if body.mass is not None and _is_solid(body)]
        return {
            "name": name,
            "kind": _kind(structure),
            **self._place(planned),
            "position_m": _rounded(pose[:3]),
            "quaternion_wxyz": _rounded(pose[3:]),
            "rpy_deg": _rounded(map(math.degrees, to_rpy(pose[3:])), 2),
            "size_m": _sizes(one, structure),
            "box_m": None if solid.low is None else {"low": _rounded(solid.low), "high": _rounded(solid.high)},
            "plane_height_m": solid.height,
            "mass_kg": round(sum(masses), 6) if masses and _has_mass(structure) else None,
            **self._relations(name, moves=moves_freely(structure)),
        }

    def _place(self, entity: Entity) -> dict[str, Any]:
        """Returns where the entity is written."""
        chain = list(chain_of(entity.origin and self._sink.trace(entity.origin)))
        written = [one for one in chain if one.path[:1] == ("entities",)]
        if not written:
            return {"file": None, "line": None}
        # The outermost node of an entity; what is outside of it includes its file.
        where = self._sink.locate(written[-1], "key")
        return {"file": where.file, "line": where.line}

    def _relations(self, name: str, *, moves: bool) -> dict[str, Any]:
        near = self._neighbours[name]
        stands = near.stands_on()
        attached = self._attached[name]
        is_mounted = name in self._articulations and not moves
        carries = self._carried[name]
        return {
            "stands_on": list(stands),
            "is_in": [other for other in self._supports(name) if self._is_in(name, other)],
            "hangs_on": [one for one in attached if self._is_above(one, name)] if not stands and moves else [],
            "attached_to": attached,
            "touches": [other for other in near.touches() if other not in carries],
            "overlaps": [{"name": other, "depth_m": round(depth, 5)} for other, depth in near.overlaps().items()],
            "above": None if is_mounted else _above(near),
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
        if own.low is None or own.high is None:
            return False
        lowest = (own.low + own.high) / 2 + self._up * (_INSIDE - abs(self._up) @ (own.high - own.low) / 2)
        point = around.frame[:3, :3].T @ (lowest - around.frame[:3, 3])
        height, *sides = np.argsort(-abs(around.frame[:3, :3].T @ self._up))
        starts, ends = (point >= around.parts[:, 0]), (point <= around.parts[:, 1])
        closed = 0
        for axis, across in (sides, sides[::-1]):
            beside = (starts & ends)[:, [height, across]].all(axis=1)
            closed += bool((beside & ~starts[:, axis]).any()) + bool((beside & ~ends[:, axis]).any())
        return closed >= _SIDES


def _above(near: Neighbours) -> dict[str, Any] | None:
    """Returns what is below an entity that stands on nothing, and the gap, where contact points show it."""
    if near.stands_on() or not near.below:
        return None
    other, gap = min(near.below.items(), key=lambda item: item[1])
    return {"name": other, "gap_m": round(gap, 5)}


def _solid(one: MeasuredEntity) -> _Solid:
    frame = pose_matrix(one.bodies[0].pose)
    inward = np.linalg.inv(frame)
    parts, ends = [np.zeros((0, 2, 3))], [np.zeros((0, 3))]
    for body in one.bodies:
        for shape in body.shapes:
            place = pose_matrix(body.pose) @ pose_matrix(shape.pose)
            here, there = (shape_bounds(shape, each) for each in (inward @ place, place))
            if here is None or there is None:  # a plane
                is_level = place[2, 0] > 0.999
                return _Solid(None, None, frame, parts[0], round(float(place[2, 3]), 6) if is_level else None)
            mesh = shape.mesh if shape.kind == "triangle_mesh" else None
            corners = here[None] if mesh is None else here[mesh.triangles]
            parts.append(np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1))
            ends.append(there)
    points = np.concatenate(ends)
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (None, None)
    return _Solid(low, high, frame, np.concatenate(parts))


def _sizes(one: MeasuredEntity, structure: Any) -> list[float] | None:
    """Returns the extents along the axes of the (root) body's own frame; None if a shape has no ends."""
    if isinstance(structure, BodyStructure) and not one.bodies[0].shapes:
        size = measure_extents(structure, one.row)
    else:
        size = measured_size(one.bodies)
    return None if size is None else _rounded(size)


def _is_solid(body: MeasuredBody) -> bool:
    return bool(body.shapes) or body.body.inertial is not None


def _kind(structure: BodyStructure | ArticulationStructure) -> str:
    if isinstance(structure, ArticulationStructure):
        return "articulation"
    return "visual" if structure.body_type == "none" else structure.body_type


def _has_mass(structure: BodyStructure | ArticulationStructure) -> bool:
    return isinstance(structure, ArticulationStructure) or structure.body_type == "dynamic"


def _other(constraint: Constraint, name: str) -> str | None:
    """Returns what a constraint connects an entity to; None if it is about others."""
    ends = [constraint.child.entity, "world" if constraint.parent is None else constraint.parent.entity]
    return ends[1 - ends.index(name)] if name in ends and ends[0] != ends[1] else None


def _rounded(numbers: Any, digits: int = 6) -> list[float]:
    return [round(float(one), digits) + 0.0 for one in numbers]
