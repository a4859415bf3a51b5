"""Findings at the start: overlapping bodies and robot links, bodies without support, and violated constraints."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.checks.physics import constrained_entities
from scenecc.plan import BodyStructure, Plane
from scenecc.plan.body import groups_collide
from scenecc.plan.constraint import Connection, Distance, Drive, Weld
from scenecc.simulation.bodies import up_of
from scenecc.simulation.bounds import bounding_boxes, is_plane, solid_components
from scenecc.simulation.findings import Finding, length_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.backends.sapien.contacts import Contacts
    from scenecc.plan import Constraint, Entity, ScenePlan
    from scenecc.simulation.bodies import MovingBody
    from scenecc.simulation.expect import OverlapRules

    Floats = NDArray[np.float64]

OVERLAP: Final = 0.0005
"""Maximum overlap of bodies at the start [m]. PhysX pushes them apart too slowly to be visible."""

MAX_CONSTRAINT_ERROR: Final = 0.001
"""[m] Maximum initial error of a constraint. PhysX pulls the bodies together with full force."""

MAX_CONSTRAINT_ANGLE: Final = math.radians(1)
"""[rad] Maximum initial error of rotation of a constraint."""

STRETCHED: Final = 5
"""The same after the simulation, as a multiple: 5 mm or 5°. Joints of a rope at rest are off by 0.1 mm."""

_LEVEL: Final = 0.01
"""Minimum cosine between a plane's normal and up. A body on a steeper plane slides away forever."""

SPACING: Final = "physics:scene_spacing"
"""Name of the distance between scenes in findings. Entity names have no colon."""


def overlaps(contacts: Contacts, plan: ScenePlan, rules: OverlapRules) -> Iterator[Finding]:
    """Yields overlapping bodies by the contacts of the first step, which PhysX computes before anything moves.

    Args:
        contacts: contacts of that step.
        plan: plan of the scenes.
        rules: allowed depths.
    """
    articulations = articulation_names(plan)
    fixed = fixed_bodies(plan)
    planes = {entity.name for entity in plan.entities if _has_plane(entity)}
    deep = np.flatnonzero(contacts.separation < -rules.least)
    deepest: dict[tuple[int, str, str], tuple[float, str, str]] = {}
    for number in deep.tolist():
        a, b = str(contacts.a[number]), str(contacts.b[number])
        if a in fixed and b in fixed:
            continue
        owners = owner(a, articulations), owner(b, articulations)
        if -contacts.separation[number] <= rules.allowed(*owners) or rules.excuses((a, owners[0]), (b, owners[1])):
            continue
        if a in fixed and a == owners[0]:  # the ground is rarely the misplaced body
            a, b, owners = b, a, (owners[1], owners[0])
        # For two entities, only the deepest pair of links is reported; for one robot, every pair.
        key = int(contacts.scene[number]), *((a, b) if owners[0] == owners[1] else owners)
        deepest[key] = max(deepest.get(key, (0.0, "", "")), (-float(contacts.separation[number]), a, b))
    for (scene, *names), (depth, a, b) in deepest.items():
        by = f"by {length_text(depth)} at the start"
        if owner(a, articulations) == owner(b, articulations):
            hint = "if intended, set `collision_bits` of `links`, or add a pair with `Default` to the SRDF, where "
            hint += "`Adjacent` and `Never` have no effect"
            yield Finding("SC851", tuple(names), scene, depth, f"the links `{a}` and `{b}` overlap {by}", hint)
        else:
            plane = next((one for one in (b, a) if one in planes), None)
            hint = None if plane is None else f"the plane of `{plane}` has no end, and all below it is solid"
            yield Finding("SC850", tuple(names), scene, depth, f"`{a}` and `{b}` overlap {by}", hint)


def _has_plane(entity: Entity) -> bool:
    return any(isinstance(shape.geometry, Plane) for body in entity.bodies for shape in body.collisions)


def articulation_names(plan: ScenePlan) -> set[str]:
    """Returns the names of entities with links."""
    return {entity.name for entity in plan.entities if not isinstance(entity.structures[0], BodyStructure)}


def owner(name: str, articulations: set[str]) -> str:
    """Returns the entity of ENTITY or ENTITY/LINK. `articulations`: the result of `articulation_names`."""
    ahead = name
    while ahead not in articulations and "/" in ahead:
        ahead = ahead.rpartition("/")[0]
    return ahead if ahead in articulations else name


