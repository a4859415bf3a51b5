"""Bounds of a value over all scenes."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.variation.operations import LISTS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray


MAX_ALTERNATIVES = 64
"""Most combinations of alternatives, or distinct samples, that are listed."""


@frozen
class ValueBounds:
    """The possible values of a quantity: some alternatives, or a range.

    Attributes:
        alternatives: each value once (numbers, booleans, strings, or tuples of these); None if too many or unknown.
        low, high: the lowest and the highest number, or one per component as a tuple (or a tuple of rows); infinite if
            unbounded. None if the value is not numeric or nothing is known.
        exact: whether every alternative or bound can occur, or be approached. Otherwise they come from samples, and
            rarer values may be outside.
    """

    alternatives: tuple[Any, ...] | None
    low: Any
    high: Any
    exact: bool

    def numbers(self) -> tuple[float, ...]:
        """The numbers of all alternatives, row by row, or of the lowest and the highest row."""
        if self.alternatives is not None:
            return tuple(flat_numbers(self.alternatives))
        return (*flat_numbers(self.low), *flat_numbers(self.high)) if self.low is not None else ()

    @staticmethod
    def of(alternatives: Iterable[Any], *, exact: bool = True) -> ValueBounds:
        """Bounds of plain values. Tuples and lists are equal."""
        # By class too, since True differs from 1.
        distinct = tuple({(item.__class__, item): item for item in map(_as_tuples, alternatives)}.values())
        low, high = _extremes(distinct)
        return ValueBounds(distinct, low, high, exact)

    @staticmethod
    def of_rows(rows: NDArray[Any], *, exact: bool = True) -> ValueBounds:
        """Bounds of values (B, …)."""
        from scenecc.variation.evaluation import distinct_rows  # noqa: PLC0415 - it loads numpy

        return ValueBounds.of(rows[distinct_rows(rows)].tolist(), exact=exact)

    @staticmethod
    def of_samples(rows: NDArray[Any]) -> ValueBounds:
        """Bounds of samples (256, …)."""
        found = ValueBounds.of_rows(rows)
        few = len(found.alternatives or ()) <= MAX_ALTERNATIVES
        return ValueBounds(found.alternatives if few else None, found.low, found.high, exact=False)


UNKNOWN = ValueBounds(None, None, None, exact=False)
"""No bounds are known."""


def component_bounds(found: ValueBounds, index: int) -> ValueBounds:
    """The bounds of one component of a tuple."""
    low, high = found.low, found.high
    if low.__class__ is not tuple or high.__class__ is not tuple or index >= len(low):
        return UNKNOWN
    if found.alternatives is not None:
        return ValueBounds.of((item[index] for item in found.alternatives), exact=found.exact)
    return ValueBounds(None, low[index], high[index], found.exact)


def combined_bounds(parts: Sequence[ValueBounds], join: Callable[[tuple[Any, ...]], Any]) -> ValueBounds:
    """The bounds of a value that `join` computes from independently drawn parts.

    `join` is monotone: the lowest parts give the lowest value.
    """
    exact = all(part.exact for part in parts)
    if math.prod(MAX_ALTERNATIVES + 1 if p.alternatives is None else len(p.alternatives) for p in parts) <= (
        MAX_ALTERNATIVES
    ):
        return ValueBounds.of(map(join, product(*(part.alternatives or () for part in parts))), exact=exact)
    if any(part.low is None for part in parts):
        return UNKNOWN
    return ValueBounds(None, join(tuple(p.low for p in parts)), join(tuple(p.high for p in parts)), exact)


def union_bounds(several: Iterable[ValueBounds]) -> ValueBounds:
    """Bounds over several values."""
    parts = list(several)
    exact = all(part.exact for part in parts)
    if all(part.alternatives is not None for part in parts):
        return ValueBounds.of((item for part in parts for item in part.alternatives or ()), exact=exact)
    if any(part.low is None for part in parts):
        return UNKNOWN
    low, high = _hull([p.low for p in parts], [p.high for p in parts])
    return UNKNOWN if low is None else ValueBounds(None, low, high, exact)


def _hull(lows: list[Any], highs: list[Any]) -> tuple[Any, Any]:
    """The least and greatest of several values per component; None if shapes differ."""
    try:
        return _componentwise(min, lows), _componentwise(max, highs)
    except ValueError:
        return None, None


def _componentwise(pick: Any, values: list[Any]) -> Any:
    tuples = {value.__class__ is tuple for value in values}
    if tuples == {False}:
        return pick(values)
    if len(tuples) > 1:
        raise ValueError("numbers and vectors")
    return tuple(_componentwise(pick, list(column)) for column in zip(*values, strict=True))


def _extremes(alternatives: tuple[Any, ...]) -> tuple[Any, Any]:
    if not alternatives or not all(map(_numeric, alternatives)):
        return None, None
    if len(alternatives) == 1:
        return alternatives[0], alternatives[0]
    return _hull(list(alternatives), list(alternatives))


def _numeric(value: Any) -> bool:
    if value.__class__ is tuple:
        return all(map(_numeric, value))
    return value.__class__ is float or value.__class__ is int


def _as_tuples(value: Any) -> Any:
    if value.__class__ in LISTS:
        return tuple(map(_as_tuples, value))
    return value


def flat_numbers(value: Any) -> Iterable[float]:
    """The numbers of a number or a nested tuple, in order."""
    if value.__class__ is tuple:
        for item in value:
            yield from flat_numbers(item)
    elif isinstance(value, int | float):
        yield value
