"""Cameras that stand in a body, and cameras that see nothing.

`scenecc check` asks these rules; `validate` does not. Cameras that are mounted on a body are not judged: they move.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from scenecc.checks.physics import plan_origin
from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotation_arrays import compose, invert, rotate
from scenecc.plan import BodyStructure
from scenecc.plan.geometry import Box, Capsule, Cylinder, Primitive, Sphere
from scenecc.plan.rendering import Perspective

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan, VisualShape
    from scenecc.plan.rendering import Camera

    Floats = NDArray[np.float64]

UNKNOWN_RADIUS: Final = 5.0
"""[m] How far a robot, a mesh or terrain reaches at most, for a camera that may see it."""

MAX_HALF_FOV: Final = 1.5
"""[rad] Of a camera whose field of view is given as a matrix."""


class _Seen(NamedTuple):
    """A visible shape over all scenes.

    Attributes:
        entity: its name.
        there: whether it exists in each scene (N,).
        pose: (N, 7) in the world. radius: (N,) of a ball around its origin that holds it [m].
        shape: of a body of one structure; None: it is not known what it looks like.
        row: of its entity by scene (N,).
    """

    entity: str
    there: NDArray[np.bool_]
    pose: Floats
    radius: Floats
    shape: VisualShape | None
    row: NDArray[np.int64]


def check_views(plan: ScenePlan, sink: Sink) -> None:
    """Applies both rules to each camera that stands in the world.

    Args:
        plan: with its draws made.
        sink: takes the warnings.
    """
    cameras = [camera for camera in plan.cameras if camera.mount is None]
    if not cameras or (plan.environment is not None and plan.environment.map is not None):
        return  # the sky is seen everywhere
    seen = [each for entity in plan.entities for each in _visible(plan, entity)]
    for camera in cameras:
        _check_camera(camera, seen, plan, sink)


def _check_camera(camera: Camera, seen: list[_Seen], plan: ScenePlan, sink: Sink) -> None:
    place = camera.origin or plan_origin(plan).child("cameras", camera.name)
    scenes = np.array(camera.scene_idxs)
    pose = np.broadcast_to(camera.pose.data, (len(scenes), 7))
    # A scene in which nothing can be seen is no fault of the camera.
    empty = np.any([each.there[scenes] for each in seen], axis=0) & np.ones(len(scenes), bool)
    for each in seen:
        there = each.there[scenes]
        empty &= ~(there & _may_see(camera, pose, each.pose[scenes, :3], each.radius[scenes]))
        inside = np.flatnonzero(there & _is_inside(each, scenes, pose))
        if inside.size:
            message = f"camera `{cut(camera.name)}` stands inside `{cut(each.entity)}` in scene {scenes[inside[0]]}"
            sink.report("SC548", message, place.child("pose"), hint="move the camera out of what is seen")
            return
    if empty.any():
        index = scenes[int(np.flatnonzero(empty)[0])]
        message = f"camera `{cut(camera.name)}` sees nothing in scene {index}"
        sink.report("SC548", message, place.child("pose"), hint="a camera looks along its x: try `look_at`")


def _visible(plan: ScenePlan, entity: Any) -> Iterator[_Seen]:
    """The visible shapes of an entity; one ball for a robot, or for an entity of several structures."""
    row, there = np.zeros(plan.num_scenes, np.int64), np.zeros(plan.num_scenes, bool)
    row[list(entity.scene_idxs)], there[list(entity.scene_idxs)] = range(len(entity.scene_idxs)), True
    frame = np.broadcast_to(entity.pose.data, (len(entity.scene_idxs), 7))[row]
    structure = entity.structures[0]
    if not isinstance(structure, BodyStructure) or entity.pick is not None:
        yield _Seen(entity.name, there, frame, np.full(len(row), UNKNOWN_RADIUS), None, row)
        return
    for shape in structure.visuals:
        pose = frame
        if shape.pose is not None:
            pose = compose(frame, np.broadcast_to(shape.pose.data, (len(entity.scene_idxs), 7))[row])
        radius = np.full(len(row), UNKNOWN_RADIUS)
        if isinstance(shape.geometry, Primitive):
            sizes = _sizes(shape.geometry, np.arange(len(entity.scene_idxs)))
            largest = shape.geometry.extent(np.eye(3), *sizes.max(axis=1).tolist())
            radius = np.full(len(row), float(np.linalg.norm(largest)))
        yield _Seen(entity.name, there, pose, radius, shape, row)


def _sizes(geometry: Primitive, rows: NDArray[np.int64]) -> Floats:
    """The sizes in some rows of an entity, an array each."""
    each = [value.data.reshape(len(value.data), -1) for value in geometry.values]
    return np.concatenate([data[rows if len(data) > 1 else rows * 0].T for data in each])


def _may_see(camera: Camera, pose: Floats, centre: Floats, radius: Floats) -> Any:
    """Whether a ball may be in a cone around all that a camera shows."""
    local = rotate(pose[:, 3:] * (1, -1, -1, -1), centre - pose[:, :3])
    distance = np.linalg.norm(local, axis=1)
    half = _half_fov(camera)
    angle = np.arccos(np.clip(local[:, 0] / np.maximum(distance, 1e-9), -1, 1))
    return (distance <= radius) | (angle - np.arcsin(np.clip(radius / np.maximum(distance, 1e-9), 0, 1)) <= half)


def _half_fov(camera: Camera) -> float:
    """Half of the largest angle between two pixels [rad], at least."""
    lens = camera.lens
    if not isinstance(lens, Perspective):
        return MAX_HALF_FOV if not hasattr(lens, "top") else np.pi
    given = lens.fovy or lens.fovx
    assert given is not None
    side = camera.height if lens.fovy is not None else camera.width
    return float(np.arctan(np.tan(given.data.max() / 2) * np.hypot(camera.width, camera.height) / side))


def _is_inside(seen: _Seen, scenes: NDArray[np.int64], pose: Floats) -> Any:
    """Whether a camera is inside of a solid. One whose faces are turned is meant to be seen from inside."""
    shape = seen.shape
    if (
        shape is None
        or shape.front_face is not None
        or not isinstance(shape.geometry, Box | Sphere | Capsule | Cylinder)
    ):
        return np.zeros(len(scenes), bool)
    frame = seen.pose[scenes]
    local = np.abs(compose(invert(frame), pose)[:, :3])
    sizes = _sizes(shape.geometry, seen.row[scenes])
    if isinstance(shape.geometry, Box):
        return (local < sizes.T).all(axis=1)
    if isinstance(shape.geometry, Sphere):
        return np.linalg.norm(local, axis=1) < sizes[0]
    radius, half_length = sizes
    if isinstance(shape.geometry, Cylinder):
        return (local[:, 0] < half_length) & (np.hypot(local[:, 1], local[:, 2]) < radius)
    local[:, 0] = np.maximum(local[:, 0] - half_length, 0)
    return np.linalg.norm(local, axis=1) < radius
