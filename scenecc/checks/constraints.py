"""Rules of constraints: what SAPIEN would take without a word, and PhysX make nothing or something else of."""

from __future__ import annotations

from math import isfinite, pi
from typing import TYPE_CHECKING

from scenecc.checks.value_queries import alternatives, is_deferred, judged_limits
from scenecc.diagnostics import Origin
from scenecc.diagnostics.messages import cut
from scenecc.plan import ArticulationStructure, Distance, Drive, Gear

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.plan import Constraint, Entity, ScenePlan, Value
    from scenecc.plan.body import Mount

_SLERP_AXES = ("twist", "swing")


def check_constraints(plan: ScenePlan, sink: Sink, *, drawn: bool = False) -> None:
    """Applies every rule to every constraint. Draws nothing, unless `drawn`.

    Args:
        plan: with or without lines behind its origins.
        sink: takes the diagnostics.
        drawn: judge what waits for its rows, and nothing else.
    """
    if not plan.constraints:
        return
    entities = {entity.name: entity for entity in plan.entities}
    around = plan.origin or Origin(None)
    for constraint in plan.constraints:
        origin = constraint.origin or around.child("constraints", constraint.name)
        for limits, place, turns in _iterate_limits(constraint, origin):
            _check_limits(limits, place, sink, turns=turns, drawn=drawn)
        if isinstance(constraint.joint, Gear):
            _check_ratio(constraint.joint.ratio, origin.child("ratio"), sink, drawn=drawn)
        if drawn:
            continue
        if _check_ends(constraint, entities, origin, sink):
            _check_movable(constraint, entities, origin, sink)
        if isinstance(constraint.joint, Drive):
            _check_drive(constraint.joint, constraint.name, origin, sink)
        elif isinstance(constraint.joint, Gear) and constraint.joint.enable_hinges:
            _check_hinges(constraint, entities, origin, sink)


def _iterate_limits(constraint: Constraint, origin: Origin) -> Iterator[tuple[Value, Origin, bool]]:
    """The limits of a constraint, where they are written, and whether they are angles."""
    joint = constraint.joint
    if isinstance(joint, Distance):
        yield joint.limits, origin.child("limits"), False
    elif isinstance(joint, Drive):
        for limit in joint.limits:
            yield limit.limits, origin.child("limits", limit.axis), limit.axis == "twist"


def _check_limits(limits: Value, place: Origin, sink: Sink, *, turns: bool, drawn: bool) -> None:
    pairs = judged_limits(limits, drawn=drawn)
    wrong = next(((low, high) for low, high in pairs if low > high), None)
    if wrong is not None:
        message = f"the lowest must not be above the highest: {wrong[0]:g} is above {wrong[1]:g}"
        sink.report("SC560", message, place, hint="PhysX takes such limits and applies none, or others")
        return
    far = next((side for pair in pairs for side in pair if turns and isfinite(side) and abs(side) > pi), None)
    if far is not None:
        message = f"PhysX knows the twist from -π to π only, so that a limit of {far:g} is never reached"
        sink.report("SC561", message, place, hint="write a limit within -π and π [rad], or ±.inf for none")


def _check_ratio(ratio: Value, place: Origin, sink: Sink, *, drawn: bool) -> None:
    if not is_deferred([ratio], drawn=drawn) and (0.0,) in (alternatives(ratio) or ()):
        sink.report("SC104", "`ratio` must not be 0", place, hint="a gear of ratio 0 turns nothing")


def _check_ends(constraint: Constraint, entities: Mapping[str, Entity], origin: Origin, sink: Sink) -> bool:
    """Whether SAPIEN has components for both ends, which are two."""
    if constraint.parent == constraint.child:
        sink.report("SC562", f"`{cut(constraint.name)}` ties a body to itself", origin.child("child"))
        return False
    good = True
    for key, mount in (("child", constraint.child), ("parent", constraint.parent)):
        kinds = _motion_types(mount, entities) if mount is not None else frozenset[str]()
        if "none" in kinds:
            message = f"`{cut(_mount_name(mount))}` is only seen: nothing can be tied to it"
            hint = "give it another body_type, or let it go with `relative_to`"
        elif key == "child" and "static" in kinds:
            message = f"`{cut(_mount_name(mount))}` never moves, so it cannot carry a constraint"
            hint = "exchange `parent` and `child`: SAPIEN hangs a constraint on a child that can move"
        else:
            continue
        good = False
        sink.report("SC563", message, origin.child(key), hint=hint)
    return good


def _check_movable(constraint: Constraint, entities: Mapping[str, Entity], origin: Origin, sink: Sink) -> None:
    ends = [mount for mount in (constraint.child, constraint.parent) if mount is not None]
    if any("dynamic" in _motion_types(mount, entities) for mount in ends):
        return
    names = [f"`{cut(_mount_name(mount))}`" for mount in ends]
    moved = f"no force moves {names[0]}" if len(names) == 1 else f"forces move neither {names[0]} nor {names[1]}"
    message = f"`{cut(constraint.name)}` does nothing: {moved}"
    sink.report("SC564", message, origin, at="key", hint="one of both must be dynamic, or a link that can move")


def _motion_types(mount: Mount | None, entities: Mapping[str, Entity]) -> frozenset[str]:
    """How the body moves in the scenes: a link that can move is dynamic, a fixed root static but may carry things."""
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
            message = f"`{axis}` does nothing beside `slerp`, which drives all turns"
            sink.report("SC115", message, origin.child("drive", axis), at="key", hint="leave one of the two out")
    if axes:
        return
    for key, given in (
        ("target", joint.target),
        ("velocity_target", joint.linear_velocity_target or joint.angular_velocity_target),
    ):
        if given is not None:
            message = f"`{key}` does nothing: no axis is driven"
            sink.report("SC115", message, origin.child(key), at="key", hint="write `drive`, or leave it out")


def _check_hinges(constraint: Constraint, entities: Mapping[str, Entity], origin: Origin, sink: Sink) -> None:
    for mount in (constraint.parent, constraint.child):
        if mount is None or not _is_hinged(mount, entities):
            what = "the world" if mount is None else f"`{cut(_mount_name(mount))}`"
            message = f"`enable_hinges` does nothing: {what} is no link with a revolute joint"
            hint = "leave it out: the velocities of the two are held to the ratio without it"
            sink.report("SC115", message, origin.child("enable_hinges"), at="key", hint=hint)
            return


def _is_hinged(mount: Mount, entities: Mapping[str, Entity]) -> bool:
    for structure in entities[mount.entity].structures:
        links = structure.links if isinstance(structure, ArticulationStructure) else ()
        joint = next((link.joint for link in links if link.name == mount.link), None)
        if joint is None or joint.type not in {"revolute", "revolute_unwrapped"}:
            return False
    return True


def _mount_name(mount: Mount | None) -> str:
    assert mount is not None
    return mount.entity if mount.link is None else f"{mount.entity}/{mount.link}"
