"""Queries of a value for rules: every possible value before it is drawn, or its rows afterwards.

Values known by scene are checked scene by scene. Values of forms are checked at their extremes, so that no seed decides
whether a file is valid. An expression may couple values (dynamic friction as a share of static friction), so rules on
expressions are checked on rows, once drawn.
"""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import At, Origin
    from scenecc.plan import Value
    from scenecc.variation.node_bounds import Dependence


Row = tuple[float, ...]


def is_deferred(values: Sequence[Value], *, drawn: bool) -> bool:
    """Returns whether a rule belongs to the other stage: rules on expressions belong to the draw stage (`drawn`)."""
    return any(map(_needs_drawn_rows, values)) is not drawn


def rows(values: Sequence[Value]) -> Iterator[tuple[Row, ...]] | None:
    """Returns the rows of the values side by side, if they are known, or drawn because of an expression.

    None means that the rule must use the extremes.
    """
    if all(value.is_constant for value in values):
        return iter([tuple(value.numbers() for value in values)])
    if not all(value.known for value in values) and not any(_needs_drawn_rows(value) for value in values):
        return None
    import numpy as np  # noqa: PLC0415 - needed only if something varies

    from scenecc.variation.evaluation import distinct_rows  # noqa: PLC0415 - as above

    columns = [value.data.reshape(len(value.data), -1) for value in values]
    count = max(map(len, columns))
    columns = [np.broadcast_to(column, (count, column.shape[1])) for column in columns]
    # A cycle has few rows, even with many scenes.
    first = distinct_rows(np.concatenate(columns, axis=1))
    return zip(*(map(tuple, column[first].tolist()) for column in columns), strict=True)


def alternatives(value: Value) -> list[Row] | None:
    """Returns every possible row of a value; None if it lies between bounds."""
    found = rows([value])
    if found is not None:
        return [row for (row,) in found]
    several = value.bounds.alternatives
    return None if several is None else list(map(_as_row, several))


def alternatives_or_extremes(value: Value) -> list[Row]:
    """Returns every possible row of a value, or else the minimum and maximum of each of its numbers."""
    found = alternatives(value)
    return [lowest(value), highest(value)] if found is None else found


def indices(value: Value) -> list[int]:
    """Returns every alternative of a table index, in order of first use."""
    return list(dict.fromkeys(map(int, value.numbers())))


def lowest(value: Value) -> Row:
    """Returns the minimum of each component."""
    return _extreme_row(value, high=False)


def highest(value: Value) -> Row:
    """Returns the maximum of each component."""
    return _extreme_row(value, high=True)


def judged_pairs(a: Value, b: Value, *, drawn: bool) -> Sequence[tuple[float, float]]:
    """Returns pairs of numbers to check that one value does not exceed another; empty if `is_deferred`.

    If known, one pair per scene; otherwise the maximum of the first with the minimum of the second.
    """
    if is_deferred([a, b], drawn=drawn):
        return ()
    found = rows([a, b])
    return [(highest(a)[0], lowest(b)[0])] if found is None else [(x[0], y[0]) for x, y in found]


def wrong_pair(
    a: Value, b: Value, is_wrong: Callable[[float, float], bool], *, drawn: bool
) -> tuple[tuple[float, float], bool] | None:
    """Returns the first wrong pair of numbers of two values, the first of which must not exceed the second.

    Args:
        a: the value that must be smaller.
        b: the value that must be larger.
        is_wrong: checks a pair of their numbers.
        drawn: check only values of expressions, which are deferred until they are drawn.

    Returns:
        The pair, and whether it is only possible: expressions are not drawn yet, and some draws may give it.
    """
    possible = not drawn and is_deferred([a, b], drawn=False)
    pairs = _bounded([(highest(a), lowest(b))]) if possible else judged_pairs(a, b, drawn=drawn)
    found = next((pair for pair in pairs if is_wrong(*pair)), None)
    if found is not None and possible and a.dependence is not None and b.dependence is not None:
        found = next((pair for pair in _joint_pairs(a.dependence, b.dependence) if is_wrong(*pair)), None)
    return None if found is None else (found, possible)


def _joint_pairs(a: Dependence, b: Dependence) -> list[tuple[float, float]]:
    """Returns pairs that two expressions may give together before they are drawn."""
    from scenecc.variation.node_bounds import joint_extremes  # noqa: PLC0415 - needed only if something varies
    from scenecc.variation.operations import DrawError  # noqa: PLC0415 - as above

    try:
        return _bounded((_as_row(x), _as_row(y)) for x, y in joint_extremes(a, b))
    except DrawError:  # reported at the expression
        return []


def _bounded(pairs: Iterable[tuple[Row, Row]]) -> list[tuple[float, float]]:
    """Returns the pairs whose numbers are both known and finite."""
    return [(x[0], y[0]) for x, y in pairs if is_bounded((*x, *y))]


def is_bounded(row: Sequence[float | None]) -> bool:
    """Returns whether all numbers of a row are known and finite."""
    return all(number is not None and isfinite(number) for number in row)


def report_fault(
    sink: Sink, code: str, message: str, place: Origin, hint: str, *, possible: bool, at: At = "value"
) -> None:
    """Reports a rule's finding. `possible`: only some draws have it, so it is a warning."""
    if possible:
        code, message, hint = "SC514", f"in some scene {message}", f"each scene is checked when it is built; {hint}"
    sink.report(code, message, place, at=at, hint=hint)


def judged_limits(value: Value, *, drawn: bool) -> Sequence[Row]:
    """Returns rows of two numbers to check that the first does not exceed the second; empty if `is_deferred`."""
    if is_deferred([value], drawn=drawn):
        return ()
    found = alternatives(value)
    return [(highest(value)[0], lowest(value)[1])] if found is None else found


def _needs_drawn_rows(value: Value) -> bool:
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
