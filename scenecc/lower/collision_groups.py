"""Collision groups to SAPIEN's four integers.

A and B collide if `(A.g0 & B.g1) or (A.g1 & B.g0)` and nothing in g2 and g3 says otherwise. Each
group gets a bit of its own in g0, and in g1 the bits of all groups that it does collide with; bit 0
is everything without a group, whose default [1, 1, 0, 0] is left as it is. Since ignoring goes both
ways, both halves of the `or` agree.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.lower.references import qualified, scope_of
from scenecc.plan.body import groups_collide

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.articulations.drafts import ArticulationDraft
    from scenecc.plan import BodyStructure
    from scenecc.spec.physics import CollisionGroup


GROUPS = 31
"""32 bits of an integer, less the one for what has no group."""

GroupBits = tuple[int, int, int, int]

DEFAULT_BITS: GroupBits = (1, 1, 0, 0)
"""What SAPIEN gives to a shape without a group."""


def assign_group_bits(groups: dict[str, CollisionGroup], origin: Origin, sink: Sink) -> dict[str, GroupBits]:
    """The four integers of each group.

    Args:
        groups: as written, in order; the order decides the bits.
        origin: of `collision_groups`.
        sink: takes the diagnostics.
    """
    if len(groups) > GROUPS:
        extra = list(groups)[GROUPS]
        sink.report(
            "SC312", f"{len(groups)} collision groups are more than the {GROUPS} bits", origin.child(extra), at="key"
        )
        return dict.fromkeys(groups, DEFAULT_BITS)
    ignored = _ignored(groups, origin, sink)
    bit = {name: 1 << (i + 1) for i, name in enumerate(groups)}
    everything = 1 | sum(bit.values())
    return {name: (bit[name], everything & ~sum(bit[other] for other in ignored[name]), 0, 0) for name in groups}


def _ignored(groups: dict[str, CollisionGroup], origin: Origin, sink: Sink) -> dict[str, set[str]]:
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
    """The four integers of a group; None, reported, where there is none of the name.

    Args:
        groups: as `assign_group_bits` gives them.
        name: as written.
        place: where it is written.
        scope: of the names there.
        sink: takes the diagnostics.
    """
    bits = groups.get(qualified(name, scope))
    if bits is None:
        prefix = qualified("", scope)
        known = [group[len(prefix) :] for group in groups if group.startswith(prefix)]
        hint = suggest_name(name, known, sink) if known else "name it under `collision_groups`"
        sink.report("SC302", f"there is no collision group `{cut(name)}`", place, hint=hint)
    return bits


def warn_ignored_pairs_collide(
    draft: ArticulationDraft,
    bodies: Sequence[BodyStructure],
    written: Mapping[int, Origin],
    whole: Origin | None,
    sink: Sink,
) -> None:
    """Warns of `collision_bits` by which links collide that were to ignore one another, each place once.

    Args:
        draft: of the articulation.
        bodies: of its links, as they are built.
        written: where the `collision_bits` of a link are written, by its number.
        whole: where it is said that no two of its links collide; None: it is not.
        sink: takes the warnings.
    """
    from scenecc.plan.articulation import MAX_LINKS  # noqa: PLC0415 - loaded where there are articulations

    if len(bodies) > MAX_LINKS:
        # Which is an error; so many pairs take long.
        return
    found: dict[Origin, list[tuple[int, int]]] = {}
    for number, place in written.items():
        pairs = list(_colliding(number, draft, bodies, all_of_them=whole is not None))
        if pairs:
            found.setdefault(place, []).extend(pairs)
    for place, pairs in found.items():
        (first, second), count = pairs[0], len({frozenset(pair) for pair in pairs}) - 1
        names = f"`{cut(draft.links[first].name)}` and `{cut(draft.links[second].name)}`"
        more = f", and {count} other pair{'s' if count > 1 else ''}" if count else ""
        message = f"by these bits {names}{more} collide, which are to ignore one another"
        hint = "say `collision_group` instead, which keeps what is ignored, or give all of them a bit in common"
        related = [("are to ignore one another", _ignore_origin(first, second, draft, whole), "value")]
        sink.report("SC524", message, place, hint=hint, related=related)  # pyright: ignore[reportArgumentType]


def _colliding(
    number: int, draft: ArticulationDraft, bodies: Sequence[BodyStructure], *, all_of_them: bool
) -> Iterator[tuple[int, int]]:
    link = draft.links[number]
    if not bodies[number].collisions:
        return
    mine = _bits(bodies[number])
    for other, body in enumerate(bodies):
        near = other in (number, link.parent) or draft.links[other].parent == number
        if near or not body.collisions:
            continue
        if (all_of_them or link.ignore_bits & draft.links[other].ignore_bits) and groups_collide(mine, _bits(body)):
            yield number, other


def _bits(body: BodyStructure) -> tuple[int, ...]:
    groups = body.collision_groups
    return DEFAULT_BITS if groups is None else tuple(map(int, groups.numbers()))


def _ignore_origin(first: int, second: int, draft: ArticulationDraft, whole: Origin | None) -> Origin:
    """Where it is said that two links ignore one another."""
    if whole is not None:
        return whole
    links = draft.links
    common = links[first].ignore_bits & links[second].ignore_bits
    bit = (common & -common).bit_length() - 1
    return draft.ignored[bit] if bit < len(draft.ignored) else links[second].origin
