"""What follows from a condition for what it compares."""

from __future__ import annotations

import ast
import math
from dataclasses import replace
from typing import TYPE_CHECKING

from scenecc.values import interval_rules
from scenecc.values.reach import Reach, bounds_of

if TYPE_CHECKING:
    from collections.abc import Callable

Narrowed = dict[str, Reach]
"""What is known of parts of an expression, by how they are written: the same text has the same value."""

_EXACT = 2.0**53
"""Up to here every integer is a float, so that there is none between two floats."""

_OTHERWISE = {"Lt": "GtE", "LtE": "Gt", "Gt": "LtE", "GtE": "Lt", "Eq": "NotEq", "NotEq": "Eq"}
_FLIPPED = {"Lt": "Gt", "LtE": "GtE", "Gt": "Lt", "GtE": "LtE", "Eq": "Eq", "NotEq": "NotEq"}


def written(node: ast.expr) -> str:
    """A part of an expression as a key."""
    return ast.dump(node)


def narrowed(test: ast.expr, *, holds: bool, reach: Callable[[ast.expr], Reach]) -> Narrowed:
    """What is known of the parts of a condition where it holds, or where it does not.

    Args:
        test: the condition.
        holds: whether it does.
        reach: of a part of it.
    """
    match test:
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return narrowed(operand, holds=not holds, reach=reach)
        case ast.BoolOp(op=op, values=values):
            if isinstance(op, ast.And) is not holds:
                return {}
            found: Narrowed = {}
            for value in values:
                found |= narrowed(value, holds=holds, reach=_after(found, reach))
            return found
        case ast.Compare(left=left, ops=ops, comparators=others):
            if len(ops) > 1 and not holds:
                return {}
            found = {}
            for a, op, b in zip([left, *others], ops, others, strict=False):
                name = type(op).__name__ if holds else _OTHERWISE[type(op).__name__]
                first, second = found.get(written(a)) or reach(a), reach(b)
                found[written(a)] = _compared(first, name, second)
                found[written(b)] = _compared(second, _FLIPPED[name], first)
            return found
        case _:
            return {written(test): _true(reach(test), holds=holds)}


def _after(found: Narrowed, reach: Callable[[ast.expr], Reach]) -> Callable[[ast.expr], Reach]:
    """The reach of a part, of which something may be known already."""
    return lambda node: found.get(written(node)) or reach(node)


def _true(part: Reach, *, holds: bool) -> Reach:
    if part.values is not None:
        kept = tuple(value for value in part.values if bool(value) is holds)
        return replace(part, values=kept, exact=False) if kept else part
    if bounds_of(part) is None:
        return part
    return replace(part, nonzero=True) if holds else Reach(values=(0.0, 0))


def _compared(part: Reach, name: str, other: Reach) -> Reach:
    """What is left of a number of which a comparison holds."""
    limits = bounds_of(other)
    if limits is None:
        return part
    if part.values is not None:
        if bounds_of(part) is None:
            return part
        kept = tuple(value for value in part.values if True in interval_rules.compared(name, (value, value), limits))
        return replace(part, values=kept, exact=False) if kept else part
    if part.items is not None:
        return part
    # What can be compared with a number is one.
    low = -math.inf if part.low is None else part.low
    high = math.inf if part.high is None else part.high
    if name in {"Lt", "LtE", "Eq"}:
        high = min(high, _below(limits[1], whole=part.whole) if name == "Lt" else limits[1])
    if name in {"Gt", "GtE", "Eq"}:
        low = max(low, -_below(-limits[0], whole=part.whole) if name == "Gt" else limits[0])
    nonzero = part.nonzero or (name == "NotEq" and limits == (0, 0)) or (name == "Eq" and not other.may_be_zero())
    if low > high:
        return part
    return Reach(low=low, high=high, whole=part.whole, nonzero=nonzero)


def _below(limit: float, *, whole: bool) -> float:
    """The greatest number below a limit, or something above it."""
    if not abs(limit) < _EXACT:
        return limit
    return math.ceil(limit) - 1 if whole else math.nextafter(limit, -math.inf)
