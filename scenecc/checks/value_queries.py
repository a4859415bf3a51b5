"""The rows by which a rule judges values, and the report of what it finds.

Known rows are judged scene by scene. Plain forms are judged by all that they can draw, since no seed may decide whether
a file is right. Expressions are judged by the rows of this seed, and by their samples of others.
"""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import At, Origin
    from scenecc.plan import Value


Row = tuple[float, ...]


class RuleFault(NamedTuple):
    """A row of values that breaks a rule.

    Attributes:
        found: what the rule says of it.
        sample: the scene and the seed of the sample with the fault; None: this seed has it, or every seed.
    """

    found: Any
    sample: tuple[int, int] | None


def find_fault(
    values: Sequence[Value],
    judge: Callable[..., Any],
    *,
    corners: Callable[[], Iterable[tuple[Row, ...]]] | None = None,
) -> RuleFault | None:
    """The first row of some values that breaks a rule.

    Args:
        values: of one object.
        judge: takes a row of each value; gives what is wrong, or None.
        corners: gives the rows by which plain forms are judged; None: those where all values are least, and greatest.
    """
    if any(map(is_sampled, values)):
        return _find_fault_of_expression(values, judge)
    every = _known_rows(values)
    if every is None:
        every = (corners or (lambda: [tuple(map(lowest, values)), tuple(map(highest, values))]))()
    found = _first_fault(every, judge)
    return None if found is None else RuleFault(found[1], None)


def _find_fault_of_expression(values: Sequence[Value], judge: Callable[..., Any]) -> RuleFault | None:
    found = _first_fault(_drawn_rows(values), judge)
    if found is not None:
        return RuleFault(found[1], None)
    found = _first_fault(_sample_rows(values), judge)
    if found is None:
        return None
    from scenecc.variation.samples import sample_of  # noqa: PLC0415 - loaded where something varies

    return RuleFault(found[1], sample_of(found[0], next(value.scenes for value in values if value.scenes)))


def _first_fault(every: Iterable[tuple[Row, ...]], judge: Callable[..., Any]) -> tuple[int, Any] | None:
    """The number of the first wrong row, and what is wrong."""
    judged = ((number, judge(*row)) for number, row in enumerate(every))
    return next(((number, found) for number, found in judged if found is not None), None)


def find_single_fault(value: Value, judge: Callable[[Row], Any]) -> RuleFault | None:
    """As `find_fault`, of one value: each alternative of a plain form, or else its least and its greatest row."""
    return find_fault([value], judge, corners=lambda: [(row,) for row in alternatives_or_extremes(value)])


def wrong_pair(a: Value, b: Value, is_wrong: Callable[[float, float], bool]) -> RuleFault | None:
    """The first pair of numbers of two values, of which the first must not be above the second."""

    def judge(x: Row, y: Row) -> tuple[float, float] | None:
        return (x[0], y[0]) if is_wrong(x[0], y[0]) else None

    return find_fault([a, b], judge, corners=lambda: [(highest(a), lowest(b))])


def reversed_limits(value: Value, judge: Callable[[Row], Any]) -> RuleFault | None:
    """The first row [low, high] of a value that breaks a rule about their order."""

    def corners() -> Iterable[tuple[Row, ...]]:
        found = list_alternatives(value)
        return [((highest(value)[0], lowest(value)[1]),)] if found is None else [(row,) for row in found]

    return find_fault([value], judge, corners=corners)


def rows(values: Sequence[Value]) -> list[tuple[Row, ...]] | None:
    """The rows of values side by side, of expressions also their samples; None where plain forms have no rows yet."""
    if any(map(is_sampled, values)):
        return [*_drawn_rows(values), *_sample_rows(values)]
    return _known_rows(values)


def _known_rows(values: Sequence[Value]) -> list[tuple[Row, ...]] | None:
    if all(value.is_constant for value in values):
        return [tuple(value.numbers() for value in values)]
    if not all(value.known for value in values):
        return None
    return _side_by_side([value.data for value in values], distinct=True)


def _drawn_rows(values: Sequence[Value]) -> list[tuple[Row, ...]]:
    """The distinct rows of this seed; none if a value depends on a placement."""
    from scenecc.variation.operations import DrawError  # noqa: PLC0415 - loaded where something varies

    try:
        return _side_by_side([value.data for value in values], distinct=True)
    except DrawError:
        return []


def _sample_rows(values: Sequence[Value]) -> list[tuple[Row, ...]]:
    """A row for each sample; none if a sample is missing or wrong, which was reported."""
    from scenecc.variation.operations import DrawError  # noqa: PLC0415 - loaded where something varies

    try:
        return _side_by_side([value.samples for value in values], distinct=False)
    except DrawError:
        return []


def _side_by_side(columns: list[NDArray[Any]], *, distinct: bool) -> list[tuple[Row, ...]]:
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.variation.evaluation import distinct_rows  # noqa: PLC0415 - see above

    count = max(map(len, columns))
    flat = [np.broadcast_to(column.reshape(len(column), -1), (count, column[0].size)) for column in columns]
    if distinct:
        # A cycle has few rows, however many scenes there are.
        first = distinct_rows(np.concatenate(flat, axis=1))
        flat = [column[first] for column in flat]
    return list(zip(*(map(tuple, column.tolist()) for column in flat), strict=True))


def list_alternatives(value: Value) -> list[Row] | None:
    """Every row that a value can have; None where they lie between bounds."""
    found = rows([value]) if value.known else None
    if found is not None:
        return [row for (row,) in found]
    several = value.bounds.alternatives
    return None if several is None else list(map(_as_row, several))


def alternatives_or_extremes(value: Value) -> list[Row]:
    """Every row that a value can have, or else the row of the least and the row of the greatest numbers."""
    found = list_alternatives(value)
    return [lowest(value), highest(value)] if found is None else found


def list_indices(value: Value) -> list[int]:
    """Every alternative of a table index, by first use."""
    return list(dict.fromkeys(map(int, value.numbers())))


def lowest(value: Value) -> Row:
    """The least that each component can be."""
    return _extreme_row(value, high=False)


def highest(value: Value) -> Row:
    """The most that each component can be."""
    return _extreme_row(value, high=True)


def is_bounded(row: Sequence[float | None]) -> bool:
    """Whether all numbers of a row are known and finite."""
    return all(number is not None and isfinite(number) for number in row)


def report_fault(
    sink: Sink,
    code: str,
    message: str,
    place: Origin,
    hint: str,
    sample: tuple[int, int] | None = None,
    *,
    at: At = "value",
) -> None:
    """Reports what a rule found. `sample`: as of `RuleFault`; then it is a warning."""
    if sample is not None:
        from scenecc.variation.samples import CHECKED_LATER, named_sample  # noqa: PLC0415 - loaded where something varies

        code, message = "SC514", f"{named_sample(*sample)} {message}"
        hint = "; ".join(part for part in (CHECKED_LATER, hint) if part)
    sink.report(code, message, place, at=at, hint=hint)


def is_sampled(value: Value) -> bool:
    """Whether a value is judged by the rows of this seed and by samples."""
    return not value.known and not value.bounds.exact


def _extreme_row(value: Value, *, high: bool) -> Row:
    if value.is_constant:
        return value.numbers()
    if value.known:
        known: list[list[float]] = value.data.reshape(len(value.data), -1).tolist()
        return tuple(map(max if high else min, zip(*known, strict=True)))
    return _as_row(value.bounds.high if high else value.bounds.low)


def _as_row(item: Any) -> Row:
    return item if item.__class__ is tuple else (item,)
