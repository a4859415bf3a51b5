"""Checks of where bodies are relative to each other: far from everything else, in the air, on something that does not
collide, or in one place; two floors, and planes that collide beyond their visual.

Only `scenecc check` applies these rules. They report what the first and the last scene have in common, by their boxes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from scenecc.checks.boxes import PlacedBox, bounding_box, placed_boxes
from scenecc.checks.physics import constrained_entities, may_collide, plan_origin, structure_origin
from scenecc.checks.plausibility import MAX_DISTANCE, METRES
from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotation_arrays import compose, rotate
from scenecc.plan import BodyStructure, Distance, Drive
from scenecc.plan.geometry import Plane, TiledPlane, VisualPlane

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.checks.boxes import Box
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import Entity, ScenePlan

    Floats = NDArray[np.float64]

FAR: Final = 5.0
"""[m], and in sizes of the rest of the scene: the minimum distance of a body or a floor that is reported."""

HIGH: Final = 1.0
"""[m] Minimum height from which a single body falls while all others rest."""

VERY_HIGH: Final = 10.0
"""[m] Height from which no body is meant to fall."""

MAX_COMPARED: Final = 200
"""Maximum number of entities of a scene that are compared with each other."""

RESTS: Final = 0.03
"""[m] Maximum distance of a body from what it stands on."""

FLUSH: Final = 1e-4
"""[m] Maximum distance of two surfaces at one height."""

UP: Final = 0.99
"""Minimum z of the normal of a floor."""

WIDE: Final = 10.0
"""[m] Half size from which the visual of a plane counts as a ground: SAPIEN's default."""


class Floor(NamedTuple):
    """A colliding plane that faces up.

    Attributes:
        entity: its entity.
        origin: where the plane is written.
        height: of the plane in the world [m].
        center, half: centre and half size of its visual in the world along x and y, each (2,) [m]; None: no visual.
    """

    entity: Entity
    origin: Origin
    height: float
    center: NDArray[np.float64] | None
    half: NDArray[np.float64] | None


def check_layout(plan: ScenePlan, sink: Sink) -> None:
    """Applies every rule of this module.

    Args:
        plan: a plan with its draws, whose files were checked.
        sink: collects diagnostics.
    """
    found: dict[tuple[str, str], list[_Finding]] = {}
    scenes = sorted({0, plan.num_scenes - 1})
    for scene in scenes:
        boxes, floors = placed_boxes(plan, scene), list(_floors(plan, scene))
        # What is farther away is reported as such.
        boxes = [box for box in boxes if np.abs((box.low, box.high)).max() < MAX_DISTANCE]
        few = boxes if len(boxes) <= MAX_COMPARED else []
        here = {
            (one[0], one[1].name): one
            for one in (
                *_two_floors(floors),
                *_flush_floors(floors, boxes, plan),
                *_small_floors(floors, boxes),
                *_far_floors(floors, boxes, plan),
                *_far_bodies(few, plan),
                *_bodies_in_the_air(few, floors, plan),
                *_bodies_on_nothing(few, floors, plan),
                *_copies(boxes, plan),
                *_long_limits(boxes, plan),
            )
        }
        for key, one in here.items():
            found.setdefault(key, []).append(one)
    for each in found.values():
        code, entity, place, message, hint = each[0]
        # What differs between scenes is meant.
        if len(each) == sum(scene in entity.scene_idxs for scene in scenes):
            sink.report(code, message, place, at="key", hint=hint)


_Finding = tuple[str, "Entity", "Origin", str, str]
"""Code, entity, place, message and hint."""


