"""Rules of articulations: what SAPIEN would take without a word, and PhysX would make something else of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from scenecc.checks.value_queries import highest, is_deferred, judged_limits, lowest
from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.plan.articulation import MAX_LINKS
from scenecc.plan.tendons import why_no_tendon

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.plan import ArticulationStructure
    from scenecc.plan.articulation import Joint, Mimic


_MAX_JOINT_DISTANCE = 1e6
"""How far a joint is from its links [m]: beyond, a simulation counts as diverged (SC820)."""


def check_articulation(structure: ArticulationStructure, name: str, origin: Origin, sink: Sink, *, drawn: bool) -> None:
    """Applies every rule to an articulation.

    Args:
        structure: of it.
        name: the entity's.
        origin: of the entity.
        sink: takes the diagnostics.
        drawn: judge what waits for its rows, and nothing else.
    """
    for link in structure.links:
        if link.joint is not None:
            _check_limits(link.joint, origin, sink, drawn=drawn)
            _check_joint_distance(link.joint, origin, sink, drawn=drawn)
    if drawn:
        return
    _check_link_count(structure, name, origin, sink)
    _check_names(structure, origin, sink)
    _check_mimics(structure, origin, sink)
    _check_masses(structure, name, origin, sink)


def _check_limits(joint: Joint, origin: Origin, sink: Sink, *, drawn: bool) -> None:
    pairs = () if joint.limits is None else judged_limits(joint.limits, drawn=drawn)
    wrong = next(((low, high) for low, high in pairs if low > high), None)
    if wrong is not None:
        low, high = wrong
        message = f"the lowest position of `{cut(joint.name)}`, {low:g}, is above the highest, {high:g}"
        place = joint.limits_origin or joint.origin or origin
        at: Literal["key", "value"] = "key" if joint.limits_origin is None else "value"
        sink.report("SC520", message, place, at=at, hint="limits are [lowest, highest]")


def _check_joint_distance(joint: Joint, origin: Origin, sink: Sink, *, drawn: bool) -> None:
    places = [pose for pose in (joint.pose_in_parent, joint.pose_in_child) if pose is not None]
    if not places or is_deferred(places, drawn=drawn):
        return
    far = max(abs(number) for place in places for number in (*lowest(place)[:3], *highest(place)[:3]))
    if far > _MAX_JOINT_DISTANCE:
        message = (
            f"the joint `{cut(joint.name)}` is {far:.3g} m from a link of it, and {_MAX_JOINT_DISTANCE:g} m is the most"
        )
        sink.report("SC512", message, joint.origin or origin, hint="mend the coordinates: they are in metres")


def _check_link_count(structure: ArticulationStructure, name: str, origin: Origin, sink: Sink) -> None:
    count = len(structure.links)
    if count > MAX_LINKS:
        message = f"`{name}` has {count} links, and PhysX holds {MAX_LINKS} of an articulation"
        sink.report("SC519", message, origin, at="key", hint="make one link of links that are fixed to one another")


def _check_names(structure: ArticulationStructure, origin: Origin, sink: Sink) -> None:
    seen: dict[tuple[str, str], Origin] = {}
    for link in structure.links:
        _check_unique_name("link", link.name, link.body.origin or origin, seen, sink)
        if link.joint is not None and link.joint.name:
            _check_unique_name("joint", link.joint.name, link.joint.origin or origin, seen, sink)


def _check_unique_name(what: str, name: str, place: Origin, seen: dict[tuple[str, str], Origin], sink: Sink) -> None:
    first = seen.setdefault((what, name), place)
    if first is not place:
        related = [(f"the first {what} of this name", first, "value")]
        sink.report("SC326", f"two {what}s are called `{cut(name)}`", place, related=related)  # pyright: ignore[reportArgumentType]


def _check_mimics(structure: ArticulationStructure, origin: Origin, sink: Sink) -> None:
    joints = {link.joint.name for link in structure.links if link.joint is not None}
    follows = {mimic.joint: mimic.source for mimic in structure.mimics}
    for mimic in structure.mimics:
        place = mimic.origin or origin
        if mimic.source not in joints:
            message = f"`{cut(mimic.joint)}` follows `{cut(mimic.source)}`, and there is no such joint"
            hint = suggest_name(mimic.source, sorted(joint for joint in joints if joint), sink)
            sink.report("SC521", message, place, hint=hint)
            continue
        why = _mimic_obstacle(mimic, structure, follows)
        if why is not None:
            message = f"`{cut(mimic.joint)}` cannot follow `{cut(mimic.source)}`: {why}"
            sink.report("SC521", message, place, hint="leave `mimic` out, and drive both joints")


def _mimic_obstacle(mimic: Mimic, structure: ArticulationStructure, follows: dict[str, str]) -> str | None:
    """Why PhysX cannot make one joint follow another; None where it can."""
    if any(factor == 0 for factor in mimic.multiplier.numbers()):
        return "a multiplier of 0 leaves nothing to follow"
    at, seen = mimic.source, {mimic.joint}
    while at in follows:
        if at in seen:
            return "they follow one another in a circle"
        seen.add(at)
        at = follows[at]
    return why_no_tendon(structure, mimic)


def _check_masses(structure: ArticulationStructure, name: str, origin: Origin, sink: Sink) -> None:
    """What moves, with all that it carries, weighs something."""
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
            message = f"`{name}/{cut(link.name)}` moves, and neither it nor what hangs on it has a mass"
            if structure.file is None:
                hint = "give it `shapes` or `collisions`, or `inertial`"
                sink.report("SC522", message, place, hint=hint)
            else:
                hint = "give it an `<inertial>` in the file, or `inertial` under `links`"
                sink.report("SC527", f"{message}: it weighs a milligram", place, hint=hint)
