"""Findings about loads that a simulation cannot carry: drives that are too weak or too stiff, joints beyond their
limits, masses that differ too much, and time steps that are too long.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.checks.physics import constrained_entities
from scenecc.plan import ArticulationStructure
from scenecc.simulation.bodies import gravity_of
from scenecc.simulation.bounds import bounding_boxes
from scenecc.simulation.findings import Finding, amount_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.backends.sapien.contacts import Contacts
    from scenecc.plan import Entity, Link
    from scenecc.simulation.bodies import MovingBody

    Positions = list[tuple[str, int, Any, NDArray[np.float64]]]

MASS_RATIO: Final = 1e4
"""Maximum mass ratio at which PhysX's solver keeps two bodies apart or together."""

JUMP: Final = {False: 0.5, True: 0.1}
"""Maximum movement of a joint by its drive in one step: [rad], and [m] for a prismatic joint. PhysX's implicit drives
are stable at any stiffness, but a link does not touch what it passes within one step. ManiSkill's tasks reach 0.39 rad.
"""

BEYOND: Final = {False: np.radians(1), True: 0.002}
"""[rad], [m] Maximum excess of a joint over its limits. Under a robot's load, PhysX allows a tenth of that."""

_TIMESTEP: Final = 0.01


def weak_drives(batch: SceneBatch) -> Iterator[Finding]:
    """Yields drives of fixed robots that are weaker than gravity at the start. The batch must not have been stepped."""
    constrained = constrained_entities(batch.plan)
    there = set(batch.scene_idxs)
    for entity in batch.plan.entities:
        if not isinstance(entity.structures[0], ArticulationStructure) or entity.name in constrained:
            continue
        for row, index in enumerate(entity.scene_idxs):
            if index in there:
                yield from _weak_drives(batch, entity, row, index)


def _weak_drives(batch: SceneBatch, entity: Entity, row: int, index: int) -> Iterator[Finding]:
    structure = entity.structure(row)
    assert isinstance(structure, ArticulationStructure)
    if not structure.fix_root_link:
        return  # it falls as a whole, or stands on its feet
    built = batch.articulations[entity.name]
    at = built.scene_idxs.index(index)
    links = [built.links[link.name][at] for link in structure.links]
    coupled = {name for mimic in structure.mimics for name in (mimic.joint, mimic.source)}
    weights = np.array([link.mass * (not link.disable_gravity) for link in links])
    centres = np.array([(link.entity_pose * link.cmass_local_pose).p for link in links], np.float64)
    pull = gravity_of(batch.plan)
    carried = [{number} for number in range(len(links))]
    for number in range(len(links) - 1, 0, -1):
        parent = structure.links[number].parent
        assert parent is not None
        carried[parent] |= carried[number]
    for number, link in enumerate(structure.links):
        joint = link.joint
        if joint is None or joint.type == "fixed" or joint.stiffness is None or joint.name in coupled:
            continue
        engine: Any = links[number].joint
        below = sorted(carried[number])
        if not engine.stiffness:
            weight = float(weights[below].sum() * np.linalg.norm(pull))
            yield from _slow_drive(entity.name, link, engine, weight, index)
            continue
        frame = links[number].entity_pose * engine.pose_in_child
        axis = frame.to_transformation_matrix()[:3, 0].astype(np.float64)
        forces = weights[below, None] * pull
        if joint.type != "prismatic":
            forces = np.cross(centres[below] - frame.p, forces)
        load, limit = abs(float((forces @ axis).sum())), float(engine.force_limit)
        if 0 < limit < load:
            unit = "N" if joint.type == "prismatic" else "N·m"
            yield Finding(
                "SC538", (f"{entity.name}/{link.name}",), index, load - limit,
                f"the drive of joint `{joint.name}` of `{entity.name}` is too weak: gravity pulls with "
                f"{load:.3g} {unit}, but its force limit is {limit:.3g} {unit}",
                "raise `force_limit`, or write `gravity: false` for the links",
            )  # fmt: skip


