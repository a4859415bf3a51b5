"""Checks for objects without an effect: drives without force, bodies that collide with nothing, scenes without a body.

Only `scenecc check` applies these rules. They need a plan with its draws, and check all its scenes.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.checks.boxes import local_box
from scenecc.checks.mass import DYNAMIC_TYPES
from scenecc.checks.physics import (
    named_bodies,
    plan_origin,
    structure_origin,
)
from scenecc.checks.plausibility import scene_bodies
from scenecc.checks.value_queries import list_alternatives
from scenecc.diagnostics.diagnostic import Origin
from scenecc.diagnostics.messages import cut, index_ranges
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan import ArticulationStructure, BodyStructure, Drive
from scenecc.plan.articulation import Joint
from scenecc.plan.body import DEFAULT_COLLISION_GROUPS
from scenecc.spec.nodes import is_mapping

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from scenecc.checks.boxes import Box
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import RelatedPlace
    from scenecc.plan import CollisionShape, Entity, ScenePlan, Value, VisualMaterial, VisualShape
    from scenecc.plan.constraint import AxisDrive
    from scenecc.source import Document

ALIKE: Final = 0.8
"""Minimum share of two boxes around shapes that are probably the same."""

MAX_COMPARED: Final = 64
"""Maximum number of shapes of a body that are compared with each other."""


def check_effects(plan: ScenePlan, sink: Sink) -> None:
    """Applies every rule of this module.

    Args:
        plan: a plan with its draws.
        sink: collects diagnostics.
    """
    for rule in PLAN_RULES:
        rule(plan, sink)


def _check_empty_scenes(plan: ScenePlan, sink: Sink) -> None:
    empty = set(range(plan.num_scenes)).difference(*(entity.scene_idxs for entity in plan.entities))
    if empty:
        some = f"there is no body in scene {index_ranges(sorted(empty))}"
        message = "no scene has a body" if len(empty) == plan.num_scenes else some
        place = plan_origin(plan).child("entities")
        sink.report("SC543", message, place, at="key", hint="write `entities`, or give an entity these `scene_idxs`")


def check_declared_names(document: Document, sink: Sink) -> None:
    """Reports names in a file's own sections that differ only in case; a plan does not contain these.

    Args:
        document: the scene file, as written.
        sink: collects diagnostics.
    """
    for section in ("params", "draws", "materials", "collision_groups", "frames"):
        declared = document.data.get(section)
        if is_mapping(declared):
            _report_alike([(str(name), Origin(document.name, (section, name))) for name in declared], sink)


def _check_names(plan: ScenePlan, sink: Sink) -> None:
    """Reports names of one kind that differ only in case. Entities and cameras share their names."""
    around = plan_origin(plan)
    sections: dict[str, tuple[Any, ...]] = {
        "cameras": plan.cameras, "lights": plan.lights, "constraints": plan.constraints
    }  # fmt: skip
    kinds = {
        section: [(one.name, one.origin or around.child(section, one.name)) for one in each]
        for section, each in sections.items()
    }
    kinds["cameras"] += [(one.name, structure_origin(one.structures[0], one, plan)) for one in plan.entities]
    for kind in kinds.values():
        _report_alike(kind, sink)
    for entity in plan.entities:
        for structure in entity.structures:
            if isinstance(structure, ArticulationStructure) and structure.file is None:
                own = [link for link in structure.links if link.file is None]
                places = [structure_origin(link.body, entity, plan) for link in own]
                _report_alike([(link.name, place) for link, place in zip(own, places, strict=True)], sink)
                joints = zip((link.joint for link in own), places, strict=True)
                _report_alike(
                    [(joint.name, place.child("joint")) for joint, place in joints if joint is not None], sink
                )


def _report_alike(named: Iterable[tuple[str, Origin]], sink: Sink) -> None:
    """Reports (name, place) pairs whose name differs from an earlier one only in case."""
    first: dict[str, tuple[str, Origin]] = {}
    for name, place in named:
        other, there = first.setdefault(name.casefold(), (name, place))
        if other != name:
            message = f"`{cut(name)}` and `{cut(other)}` differ only in case"
            here: list[RelatedPlace] = [(f"`{cut(other)}` is here", there, "key")]
            sink.report("SC547", message, place, at="key", hint="give one of them another name", related=here)


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


_DRIVE_HINT: Final = "give it a stiffness or damping, and a force limit above 0; or remove it"


def _is_driven(joint: Joint) -> bool:
    """Returns whether a joint's drive is intended: a stiffness and damping of 0 mean a passive joint."""
    return any(map(_is_nonzero, (joint.stiffness, joint.damping, joint.drive_velocity_target)))


def _why_no_pull(drive: Joint | AxisDrive) -> str | None:
    """Returns why a drive has no force in any scene; None if it has one."""
    stiff, damped = _is_nonzero(drive.stiffness), _is_nonzero(drive.damping)
    if not stiff and not damped:
        return "its stiffness and its damping are 0"
    if isinstance(drive, Joint) and not damped and _is_nonzero(drive.drive_velocity_target):
        return "it has a velocity target, but its damping is 0"
    return "its force limit is 0" if drive.force_limit is not None and not _is_nonzero(drive.force_limit) else None


