"""Checks of cameras that are inside a body or see nothing, and of lights and shadows without effect.

Only `scenecc check` applies these rules. Mounted cameras and lights are not checked, because they move.
"""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.checks.boxes import bounding_box, corners, placed_boxes, shape_box
from scenecc.checks.physics import plan_origin
from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotation_arrays import compose, invert, rotate
from scenecc.plan import BodyStructure, MeshGeometry
from scenecc.plan.geometry import Box, Capsule, Cylinder, Heightfield, Plane, Primitive, Sphere, TiledPlane, VisualPlane
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
    from scenecc.plan import Entity, ScenePlan, Value, VisualShape
    from scenecc.plan.rendering import Camera, Light

    Floats = NDArray[np.float64]

UNKNOWN_RADIUS: Final = 5.0
"""[m] Maximum reach of a robot, a mesh or terrain that a camera may see."""

MAX_HALF_FOV: Final = 1.5
"""[rad] Half field of view of a camera given as a matrix."""

FLOOR: Final = 0.7
"""Minimum z of the normal of a plane that counts as a floor."""

FAINT: Final = 2e-3
"""Maximum brightness of the nearest object at which a light has no visible effect. One level of a picture is 0.004."""

GLARE: Final = 30.0
"""Brightness of the farthest object from which everything is white."""

MIN_PIXELS: Final = 10.0
"""Minimum size of the largest body in a picture."""

WIDE: Final = 8.0
"""[m] Extent from which a static shape is a ground."""

UPSIDE_DOWN: Final = -0.2
"""Maximum z of a camera's up direction that is a mistake. A camera that looks straight down has 0."""

RAYS: Final = np.stack(np.meshgrid(np.linspace(-0.9, 0.9, 9), np.linspace(-0.9, 0.9, 7)), axis=-1).reshape(-1, 2)
"""Points of a picture, in halves of its width and height."""


class _VisibleShape(NamedTuple):
    """A visual shape over all scenes.

    Attributes:
        entity: name of its entity.
        there: whether it exists in each scene (N,).
        pose: (N, 7) in the world. radius: (N,) of a bounding ball around its origin [m].
        shape: the shape, for a body with one structure; None if unknown.
        row: row of its entity by scene (N,).
        is_ground: whether it is a plane, terrain, or as wide as a ground.
        corners: (8, 3) of a box around the shape, in its frame [m]; None: only the ball is known.
    """

    entity: str
    there: NDArray[np.bool_]
    pose: Floats
    radius: Floats
    shape: VisualShape | None
    row: NDArray[np.int64]
    is_ground: bool = False
    corners: Floats | None = None


def check_views(plan: ScenePlan, sink: Sink) -> None:
    """Applies the rules to each camera and light that is fixed in the world.

    Args:
        plan: a plan with its draws.
        sink: collects diagnostics.
    """
    cameras = [camera for camera in plan.cameras if camera.mount is None]
    if plan.environment is not None and plan.environment.map is not None:
        cameras = []  # the sky is visible everywhere
    _check_darkness(plan, sink)
    if not cameras and not plan.lights:
        return
    visible = [each for entity in plan.entities for each in _visible_shapes(plan, entity)]
    for camera in cameras:
        _check_camera(camera, visible, plan, sink)
    for light in plan.lights:
        if light.mount is not None and light.color.data.any():
            continue
        for message, hint in islice(_why_no_effect(light, visible, plan), 1):
            place = light.origin or plan_origin(plan).child("lights", light.name)
            sink.report("SC570", f"the light `{cut(light.name)}` {message}", place, at="key", hint=hint)


def _check_camera(camera: Camera, visible: list[_VisibleShape], plan: ScenePlan, sink: Sink) -> None:
    place = camera.origin or plan_origin(plan).child("cameras", camera.name)
    scenes = np.array(camera.scene_idxs)
    pose = np.broadcast_to(camera.pose.data, (len(scenes), 7))
    # A scene without visible objects is not the camera's fault.
    empty = np.any([each.there[scenes] for each in visible], axis=0) & np.ones(len(scenes), bool)
    shown: list[tuple[_VisibleShape, NDArray[np.bool_]]] = []
    for each in visible:
        there = each.there[scenes]
        shown.append((each, there & _may_show(camera, pose, each, scenes)))
        empty &= ~shown[-1][1]
        inside = np.flatnonzero(there & _is_inside(each, scenes, pose))
        if inside.size:
            is_plane = each.shape is not None and isinstance(each.shape.geometry, VisualPlane)
            where = f"{'below' if is_plane else 'inside'} `{cut(each.entity)}` in scene {scenes[inside[0]]}"
            message = f"camera `{cut(camera.name)}` is {where}"
            sink.report("SC548", message, place.child("pose"), hint="move the camera out of it")
            return
    fault = _view_fault(camera, shown, scenes, pose, empty)
    if fault is not None:
        message, hint = fault
        sink.report("SC548", f"camera `{cut(camera.name)}` {message}", place.child("pose"), hint=hint)