def _slow_drive(entity: str, link: Link, joint: Any, weight: float, index: int) -> Iterator[Finding]:
    """Yields a drive by speed whose joint friction takes a tenth of the speed or more.

    PhysX's friction is a ratio of the load: it takes `friction` · weight from the force damping · (target - speed),
    also for a joint that turns. `weight`: of the links that the joint carries [N].
    """
    target, damping = abs(float(np.ravel(joint.drive_velocity_target)[0])), float(joint.damping)
    friction = float(joint.friction) * weight
    if target and damping and 10 * friction > damping * target:
        speed = max(0.0, target - friction / damping)
        yield Finding(
            "SC581", (f"{entity}/{link.name}",), index, friction,
            f"the friction {float(joint.friction):.3g} of joint `{joint.name}` of `{entity}` slows its drive from "
            f"{target:.3g} to about {speed:.2g}",
            f"write `joints: {{{joint.name}: {{friction: 0}}}}`, or raise the `damping` of the drive",
        )  # fmt: skip


def uneven_scenes(moving: list[MovingBody]) -> set[int]:
    """Returns the scenes in which masses differ by more than `MASS_RATIO`."""
    masses: dict[int, list[float]] = {}
    for body in moving:
        masses.setdefault(body.scene, []).append(float(body.component.mass))
    return {scene for scene, found in masses.items() if max(found) > MASS_RATIO * min(found)}


def mass_ratios(batch: SceneBatch, moving: list[MovingBody], contacts: Contacts) -> Iterator[Finding]:
    """Yields bodies in contact or connected by a constraint whose masses differ by more than `MASS_RATIO`.

    Args:
        batch: a batch after one step.
        moving: its moving bodies. Links are ignored: an articulation keeps its joints for any masses.
        contacts: contacts of the step, at least those of `uneven_scenes`.
    """
    masses = {(body.scene, body.entity): float(body.component.mass) for body in moving if body.entity in batch.entities}
    near = contacts.separation <= 0
    pairs = {*zip(contacts.scene[near].tolist(), contacts.a[near].tolist(), contacts.b[near].tolist(), strict=True)}
    for one in batch.plan.constraints:
        if one.parent is not None:
            pairs |= {(index, one.parent.entity, one.child.entity) for index in one.scene_idxs}
    for index, *names in sorted(pairs):
        if not all((index, name) in masses for name in names):
            continue
        light, heavy = sorted(names, key=lambda name: masses[index, name])
        ratio = masses[index, heavy] / masses[index, light]
        if ratio > MASS_RATIO:
            yield Finding(
                "SC539", (light, heavy), index, ratio,
                f"`{heavy}` has {ratio:.2g} times the mass of `{light}`, which it touches or is connected to",
                "make the masses more similar, or make one of the two static or kinematic",
            )  # fmt: skip


def long_steps(batch: SceneBatch, moving: list[MovingBody]) -> Iterator[Finding]:
    """Yields bodies that fall or fly so far in one step that they may pass through obstacles."""
    physics = batch.plan.physics
    gravity, step = -float(gravity_of(batch.plan)[2]), physics.timestep or _TIMESTEP
    if physics.enable_ccd:
        return
    for scene in batch.scene_idxs:
        bodies = [body for body in moving if body.scene == scene and body.entity in batch.entities]
        system = batch.scenes[batch.scene_idxs.index(scene)].physx_system
        fixed = [each for each in system.get_rigid_static_components() if each.collision_shapes and _is_thick(each)]
        if not bodies or not fixed:
            continue
        boxes = bounding_boxes(fixed)
        for body in bodies:
            if not body.component.collision_shapes:
                continue
            yield from _find_passed_walls(body, fixed, boxes, step)
            if gravity > 0 and not body.component.get_disable_gravity():
                yield from _find_long_step(body, fixed, boxes, gravity, step)


def _find_passed_walls(body: MovingBody, fixed: list[Any], boxes: Any, step: float) -> Iterator[Finding]:
    """Yields bodies that a body may pass through within a second at its initial velocity."""
    velocity = np.array(body.component.get_linear_velocity(), np.float64)
    if not velocity[:2].any():
        return
    low, high = np.array(body.component.get_global_aabb_fast(), np.float64)
    # Times at which it starts and stops overlapping each box along each axis [s].
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([boxes[:, 0] - high, boxes[:, 1] - low]) / velocity
    enters, leaves = np.nanmax(ends.min(axis=0), axis=1), np.nanmin(ends.max(axis=0), axis=1)
    for target in np.flatnonzero((enters > 0) & (enters < 1) & (leaves > enters) & (leaves - enters < step)).tolist():
        speed, name = float(np.linalg.norm(velocity)), fixed[target].entity.name
        yield Finding(
            "SC540", (body.entity, name), body.scene, step / float(leaves[target] - enters[target]),
            f"`{body.entity}` may pass through `{name}`: it moves at {speed:.3g} m/s, {speed * step:.3g} m per step",
            "lower `timestep`, write `enable_ccd: true` under `physics`, or make the obstacle thicker",
        )  # fmt: skip
        return