def _is_nonzero(value: Value | None) -> bool:
    return value is not None and bool(value.data.any())


def _check_locks(plan: ScenePlan, sink: Sink) -> None:
    """Reports dynamic bodies that cannot move, and joints whose limits leave no range."""
    for name, body, origin, _ in scene_bodies(plan):
        if body.locked_motion_axes is not None and bool(body.locked_motion_axes.data.all()):
            message = f"`{cut(name)}` is dynamic but cannot move: all six axes are locked"
            hint = "use `body_type: static` or `kinematic`"
            sink.report("SC545", message, origin.child("locked_axes"), at="key", hint=hint)
    for entity in plan.entities:
        for structure in entity.structures:
            # The author of a scene cannot change the limits in a robot file.
            if not isinstance(structure, ArticulationStructure) or structure.file is not None:
                continue
            for link in structure.links:
                joint = link.joint if link.file is None else None
                limits = None if joint is None else joint.limits
                if joint is not None and limits is not None and (limits.data[:, 0] == limits.data[:, 1]).all():
                    message = f"joint `{cut(joint.name)}` cannot move: both of its limits are {limits.data[0, 0]:g}"
                    place = structure_origin(link.body, entity, plan).child("joint")
                    sink.report("SC545", message, place, at="key", hint="use `type: fixed`, or widen the limits")


def _check_collision_bits(plan: ScenePlan, sink: Sink) -> None:
    """Reports bodies whose collision bits match no other entity, unless the last two numbers make them ignore each
    other.
    """
    by_entity = {entity.name: _collision_bits(entity.bodies) for entity in plan.entities}
    colliding = Counter(bits for bits in by_entity.values() if bits != (0, 0))
    if colliding.total() < 2:
        return
    for name, body, origin, entity in scene_bodies(plan):
        first, second = _collision_bits((body,))
        # Bits of 0 are intended: the body collides with nothing.
        if (first, second) == (0, 0) or all(groups is None for groups in body.shape_groups()):
            continue
        others = colliding - Counter([by_entity[entity.name]])
        if others and not any(first & second_of | second & first_of for first_of, second_of in others):
            message = f"`{cut(name)}` collides with nothing: no other body has matching collision bits"
            hint = "two shapes collide if the first number of one shares a bit with the second number of the other"
            sink.report("SC544", message, origin.child("collision_bits"), at="key", hint=hint)


def _check_weights(plan: ScenePlan, sink: Sink) -> None:
    """Reports shapes that collide with nothing, beside others that do, and whose default density counts."""
    for name, body, origin, _ in scene_bodies(plan):
        if body.body_type not in DYNAMIC_TYPES or body.mass is not None or body.inertial is not None:
            continue
        idle = [groups is not None and not groups.data[:, :2].any() for groups in body.shape_groups()]
        for shape, is_idle in zip(body.collisions, idle, strict=True):
            if is_idle and shape.density is None and not all(idle):
                message = f"this shape of `{cut(name)}` collides with nothing, but its density counts"
                hint = "move it to `visuals`, or write its `density`: 0 for no mass"
                sink.report("SC589", message, shape.origin or origin, hint=hint)


def _collision_bits(bodies: Iterable[BodyStructure]) -> tuple[int, int]:
    """Returns the first two collision group integers, with the bits of all shapes combined."""
    first = second = 0
    for body in bodies:
        for groups in body.shape_groups() if body.body_type != "none" else ():
            rows = [DEFAULT_COLLISION_GROUPS] if groups is None else groups.data.astype(int).tolist()
            for row in rows:
                first, second = first | row[0], second | row[1]
    return first, second


def _check_copies(plan: ScenePlan, sink: Sink) -> None:
    """Reports bodies of one kind in one place that never move apart. Other checks report overlaps of dynamic ones."""
    kinds: dict[object, list[Entity]] = {}
    for entity in plan.entities:
        structure = entity.structures[0]
        if not isinstance(structure, BodyStructure) or entity.pick is not None:
            continue
        solid = tuple(map(_solid, structure.collisions))
        if structure.body_type == "static" or (structure.body_type == "kinematic" and solid):
            kinds.setdefault((structure.body_type, solid or structure), []).append(entity)
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


