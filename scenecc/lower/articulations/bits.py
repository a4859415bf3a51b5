"""Links that are to ignore one another, and collide by what is said of one of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.plan.articulation import MOST_LINKS
from scenecc.plan.bits import collide

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.articulations.draft import Draft
    from scenecc.plan import BodyStructure

_SAPIENS = (1, 1, 0, 0)


def report_colliding(
    draft: Draft,
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
    if len(bodies) > MOST_LINKS:
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
        related = [("are to ignore one another", _said(first, second, draft, whole), "value")]
        sink.report("SC524", message, place, hint=hint, related=related)  # pyright: ignore[reportArgumentType]


def _colliding(
    number: int, draft: Draft, bodies: Sequence[BodyStructure], *, all_of_them: bool
) -> Iterator[tuple[int, int]]:
    link = draft.links[number]
    if not bodies[number].collisions:
        return
    mine = _bits(bodies[number])
    for other, body in enumerate(bodies):
        near = other in (number, link.parent) or draft.links[other].parent == number
        if near or not body.collisions:
            continue
        if (all_of_them or link.ignore_bits & draft.links[other].ignore_bits) and collide(mine, _bits(body)):
            yield number, other


def _bits(body: BodyStructure) -> tuple[int, ...]:
    groups = body.collision_groups
    return _SAPIENS if groups is None else tuple(map(int, groups.numbers()))


def _said(first: int, second: int, draft: Draft, whole: Origin | None) -> Origin:
    """Where it is said that two links ignore one another."""
    if whole is not None:
        return whole
    links = draft.links
    common = links[first].ignore_bits & links[second].ignore_bits
    bit = (common & -common).bit_length() - 1
    return draft.ignored[bit] if bit < len(draft.ignored) else links[second].origin