def _is_thick(component: Any) -> bool:
    """Returns whether all shapes of a component are finite solids."""
    thin = {"PhysxCollisionShapePlane", "PhysxCollisionShapeTriangleMesh"}
    return all(type(shape).__name__ not in thin for shape in component.collision_shapes)


def _find_long_step(body: MovingBody, fixed: list[Any], boxes: Any, gravity: float, step: float) -> Iterator[Finding]:
    low, high = np.array(body.component.get_global_aabb_fast(), np.float64)
    below = (boxes[:, 0, :2] <= high[:2]).all(axis=1) & (boxes[:, 1, :2] >= low[:2]).all(axis=1)
    below &= boxes[:, 1, 2] <= low[2]
    if not below.any():
        return
    target = int(np.flatnonzero(below)[boxes[below, 1, 2].argmax()])
    start = min(float(body.component.get_linear_velocity()[2]), 0.0)
    speed = (start**2 + 2 * gravity * float(low[2] - boxes[target, 1, 2])) ** 0.5
    offset = sum(each.collision_shapes[0].contact_offset for each in (body.component, fixed[target]))
    thickness = float(np.ptp(boxes[target, :, 2]))
    room = float(high[2] - low[2]) + thickness + offset
    if speed * step > room:
        name = fixed[target].entity.name
        yield Finding(
            "SC540", (body.entity,), body.scene, speed * step / room,
            f"`{body.entity}` may fall through `{name}`, which is {thickness:.3g} m thick: it arrives at "
            f"{speed:.3g} m/s, {speed * step:.3g} m per step",
            "lower `timestep`, write `enable_ccd: true` under `physics`, or make the body below thicker",
        )  # fmt: skip


def joint_positions(batch: SceneBatch) -> Positions:
    """Returns for each articulation: entity, scene index, `PhysxArticulation` and its `qpos` (dof,) [rad] or [m]."""
    return [
        (name, index, obj, np.array(obj.get_qpos(), np.float64))
        for name, built in batch.articulations.items()
        for index, obj in zip(built.scene_idxs, built.objs, strict=True)
    ]


def jumps(before: Positions, timestep: float) -> Iterator[Finding]:
    """Yields drives that move their joints too far in one step.

    Args:
        before: positions before the last step.
        timestep: length of the step [s].
    """
    for entity, scene, obj, start in before:
        moved = np.abs(np.array(obj.get_qpos(), np.float64) - start)
        for joint, link, way in zip(obj.get_active_joints(), _children(obj), moved.tolist(), strict=True):
            slides = joint.type == "prismatic"
            if joint.stiffness and way > JUMP[slides]:
                yield Finding(
                    "SC864", (f"{entity}/{link}",), scene, way / JUMP[slides],
                    f"the drive of joint `{joint.name}` of `{entity}` is too stiff for a time step of {timestep:g} s: "
                    f"it moves {amount_text(way, slides=slides)} in the first step",
                    "start at the target, lower `stiffness`, or set `force_limit` or `max_velocity`",
                )  # fmt: skip


def beyond_limits(batch: SceneBatch, seconds: float) -> Iterator[Finding]:
    """Yields joints beyond their limits after a simulation of `seconds` [s]."""
    for entity, scene, obj, end in joint_positions(batch):
        low, high = np.array(obj.get_qlimits(), np.float64).reshape(-1, 2).T
        excess = np.maximum(low - end, end - high)
        for joint, link, way in zip(obj.get_active_joints(), _children(obj), excess.tolist(), strict=True):
            slides = joint.type == "prismatic"
            if way > BEYOND[slides]:
                yield Finding(
                    "SC865", (f"{entity}/{link}",), scene, way / BEYOND[slides],
                    f"joint `{joint.name}` of `{entity}` is {amount_text(way, slides=slides)} beyond its limits after "
                    f"{seconds:g} s",
                    "a force is stronger than the limit: look for an overlap, a constraint, or unequal masses",
                )  # fmt: skip


def _children(articulation: Any) -> list[str]:
    """Returns the names of the links that its joints move, in the order of `qpos`."""
    return [joint.child_link.name for joint in articulation.get_active_joints()]