def _check_shape_copies(plan: ScenePlan, sink: Sink) -> None:
    """Reports collision shapes that a body has twice in one place, or nearly so: their mass counts twice.

    Of a body of a robot's file, only equal shapes are reported, and only where masses come from the shapes.
    """
    for entity in plan.entities:
        for structure in entity.structures:
            for name, body, described in named_bodies(structure, entity.name):
                if described and body.inertial is None and body.mass is None:
                    hint = "its mass counts twice: remove one of the two, or give the mass"
                    origin = structure_origin(body, entity, plan)
                    _report_repeated_shapes(name, body, origin, hint, sink)
    for name, body, origin, _ in scene_bodies(plan):
        hint = "`shapes` collide too: move one of them, or remove it"
        repeated = _report_repeated_shapes(name, body, origin, hint, sink)
        boxes: list[Box] = []
        for number, shape in enumerate(body.collisions if len(body.collisions) <= MAX_COMPARED else ()):
            box = _own_box(shape, plan)
            if box is None:
                continue
            if number not in repeated and any(_share(box, other) > ALIKE for other in boxes):
                message = f"`{cut(name)}` has another collision shape that fills the same space as this one"
                hint = "its mass counts twice: `shapes` collide too, so remove one of the two"
                sink.report("SC546", message, shape.origin or origin, hint=hint)
            boxes.append(box)


def _report_repeated_shapes(name: str, body: BodyStructure, origin: Origin, hint: str, sink: Sink) -> set[int]:
    """Reports collision shapes that are equal to an earlier one, and returns their indices."""
    first: dict[object, int] = {}
    repeated = {n for n, shape in enumerate(body.collisions) if first.setdefault(_solid(shape), n) != n}
    for number in sorted(repeated):
        message = f"`{cut(name)}` has this collision shape twice in the same place"
        sink.report("SC546", message, body.collisions[number].origin or origin, hint=hint)
    return repeated


def _own_box(shape: CollisionShape, plan: ScenePlan) -> Box | None:
    try:
        return local_box(shape, 0, plan)
    except AssetError:
        return None  # the build reports that the file changed


def _share(one: Box, other: Box) -> float:
    """Returns the volume that two boxes share, relative to their union."""
    both = np.minimum(one[1], other[1]) - np.maximum(one[0], other[0])
    shared = float(np.maximum(both, 0).prod())
    whole = float((one[1] - one[0]).prod() + (other[1] - other[0]).prod()) - shared
    return shared / whole if whole > 0 else 0.0


def _solid(shape: CollisionShape) -> object:
    """Returns a key that is equal for collision shapes that fill the same space of their bodies."""
    pose = shape.pose
    return shape.geometry, None if pose is None or (pose.data == IDENTITY_POSE).all() else pose


_MEANT_TO_BE_VISIBLE: Final = frozenset(("dynamic", "kinematic", "static"))
"""Types of bodies that are visible, unless a scene without cameras leaves it open."""


def _check_visible(plan: ScenePlan, sink: Sink) -> None:
    """Reports colliding bodies that no camera can show. Without cameras, only free bodies are meant to be seen."""
    for name, body, origin, entity in scene_bodies(plan):
        if not body.collisions or entity.hidden or not (plan.cameras or body.body_type in _MEANT_TO_BE_VISIBLE):
            continue
        if not body.visuals:
            hint = "use `shapes` instead of `collisions`, or add `visuals`"
            sink.report("SC542", f"no camera shows `{cut(name)}`: it has nothing visible", origin, at="key", hint=hint)
        elif body.visibility is not None and not body.visibility.data.any():
            message = f"no camera shows `{cut(name)}`: its `visibility` is 0"
            sink.report("SC542", message, origin.child("visibility"), hint="1 is fully visible")
        elif all(_is_clear(shape, plan) for shape in body.visuals):
            message = f"no camera shows `{cut(name)}`: the fourth number of its colour is 0"
            sink.report("SC542", message, origin, at="key", hint="it is the opacity: 1 is opaque")


def _is_clear(shape: VisualShape, plan: ScenePlan) -> bool:
    """Returns whether a visual shape is fully transparent in every scene."""
    if shape.material is None:
        return False
    for index in shape.material.data.ravel():
        material: VisualMaterial = plan.visual_materials[int(index)]
        color = material.base_color if material.base_color_texture is None else None
        if color is None or color.data[:, 3].any():
            return False
    return True


def _check_variants(plan: ScenePlan, sink: Sink) -> None:
    """Reports variants that no scene uses, for any draw, in any copy of the entity."""
    used: set[object] = set()
    unused: dict[object, tuple[str, Origin]] = {}
    for entity in plan.entities:
        possible = None if entity.pick is None else list_alternatives(entity.pick)
        if possible is None:
            continue
        picked = {int(number) for (number,) in possible}
        for number, structure in enumerate(entity.structures):
            place = structure_origin(structure, entity, plan)
            written = place if sink.trace is None else sink.trace(place)
            # A `pick` of a single number may come from a parameter.
            if number in picked or len(picked) == 1:
                used.add((written.file, written.path))
            else:
                message = f"no scene uses variant {number} of `{cut(entity.name)}`"
                unused.setdefault((written.file, written.path), (message, place))
    for written, (message, place) in unused.items():
        if written not in used:
            sink.report("SC571", message, place, hint="give `pick` its number, too, or remove it")


PLAN_RULES: Final[tuple[Callable[[ScenePlan, Sink], None], ...]] = (
    _check_empty_scenes,
    _check_names,
    _check_drives,
    _check_locks,
    _check_collision_bits,
    _check_weights,
    _check_copies,
    _check_shape_copies,
    _check_visible,
    _check_variants,
)
