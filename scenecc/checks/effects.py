"""What is built and has no effect: drives that pull nothing, bodies that nothing meets, scenes without a body.

`scenecc check` asks these rules; `validate` does not. They take a plan whose draws are made, and judge all its scenes.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.checks.physics import (
    plan_origin,
    structure_origin,
)
from scenecc.checks.plausibility import scene_bodies
from scenecc.diagnostics.messages import cut, index_ranges
from scenecc.plan import ArticulationStructure, BodyStructure, Drive
from scenecc.plan.body import DEFAULT_COLLISION_GROUPS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import RelatedPlace
    from scenecc.plan import Entity, ScenePlan, Value
    from scenecc.plan.articulation import Joint
    from scenecc.plan.constraint import AxisDrive


def check_effects(plan: ScenePlan, sink: Sink) -> None:
    """Applies every rule of this module.

    Args:
        plan: with its draws made.
        sink: takes the findings.
    """
    for rule in PLAN_RULES:
        rule(plan, sink)


def _check_empty_scenes(plan: ScenePlan, sink: Sink) -> None:
    empty = set(range(plan.num_scenes)).difference(*(entity.scene_idxs for entity in plan.entities))
    if empty:
        some = f"no body is in scene {index_ranges(sorted(empty))}"
        message = "no scene has a body" if len(empty) == plan.num_scenes else some
        place = plan_origin(plan).child("entities")
        sink.report("SC543", message, place, at="key", hint="write `entities`, or give an entity these `scene_idxs`")


def _check_names(plan: ScenePlan, sink: Sink) -> None:
    first: dict[str, Entity] = {}
    for entity in plan.entities:
        other = first.setdefault(entity.name.casefold(), entity)
        if other is not entity:
            places = [structure_origin(one.structures[0], one, plan) for one in (entity, other)]
            sink.report(
                "SC547",
                f"`{cut(entity.name)}` and `{cut(other.name)}` differ in case alone",
                places[0],
                at="key",
                hint="give one of them another name",
                related=[(f"`{cut(other.name)}` is here", places[1], "key")],
            )


def _check_drives(plan: ScenePlan, sink: Sink) -> None:
    for entity in plan.entities:
        for structure in entity.structures:
            for joint in structure.active_joints if isinstance(structure, ArticulationStructure) else ():
                why = _why_no_pull(joint) if _is_driven(joint) else None
                if why is not None:
                    place = structure_origin(structure, entity, plan).child("drives", joint.name)
                    message = f"the drive of joint `{cut(joint.name)}` does nothing: {why}"
                    sink.report("SC537", message, place, at="key", hint=_DRIVE_HINT)
    for constraint in plan.constraints:
        for drive in constraint.joint.drives if isinstance(constraint.joint, Drive) else ():
            why = _why_no_pull(drive)
            if why is not None:
                place = constraint.origin or plan_origin(plan).child("constraints", constraint.name)
                message = f"the drive of `{drive.axis}` does nothing: {why}"
                sink.report("SC537", message, place.child("drive", drive.axis), at="key", hint=_DRIVE_HINT)


_DRIVE_HINT: Final = "give it a stiffness or a damping, and a force limit above 0; or leave it out"


def _is_driven(joint: Joint) -> bool:
    """Whether the drive of a joint is meant to pull: a stiffness and damping of 0 alone say that it is passive."""
    return any(map(_any, (joint.stiffness, joint.damping, joint.drive_velocity_target)))


def _why_no_pull(drive: Joint | AxisDrive) -> str | None:
    """Why a drive has no force in any scene; None where it has one."""
    if not _any(drive.stiffness) and not _any(drive.damping):
        return "its stiffness and its damping are 0"
    return "its force limit is 0" if drive.force_limit is not None and not _any(drive.force_limit) else None


def _any(value: Value | None) -> bool:
    return value is not None and bool(value.data.any())


def _check_locks(plan: ScenePlan, sink: Sink) -> None:
    for name, body, origin, _ in scene_bodies(plan):
        if body.locked_motion_axes is not None and bool(body.locked_motion_axes.data.all()):
            message = f"all six axes of `{cut(name)}` are locked: it is dynamic and never moves"
            hint = "use `body_type: static` or `kinematic`"
            sink.report("SC545", message, origin.child("locked_axes"), at="key", hint=hint)


def _check_collision_bits(plan: ScenePlan, sink: Sink) -> None:
    """Bodies whose collision bits no other entity has. Those that ignore one another by the last two are meant to."""
    by_entity = {entity.name: _collision_bits(entity.bodies) for entity in plan.entities}
    colliding = Counter(bits for bits in by_entity.values() if bits != (0, 0))
    if colliding.total() < 2:
        return
    for name, body, origin, entity in scene_bodies(plan):
        first, second = _collision_bits((body,))
        # Bits of 0 are meant: such a body meets nothing.
        if (first, second) == (0, 0) or all(groups is None for groups in body.shape_groups()):
            continue
        others = colliding - Counter([by_entity[entity.name]])
        if others and not any(first & second_of | second & first_of for first_of, second_of in others):
            message = f"`{cut(name)}` collides with nothing: no other body answers its collision bits"
            hint = "two shapes collide if bits of the first number of one are in the second of the other"
            sink.report("SC544", message, origin.child("collision_bits"), at="key", hint=hint)


def _collision_bits(bodies: Iterable[BodyStructure]) -> tuple[int, int]:
    """The first two of SAPIEN's integers, the bits of all shapes together."""
    first = second = 0
    for body in bodies:
        for groups in body.shape_groups() if body.body_type != "none" else ():
            rows = [DEFAULT_COLLISION_GROUPS] if groups is None else groups.data.astype(int).tolist()
            for row in rows:
                first, second = first | row[0], second | row[1]
    return first, second


