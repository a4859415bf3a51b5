"""Checks of cameras that are inside a body or see nothing, and of lights and shadows without effect.

Only `scenecc check` applies these rules. Mounted cameras and lights are not checked, because they move.
"""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from scenecc.checks.physics import plan_origin
from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotation_arrays import compose, invert, rotate
from scenecc.plan import BodyStructure
from scenecc.plan.geometry import Box, Capsule, Cylinder, Heightfield, Plane, Primitive, Sphere, VisualPlane
from scenecc.plan.rendering import (
    DirectionalLight,
    Intrinsic,
    Orthographic,
    Perspective,
    PointLight,
    SpotLight,
    TexturedLight,
    shadow_parameters,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan, Value, VisualShape
    from scenecc.plan.rendering import Camera, Light

    Floats = NDArray[np.float64]

UNKNOWN_RADIUS: Final = 5.0
"""[m] Maximum reach of a robot, a mesh or terrain that a camera may see."""

MAX_HALF_FOV: Final = 1.5
"""[rad] Half field of view of a camera given as a matrix."""

FLOOR: Final = 0.7
"""Minimum z of the normal of a plane that counts as a floor."""

FAINT: Final = 1e-4
"""Maximum brightness of the nearest object at which a light has no visible effect. One level of a picture is 0.004."""


class _VisibleShape(NamedTuple):
    """A visual shape over all scenes.

    Attributes:
        entity: name of its entity.
        there: whether it exists in each scene (N,).
        pose: (N, 7) in the world. radius: (N,) of a bounding ball around its origin [m].
        shape: the shape, for a body with one structure; None if unknown.
        row: row of its entity by scene (N,).
    """

    entity: str
    there: NDArray[np.bool_]
    pose: Floats
    radius: Floats
    shape: VisualShape | None
    row: NDArray[np.int64]


def check_views(plan: ScenePlan, sink: Sink) -> None:
    """Applies the rules to each camera and light that is fixed in the world.

    Args:
        plan: a plan with its draws.
        sink: collects diagnostics.
    """
    cameras = [camera for camera in plan.cameras if camera.mount is None]
    if plan.environment is not None and plan.environment.map is not None:
        cameras = []  # the sky is visible everywhere
    lights = [light for light in plan.lights if light.mount is None]
    if not cameras and not lights:
        return
    visible = [each for entity in plan.entities for each in _visible_shapes(plan, entity)]
    for camera in cameras:
        _check_camera(camera, visible, plan, sink)
    for light in lights:
        for message, hint in islice(_why_no_effect(light, visible, plan), 1):
            place = light.origin or plan_origin(plan).child("lights", light.name)
            sink.report("SC570", f"the light `{cut(light.name)}` {message}", place, at="key", hint=hint)


def _check_camera(camera: Camera, visible: list[_VisibleShape], plan: ScenePlan, sink: Sink) -> None:
    place = camera.origin or plan_origin(plan).child("cameras", camera.name)
    scenes = np.array(camera.scene_idxs)
    pose = np.broadcast_to(camera.pose.data, (len(scenes), 7))
    # A scene without visible objects is not the camera's fault.
    empty = np.any([each.there[scenes] for each in visible], axis=0) & np.ones(len(scenes), bool)
    for each in visible:
        there = each.there[scenes]
        empty &= ~(there & _may_show(camera, pose, each.pose[scenes, :3], each.radius[scenes]))
        inside = np.flatnonzero(there & _is_inside(each, scenes, pose))
        if inside.size:
            is_plane = each.shape is not None and isinstance(each.shape.geometry, VisualPlane)
            where = f"{'below' if is_plane else 'inside'} `{cut(each.entity)}` in scene {scenes[inside[0]]}"
            message = f"camera `{cut(camera.name)}` is {where}"
            sink.report("SC548", message, place.child("pose"), hint="move the camera out of it")
            return
    if empty.any():
        index = scenes[int(np.flatnonzero(empty)[0])]
        message = f"camera `{cut(camera.name)}` sees nothing in scene {index}"
        sink.report("SC548", message, place.child("pose"), hint="a camera looks along its x: try `look_at`")


def _visible_shapes(plan: ScenePlan, entity: Any) -> Iterator[_VisibleShape]:
    """Yields the visual shapes of an entity; one ball for a robot, or for an entity with several structures."""
    row, there = np.zeros(plan.num_scenes, np.int64), np.zeros(plan.num_scenes, bool)
    row[list(entity.scene_idxs)], there[list(entity.scene_idxs)] = range(len(entity.scene_idxs)), True
    frame = np.broadcast_to(entity.pose.data, (len(entity.scene_idxs), 7))[row]
    structure = entity.structures[0]
    if not isinstance(structure, BodyStructure) or entity.pick is not None:
        yield _VisibleShape(entity.name, there, frame, np.full(len(row), UNKNOWN_RADIUS), None, row)
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
        elif isinstance(shape.geometry, Heightfield):
            radius = np.full(len(row), float(np.linalg.norm(shape.geometry.size.data, axis=-1).max()))
        yield _VisibleShape(entity.name, there, pose, radius, shape, row)


def _sizes(geometry: Primitive, rows: NDArray[np.int64]) -> Floats:
    """Returns the sizes in some rows of an entity, one array per size."""
    each = [value.data.reshape(len(value.data), -1) for value in geometry.values]
    return np.concatenate([data[rows if len(data) > 1 else rows * 0].T for data in each])


def _why_no_effect(light: Light, visible: list[_VisibleShape], plan: ScenePlan) -> Iterator[tuple[str, str]]:
    """Yields why a light, or its shadow, has no effect in any scene, with a hint."""
    if not light.color.data.any():
        yield "is black", "give it a `color` above 0, or remove it"
    scenes, kind = np.array(light.scene_idxs), light.light
    pose = np.broadcast_to(light.pose.data, (len(scenes), 7))
    if isinstance(kind, DirectionalLight) and _has_ground(plan) and (_along_x(pose)[:, 2] > 0).all():
        yield "shines upwards, but there is a ground", "`direction` is the direction of the light, as in [0, 0, -1]"
    near = [each for each in visible if each.there[scenes].any()]
    if isinstance(kind, SpotLight | TexturedLight):
        half = float(kind.outer_fov.data.max()) / 2
        if near and not any(
            (each.there[scenes] & _is_in_cone(half, pose, *_balls(each, scenes))).any() for each in near
        ):
            yield "shines on nothing", "turn it towards an object, or widen `outer_fov`"
    if near and isinstance(kind, SpotLight | PointLight):
        brightness = max(_brightness(light, each.pose[scenes, :3] - pose[:, :3], each.radius[scenes]) for each in near)
        if brightness < FAINT:
            yield "is too far away to light anything visibly", "move it nearer, or make its `color` brighter"
    numbers = shadow_parameters(light)
    if not near or not numbers or not numbers["shadow"].data.any():
        return
    for each in near if isinstance(kind, PointLight | SpotLight | TexturedLight) else ():
        if (_is_inside(each, scenes, pose) & each.there[scenes]).all():
            yield f"is in or below `{cut(each.entity)}`, which shadows it", "move it out, or remove `shadow`"
    if not any((each.there[scenes] & _is_shadowed(numbers, pose, *_balls(each, scenes))).any() for each in near):
        keys = "`shadow_near`, `shadow_far`" + (" and `shadow_scale`" if isinstance(kind, DirectionalLight) else "")
        yield "casts no shadow: nothing is within the range of its shadow map", f"move it, or set {keys}"


def _has_ground(plan: ScenePlan) -> bool:
    bodies = (body for entity in plan.entities for body in entity.bodies)
    return any(isinstance(shape.geometry, Plane) for body in bodies for shape in body.collisions)


def _balls(visible: _VisibleShape, scenes: NDArray[np.int64]) -> tuple[Floats, Floats]:
    return visible.pose[scenes, :3], visible.radius[scenes]


def _brightness(light: Light, way: Floats, radius: Floats) -> float:
    """Returns the maximum brightness of a light within a ball: its colour falls off with the squared distance."""
    distance = np.maximum(np.linalg.norm(way, axis=1) - radius, 1e-3)
    return float((light.color.data.max(axis=1) / distance**2).max())


def _along_x(pose: Floats) -> Floats:
    return np.asarray(rotate(pose[:, 3:], np.broadcast_to((1.0, 0.0, 0.0), (len(pose), 3))))


def _is_shadowed(numbers: dict[str, Value], pose: Floats, centre: Floats, radius: Floats) -> Any:
    """Returns whether a ball may be in the range of the shadow map; the cone of a spot light is ignored."""
    local = rotate(pose[:, 3:] * (1, -1, -1, -1), centre - pose[:, :3])
    depth = np.linalg.norm(local, axis=1)
    inside = np.ones(len(pose), np.bool_)
    if "shadow_half_size" in numbers:
        depth, half = local[:, 0], numbers["shadow_half_size"].data
        inside = (np.abs(local[:, 1:]).max(axis=1) - radius) < half
    return inside & (depth + radius > numbers["shadow_near"].data) & (depth - radius < numbers["shadow_far"].data)


def _is_in_cone(half: float, pose: Floats, centre: Floats, radius: Floats) -> Any:
    """Returns whether a ball may be in a cone of this half angle [rad] around the x axis of a pose."""
    local = rotate(pose[:, 3:] * (1, -1, -1, -1), centre - pose[:, :3])
    distance = np.linalg.norm(local, axis=1)
    angle = np.arccos(np.clip(local[:, 0] / np.maximum(distance, 1e-9), -1, 1))
    return (distance <= radius) | (angle - np.arcsin(np.clip(radius / np.maximum(distance, 1e-9), 0, 1)) <= half)


def _may_show(camera: Camera, pose: Floats, centre: Floats, radius: Floats) -> Any:
    """Returns whether a ball may be in a camera's view: between its near and far planes, and within its sides."""
    local = rotate(pose[:, 3:] * (1, -1, -1, -1), centre - pose[:, :3])
    between = (local[:, 0] + radius > camera.near.data) & (local[:, 0] - radius < camera.far.data)
    if isinstance(camera.lens, Orthographic):
        top = camera.lens.top.data
        beyond = np.abs(local[:, 1]) - radius, np.abs(local[:, 2]) - radius
        return between & (beyond[0] < top * camera.width / camera.height) & (beyond[1] < top)
    return between & _is_in_cone(_half_fov(camera.lens, camera.width, camera.height), pose, centre, radius)


def _half_fov(lens: Perspective | Intrinsic, width: int, height: int) -> float:
    """Returns at least half of the largest angle between two pixels [rad]."""
    if not isinstance(lens, Perspective):
        return MAX_HALF_FOV
    given = lens.fovy or lens.fovx
    assert given is not None
    side = height if lens.fovy is not None else width
    return float(np.arctan(np.tan(given.data.max() / 2) * np.hypot(width, height) / side))


def _is_inside(visible: _VisibleShape, scenes: NDArray[np.int64], pose: Floats) -> Any:
    """Returns whether a camera is inside a solid or below a floor. Solids with inverted faces are rooms."""
    shape = visible.shape
    if (
        shape is None
        or shape.front_face is not None
        or not isinstance(shape.geometry, Box | Sphere | Capsule | Cylinder | VisualPlane)
    ):
        return np.zeros(len(scenes), bool)
    frame = visible.pose[scenes]
    local = compose(invert(frame), pose)[:, :3]
    sizes = _sizes(shape.geometry, visible.row[scenes])
    if isinstance(shape.geometry, VisualPlane):
        is_floor = _along_x(frame)[:, 2] > FLOOR
        return is_floor & (local[:, 0] < 0) & (np.abs(local[:, 1:]) < sizes.T).all(axis=1)
    local = np.abs(local)
    if isinstance(shape.geometry, Box):
        return (local < sizes.T).all(axis=1)
    if isinstance(shape.geometry, Sphere):
        return np.linalg.norm(local, axis=1) < sizes[0]
    radius, half_length = sizes
    if isinstance(shape.geometry, Cylinder):
        return (local[:, 0] < half_length) & (np.hypot(local[:, 1], local[:, 2]) < radius)
    local[:, 0] = np.maximum(local[:, 0] - half_length, 0)
    return np.linalg.norm(local, axis=1) < radius
