"""What an expression can give, as far as that is known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.values import operations
from scenecc.values.support import UNKNOWN, Support

if TYPE_CHECKING:
    from collections.abc import Iterable

FEW = 64
"""How many values, or combinations of values, are followed one by one."""


@frozen
class Reach:
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
    items: tuple[Reach, ...] | None = None
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


ANYTHING = Reach()


def known(values: Iterable[Any], *, exact: bool = True) -> Reach:
    """One of some values; what bounds them where they are many."""
    distinct = list({(value.__class__, repr(value)): value for value in values}.values())
    if not distinct:
        return ANYTHING
    if len(distinct) <= FEW:
        return Reach(values=tuple(distinct), exact=exact)
    if all(map(operations.is_number, distinct)):
        whole = all(type(value) is int for value in distinct)
        return Reach(low=min(distinct), high=max(distinct), exact=exact, whole=whole, nonzero=0 not in distinct)
    return ANYTHING


def reach_of(found: Support, *, whole: bool = False) -> Reach:
    """The reach of a name whose support is known; `whole`: and that all numbers of it are integers."""
    if found.alternatives is not None:
        reached = known(found.alternatives, exact=found.exact)
        if reached is not ANYTHING:
            return reached
    return _between(found.low, found.high, found.exact, whole)


def support_of(found: Reach) -> Support:
    """The support of what has a reach."""
    if found.values is not None:
        return Support.of(found.values, exact=found.exact)
    if found.items is not None:
        parts = [support_of(item) for item in found.items]
        if any(part.low is None for part in parts):
            return UNKNOWN
        return Support(None, tuple(p.low for p in parts), tuple(p.high for p in parts), all(p.exact for p in parts))
    return UNKNOWN if found.low is None else Support(None, found.low, found.high, found.exact)


def examples(found: Reach) -> list[Any]:
    """Values of every kind and length that something can have, its numbers but for known ones being 1; none where that
    is not known.
    """
    if found.values is not None:
        return list(found.values)
    if found.low is not None:
        return [1 if found.whole else 1.0]
    items = [next(iter(examples(item)), None) for item in found.items or ()]
    return [] if found.items is None or None in items else [items]


def join(parts: list[Reach]) -> Reach:
    """Any of several."""
    if len(parts) == 1:
        return parts[0]
    if all(part.values is not None for part in parts):
        return known((value for part in parts for value in part.values or ()), exact=False)
    bounds = [bounds_of(part) for part in parts]
    if all(bound is not None for bound in bounds):
        return Reach(
            low=min(b[0] for b in bounds if b),
            high=max(b[1] for b in bounds if b),
            whole=all(part.is_whole for part in parts),
            nonzero=not any(part.may_be_zero() for part in parts),
        )
    lists = [items_of(part) for part in parts]
    if all(items is not None for items in lists) and len({len(items or ()) for items in lists}) == 1:
        return Reach(items=tuple(join(list(column)) for column in zip(*(items or () for items in lists), strict=True)))
    return ANYTHING


def are_exact(parts: list[Reach]) -> bool:
    """Whether all combinations can occur: where one part varies at most, since two may read the same draw."""
    varying = [part for part in parts if part.values is None or len(part.values) > 1]
    return len(varying) <= 1 and all(part.exact for part in parts)


def bounds_of(part: Reach) -> tuple[float, float] | None:
    """The bounds of what is a number in any case."""
    if part.values is not None:
        if not all(map(operations.is_number, part.values)):
            return None
        return min(part.values), max(part.values)
    return None if part.low is None or part.high is None else (part.low, part.high)


def items_of(part: Reach) -> tuple[Reach, ...] | None:
    """The reaches of a list's items."""
    if part.values is None:
        return part.items
    if not all(type(value) in operations.LISTS for value in part.values) or len({*map(len, part.values)}) != 1:
        return None
    return tuple(known(column, exact=part.exact) for column in zip(*part.values, strict=True))


def truths_of(part: Reach) -> set[bool]:
    """What it can be as a condition."""
    if part.values is not None:
        return {bool(value) for value in part.values}
    bounds = bounds_of(part)
    if bounds is None:
        return {True, False}
    return {False} if bounds == (0, 0) else {True, False} if part.may_be_zero() else {True}


def _between(low: Any, high: Any, exact: bool, whole: bool) -> Reach:  # noqa: FBT001
    if low is None:
        return ANYTHING
    if low.__class__ is tuple:
        items = tuple(_between(a, b, exact, whole) for a, b in zip(low, high, strict=True))
        return Reach(items=items, exact=exact)
    return Reach(low=low, high=high, exact=exact, whole=whole)
