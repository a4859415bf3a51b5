"""Selects the rows of values that a rule checks, and reports the faults that it finds.

Known rows are checked scene by scene. Plain forms are checked for all possible draws, because a file must not be valid
for some seeds only. Expressions are checked by their rows with this seed, and by samples of other seeds.
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
        found: the result of the rule.
        sample: the scene and the seed of the faulty row of an expression, the seed None for this one; None: every scene
            may have the fault.
    """

    found: Any
    sample: tuple[int, int | None] | None = None


def find_fault(
    values: Sequence[Value],
    rule: Callable[..., Any],
    *,
    corners: Callable[[], Iterable[tuple[Row, ...]]] | None = None,
) -> RuleFault | None:
    """Returns the first row of some values that breaks a rule, or None.

    Args:
        values: of one object.
        rule: takes a row of each value; returns the fault, or None.
        corners: returns the rows that are checked for plain forms; None: all values at their minimum, and at their
            maximum.
    """
    if any(map(is_sampled, values)):
        return _find_fault_of_expression(values, rule)
    every = _known_rows(values)
    if every is None:
        every = (corners or (lambda: [tuple(map(lowest, values)), tuple(map(highest, values))]))()
    found = _first_fault(every, rule)
    return None if found is None else RuleFault(found[1])


def _find_fault_of_expression(values: Sequence[Value], rule: Callable[..., Any]) -> RuleFault | None:
    scenes = next(value.scenes for value in values if value.scenes)
    every = _drawn_rows(values)
    found = _first_fault(every, rule)
    if found is not None:
        return RuleFault(found[1], (scenes[found[0]], None) if len(every) > 1 else None)
    found = _first_fault(_sample_rows(values), rule)
    if found is None:
        return None
    from scenecc.variation.samples import sample_of  # noqa: PLC0415 - loaded where something varies

    return RuleFault(found[1], sample_of(found[0], scenes))


def _first_fault(every: Iterable[tuple[Row, ...]], rule: Callable[..., Any]) -> tuple[int, Any] | None:
    """Returns the number of the first faulty row, and the fault."""
    results = ((number, rule(*row)) for number, row in enumerate(every))
    return next(((number, found) for number, found in results if found is not None), None)


def find_single_fault(value: Value, rule: Callable[[Row], Any]) -> RuleFault | None:
    """Like `find_fault`, for one value: checks each alternative of a plain form, or its minimum and its maximum."""
    return find_fault([value], rule, corners=lambda: [(row,) for row in alternatives_or_extremes(value)])


def find_wrong_pair(a: Value, b: Value, is_wrong: Callable[[float, float], bool]) -> RuleFault | None:
    """Returns the first pair of numbers of two values for which `is_wrong`, or None."""

    def rule(x: Row, y: Row) -> tuple[float, float] | None:
        return (x[0], y[0]) if is_wrong(x[0], y[0]) else None

    return find_fault([a, b], rule, corners=lambda: [(highest(a), lowest(b))])


def find_reversed_limits(value: Value, rule: Callable[[Row], Any]) -> RuleFault | None:
    """Returns the first row [low, high] of a value that breaks a rule about their order, or None."""

    def corners() -> Iterable[tuple[Row, ...]]:
        found = list_alternatives(value)
        return [((highest(value)[0], lowest(value)[1]),)] if found is None else [(row,) for row in found]

    return find_fault([value], rule, corners=corners)


def rows(values: Sequence[Value]) -> list[tuple[Row, ...]] | None:
    """Returns the rows of values side by side, with samples of expressions; None if plain forms have no rows yet."""
    if any(map(is_sampled, values)):
        return [*_drawn_rows(values), *_sample_rows(values)]
    return _known_rows(values)


def _known_rows(values: Sequence[Value]) -> list[tuple[Row, ...]] | None:
    """Returns the rows of known values side by side; None if plain forms have no rows yet."""
    if all(value.is_constant for value in values):
        return [tuple(value.numbers() for value in values)]
    if not all(value.known for value in values):
        return None
    return _join_columns([value.data for value in values], distinct=True)


def _drawn_rows(values: Sequence[Value]) -> list[tuple[Row, ...]]:
    """Returns a row of this seed for each scene; none if a value depends on a placement."""
    from scenecc.variation.operations import DrawError  # noqa: PLC0415 - loaded where something varies

    try:
        return _join_columns([value.data for value in values], distinct=False)
    except DrawError:
        return []


def _sample_rows(values: Sequence[Value]) -> list[tuple[Row, ...]]:
    """Returns a row for each sample; none if a sample is missing or wrong, which was reported."""
    from scenecc.variation.operations import DrawError  # noqa: PLC0415 - loaded where something varies

    try:
        return _join_columns([value.samples for value in values], distinct=False)
    except DrawError:
        return []


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
    sample: tuple[int, int | None] | None = None,
    *,
    at: At = "value",
) -> None:
    """Reports a fault; a warning (SC514) if only another seed has it. `sample`: as in `RuleFault`."""
    if sample is not None:
        from scenecc.variation.samples import name_sample, sample_hint  # noqa: PLC0415 - loaded where something varies

        scene, seed = sample
        message = f"{name_sample(scene, seed)}: {message}"
        if seed is not None:
            code, hint = "SC514", sample_hint(seed, hint)
    sink.report(code, message, place, at=at, hint=hint)


def is_sampled(value: Value) -> bool:
    """Returns whether a value is checked by the rows of this seed and by samples."""
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