def _view_fault(
    camera: Camera,
    visible: list[tuple[_VisibleShape, NDArray[np.bool_]]],
    scenes: NDArray[np.int64],
    pose: Floats,
    empty: NDArray[np.bool_],
) -> tuple[str, str] | None:
    """Returns what is wrong with a view, and a hint; None if nothing is.

    Args:
        camera: a camera in the world.
        visible: all visual shapes, and whether each may be in view (n,).
        scenes: scenes of the camera (n,).
        pose: of the camera in each (n, 7).
        empty: whether nothing at all is in view (n,).
    """
    try_it = "a camera looks along its x: try `look_at`"
    up = np.asarray(rotate(pose[:, 3:], np.broadcast_to((0.0, 0.0, 1.0), (len(pose), 3))))
    if empty.any() or (up[:, 2] < UPSIDE_DOWN).all():
        nothing = f"sees nothing in scene {scenes[int(np.flatnonzero(empty)[0])]}" if empty.any() else ""
        return nothing or "is upside down", try_it
    bodies = [one for one in visible if not one[0].is_ground and one[0].there[scenes].any()]
    if not bodies:
        return None
    shown = [one for _, one in bodies]
    present = np.any([each.there[scenes] for each, _ in bodies], axis=0)
    missed = present & ~np.any(shown, axis=0)
    if missed.any():
        return f"sees only the ground in scene {scenes[int(np.flatnonzero(missed)[0])]}", try_it
    pixels = np.where(shown, [_pixels(camera, pose, *_balls(each, scenes)) for each, _ in bodies], 0.0)
    largest = float(pixels.max(axis=0)[present].min())
    if largest < MIN_PIXELS:
        return f"shows no body larger than {largest:.2g} pixels", "move it nearer, in metres, or narrow its `fovy_deg`"
    wide = [each for (each, _), size in zip(bodies, pixels, strict=True) if size[0] >= camera.height]
    blocker = _blocker(camera, wide, [each for each, one in bodies if one[0]], int(scenes[0]), pose[0])
    if blocker is not None:
        return f"sees only `{cut(blocker)}`, which hides everything else", "move it to where its view is free"
    return None


def _pixels(camera: Camera, pose: Floats, centre: Floats, radius: Floats) -> Floats:
    """Returns the size of balls in a picture [pixels]."""
    if isinstance(camera.lens, Orthographic):
        return np.asarray(radius * camera.height / camera.lens.top.data)
    distance = np.maximum(np.linalg.norm(centre - pose[:, :3], axis=1), radius)
    return np.asarray(2 * radius / distance * _focal_length(camera))


def _focal_length(camera: Camera) -> float:
    """Returns the largest focal length of a camera with perspective [pixels]."""
    if isinstance(camera.lens, Perspective):
        angles, side = _fields_of_view(camera.lens, camera.width, camera.height)
        return float(side / 2 / np.tan(angles.min() / 2))
    return float(camera.lens.fy.data.max()) if isinstance(camera.lens, Intrinsic) else np.inf


def _fields_of_view(lens: Perspective, width: int, height: int) -> tuple[Floats, int]:
    """Returns the angles of view [rad] in all scenes, and the pixels across them."""
    if lens.fovy is not None:
        return lens.fovy.data, height
    assert lens.fovx is not None
    return lens.fovx.data, width


