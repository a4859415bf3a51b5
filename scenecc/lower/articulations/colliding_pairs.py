"""Links that collide by their collision bits, although they should ignore one another (SC524)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.lower.collision_groups import DEFAULT_BITS
from scenecc.plan.articulation import MAX_LINKS
from scenecc.plan.body import groups_collide

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.articulations.drafts import ArticulationDraft
    from scenecc.plan import BodyStructure


def shape_bits_origin(body: BodyStructure) -> Origin | None:
    """Origin of the first shape's own collision bits; None if no shape has any."""
    written = (shape.origin for shape in body.collisions if shape.collision_groups is not None and shape.origin)
    place = next(written, None)
    return place and place.child("collision_bits")


def warn_ignored_pairs_collide(
    draft: ArticulationDraft,
    bodies: Sequence[BodyStructure],
    written: Mapping[int, Origin],
    whole: Origin | None,
    sink: Sink,
) -> None:
    """Warns of `collision_bits` that make links collide although their pair is ignored, once per place."""
    if len(bodies) > MAX_LINKS:
        # This is an error elsewhere, and checking so many pairs is slow.
        return
    found: dict[Origin, list[tuple[int, int]]] = {}
    for link, place in written.items():
        pairs = list(_find_colliding_pairs(link, draft, bodies, all_of_them=whole is not None))
        if pairs:
            found.setdefault(place, []).extend(pairs)
    for place, pairs in found.items():
        (first, second), count = pairs[0], len({frozenset(pair) for pair in pairs}) - 1
        names = f"`{cut(draft.links[first].name)}` and `{cut(draft.links[second].name)}`"
        more = f", and {count} other pair{'s' if count > 1 else ''}" if count else ""
        message = f"with these bits {names}{more} collide, but should ignore one another"
        hint = "write `collision_group` instead, which keeps ignored pairs, or give all of them a common bit"
        related = [("should ignore one another", _ignore_origin(first, second, draft, whole), "value")]
        sink.report("SC524", message, place, hint=hint, related=related)  # pyright: ignore[reportArgumentType]


def _find_colliding_pairs(
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
        ignored = all_of_them or link.ignore_bits & draft.links[other].ignore_bits
        if ignored and any(groups_collide(a, b) for a in mine for b in _bits(body)):
            yield number, other


def _bits(body: BodyStructure) -> list[tuple[int, ...]]:
    """The distinct collision integers of a link's shapes."""
    each = dict.fromkeys(body.shape_groups())
    return [DEFAULT_BITS if groups is None else tuple(map(int, groups.numbers())) for groups in each]


def _ignore_origin(first: int, second: int, draft: ArticulationDraft, whole: Origin | None) -> Origin:
    """The place that makes two links ignore one another."""
    if whole is not None:
        return whole
    links = draft.links
    common = links[first].ignore_bits & links[second].ignore_bits
    bit = (common & -common).bit_length() - 1
    return draft.ignored.get(bit, links[second].origin)