def _floors(plan: ScenePlan, scene: int) -> Iterator[Floor]:
    """Yields the colliding planes of a scene that face up."""
    for entity in plan.entities:
        if scene not in entity.scene_idxs:
            continue
        row = entity.scene_idxs.index(scene)
        body = entity.structure(row)
        if not isinstance(body, BodyStructure):
            continue
        frame = entity.pose.row(row)
        patches = [shape for shape in body.visuals if isinstance(shape.geometry, VisualPlane | TiledPlane)]
        for shape in body.collisions:
            if not isinstance(shape.geometry, Plane):
                continue
            pose = frame if shape.pose is None else compose(frame[None], shape.pose.row(row)[None])[0]
            if rotate(pose[None, 3:], np.array([[1.0, 0.0, 0.0]]))[0, 2] < UP:
                continue
            center = half = None
            for patch in patches[:1]:
                local = frame if patch.pose is None else compose(frame[None], patch.pose.row(row)[None])[0]
                geometry: Any = patch.geometry
                one, other = geometry.half_size.row(row).tolist()
                flat = [0.0, one, other] if isinstance(geometry, VisualPlane) else [one, other, 0.0]
                corner = rotate(local[None, 3:], np.array([flat]))[0]
                center, half = local[:2], np.abs(corner[:2])
            yield Floor(entity, shape.origin or structure_origin(body, entity, plan), float(pose[2]), center, half)


def _two_floors(floors: list[Floor]) -> Iterator[_Finding]:
    """Yields floors beside the first. Copies in the same place are reported elsewhere."""
    for floor in floors[1:]:
        first = floors[0]
        if floor.entity.pose == first.entity.pose and floor.height == first.height:
            continue
        low, high = sorted((first.height, floor.height))
        where = f"{high - low:.3g} m apart" if high - low > 1e-6 else "at the same height"
        message = f"`{cut(floor.entity.name)}` is a second floor, beside `{cut(first.entity.name)}`, {where}"
        hint = "remove one of the two: nothing reaches the lower one"
        if first.half is not None or floor.half is not None:
            hint += "; a plane has no end, and `half_size` is the size of its visual only"
        yield "SC576", floor.entity, floor.origin, message, hint


def _flush_floors(floors: list[Floor], boxes: list[PlacedBox], plan: ScenePlan) -> Iterator[_Finding]:
    """Yields large bodies that never move and whose top is in a plane: the body below it is a floor, too."""
    for floor in floors[:1]:
        for box in boxes:
            body = box.entity.structures[0]
            large = (box.high - box.low)[:2].min() > 2 * HIGH
            flush = abs(box.high[2] - floor.height) < FLUSH and box.low[2] < floor.height
            if large and flush and isinstance(body, BodyStructure) and body.body_type == "static":
                message = f"`{cut(box.entity.name)}` is a second floor, level with the plane `{cut(floor.entity.name)}`"
                place = structure_origin(body, box.entity, plan)
                yield "SC576", box.entity, place, message, "remove one of the two: every contact is computed twice"


def _small_floors(floors: list[Floor], boxes: list[PlacedBox]) -> Iterator[_Finding]:
    """Yields the only floor if its visual ends where other bodies are beyond it, or below it."""
    floor = floors[0] if len(floors) == 1 else None
    if floor is None or floor.half is None or floor.center is None:
        return
    for box in boxes:
        is_below = box.high[2] < floor.height - RESTS
        reach = np.maximum(box.high[:2] - floor.center, floor.center - box.low[:2]) - floor.half
        is_beyond = bool((reach > 0.05 * floor.half + 0.01).any())
        if floor.half.max() >= WIDE:  # a ground, whose end matters only to what stands there
            is_below, is_beyond = False, _stands_beyond(floor.center, floor.half, floor.height, box, boxes)
        if is_below or is_beyond:
            where = "below" if is_below else "beyond the visual of"
            size = " by ".join(f"{2 * side:.3g}" for side in floor.half)
            message = (
                f"`{cut(floor.entity.name)}` looks {size} m large, but a plane collides without end, and "
                f"`{cut(box.entity.name)}` is {where} it"
            )
            yield "SC577", floor.entity, floor.origin, message, "use a thin box, or a larger `half_size`"
            return