def _blocker(
    camera: Camera, wide: list[_VisibleShape], bodies: list[_VisibleShape], scene: int, pose: Floats
) -> str | None:
    """Returns the entity whose box fills the picture and hides the centres of all other bodies; None if none does."""
    if isinstance(camera.lens, Orthographic) or len({each.entity for each in bodies}) < 2:
        return None
    sides = np.array([camera.width, camera.height]) / 2 / _focal_length(camera)
    rays = np.concatenate((np.ones((len(RAYS), 1)), RAYS * sides), axis=1)
    rays = np.asarray(rotate(np.broadcast_to(pose[3:], (len(rays), 4)), rays))
    for each in wide:
        if each.shape is None or not isinstance(each.shape.geometry, Box):
            continue
        others = [other for other in bodies if other.entity != each.entity]
        ways = np.array([other.pose[scene, :3] - pose[:3] for other in others])
        half, back = _sizes(each.shape.geometry, each.row[[scene]])[:, 0], invert(each.pose[[scene]])
        near = _distance_to_box(half, back, pose, rays)
        hidden = _distance_to_box(half, back, pose, ways)
        if np.isfinite(near).all() and others and (hidden < 1 - 1e-6).all():
            return each.entity
    return None


def _distance_to_box(half: Floats, back: Floats, pose: Floats, rays: Floats) -> Floats:
    """Returns where rays (n, 3) from a camera enter a box, in their lengths (n,); infinity where they miss it.

    `half`: (3,) of the box; `back`: (1, 7), the inverse of its pose.
    """
    start = compose(back, pose[None])[0, :3]
    local = np.asarray(rotate(np.broadcast_to(back[0, 3:], (len(rays), 4)), rays))
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (-half - start) / local, (half - start) / local
    enter, leave = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
    return np.where((enter <= leave) & (enter > 0), enter, np.inf)


def _check_darkness(plan: ScenePlan, sink: Sink) -> None:
    """Reports a black environment without lights. Black lights are reported themselves."""
    surroundings = plan.environment
    ambient = surroundings and surroundings.ambient_light
    if surroundings is None or surroundings.map is not None or ambient is None or ambient.data.any() or plan.lights:
        return
    place = (surroundings.origin or plan_origin(plan).child("environment")).child("ambient_light")
    hint = "raise it, or remove it: a file without lights gets a default lighting"
    sink.report("SC570", "pictures are black: `ambient_light` is 0, and no light shines", place, hint=hint)


def _visible_shapes(plan: ScenePlan, entity: Entity) -> Iterator[_VisibleShape]:
    """Yields the visual shapes of an entity; one ball for a robot, or for an entity with several structures."""
    row, there = np.zeros(plan.num_scenes, np.int64), np.zeros(plan.num_scenes, bool)
    row[list(entity.scene_idxs)], there[list(entity.scene_idxs)] = range(len(entity.scene_idxs)), True
    frame = np.broadcast_to(entity.pose.data, (len(entity.scene_idxs), 7))[row]
    structure = entity.structures[0]
    if not isinstance(structure, BodyStructure) or entity.pick is not None:
        first = entity.scene_idxs[0]
        boxes = [one for one in placed_boxes(plan, first) if one.entity is entity]
        ends = np.abs([(box.low, box.high) - frame[first, :3] for box in boxes]).reshape(-1, 3)
        # Links and variants reach farther in other positions.
        radius = 1.5 * float(np.linalg.norm(ends.max(axis=0))) if boxes else UNKNOWN_RADIUS
        yield _VisibleShape(entity.name, there, frame, np.full(len(row), radius), None, row)
        return
    for shape in structure.visuals:
        pose = frame
        if shape.pose is not None:
            pose = compose(frame, np.broadcast_to(shape.pose.data, (len(entity.scene_idxs), 7))[row])
        ends = _corners(shape.geometry, len(entity.scene_idxs), plan)
        radius = UNKNOWN_RADIUS if ends is None else float(np.linalg.norm(ends, axis=1).max())
        is_ground = isinstance(shape.geometry, VisualPlane | TiledPlane | Heightfield)
        is_ground |= radius > WIDE and structure.body_type == "static"
        yield _VisibleShape(entity.name, there, pose, np.full(len(row), radius), shape, row, is_ground, ends)