def fixed_bodies(plan: ScenePlan) -> set[str]:
    """Returns static and kinematic bodies, and immovable links: those fixed to a fixed root, in each scene."""
    fixed: set[str] = set()
    for entity in plan.entities:
        moving: set[str] = set()
        for structure in entity.structures:
            if isinstance(structure, BodyStructure):
                moving |= {entity.name} if structure.body_type == "dynamic" else set()
                continue
            is_fixed: dict[str, bool] = {}
            for link in structure.links:
                if link.joint is None or link.parent is None:
                    is_fixed[link.name] = structure.fix_root_link
                else:
                    is_fixed[link.name] = link.joint.type == "fixed" and is_fixed[structure.links[link.parent].name]
            moving |= {f"{entity.name}/{name}" for name, stays in is_fixed.items() if not stays}
            fixed |= {f"{entity.name}/{name}" for name in is_fixed}
        fixed = (fixed | {entity.name}) - moving
    return fixed


def crowded_scenes(batch: SceneBatch) -> Iterator[Finding]:
    """Yields bodies that reach beyond half of `scene_spacing`, for scenes that share one space on a GPU."""
    spacing = batch.plan.physics.scene_spacing
    if spacing is None or batch.plan.num_scenes < 2:
        return
    for index, scene in zip(batch.scene_idxs, batch.scenes, strict=True):
        solid = [each for each in solid_components(scene.physx_system) if not any(map(is_plane, each.collision_shapes))]
        reach = np.abs(bounding_boxes(solid)[:, :, :2]).max(axis=(1, 2), initial=0.0)
        if (reach > spacing / 2).any():
            far, name = float(reach.max()), solid[int(reach.argmax())].entity.name
            yield Finding(
                "SC541", (SPACING,), index, far,
                f"scenes are {spacing:g} m apart, but `{name}` reaches {far:.3g} m from the middle of its scene",
                f"make it {2 * far:.2g} or more: neighbours on a GPU cost time",
            )  # fmt: skip


def unsupported_bodies(batch: SceneBatch, moving: list[MovingBody]) -> Iterator[Finding]:
    """Yields dynamic bodies with no support below them, along gravity, so that they fall forever."""
    up = up_of(batch.plan)
    if up is None:
        return
    constrained = constrained_entities(batch.plan)
    falling = [body for body in moving if body.entity not in constrained and _falls(body)]
    by_scene: dict[int, list[MovingBody]] = {}
    for body in falling:
        by_scene.setdefault(body.scene, []).append(body)
    for scene, bodies in by_scene.items():
        solid = solid_components(batch.scenes[batch.scene_idxs.index(scene)].physx_system)
        # A plane supports everything that collides with it, because it pushes bodies up from beneath.
        planes = [each for each in solid if any(faces(shape, each, up) for shape in each.collision_shapes)]
        boxes = _boxes_along(bounding_boxes(solid), up)
        endless = np.array([any(map(is_plane, each.collision_shapes)) for each in solid])
        for body in bodies:
            parts = _parts(body.component)
            if any(can_collide(part, plane) for plane in planes for part in parts):
                continue
            own = np.isin([id(each) for each in solid], [id(part) for part in parts])
            low, high = boxes[own].min(axis=0)[0], boxes[own].max(axis=0)[1]
            below = (boxes[:, 0, :2] <= high[:2]).all(axis=1) & (boxes[:, 1, :2] >= low[:2]).all(axis=1)
            below &= ~own & ~endless & (boxes[:, 0, 2] < high[2])
            under = [solid[number] for number in np.flatnonzero(below).tolist()]
            if not any(can_collide(part, each) for each in [*under, *planes] for part in parts):
                yield Finding(
                    "SC852",
                    (body.entity,),
                    scene,
                    float(low[2]),
                    f"nothing is below `{body.entity}`: it falls forever",
                    "put a body below it, fix it with `body_type: static`, or write `gravity: false`",
                )


def faces(shape: Any, component: Any, up: Floats) -> bool:
    """Returns whether one of the engine's collision shapes is a plane on which bodies can rest, and no wall."""
    if not is_plane(shape):
        return False
    return float((component.entity_pose * shape.local_pose).to_transformation_matrix()[:3, 0] @ up) > _LEVEL


def _boxes_along(boxes: Floats, up: Floats) -> Floats:
    """Returns bounding boxes (N, 2, 3) in a frame whose z is up; larger ones unless up is along an axis."""
    first = np.eye(3)[np.abs(up).argmin()]
    side = np.cross(up, first)
    frame = np.stack([np.cross(side, up), side, up]) / np.array([[np.linalg.norm(side)], [np.linalg.norm(side)], [1]])
    middle, half = boxes.mean(axis=1) @ frame.T, np.ptp(boxes, axis=1) / 2 @ np.abs(frame).T
    return np.stack([middle - half, middle + half], axis=1)