def _stands_beyond(center: Floats, half: Floats, height: float, box: PlacedBox, boxes: list[PlacedBox]) -> bool:
    """Returns whether a movable body is on a plane where neither the plane nor anything flat on it is visible."""
    body = box.entity.structures[0]
    if (isinstance(body, BodyStructure) and body.body_type != "dynamic") or abs(box.low[2] - height) > RESTS:
        return False
    gap = np.maximum(box.low[:2] - center, center - box.high[:2]) - half
    parts = (part for other in boxes if other is not box for part in other.parts)
    return bool(gap.max() > RESTS) and not any(
        abs(part[1][2] - height) < RESTS and _overlap(part, (box.low, box.high)) for part in parts
    )


def _far_floors(floors: list[Floor], boxes: list[PlacedBox], plan: ScenePlan) -> Iterator[_Finding]:
    if not boxes or len(floors) != 1:
        return
    low, high = bounding_box((box.low, box.high) for box in boxes)
    gap, size = float(low[2]) - floors[0].height, float(np.linalg.norm(high - low))
    if gap > max(FAR, FAR * size):
        entity = floors[0].entity
        message = f"the floor `{cut(entity.name)}` is {gap:.4g} m below everything else, which is {size:.2g} m large"
        yield "SC534", entity, _pose_origin(entity, plan), message, METRES


def _pose_origin(entity: Entity, plan: ScenePlan) -> Origin:
    return structure_origin(entity.structures[0], entity, plan).child("pose")


def _far_bodies(boxes: list[PlacedBox], plan: ScenePlan) -> Iterator[_Finding]:
    """Yields bodies that are far away from all others, measured in sizes of these."""
    for box in boxes if len(boxes) > 2 else ():
        others = [other for other in boxes if other is not box]
        low, high = bounding_box((other.low, other.high) for other in others)
        size = float(np.linalg.norm(high - low))
        gap = float(np.linalg.norm(np.maximum(np.maximum(low - box.high, box.low - high), 0)))
        if gap > max(FAR, FAR * size):
            message = f"`{cut(box.entity.name)}` is {gap:.4g} m away from everything else, which is {size:.2g} m large"
            yield "SC534", box.entity, _pose_origin(box.entity, plan), message, METRES


def _bodies_in_the_air(boxes: list[PlacedBox], floors: list[Floor], plan: ScenePlan) -> Iterator[_Finding]:
    """Yields bodies that fall very far, and the only one that falls far while at least two others rest."""
    left_out = constrained_entities(plan) | {mount.entity for one in plan.placements for mount in one.members}
    free = [box for box in boxes if _falls(box.entity) and box.entity.name not in left_out]
    heights = [float(box.low[2]) - _support(box, boxes, floors) for box in free]
    alone = sum(height > RESTS for height in heights) == 1 and len(free) > 2
    for box, height in zip(free, heights, strict=True):
        if (HIGH if alone else VERY_HIGH) < height < np.inf:
            others = ", and all others rest" if alone else ""
            message = f"`{cut(box.entity.name)}` starts {height:.3g} m above what is below it{others}"
            yield "SC534", box.entity, _pose_origin(box.entity, plan), message, f"{METRES}; or give it a velocity"


def _long_limits(boxes: list[PlacedBox], plan: ScenePlan) -> Iterator[_Finding]:
    """Yields linear limits of constraints that are many times as long as the whole scene."""
    by_name = {box.entity.name: box for box in boxes}
    if not boxes:
        return
    low, high = bounding_box((box.low, box.high) for box in boxes)
    size = float(np.linalg.norm(high - low))
    for constraint in plan.constraints:
        box = by_name.get(constraint.child.entity)
        joint = constraint.joint
        limits = [joint.limits] if isinstance(joint, Distance) else []
        if isinstance(joint, Drive):
            limits = [limit.limits for limit in joint.limits if limit.axis != "twist"]
        ends = [float(end) for limit in limits for end in limit.data.ravel() if np.isfinite(end)]
        far = max(map(abs, ends), default=0.0)
        if box is not None and far > max(FAR, FAR * size):
            message = f"a limit of `{cut(constraint.name)}` is {far:.4g} m, in a scene of {size:.2g} m"
            place = constraint.origin or plan_origin(plan).child("constraints", constraint.name)
            yield "SC534", box.entity, place.child("limits"), message, METRES