def _check_copies(plan: ScenePlan, sink: Sink) -> None:
    """Static bodies of one kind in one place. Others are moved, or their overlap is found."""
    kinds: dict[object, list[Entity]] = {}
    for entity in plan.entities:
        structure = entity.structures[0]
        if isinstance(structure, BodyStructure) and structure.body_type == "static" and entity.pick is None:
            kinds.setdefault(structure, []).append(entity)
    for alike in kinds.values():
        if len(alike) < 2:
            continue
        rows = [np.broadcast_to(entity.pose.data, (len(entity.scene_idxs), 7)) for entity in alike]
        scenes = [np.array(entity.scene_idxs)[:, None] for entity in alike]
        table = np.hstack([np.concatenate(scenes), np.concatenate(rows).round(6)])
        _, first, group = np.unique(table, axis=0, return_index=True, return_inverse=True)
        owner = np.repeat(np.arange(len(alike)), [len(each) for each in rows])
        pairs = {(int(a), int(b)) for a, b in zip(owner, owner[first[group.reshape(-1)]], strict=True) if a != b}
        for a, b in sorted(pairs):
            places = [structure_origin(alike[one].structures[0], alike[one], plan) for one in (a, b)]
            message = f"`{cut(alike[a].name)}` is a copy of `{cut(alike[b].name)}` in the same place"
            related: list[RelatedPlace] = [(f"`{cut(alike[b].name)}` is here", places[1], "key")]
            sink.report("SC546", message, places[0], at="key", hint="move one of them, or remove it", related=related)


def _check_visible(plan: ScenePlan, sink: Sink) -> None:
    """Bodies that move and that no camera can show, in a scene that has cameras."""
    for name, body, origin, entity in scene_bodies(plan) if plan.cameras else ():
        if body.body_type == "dynamic" and body.collisions and not body.visuals and not entity.hidden:
            hint = "use `shapes` instead of `collisions`, or add `visuals`"
            sink.report("SC542", f"no camera shows `{cut(name)}`: it has nothing visible", origin, at="key", hint=hint)


def _check_spacing(plan: ScenePlan, sink: Sink) -> None:
    spacing = plan.physics.scene_spacing
    if spacing is None or plan.num_scenes < 2:
        return
    far, name = max(((float(np.abs(one.pose.data[:, :2]).max()), one.name) for one in plan.entities), default=(0.0, ""))
    if far > spacing / 2:
        place = (plan.physics.origin or plan_origin(plan).child("physics")).child("scene_spacing")
        message = f"scenes stand {spacing:g} m apart, and `{cut(name)}` is {far:.3g} m from the middle of its own"
        sink.report("SC541", message, place, hint=f"make it {2 * far:.2g} or more: neighbours on a GPU cost time")


PLAN_RULES: Final[tuple[Callable[[ScenePlan, Sink], None], ...]] = (
    _check_empty_scenes,
    _check_names,
    _check_drives,
    _check_locks,
    _check_collision_bits,
    _check_copies,
    _check_visible,
    _check_spacing,
)
