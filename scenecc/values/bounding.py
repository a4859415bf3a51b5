"""Whether the bounds of a draw are bounds in every scene, found without drawing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.values import drawing
from scenecc.values.differences import difference
from scenecc.values.enumerating import FEW, combinations
from scenecc.values.failure import DrawError
from scenecc.values.nodes import Chosen, Computed, Cycled, Drawn, Rows, Stacked
from scenecc.values.operations import LISTS, is_number
from scenecc.values.support import flat
from scenecc.values.support_rules import names_of, reach_and_faults, spread

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.values.assigned import Assigned
    from scenecc.values.interval_rules import Interval
    from scenecc.values.support import Support
    from scenecc.values.supporting import Reader

Refusal = tuple[str, bool]
"""Why there may be no value in some scene, and whether there is one for certain that has none."""


def refusal(node: Drawn, reader: Reader, scenes: tuple[int, ...]) -> Refusal | None:
    """Why a draw may have no value in one of the scenes, by its bounds; None where it has one in all."""
    items = (node.low, node.high, *(node.clip or ()))
    # One more than few: then every scene is looked at where the scene's index decides.
    rows = combinations(
        items, reader.draws, reader.given, reader.num_scenes, scenes=scenes, most=FEW + 1, work=reader.work
    )
    if rows is None:
        return _by_supports(node, [spread(reader.item(item), node.shape) for item in items], reader)
    failed = _failed(rows, node)
    if failed is None:
        return None
    if not rows.assigned:
        return f"in scene {failed.scene}: {failed.message}", True
    alone = map(rows.row, range(len(rows.scenes)))
    good = {int(one.scenes[0]) for one in alone if _failed(one, node) is None}
    lost = min(set(rows.scenes.tolist()) - good, default=None)
    return (failed.message, False) if lost is None else (f"in scene {lost}: {failed.message}", True)


def _failed(rows: Assigned, node: Drawn) -> DrawError | None:
    """Why the bounds are none in one of the rows. A bound that has no value itself is told by itself."""
    try:
        drawing.bounds(rows, node)
    except DrawError as error:
        return error if error.node is node else None
    return None


def _by_supports(node: Drawn, ends: list[Support], reader: Reader) -> Refusal | None:
    for end in ends:
        if end.low is None:
            some = end.alternatives is None or any(is_number(part) for one in end.alternatives for part in flat(one))
            return drawing.no_bound(node), not some
    low, high, *clip = ends
    if node.kind == "normal":
        found = [_beyond(drawing.NEGATIVE, _sides(high))]
        if node.clip is not None:
            found.append(_beyond(drawing.CROSSED_CLIP, _between(clip[0], clip[1], node.clip, reader)))
    else:
        apart = _between(low, high, (node.low, node.high), reader)
        found = [_beyond(drawing.CROSSED, apart)]
        if node.kind == "log_uniform":
            found.append(_beyond(drawing.NOT_POSITIVE, _sides(low), zero=True))
        elif node.kind == "integers":
            are_whole = _is_whole(node.low, reader) and _is_whole(node.high, reader)
            found.append(None if are_whole else (drawing.NOT_WHOLE, False))
            left = [(drawing.WIDEST - most, drawing.WIDEST - least) for least, most in apart]
            found.append(_beyond(drawing.TOO_MANY, left, zero=True))
    return next((one for one in found if one is not None), None)


def _beyond(message: str, margins: Iterable[Interval], *, zero: bool = False) -> Refusal | None:
    """What is wrong where one of some numbers is, or may be, negative, or 0 where `zero`."""
    wrong = [most < 0 or (zero and most == 0) for least, most in margins if least < 0 or (zero and least == 0)]
    return (message, any(wrong)) if wrong else None


def _sides(bound: Support) -> list[Interval]:
    return list(zip(flat(bound.low), flat(bound.high), strict=True))


def _between(low: Support, high: Support, items: tuple[Any, Any], reader: Reader) -> list[Interval]:
    """How far one bound is above the other: in each component, its least and its most."""
    first, second = items
    if isinstance(first, Computed) and isinstance(second, Computed) and first.shape == second.shape == ():
        names = {**names_of(reader, first), **names_of(reader, second)}
        found = difference(second.template, first.template, names)
        if found is not None:
            return [found]
    return [(b[0] - a[1], b[1] - a[0]) for a, b in zip(_sides(low), _sides(high), strict=True)]


def _is_whole(item: Any, reader: Reader) -> bool:
    """Whether a bound's numbers are integers in any case."""
    match item:
        case Drawn():
            return item.kind == "integers"
        case Computed():
            found, _ = reach_and_faults(reader, item)
            return found.is_whole
        case Rows(items=items) | Cycled(items=items) | Chosen(items=items) | Stacked(items=items):
            return all(_is_whole(one, reader) for one in items)
        case _:
            parts = item if type(item) in LISTS else (item,)
            return all(float(part).is_integer() for part in parts if is_number(part))
