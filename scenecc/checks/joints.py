"""Rules of articulations and constraints that SAPIEN and PhysX do not enforce."""

from __future__ import annotations

from math import ceil, degrees, hypot, isfinite, pi
from typing import TYPE_CHECKING, Literal

from scenecc.checks.value_queries import (
    Row,
    find_reversed_limits,
    find_single_fault,
    highest,
    is_bounded,
    lowest,
    report_fault,
)
from scenecc.diagnostics.diagnostic import Origin
from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.plan import ArticulationStructure, Distance, Drive, Gear
from scenecc.plan.articulation import MAX_LINKS, why_no_tendon
from scenecc.plan.mimics import inexact_mimics, list_mimics

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.plan import Constraint, Entity, ScenePlan, Value
    from scenecc.plan.articulation import Joint, Mimic
    from scenecc.plan.body import Mount


_MAX_JOINT_DISTANCE = 1e6
"""Maximum distance of a joint from its links [m]. Beyond it, a simulation counts as diverged (SC820)."""


def apply_joint_rules(structure: ArticulationStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Applies every rule to an articulation.

    Args:
        structure: the articulation.
        name: name of the entity.
        origin: origin of the entity.
        sink: collects diagnostics.
    """
    for link in structure.links:
        if link.joint is not None:
            _check_joint_limits(link.joint, origin, sink)
            _check_joint_distance(link.joint, origin, sink)
    _check_link_count(structure, name, origin, sink)
    _check_names(structure, origin, sink)
    _check_mimics(structure, origin, sink)
    _check_tendons(structure, name, origin, sink)
    _check_masses(structure, name, origin, sink)
    _check_speeds(structure, name, origin, sink)


def _format_joint(joint: Joint) -> str:
    return f"the joint `{cut(joint.name)}`" if joint.name else "the joint"


def _check_joint_limits(joint: Joint, origin: Origin, sink: Sink) -> None:
    found = joint.limits and find_reversed_limits(joint.limits, _find_reversed)
    if found is not None:
        low, high = found.found
        message = f"the lower limit of {_format_joint(joint)}, {low:g}, is above its upper limit, {high:g}"
        place = joint.limits_origin or joint.origin or origin
        at: Literal["key", "value"] = "key" if joint.limits_origin is None else "value"
        key = str(place.path[-1]) if place.path[-1:] == ("limits_deg",) else "limits"
        ends = [f"{degrees(one) if key == 'limits_deg' else one:.10g}" for one in (high, low)]
        report_fault(sink, "SC520", message, place, f"write `{key}: [{', '.join(ends)}]`", found.sample, at=at)


def _find_reversed(limits: Row) -> Row | None:
    return limits if limits[0] > limits[1] else None


def _check_joint_distance(joint: Joint, origin: Origin, sink: Sink) -> None:
    def find_distance_fault(pose: Row) -> float | None:
        far = max(map(abs, pose[:3]))
        return far if far > _MAX_JOINT_DISTANCE else None

    for place in (joint.pose_in_parent, joint.pose_in_child):
        found = place and find_single_fault(place, find_distance_fault)
        if found is not None:
            far = f"{found.found:.3g} m from one of its links; the maximum is {_MAX_JOINT_DISTANCE:g} m"
            hint = "fix the coordinates: they are in metres"
            report_fault(sink, "SC512", f"{_format_joint(joint)} is {far}", joint.origin or origin, hint, found.sample)
            return


def _check_speeds(structure: ArticulationStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Warns of a motion at the start, or a target speed, above the maximum of its link."""
    root, starts = structure.links[0], f"`{cut(name)}` starts"
    motions = [
        (root, _LINEAR, "linear_velocity", starts, structure.linear_velocity),
        (root, _ANGULAR, "angular_velocity", starts, structure.angular_velocity),
    ]
    for link in structure.links:
        if (joint := link.joint) is not None:
            kind, words = _LINEAR if joint.type == "prismatic" else _ANGULAR, _format_joint(joint)
            motions.append((link, kind, "qvel", f"{words} starts", joint.qvel))
            motions.append((link, kind, "drives", f"{words} is driven", joint.drive_velocity_target))
    for link, (field, default, unit), key, words, value in motions:
        limit = getattr(link.body, field)
        most = default if limit is None else highest(limit)[0]

        def find_fault(row: Row, most: float = most) -> float | None:
            return hypot(*row) if is_bounded(row) and hypot(*row) > most else None

        found = None if value is None else find_single_fault(value, find_fault)
        if value is not None and found is not None:
            message = f"{words} with {found.found:.4g} {unit}, but SAPIEN limits `{cut(link.name)}` to {most:g}"
            enough = ceil(max(found.found, _greatest(value)))
            hint = f"write `{field}: {enough}` for this link, and for those that it carries"
            report_fault(sink, "SC567", message, origin.child(key), hint, found.sample, at="key")


def _greatest(value: Value) -> float:
    """Returns a length that no row exceeds; 0 if there is none."""
    low, high = lowest(value), highest(value)
    return hypot(*map(max, map(abs, low), map(abs, high))) if is_bounded((*low, *high)) else 0.0


_SpeedLimit = tuple[str, float, str]
"""Key, SAPIEN's default and unit of the maximum speed of a link."""

_LINEAR: _SpeedLimit = ("max_linear_velocity", 10.0, "m/s")
_ANGULAR: _SpeedLimit = ("max_angular_velocity", 50.0, "rad/s")


def _check_link_count(structure: ArticulationStructure, name: str, origin: Origin, sink: Sink) -> None:
    count = len(structure.links)
    if count > MAX_LINKS:
        message = f"`{name}` has {count} links; PhysX allows {MAX_LINKS} per articulation"
        sink.report("SC519", message, origin, at="key", hint="merge links that are fixed to each other")


def _check_names(structure: ArticulationStructure, origin: Origin, sink: Sink) -> None:
    names: dict[tuple[str, str], Origin] = {}
    for link in structure.links:
        _check_unique_name("link", link.name, link.body.origin or origin, names, sink)
        if link.joint is not None and link.joint.name:
            _check_unique_name("joint", link.joint.name, link.joint.origin or origin, names, sink)


def _check_unique_name(what: str, name: str, place: Origin, names: dict[tuple[str, str], Origin], sink: Sink) -> None:
    first = names.setdefault((what, name), place)
    if first is not place:
        related = [(f"the first {what} with this name", first, "value")]
        sink.report("SC326", f"two {what}s have the name `{cut(name)}`", place, related=related)  # pyright: ignore[reportArgumentType]


def _check_mimics(structure: ArticulationStructure, origin: Origin, sink: Sink) -> None:
    joints = {link.joint.name for link in structure.links if link.joint is not None}
    follows = {mimic.joint: mimic.source for mimic in structure.mimics}
    for mimic in structure.mimics:
        place = mimic.origin or origin
        if mimic.source not in joints:
            message = f"`{cut(mimic.joint)}` mimics `{cut(mimic.source)}`, which does not exist"
            hint = suggest_name(mimic.source, sorted(joint for joint in joints if joint), sink)
            sink.report("SC521", message, place, hint=hint)
            continue
        why = _mimic_obstacle(mimic, structure, follows)
        if why is not None:
            message = f"`{cut(mimic.joint)}` cannot mimic `{cut(mimic.source)}`: {why}"
            sink.report("SC521", message, place, hint="remove `mimic`, and drive both joints")


def _check_tendons(structure: ArticulationStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Warns once of mimic joints that a tendon couples inexactly."""
    found = inexact_mimics(structure)
    if found:
        words = f"PhysX couples {list_mimics(found)} inexactly, because their axes differ in direction or kind"
        hint = "remove `mimic`, and drive both joints"
        sink.report("SC578", f"`{cut(name)}`: {words}", found[0].origin or origin, hint=hint)


def _mimic_obstacle(mimic: Mimic, structure: ArticulationStructure, follows: dict[str, str]) -> str | None:
    """Returns why PhysX cannot make one joint mimic another; None if it can."""
    if any(factor == 0 for factor in mimic.multiplier.numbers()):
        return "its multiplier is 0"
    at, visited = mimic.source, {mimic.joint}
    while at in follows:
        if at in visited:
            return "the mimic joints form a cycle"
        visited.add(at)
        at = follows[at]
    return why_no_tendon(structure, mimic)


def _check_masses(structure: ArticulationStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Checks that every moving link, or a link below it, has a mass."""
    links = structure.links
    weighs = [bool(link.body.collisions) or link.body.inertial is not None for link in links]
    for number in range(len(links) - 1, 0, -1):
        parent = links[number].parent
        if weighs[number] and parent is not None:
            weighs[parent] = True
    for number, link in enumerate(links):
        moves = not structure.fix_root_link if link.joint is None else link.joint.type != "fixed"
        if moves and not weighs[number]:
            place = link.body.origin or origin
            message = f"`{name}/{cut(link.name)}` moves, but neither it nor any link below it has a mass"
            if structure.file is None and link.file is None:
                hint = "give it `shapes` or `collisions`, or `inertial`"
                sink.report("SC522", message, place, hint=hint)
            else:
                hint = "give it an `<inertial>` in the file, or `inertial` under `links`"
                sink.report("SC527", f"{message}: it weighs a milligram", place, hint=hint)


_SLERP_AXES = ("twist", "swing")


def check_constraints(plan: ScenePlan, sink: Sink) -> None:
    """Applies every rule to every constraint.

    Args:
        plan: with or without lines for its origins.
        sink: collects diagnostics.
    """
    if not plan.constraints:
        return
    entities = {entity.name: entity for entity in plan.entities}
    around = plan.origin or Origin(None)
    for constraint in plan.constraints:
        origin = constraint.origin or around.child("constraints", constraint.name)
        for limits, place, turns in _iterate_limits(constraint, origin):
            _check_drive_limits(limits, place, sink, turns=turns)
        if isinstance(constraint.joint, Gear):
            _check_ratio(constraint.joint.ratio, origin.child("ratio"), sink)
        if _check_ends(constraint, entities, origin, sink):
            _check_movable(constraint, entities, origin, sink)
        if isinstance(constraint.joint, Drive):
            _check_drive(constraint.joint, constraint.name, origin, sink)
        elif isinstance(constraint.joint, Gear) and constraint.joint.enable_hinges:
            _check_hinges(constraint, entities, origin, sink)


def _iterate_limits(constraint: Constraint, origin: Origin) -> Iterator[tuple[Value, Origin, bool]]:
    """Yields the limits of a constraint, their origin, and whether they are angles."""
    joint = constraint.joint
    if isinstance(joint, Distance):
        yield joint.limits, origin.child("limits"), False
    elif isinstance(joint, Drive):
        for limit in joint.limits:
            yield limit.limits, origin.child("limits", limit.axis), limit.axis == "twist"


def _check_drive_limits(limits: Value, place: Origin, sink: Sink, *, turns: bool) -> None:
    found = find_reversed_limits(limits, _find_reversed)
    if found is not None:
        low, high = found.found
        message = f"the lower limit must not be above the upper one: {low:g} is above {high:g}"
        hint = "PhysX accepts such limits, but ignores or changes them"
        report_fault(sink, "SC560", message, place, hint, found.sample)
        return
    found = find_reversed_limits(limits, _beyond_half_turn) if turns else None
    if found is not None:
        far = found.found
        message = f"PhysX measures twist from -π to π, so a limit of {far:g} is never reached"
        degrees = "write `limits_deg` instead of `limits`: angles are radians"
        hint = degrees if abs(far) > 2 * pi else "use -π to π, or ±.inf for no limit"
        report_fault(sink, "SC561", message, place, hint, found.sample)


def _beyond_half_turn(limits: Row) -> float | None:
    return next((side for side in limits if isfinite(side) and abs(side) > pi), None)


def _check_ratio(ratio: Value, place: Origin, sink: Sink) -> None:
    found = find_single_fault(ratio, lambda row: None if row[0] else row)
    if found is not None:
        report_fault(sink, "SC104", "`ratio` must not be 0", place, "a gear of ratio 0 has no effect", found.sample)


def _check_ends(constraint: Constraint, entities: Mapping[str, Entity], origin: Origin, sink: Sink) -> bool:
    """Checks that both ends exist, differ, and can carry SAPIEN's components."""
    if constraint.parent == constraint.child:
        sink.report("SC562", f"`{cut(constraint.name)}` connects a body to itself", origin.child("child"))
        return False
    good = True
    for key, mount in (("child", constraint.child), ("parent", constraint.parent)):
        kinds = _motion_types(mount, entities) if mount is not None else frozenset[str]()
        if "none" in kinds:
            message = f"`{cut(str(mount))}` has no physics body, so no constraint can connect it"
            hint = "give it another body_type, or attach it with `relative_to`"
        elif key == "child" and "static" in kinds:
            message = f"`{cut(str(mount))}` never moves, so it cannot carry a constraint"
            hint = "swap `parent` and `child`: SAPIEN attaches a constraint to a child that can move"
        else:
            continue
        good = False
        sink.report("SC563", message, origin.child(key), hint=hint)
    return good


def _check_movable(constraint: Constraint, entities: Mapping[str, Entity], origin: Origin, sink: Sink) -> None:
    ends = [mount for mount in (constraint.child, constraint.parent) if mount is not None]
    if any("dynamic" in _motion_types(mount, entities) for mount in ends):
        return
    names = [f"`{cut(str(mount))}`" for mount in ends]
    moved = f"no force moves {names[0]}" if len(names) == 1 else f"forces move neither {names[0]} nor {names[1]}"
    message = f"`{cut(constraint.name)}` does nothing: {moved}"
    sink.report("SC564", message, origin, at="key", hint="one of them must be dynamic, or a link that can move")


def _motion_types(mount: Mount | None, entities: Mapping[str, Entity]) -> frozenset[str]:
    """Returns how a body moves in its scenes. A movable link counts as dynamic, a fixed root as static, though it may
    carry constraints.
    """
    assert mount is not None
    kinds: set[str] = set()
    for structure in entities[mount.entity].structures:
        if not isinstance(structure, ArticulationStructure):
            kinds.add(structure.body_type)
        elif structure.fix_root_link and mount.link in {None, structure.links[0].name}:
            kinds.add("fixed root")
        else:
            kinds.add("dynamic")
    return frozenset(kinds)


def _check_drive(joint: Drive, name: str, origin: Origin, sink: Sink) -> None:
    axes = [drive.axis for drive in joint.drives]
    if not joint.limits and not axes:
        message = f"`{cut(name)}` does nothing: it has neither limits nor drives"
        sink.report("SC564", message, origin, at="key", hint="write `limits` or `drive`, or use type: weld")
        return
    for axis in _SLERP_AXES:
        if axis in axes and "slerp" in axes:
            message = f"`{axis}` does nothing with `slerp`, which drives all rotations"
            sink.report("SC115", message, origin.child("drive", axis), at="key", hint="remove one of them")
    if axes:
        return
    for key, given in (
        ("target", joint.target),
        ("velocity_target", joint.linear_velocity_target or joint.angular_velocity_target),
    ):
        if given is not None:
            message = f"`{key}` does nothing: no axis is driven"
            sink.report("SC115", message, origin.child(key), at="key", hint="add `drive`, or remove it")


def _check_hinges(constraint: Constraint, entities: Mapping[str, Entity], origin: Origin, sink: Sink) -> None:
    for mount in (constraint.parent, constraint.child):
        if mount is None or not _is_hinged(mount, entities):
            what = "the world" if mount is None else f"`{cut(str(mount))}`"
            message = f"`enable_hinges` does nothing: {what} is not a link with a revolute joint"
            hint = "remove it: the gear constrains the velocities without it"
            sink.report("SC115", message, origin.child("enable_hinges"), at="key", hint=hint)
            return


def _is_hinged(mount: Mount, entities: Mapping[str, Entity]) -> bool:
    for structure in entities[mount.entity].structures:
        links = structure.links if isinstance(structure, ArticulationStructure) else ()
        joint = next((link.joint for link in links if link.name == mount.link), None)
        if joint is None or joint.type not in {"revolute", "revolute_unwrapped"}:
            return False
    return True
