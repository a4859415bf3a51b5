"""What a rule judges of a value: all that it can be, without drawing it, or else its rows once they are drawn.

What is known by scene is judged scene by scene. What forms draw is judged by the corners of all that it can be, since
no seed may decide whether a file is right. An expression may tie values together (a sliding friction that is a share
of the sticking one), so a rule that one is part of is judged by rows, once there are some.
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
    """Whether a rule is none of this stage's: it is the draw stage's (`drawn`) if a value of it holds an expression."""
    return any(map(_needs_drawn_rows, values)) is not drawn


def rows(values: Sequence[Value]) -> Iterator[tuple[Row, ...]] | None:
    """The rows of values that are known, or were drawn since one holds an expression, side by side.

    None where a rule has to be judged by corners.
    """
    if all(value.is_constant for value in values):
        return iter([tuple(value.numbers() for value in values)])
    if not all(value.known for value in values) and not any(_needs_drawn_rows(value) for value in values):
        return None
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.variation.evaluation import distinct_rows  # noqa: PLC0415 - likewise

    columns = [value.data.reshape(len(value.data), -1) for value in values]
    count = max(map(len, columns))
    columns = [np.broadcast_to(column, (count, column.shape[1])) for column in columns]
    # A cycle has few rows, however many scenes there are.
    first = distinct_rows(np.concatenate(columns, axis=1))
    return zip(*(map(tuple, column[first].tolist()) for column in columns), strict=True)


def list_alternatives(value: Value) -> list[Row] | None:
    """Every row that one value can have; None where they lie between bounds."""
    found = rows([value])
    if found is not None:
        return [row for (row,) in found]
    several = value.bounds.alternatives
    return None if several is None else list(map(_as_row, several))


def alternatives_or_extremes(value: Value) -> list[Row]:
    """Every row that a value can have, or else the least and the most that each of its numbers can be."""
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


def judged_pairs(a: Value, b: Value, *, drawn: bool) -> Sequence[tuple[float, float]]:
    """Pairs of numbers by which a rule judges that one value is not above another; none if `is_deferred`.

    Those of each scene, if known; otherwise the maximum of the first with the minimum of the second.
    """
    if is_deferred([a, b], drawn=drawn):
        return ()
    found = rows([a, b])
    return [(highest(a)[0], lowest(b)[0])] if found is None else [(x[0], y[0]) for x, y in found]


def wrong_pair(
    a: Value, b: Value, is_wrong: Callable[[float, float], bool], *, drawn: bool
) -> tuple[tuple[float, float], bool] | None:
    """The first wrong pair of numbers of two values, of which the first must not be above the second.

    Args:
        a: the value that must be small.
        b: the value that must be large.
        is_wrong: judges a pair of their numbers.
        drawn: judge only values of expressions, which are deferred until they are drawn.

    Returns:
        The pair, and whether it is only possible: expressions are not drawn yet, and some draws may give it.
    """
    possible = not drawn and is_deferred([a, b], drawn=False)
    pairs = _finite_pairs([(highest(a), lowest(b))]) if possible else judged_pairs(a, b, drawn=drawn)
    found = next((pair for pair in pairs if is_wrong(*pair)), None)
    if found is not None and possible and a.dependence is not None and b.dependence is not None:
        found = next((pair for pair in _joint_pairs(a.dependence, b.dependence) if is_wrong(*pair)), None)
    return None if found is None else (found, possible)


def _joint_pairs(a: Dependence, b: Dependence) -> list[tuple[float, float]]:
    """Pairs that two expressions may give together before they are drawn."""
    from scenecc.variation.node_bounds import joint_extremes  # noqa: PLC0415 - loaded where something varies
    from scenecc.variation.operations import DrawError  # noqa: PLC0415 - likewise

    try:
        return _finite_pairs((_as_row(x), _as_row(y)) for x, y in joint_extremes(a, b))
    except DrawError:  # reported at the expression
        return []


def _finite_pairs(pairs: Iterable[tuple[Row, Row]]) -> list[tuple[float, float]]:
    """The pairs of which both numbers are known and finite."""
    return [(x[0], y[0]) for x, y in pairs if is_bounded((*x, *y))]


def is_bounded(row: Sequence[float | None]) -> bool:
    """Whether all numbers of a row are known and finite."""
    return all(number is not None and isfinite(number) for number in row)


def report_fault(
    sink: Sink, code: str, message: str, place: Origin, hint: str, *, possible: bool, at: At = "value"
) -> None:
    """Reports what a rule found. `possible`: only some draws have it, so that it is a warning."""
    if possible:
        code, message, hint = "SC514", f"in some scene {message}", f"each scene is judged as it is drawn; {hint}"
    sink.report(code, message, place, at=at, hint=hint)


def judged_limits(value: Value, *, drawn: bool) -> Sequence[Row]:
    """Rows of two numbers by which a rule judges that the first is not above the second; none if `is_deferred`."""
    if is_deferred([value], drawn=drawn):
        return ()
    found = list_alternatives(value)
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
