"""What a node can give in any scene, found without drawing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.values.operations import LISTS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray


_NUMBERS = frozenset((float, int))


@frozen
class Support:
    """Everything that a value can be: alternatives, or else bounds.

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
            return tuple(flat(self.alternatives))
        return (*flat(self.low), *flat(self.high)) if self.low is not None else ()

    @staticmethod
    def of(alternatives: Iterable[Any], *, exact: bool = True) -> Support:
        """Of plain values; tuples and lists are one."""
        # By class too, since True is no 1.
        distinct = tuple({(item.__class__, item): item for item in map(_tupled, alternatives)}.values())
        low, high = _extremes(distinct)
        return Support(distinct, low, high, exact)

    @staticmethod
    def of_rows(rows: NDArray[Any]) -> Support:
        """Of values (B, …), each of which occurs."""
        from scenecc.values.columns import distinct  # noqa: PLC0415 - it loads numpy

        return Support.of(rows[distinct(rows)].tolist())


UNKNOWN = Support(None, None, None, exact=False)
"""Anything at all."""


def held_support(of: Support, factor: Support, offset: Support, low: Support, high: Support) -> Support:
    """What a number can be that is moved and held (`nodes.Held`): by bounds, where all that it is made of has some."""
    bounds = (of, factor, offset, low, high)
    if any(part.low.__class__ not in _NUMBERS or part.high.__class__ not in _NUMBERS for part in bounds):
        return UNKNOWN
    products = [f * x for f in (factor.low, factor.high) for x in (of.low, of.high)]
    least, most = min(products) + offset.low, max(products) + offset.high
    exact = all(part.exact for part in bounds)
    return Support(None, max(min(least, high.low), low.low), max(min(most, high.high), low.high), exact=exact)


def component(found: Support, index: int) -> Support:
    """What one component of a tuple can be."""
    low, high = found.low, found.high
    if low.__class__ is not tuple or high.__class__ is not tuple or index >= len(low):
        return UNKNOWN
    return Support(None, low[index], high[index], found.exact)


def union(supports: Iterable[Support]) -> Support:
    """What any of several can be."""
    parts = list(supports)
    exact = all(part.exact for part in parts)
    if all(part.alternatives is not None for part in parts):
        return Support.of((item for part in parts for item in part.alternatives or ()), exact=exact)
    if any(part.low is None for part in parts):
        return UNKNOWN
    try:
        low, high = componentwise(min, [p.low for p in parts]), componentwise(max, [p.high for p in parts])
    except ValueError:
        return UNKNOWN
    return Support(None, low, high, exact)


def componentwise(pick: Any, values: list[Any]) -> Any:
    """The least or greatest of several values of one shape, each component by itself.

    Raises:
        ValueError: they differ in shape.
    """
    if values[0].__class__ is not tuple:
        if any(value.__class__ is tuple for value in values):
            raise ValueError("numbers and vectors")
        return pick(values)
    if any(value.__class__ is not tuple for value in values):
        raise ValueError("numbers and vectors")
    return tuple(componentwise(pick, list(column)) for column in zip(*values, strict=True))


def _extremes(alternatives: tuple[Any, ...]) -> tuple[Any, Any]:
    if not alternatives or not all(map(_numeric, alternatives)):
        return None, None
    if len(alternatives) == 1:
        return alternatives[0], alternatives[0]
    try:
        return componentwise(min, list(alternatives)), componentwise(max, list(alternatives))
    except ValueError:
        return None, None


def _numeric(value: Any) -> bool:
    if value.__class__ is tuple:
        return all(map(_numeric, value))
    return value.__class__ is float or value.__class__ is int


def _tupled(value: Any) -> Any:
    if value.__class__ in LISTS:
        return tuple(map(_tupled, value))
    return value


def flat(value: Any) -> Iterable[float]:
    """The numbers of a number or a nested tuple, in order."""
    if value.__class__ is tuple:
        for item in value:
            yield from flat(item)
    elif isinstance(value, int | float):
        yield value
