"""Assigns four collision integers to each collision group."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.lower.references import qualified, scope_of
from scenecc.plan.body import DEFAULT_COLLISION_GROUPS

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.spec.physics import CollisionGroup

GROUPS = 31
"""Most groups: 32 bits of an integer, less one for shapes without a group."""

GroupBits = tuple[int, int, int, int]

DEFAULT_BITS: GroupBits = DEFAULT_COLLISION_GROUPS
"""SAPIEN's default for a shape without a group."""


def assign_group_bits(groups: dict[str, CollisionGroup], origin: Origin, sink: Sink) -> dict[str, GroupBits]:
    """Assigns the four integers of each group.

    Args:
        groups: as written; their order decides the bits.
        origin: of `collision_groups`.
        sink: receives the diagnostics.
    """
    if len(groups) > GROUPS:
        extra = list(groups)[GROUPS]
        sink.report(
            "SC312", f"{len(groups)} collision groups are more than the {GROUPS} bits", origin.child(extra), at="key"
        )
        return dict.fromkeys(groups, DEFAULT_BITS)
    ignored = _find_ignored(groups, origin, sink)
    bit = {name: 1 << (i + 1) for i, name in enumerate(groups)}
    everything = 1 | sum(bit.values())
    return {name: (bit[name], everything & ~sum(bit[other] for other in ignored[name]), 0, 0) for name in groups}


def _find_ignored(groups: dict[str, CollisionGroup], origin: Origin, sink: Sink) -> dict[str, set[str]]:
    ignored: dict[str, set[str]] = {name: set() for name in groups}
    for name, group in groups.items():
        scope = scope_of(name)
        for i, written in enumerate(group.ignore):
            other = qualified(written, scope)
            if other not in groups:
                place = origin.child(name, "ignore", i)
                hint = suggest_name(written, groups, sink)
                sink.report("SC302", f"there is no collision group `{cut(written)}`", place, hint=hint)
                continue
            ignored[name].add(other)
            ignored[other].add(name)
    return ignored


def find_group(groups: dict[str, GroupBits], name: str, place: Origin, scope: str, sink: Sink) -> GroupBits | None:
    """The four integers of a group. Reports an unknown name and returns None.

    Args:
        groups: result of `assign_group_bits`.
        name: as written.
        place: where it is written.
        scope: of the name.
        sink: receives the diagnostics.
    """
    full = qualified(name, scope)
    bits = groups.get(full)
    if bits is None:
        prefix = qualified("", scope_of(full))
        name = full[len(prefix) :]
        known = [group[len(prefix) :] for group in groups if group.startswith(prefix)]
        hint = suggest_name(name, known, sink) if known else "name it under `collision_groups`"
        sink.report("SC302", f"there is no collision group `{cut(name)}`", place, hint=hint)
    return bits