def _parts(component: Any) -> list[Any]:
    """Returns all links of the articulation of a root link; for a body, only itself."""
    articulation = getattr(component, "articulation", None)
    return [component] if articulation is None else list(articulation.links)


def can_collide(one: Any, other: Any) -> bool:
    """Returns whether any shapes of two components collide."""
    return any(
        groups_collide(a.collision_groups, b.collision_groups)
        for a in one.collision_shapes
        for b in other.collision_shapes
    )


def _falls(body: MovingBody) -> bool:
    """Returns whether gravity acts on any part of a body, and any part can be supported."""
    parts = _parts(body.component)
    return not all(part.get_disable_gravity() for part in parts) and any(part.collision_shapes for part in parts)


def violated_constraints(batch: SceneBatch) -> Iterator[Finding]:
    """Yields constraints whose limits are violated at the start. The batch must not have been stepped."""
    for name, scene, excess, text in _constraint_errors(batch):
        message = f"the constraint `{name}` is violated at the start: {text}"
        yield Finding("SC853", (f"constraints/{name}",), scene, excess, message)


def stretched_constraints(batch: SceneBatch, seconds: float) -> Iterator[Finding]:
    """Yields constraints that the solver does not hold. `seconds`: simulated time."""
    connections = {each.name for each in batch.plan.constraints if isinstance(each.joint, Connection)}
    for name, scene, excess, text in _constraint_errors(batch):
        if excess > STRETCHED:
            other = "write `type: ball`, or " if name in connections else "write "
            yield Finding(
                "SC584", (f"constraints/{name}",), scene, excess,
                f"the constraint `{name}` does not hold: {text} after {seconds:g} s",
                f"{other}`solver_position_iterations: 255` on one of its bodies, or use a smaller `timestep`, or more "
                "similar masses",
            )  # fmt: skip


def _constraint_errors(batch: SceneBatch) -> Iterator[tuple[str, int, float, str]]:
    """Yields violated constraints: name, scene, largest error as a multiple of the tolerance, description."""
    for constraint in batch.plan.constraints:
        if constraint.name not in batch.constraints:
            continue
        built = batch.constraints[constraint.name]
        row_of = {index: row for row, index in enumerate(constraint.scene_idxs)}
        for index, component in zip(built.scene_idxs, built.objs, strict=True):
            if component.is_enabled and (errors := list(_errors(constraint, row_of[index], component))):
                yield constraint.name, index, *max(errors)


def _errors(constraint: Constraint, row: int, component: Any) -> Iterator[tuple[float, str]]:
    """Yields errors of a constraint, each as a multiple of the tolerance, with a description."""
    joint = constraint.joint
    pose = component.relative_pose
    if isinstance(joint, Connection):
        yield from _find_excess(component.distance, 0.0, 0.0, MAX_CONSTRAINT_ERROR, "its frames are {} apart")
    elif isinstance(joint, Distance) and joint.stiffness is None:
        low, high = map(float, joint.limits.row(row))
        yield from _find_excess(
            component.distance, low, high, MAX_CONSTRAINT_ERROR, f"its frames are {{}} beyond {low:g}…{high:g} m apart"
        )
    elif isinstance(joint, Weld):
        distance = math.hypot(*map(float, pose.p))
        yield from _find_excess(distance, 0.0, 0.0, MAX_CONSTRAINT_ERROR, "its frames are {} apart")
        turn = 2 * math.acos(min(1.0, abs(float(pose.q[0]))))
        yield from _find_excess(
            turn, 0.0, 0.0, MAX_CONSTRAINT_ANGLE, "its frames are rotated by {} relative to each other"
        )
    elif isinstance(joint, Drive):
        twist = 2 * math.atan2(float(pose.q[1]), float(pose.q[0]))
        twist = math.remainder(twist, 2 * math.pi)
        for limit in joint.limits:
            if limit.stiffness is not None:
                continue
            low, high = map(float, limit.limits.row(row))
            if limit.axis == "twist":
                yield from _find_excess(twist, low, high, MAX_CONSTRAINT_ANGLE, "its twist is {} beyond its limits")
            else:
                where = float(pose.p["xyz".index(limit.axis)])
                yield from _find_excess(
                    where, low, high, MAX_CONSTRAINT_ERROR, f"along {limit.axis} it is {{}} beyond its limits"
                )


def _find_excess(value: float, low: float, high: float, tolerance: float, text: str) -> Iterator[tuple[float, str]]:
    excess = max(low - value, value - high)
    if excess > tolerance:
        shown = f"{math.degrees(excess):.3g}°" if tolerance == MAX_CONSTRAINT_ANGLE else length_text(excess)
        yield excess / tolerance, text.format(shown)