def _falls(entity: Entity) -> bool:
    """Returns whether an entity is a dynamic body at rest that gravity moves."""
    body = entity.structures[0]
    return (
        isinstance(body, BodyStructure)
        and body.body_type == "dynamic"
        and bool(body.collisions)
        and (body.disable_gravity is None or not body.disable_gravity.data.any())
        and body.linear_velocity is body.angular_velocity is None
    )


def _support(box: PlacedBox, boxes: list[PlacedBox], floors: list[Floor]) -> float:
    """Returns the height of the highest thing below a box that collides with it [m]; minus infinity if none does."""
    solid = [floor for floor in floors if floor.height < box.low[2] + RESTS]
    tops = [floor.height for floor in solid if _collide(box.entity, floor.entity)]
    for other in boxes:
        below = [part for part in other.parts if part[0][2] < box.low[2] and _overlap(part, (box.low, box.high))]
        if other is not box and below and _collide(box.entity, other.entity):
            tops += [min(float(high[2]), float(box.low[2])) for _, high in below]
    return max(tops, default=-np.inf)


def _overlap(one: Box, other: Box) -> bool:
    """Returns whether two boxes overlap as seen from above."""
    return bool((one[0][:2] < other[1][:2]).all() and (other[0][:2] < one[1][:2]).all())


def _collide(one: Entity, other: Entity) -> bool:
    """Returns whether any bodies of two entities may collide."""
    return any(
        a.collisions and b.collisions and may_collide(one, a, other, b) for a in one.bodies for b in other.bodies
    )


def _bodies_on_nothing(boxes: list[PlacedBox], floors: list[Floor], plan: ScenePlan) -> Iterator[_Finding]:
    """Yields dynamic bodies that start on top of a body that does not collide with them."""
    held = constrained_entities(plan)
    for box in boxes:
        if not _falls(box.entity) or box.entity.name in held:
            continue
        center = (box.low + box.high) / 2
        below = [(other, part) for other in boxes for part in other.parts if _overlap(part, (center, center))]
        tops = [(other.entity, float(high[2])) for other, (_, high) in below if other is not box]
        tops += [(floor.entity, floor.height) for floor in floors]
        near = [entity for entity, top in tops if abs(box.low[2] - top) < RESTS]
        if near and RESTS < box.low[2] - _support(box, boxes, floors) < np.inf:
            other, name = near[0], cut(box.entity.name)
            if any(body.collisions for body in other.bodies):
                message = f"`{name}` is on `{cut(other.name)}`, but their collision groups ignore each other"
                hint = "give them groups or bits that match"
            else:
                message = f"`{name}` is on `{cut(other.name)}`, which does not collide"
                hint = "write `shapes` instead of `visuals`"
            place = structure_origin(box.entity.structures[0], box.entity, plan)
            yield "SC574", box.entity, place, message, hint


def _copies(boxes: list[PlacedBox], plan: ScenePlan) -> Iterator[_Finding]:
    """Yields colliding bodies of the same extent in one place. Others report equal poses of bodies that never move, and
    overlaps of those that collide.
    """
    first: dict[bytes, PlacedBox] = {}
    for box in boxes:
        if not box.collides or not isinstance(box.entity.structures[0], BodyStructure):
            continue
        other = first.setdefault((np.array([box.low, box.high]).round(4) + 0.0).tobytes(), box)
        if other is box:
            continue
        moves = any(body.body_type == "dynamic" for body in (*box.entity.bodies, *other.entity.bodies))
        if _collide(box.entity, other.entity) if moves else box.entity.pose == other.entity.pose:
            continue
        message = f"`{cut(box.entity.name)}` is in the same place as `{cut(other.entity.name)}`, and as large"
        place = structure_origin(box.entity.structures[0], box.entity, plan)
        yield "SC546", box.entity, place, message, "move one of them, or remove it"
