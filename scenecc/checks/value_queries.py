"""The rows by which a rule judges values, and the report of what it finds.

Rows that are known are judged scene by scene. Plain forms are judged by all that they can draw, since no seed may
decide whether a file is right. Expressions are judged by their samples, and by their rows once they are drawn.
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
        found: what the rule says of it.
        sample: the scene and the seed of the sample, where other samples are right; None: every seed has the fault.
    """

    found: Any
    sample: tuple[int, int] | None


def find_fault(
    values: Sequence[Value],
    judge: Callable[..., Any],
    *,
    drawn: bool,
    corners: Callable[[], Iterable[tuple[Row, ...]]] | None = None,
) -> Fault | None:
    """The first row of some values that breaks a rule.

    Args:
        values: of one object.
        judge: takes a row of each value; gives what is wrong, or None.
        drawn: judge only the rows of expressions that have been drawn.
        corners: gives the rows by which plain forms are judged; None: those where all values are least, and greatest.
    """
    sampled = any(map(is_sampled, values))
    if drawn and not sampled:
        return None
    every = rows(values, drawn=drawn)
    if every is None:
        every = list((corners or (lambda: [tuple(map(lowest, values)), tuple(map(highest, values))]))())
    faults = [(number, found) for number, row in enumerate(every) if (found := judge(*row)) is not None]
    if not faults:
        return None
    number, found = faults[0]
    if drawn or not sampled or len(every) == 1:
        return Fault(found, None)
    from scenecc.variation.samples import same_scene, sample_of  # noqa: PLC0415 - loaded where something varies

    scenes = next(value.scenes for value in values if value.scenes)
    is_certain = {row for row, _ in faults}.issuperset(same_scene(number, len(scenes)))
    return Fault(found, None if is_certain else sample_of(number, scenes))


def find_single_fault(value: Value, judge: Callable[[Row], Any], *, drawn: bool) -> Fault | None:
    """As `find_fault`, of one value: each alternative of a plain form, or else its least and its greatest row."""
    return find_fault([value], judge, drawn=drawn, corners=lambda: [(row,) for row in alternatives_or_extremes(value)])


def wrong_pair(a: Value, b: Value, is_wrong: Callable[[float, float], bool], *, drawn: bool) -> Fault | None:
    """The first pair of numbers of two values, of which the first must not be above the second."""

    def judge(x: Row, y: Row) -> tuple[float, float] | None:
        return (x[0], y[0]) if is_wrong(x[0], y[0]) else None

    return find_fault([a, b], judge, drawn=drawn, corners=lambda: [(highest(a), lowest(b))])


def reversed_limits(value: Value, judge: Callable[[Row], Any], *, drawn: bool) -> Fault | None:
    """The first row [low, high] of a value that breaks a rule about their order."""

    def corners() -> Iterable[tuple[Row, ...]]:
        found = list_alternatives(value)
        return [((highest(value)[0], lowest(value)[1]),)] if found is None else [(row,) for row in found]

    return find_fault([value], judge, drawn=drawn, corners=corners)


def rows(values: Sequence[Value], *, drawn: bool = False) -> list[tuple[Row, ...]] | None:
    """The rows of values side by side; None where plain forms have no rows yet.

    Of expressions these are the samples, or the rows that are drawn; none where the expression is at fault.
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
    return _side_by_side(columns, distinct=not sampled)


def _side_by_side(columns: list[NDArray[Any]], *, distinct: bool) -> list[tuple[Row, ...]]:
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.variation.evaluation import distinct_rows  # noqa: PLC0415 - likewise

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
    """Reports what a rule found. `sample`: as of `Fault`; then it is a warning."""
    if sample is not None:
        scene, seed = sample
        code, message = "SC514", f"in scene {scene} with seed {seed} {message}"
        hint = "; ".join(part for part in ("each scene is checked when it is built", hint) if part)
    sink.report(code, message, place, at=at, hint=hint)


def is_sampled(value: Value) -> bool:
    """Whether a value is judged by its samples, and by its rows once they are drawn."""
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
