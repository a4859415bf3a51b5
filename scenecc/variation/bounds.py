"""Bounds of a value in any scene: of nodes, and of parts of expressions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.variation import operations
from scenecc.variation.operations import LISTS, NUMBERS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray


@frozen
class ValueBounds:
    """Everything that a value can be: one of some alternatives, or else within bounds.

    Attributes:
        alternatives: all of them, each once (numbers, booleans, strings, or tuples of such); None where
            they are too many or not known.
        low, high: a number, or one for each component as a tuple (or tuple of rows), that no value is below or
            above; infinite where there is no such bound. None where the value is not made of numbers, or
            may be anything.
        exact: whether each alternative, or each bound, can really occur (or be come as near to as one
            likes); otherwise these may lie wider than what occurs.
    """

    alternatives: tuple[Any, ...] | None
    low: Any
    high: Any
    exact: bool

    def numbers(self) -> tuple[float, ...]:
        """Numbers that bound everything it can be, row by row: of all alternatives, or of the lowest and highest."""
        if self.alternatives is not None:
            return tuple(flat_numbers(self.alternatives))
        return (*flat_numbers(self.low), *flat_numbers(self.high)) if self.low is not None else ()

    @staticmethod
    def of(alternatives: Iterable[Any], *, exact: bool = True) -> ValueBounds:
        """Of plain values; tuples and lists are one."""
        # By class too, since True is no 1.
        distinct = tuple({(item.__class__, item): item for item in map(_as_tuples, alternatives)}.values())
        low, high = _extremes(distinct)
        return ValueBounds(distinct, low, high, exact)

    @staticmethod
    def of_rows(rows: NDArray[Any]) -> ValueBounds:
        """Of values (B, …), each of which occurs."""
        from scenecc.variation.evaluation import distinct_rows  # noqa: PLC0415 - it loads numpy

        return ValueBounds.of(rows[distinct_rows(rows)].tolist())


UNKNOWN = ValueBounds(None, None, None, exact=False)
"""Anything at all."""


def affine_clamp_bounds(
    of: ValueBounds, factor: ValueBounds, offset: ValueBounds, low: ValueBounds, high: ValueBounds
) -> ValueBounds:
    """What a number can be that is moved and held (`AffineClamp`): by bounds, where all that it is made of has some."""
    bounds = (of, factor, offset, low, high)
    if any(part.low.__class__ not in NUMBERS or part.high.__class__ not in NUMBERS for part in bounds):
        return UNKNOWN
    products = [f * x for f in (factor.low, factor.high) for x in (of.low, of.high)]
    least, most = min(products) + offset.low, max(products) + offset.high
    exact = all(part.exact for part in bounds)
    return ValueBounds(None, max(min(least, high.low), low.low), max(min(most, high.high), low.high), exact=exact)


def component_bounds(found: ValueBounds, index: int) -> ValueBounds:
    """What one component of a tuple can be."""
    low, high = found.low, found.high
    if low.__class__ is not tuple or high.__class__ is not tuple or index >= len(low):
        return UNKNOWN
    return ValueBounds(None, low[index], high[index], found.exact)


def stack_bounds(parts: list[ValueBounds]) -> ValueBounds:
    """What several can be side by side."""
    if any(part.low is None for part in parts):
        return UNKNOWN
    low, high = tuple(part.low for part in parts), tuple(part.high for part in parts)
    return ValueBounds(None, low, high, all(part.exact for part in parts))


def union_bounds(several: Iterable[ValueBounds]) -> ValueBounds:
    """What any of several can be."""
    parts = list(several)
    exact = all(part.exact for part in parts)
    if all(part.alternatives is not None for part in parts):
        return ValueBounds.of((item for part in parts for item in part.alternatives or ()), exact=exact)
    if any(part.low is None for part in parts):
        return UNKNOWN
    low, high = _hull([p.low for p in parts], [p.high for p in parts])
    return UNKNOWN if low is None else ValueBounds(None, low, high, exact)


def _hull(lows: list[Any], highs: list[Any]) -> tuple[Any, Any]:
    """The least and greatest of several values, each component by itself; None where they differ in shape."""
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


MAX_KNOWN_VALUES = 64
"""How many values, or combinations of values, are followed one by one."""


@frozen
class ExpressionBounds:
    """What an expression can give: one of few values, a number within bounds, a list of such, or anything.

    Attributes:
        values: all of them; None where they are too many or not known.
        low, high: of a number that is not one of few; None of anything else.
        items: of a list that is not one of few; None of anything else.
        exact: whether every value, or every bound, can occur.
        whole: whether a number that is not one of few is an integer in any case.
        nonzero: whether it is not 0 in any case, though that may lie between its bounds.
    """

    values: tuple[Any, ...] | None = None
    low: float | None = None
    high: float | None = None
    items: tuple[ExpressionBounds, ...] | None = None
    exact: bool = False
    whole: bool = False
    nonzero: bool = False

    @property
    def is_whole(self) -> bool:
        """Whether it is an integer in any case."""
        return self.whole if self.values is None else all(type(value) is int for value in self.values)

    def may_be_zero(self) -> bool:
        """Whether it can be the number 0."""
        if self.values is not None:
            return any(operations.is_number(value) and value == 0 for value in self.values)
        return not self.nonzero and self.low is not None and self.high is not None and self.low <= 0 <= self.high


ANYTHING = ExpressionBounds()


def bounds_of_values(values: Iterable[Any], *, exact: bool = True) -> ExpressionBounds:
    """One of some values; what bounds them where they are many."""
    distinct = list({(value.__class__, repr(value)): value for value in values}.values())
    if not distinct:
        return ANYTHING
    if len(distinct) <= MAX_KNOWN_VALUES:
        return ExpressionBounds(values=tuple(distinct), exact=exact)
    if all(map(operations.is_number, distinct)):
        whole = all(type(value) is int for value in distinct)
        return ExpressionBounds(
            low=min(distinct), high=max(distinct), exact=exact, whole=whole, nonzero=0 not in distinct
        )
    return ANYTHING


def to_expression_bounds(found: ValueBounds, *, whole: bool = False) -> ExpressionBounds:
    """The bounds of a name whose values have known bounds; `whole`: all numbers of it are integers."""
    if found.alternatives is not None:
        reached = bounds_of_values(found.alternatives, exact=found.exact)
        if reached is not ANYTHING:
            return reached
    return _bounds_between(found.low, found.high, found.exact, whole)


def to_value_bounds(found: ExpressionBounds) -> ValueBounds:
    """The bounds of the values of an expression."""
    if found.values is not None:
        return ValueBounds.of(found.values, exact=found.exact)
    if found.items is not None:
        return stack_bounds(list(map(to_value_bounds, found.items)))
    return UNKNOWN if found.low is None else ValueBounds(None, found.low, found.high, found.exact)


def example_values(found: ExpressionBounds) -> list[Any]:
    """Values of every kind and length that something can have, its numbers but for known ones being 1; none where that
    is not known.
    """
    if found.values is not None:
        return list(found.values)
    if found.low is not None:
        return [1 if found.whole else 1.0]
    items = [next(iter(example_values(item)), None) for item in found.items or ()]
    return [] if found.items is None or None in items else [items]


def join_bounds(parts: list[ExpressionBounds]) -> ExpressionBounds:
    """Any of several."""
    if len(parts) == 1:
        return parts[0]
    if all(part.values is not None for part in parts):
        return bounds_of_values((value for part in parts for value in part.values or ()), exact=False)
    bounds = [interval_of(part) for part in parts]
    if all(bound is not None for bound in bounds):
        return ExpressionBounds(
            low=min(b[0] for b in bounds if b),
            high=max(b[1] for b in bounds if b),
            whole=all(part.is_whole for part in parts),
            nonzero=not any(part.may_be_zero() for part in parts),
        )
    lists = [items_of(part) for part in parts]
    if all(items is not None for items in lists) and len({len(items or ()) for items in lists}) == 1:
        return ExpressionBounds(
            items=tuple(join_bounds(list(column)) for column in zip(*(items or () for items in lists), strict=True))
        )
    return ANYTHING


def are_exact(parts: list[ExpressionBounds]) -> bool:
    """Whether all combinations can occur: where one part varies at most, since two may read the same draw."""
    varying = [part for part in parts if part.values is None or len(part.values) > 1]
    return len(varying) <= 1 and all(part.exact for part in parts)


def interval_of(part: ExpressionBounds) -> tuple[float, float] | None:
    """The bounds of what is a number in any case."""
    if part.values is not None:
        if not all(map(operations.is_number, part.values)):
            return None
        return min(part.values), max(part.values)
    return None if part.low is None or part.high is None else (part.low, part.high)


def items_of(part: ExpressionBounds) -> tuple[ExpressionBounds, ...] | None:
    """The reaches of a list's items."""
    if part.values is None:
        return part.items
    if not all(type(value) in operations.LISTS for value in part.values) or len({*map(len, part.values)}) != 1:
        return None
    return tuple(bounds_of_values(column, exact=part.exact) for column in zip(*part.values, strict=True))


def truth_values(part: ExpressionBounds) -> set[bool]:
    """What it can be as a condition."""
    if part.values is not None:
        return {bool(value) for value in part.values}
    bounds = interval_of(part)
    if bounds is None:
        return {True, False}
    return {False} if bounds == (0, 0) else {True, False} if part.may_be_zero() else {True}


def _bounds_between(low: Any, high: Any, exact: bool, whole: bool) -> ExpressionBounds:  # noqa: FBT001
    if low is None:
        return ANYTHING
    if low.__class__ is tuple:
        items = tuple(_bounds_between(a, b, exact, whole) for a, b in zip(low, high, strict=True))
        return ExpressionBounds(items=items, exact=exact)
    return ExpressionBounds(low=low, high=high, exact=exact, whole=whole)
