"""Checks without drawing whether the bounds of a draw are valid in every scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.variation import evaluation
from scenecc.variation.bounds import ValueBounds, flat_numbers
from scenecc.variation.distributions import WIDEST_INTEGERS
from scenecc.variation.expression_bounds import difference_interval
from scenecc.variation.node_bounds import (
    MAX_COMBINATIONS,
    BoundsAnalysis,
    bounds_and_faults,
    broadcast_bounds,
    combination_batch,
    name_bounds,
)
from scenecc.variation.nodes import Chosen, Computed, Cycled, Drawn, Rows, Shuffled, Stacked
from scenecc.variation.operations import LISTS, DrawError, Interval, is_number

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.variation.evaluation import CombinationBatch

DrawFault = tuple[str, bool]
"""Why there may be no value in some scene, and whether there is one for certain that has none."""


def find_draw_fault(node: Drawn, analysis: BoundsAnalysis, scenes: tuple[int, ...]) -> DrawFault | None:
    """Why a draw may have no value in one of the scenes, by its bounds; None where it has one in all."""
    # One more than few: then every scene is looked at where the scene's index decides.
    rows = combination_batch(node.operands, analysis, scenes=scenes, most=MAX_COMBINATIONS + 1, work=analysis.work)
    if rows is None:
        return _by_bounds(node, [broadcast_bounds(analysis.item(item), node.shape) for item in node.operands], analysis)
    failed = _failed(rows, node)
    if failed is None:
        return None
    if not rows.assigned:
        return f"in scene {failed.scene}: {failed.message}", True
    alone = map(rows.row, range(len(rows.scenes)))
    good = {int(one.scenes[0]) for one in alone if _failed(one, node) is None}
    lost = min(set(rows.scenes.tolist()) - good, default=None)
    return (failed.message, False) if lost is None else (f"in scene {lost}: {failed.message}", True)


def _failed(rows: CombinationBatch, node: Drawn) -> DrawError | None:
    """Why the bounds of one of the rows are invalid. A bound without a value is reported separately."""
    try:
        evaluation.draw_bounds(rows, node)
    except DrawError as error:
        return error if error.node is node else None
    return None


def _by_bounds(node: Drawn, ends: list[ValueBounds], analysis: BoundsAnalysis) -> DrawFault | None:
    for end in ends:
        if end.low is None:
            some = end.alternatives is None or any(
                is_number(part) for one in end.alternatives for part in flat_numbers(one)
            )
            return evaluation.bound_mismatch(node), not some
    found: list[DrawFault | None] = []
    for condition in node.distribution.holding(len(ends)):
        greater, less, limit = condition.greater, condition.less, condition.limit
        if greater is None or less is None:
            sides = _sides(ends[greater or less or 0])
            margins = [(limit - b, limit - a) if greater is None else (a - limit, b - limit) for a, b in sides]
        else:
            margins = _between(ends, node.operands, less, greater, analysis)
        found.append(_beyond(condition.message, margins, zero=condition.strict))
    if node.distribution.whole:
        whole = all(_is_whole(item, analysis) for item in node.operands)
        found.append(None if whole else (evaluation.NOT_WHOLE, False))
        apart = _between(ends, node.operands, 0, 1, analysis)
        left = [(WIDEST_INTEGERS - most, WIDEST_INTEGERS - least) for least, most in apart]
        found.append(_beyond(evaluation.TOO_MANY, left, zero=True))
    return next((one for one in found if one is not None), None)


def _beyond(message: str, margins: Iterable[Interval], *, zero: bool = False) -> DrawFault | None:
    """What is wrong where one of some numbers is, or may be, negative, or 0 where `zero`."""
    wrong = [most < 0 or (zero and most == 0) for least, most in margins if least < 0 or (zero and least == 0)]
    return (message, any(wrong)) if wrong else None


def _sides(bound: ValueBounds) -> list[Interval]:
    return list(zip(flat_numbers(bound.low), flat_numbers(bound.high), strict=True))


def _between(
    ends: list[ValueBounds], items: tuple[Any, ...], less: int, greater: int, analysis: BoundsAnalysis
) -> list[Interval]:
    """How far one operand is above another: in each component, its least and its most."""
    first, second = items[less], items[greater]
    if isinstance(first, Computed) and isinstance(second, Computed) and first.shape == second.shape == ():
        names = {**name_bounds(analysis, first), **name_bounds(analysis, second)}
        found = difference_interval(second.template, first.template, names)
        if found is not None:
            return [found]
    return [(b[0] - a[1], b[1] - a[0]) for a, b in zip(_sides(ends[less]), _sides(ends[greater]), strict=True)]


def _is_whole(item: Any, analysis: BoundsAnalysis) -> bool:
    """Whether a bound's numbers are integers in any case."""
    match item:
        case Drawn():
            return item.distribution.whole
        case Computed():
            found, _ = bounds_and_faults(analysis, item)
            return found.is_whole
        case (
            Rows(items=items) | Cycled(items=items) | Chosen(items=items) | Shuffled(items=items) | Stacked(items=items)
        ):
            return all(_is_whole(one, analysis) for one in items)
        case _:
            parts = item if type(item) in LISTS else (item,)
            return all(float(part).is_integer() for part in parts if is_number(part))