def _corners(geometry: Any, rows: int, plan: ScenePlan) -> Floats | None:
    """Returns the corners (8, 3) of a box around a shape in its frame in all scenes [m]; None if unknown."""
    if isinstance(geometry, Primitive):
        high = geometry.extent(np.eye(3), *_sizes(geometry, np.arange(rows)).max(axis=1).tolist())
        return corners((-high, high))
    values = (geometry.file, geometry.scale) if isinstance(geometry, MeshGeometry) else geometry.values
    is_constant = all(value.is_constant for value in values)
    try:
        boxes = [shape_box(geometry, row, plan) for row in range(1 if is_constant else rows)]
    except AssetError:
        return None  # the build reports that the file changed
    known = [box for box in boxes if box is not None]
    return corners(bounding_box(known)) if known else None


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
    yield from _why_wrong_brightness(light, [each for each in near if not each.is_ground] or near, scenes, pose)
    numbers = shadow_parameters(light)
    if not near or not numbers or not numbers["shadow"].data.any():
        return
    for each in near if isinstance(kind, PointLight | SpotLight | TexturedLight) else ():
        if (_is_inside(each, scenes, pose) & each.there[scenes]).all():
            yield f"is in or below `{cut(each.entity)}`, which shadows it", "move it out, or remove `shadow`"
    if not any((each.there[scenes] & _is_shadowed(numbers, pose, *_balls(each, scenes))).any() for each in near):
        keys = "`shadow_near`, `shadow_far`" + (" and `shadow_scale`" if isinstance(kind, DirectionalLight) else "")
        yield "casts no shadow: nothing is within the range of its shadow map", f"move it, or set {keys}"


_COLOR_HINT: Final = (
    "`color` is the brightness: 1 lights a white surface fully; it is not in lux, lumen or watts, nor from 0 to 255"
)


def _why_wrong_brightness(
    light: Light, near: list[_VisibleShape], scenes: NDArray[np.int64], pose: Floats
) -> Iterator[tuple[str, str]]:
    """Yields why a light lights nothing visibly, or everything too brightly."""
    kind = light.light
    if isinstance(kind, SpotLight | TexturedLight):
        half = float(kind.outer_fov.data.max()) / 2
        if near and not any(
            (each.there[scenes] & _is_in_cone(half, pose, *_balls(each, scenes))).any() for each in near
        ):
            yield "shines on nothing", "turn it towards an object, or widen `outer_fov`"
    if near and isinstance(kind, SpotLight | PointLight):
        brightness = max(_brightness(light, each.pose[scenes, :3] - pose[:, :3], each.radius[scenes]) for each in near)
        if brightness < FAINT:
            yield (
                "is too far away or too faint to light anything visibly",
                "move it nearer, or make its `color` brighter",
            )
        least = min(_brightness(light, each.pose[scenes, :3] - pose[:, :3], 0 * each.radius[scenes]) for each in near)
        if least > GLARE:
            yield f"is so bright that everything is white: {least:.3g} at the farthest body", _COLOR_HINT
    if isinstance(kind, DirectionalLight) and not FAINT < light.color.data.max() < GLARE:
        faint = light.color.data.max() <= FAINT
        yield (
            ("is too faint to light anything visibly" if faint else "is so bright that everything is white"),
            _COLOR_HINT,
        )


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


def _may_show(camera: Camera, pose: Floats, each: _VisibleShape, scenes: NDArray[np.int64]) -> Any:
    """Returns whether a shape may be in a camera's view: its ball is, and no side of the view excludes its box."""
    centre, radius = _balls(each, scenes)
    seen = _may_show_ball(camera, pose, centre, radius)
    if each.corners is None or not seen.any():
        return seen
    count = len(scenes)
    frame = compose(invert(pose), np.ascontiguousarray(each.pose[scenes]))
    turned = rotate(np.repeat(frame[:, 3:], 8, axis=0), np.tile(each.corners, (count, 1))).reshape(count, 8, 3)
    x, y, z = np.moveaxis(turned + frame[:, None, :3], -1, 0)
    side, top = _half_sizes(camera)
    depth = np.ones_like(x) if isinstance(camera.lens, Orthographic) else x
    inside = (x > camera.near.data[:, None], x < camera.far.data[:, None])
    inside += (y < side * depth, y > -side * depth, z < top * depth, z > -top * depth)
    return seen & np.all([one.any(axis=1) for one in inside], axis=0)


def _half_sizes(camera: Camera) -> tuple[float, float]:
    """Returns half the width and height of the widest view [m], at a distance of 1 m for a perspective."""
    if isinstance(camera.lens, Orthographic):
        top = float(camera.lens.top.data.max())
        return top * camera.width / camera.height, top
    half = np.tan(_half_fov(camera.lens, camera.width, camera.height))
    diagonal = np.hypot(camera.width, camera.height)
    return float(half * camera.width / diagonal), float(half * camera.height / diagonal)


def _may_show_ball(camera: Camera, pose: Floats, centre: Floats, radius: Floats) -> Any:
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
    angles, side = _fields_of_view(lens, width, height)
    return float(np.arctan(np.tan(angles.max() / 2) * np.hypot(width, height) / side))


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
