"""Selects the rows of values that a rule checks, and reports the faults that it finds.

Known rows are checked scene by scene. Plain forms are checked for all possible draws, because a file must not be valid
for some seeds only. Expressions are checked by their samples, and by their rows once they are drawn.
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


class Fault(NamedTuple):
    """A row of values that breaks a rule.

    Attributes:
        found: the result of the rule.
        sample: scene and seed of the faulty sample, if other samples are valid; None: every seed has the fault.
    """

    found: Any
    sample: tuple[int, int] | None


def find_fault(
    values: Sequence[Value],
    rule: Callable[..., Any],
    *,
    drawn: bool,
    corners: Callable[[], Iterable[tuple[Row, ...]]] | None = None,
) -> Fault | None:
    """Returns the first row of some values that breaks a rule, or None.

    Args:
        values: of one object.
        rule: takes a row of each value; returns the fault, or None.
        drawn: check only drawn rows of expressions.
        corners: returns the rows that are checked for plain forms; None: all values at their minimum, and at their
            maximum.
    """
    sampled = any(map(is_sampled, values))
    if drawn and not sampled:
        return None
    every = rows(values, drawn=drawn)
    if every is None:
        every = list((corners or (lambda: [tuple(map(lowest, values)), tuple(map(highest, values))]))())
    faults = [(number, found) for number, row in enumerate(every) if (found := rule(*row)) is not None]
    if not faults:
        return None
    number, found = faults[0]
    if drawn or not sampled or len(every) == 1:
        return Fault(found, None)
    from scenecc.variation.samples import same_scene, sample_of  # noqa: PLC0415 - loaded where something varies

    scenes = next(value.scenes for value in values if value.scenes)
    is_certain = {row for row, _ in faults}.issuperset(same_scene(number, len(scenes)))
    return Fault(found, None if is_certain else sample_of(number, scenes))


def find_single_fault(value: Value, rule: Callable[[Row], Any], *, drawn: bool) -> Fault | None:
    """Like `find_fault`, for one value: checks each alternative of a plain form, or its minimum and its maximum."""
    return find_fault([value], rule, drawn=drawn, corners=lambda: [(row,) for row in alternatives_or_extremes(value)])


def find_wrong_pair(a: Value, b: Value, is_wrong: Callable[[float, float], bool], *, drawn: bool) -> Fault | None:
    """Returns the first pair of numbers of two values for which `is_wrong`, or None."""

    def rule(x: Row, y: Row) -> tuple[float, float] | None:
        return (x[0], y[0]) if is_wrong(x[0], y[0]) else None

    return find_fault([a, b], rule, drawn=drawn, corners=lambda: [(highest(a), lowest(b))])


def find_reversed_limits(value: Value, rule: Callable[[Row], Any], *, drawn: bool) -> Fault | None:
    """Returns the first row [low, high] of a value that breaks a rule about their order, or None."""

    def corners() -> Iterable[tuple[Row, ...]]:
        found = list_alternatives(value)
        return [((highest(value)[0], lowest(value)[1]),)] if found is None else [(row,) for row in found]

    return find_fault([value], rule, drawn=drawn, corners=corners)


def rows(values: Sequence[Value], *, drawn: bool = False) -> list[tuple[Row, ...]] | None:
    """Returns the rows of values side by side; None if plain forms have no rows yet.

    For expressions, these are the samples or the drawn rows; empty if an expression is faulty.
    """
    if all(value.is_constant for value in values):
        return [tuple(value.numbers() for value in values)]
    sampled = any(map(is_sampled, values))
    if not sampled and not all(value.known for value in values):
        return None
    from scenecc.variation.operations import DrawError  # noqa: PLC0415 - loaded where something varies

    try:
        columns = [value.samples if sampled and not drawn else value.data for value in values]
    except DrawError:  # reported at the expression
        return []
    return _join_columns(columns, distinct=not sampled)


def _join_columns(columns: list[NDArray[Any]], *, distinct: bool) -> list[tuple[Row, ...]]:
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.variation.evaluation import distinct_rows  # noqa: PLC0415 - as above

    count = max(map(len, columns))
    flat = [np.broadcast_to(column.reshape(len(column), -1), (count, column[0].size)) for column in columns]
    if distinct:
        # A cycle has few rows, however many scenes there are.
        first = distinct_rows(np.concatenate(flat, axis=1))
        flat = [column[first] for column in flat]
    return list(zip(*(map(tuple, column.tolist()) for column in flat), strict=True))


def list_alternatives(value: Value) -> list[Row] | None:
    """Returns every row that a value can have; None if it is continuous."""
    found = rows([value]) if value.known else None
    if found is not None:
        return [row for (row,) in found]
    several = value.bounds.alternatives
    return None if several is None else list(map(_as_row, several))


def alternatives_or_extremes(value: Value) -> list[Row]:
    """Returns every row that a value can have; if it is continuous, the rows of the minimums and of the maximums."""
    found = list_alternatives(value)
    return [lowest(value), highest(value)] if found is None else found


def list_indices(value: Value) -> list[int]:
    """Returns every alternative of a table index, in order of first use."""
    return list(dict.fromkeys(map(int, value.numbers())))


def lowest(value: Value) -> Row:
    """Returns the minimum of each component."""
    return _extreme_row(value, high=False)


def highest(value: Value) -> Row:
    """Returns the maximum of each component."""
    return _extreme_row(value, high=True)


def is_bounded(row: Sequence[float | None]) -> bool:
    """Returns whether all numbers of a row are known and finite."""
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
    """Reports a fault; a warning (SC514) if it has a `sample`, as in `Fault`."""
    if sample is not None:
        scene, seed = sample
        code, message = "SC514", f"in scene {scene} with seed {seed} {message}"
        hint = "; ".join(part for part in ("each scene is checked when it is built", hint) if part)
    sink.report(code, message, place, at=at, hint=hint)


def is_sampled(value: Value) -> bool:
    """Returns whether a value is checked by its samples, and by its rows once they are drawn."""
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
