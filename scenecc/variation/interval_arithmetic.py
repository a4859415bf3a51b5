"""Bounds of operators and functions from the bounds of their operands.

Rounding keeps order, so what is computed at the ends bounds what is computed between them.
"""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

Interval = tuple[float, float]

EVERYTHING: Interval = (-math.inf, math.inf)


def _add(a: Interval, b: Interval) -> Interval:
    return _sorted(a[0] + b[0], a[1] + b[1])


def _subtract(a: Interval, b: Interval) -> Interval:
    return _sorted(a[0] - b[1], a[1] - b[0])


def _multiply(a: Interval, b: Interval) -> Interval:
    # An end without bound stands for large numbers, and 0 times those is 0.
    return _sorted(*(0.0 if x == 0 or y == 0 else x * y for x, y in product(a, b)))


def _divide(a: Interval, b: Interval) -> Interval:
    if b[0] <= 0 <= b[1]:
        return EVERYTHING
    return _sorted(*(_quotient(x, y) for x, y in product(a, b)))


def _quotient(x: float, y: float) -> float:
    if math.isinf(y):
        return 0.0 if not math.isinf(x) else math.nan
    return x / y


def _floor_divide(a: Interval, b: Interval) -> Interval:
    low, high = _divide(a, b)
    # Python's // takes the floor of the true quotient, of which / has the nearest number.
    return (_floor(low) - 1, _floor(high) + 1) if b[0] != b[1] or b[0] != 1 else (_floor(low), _floor(high))


def _floor(x: float) -> float:
    return math.floor(x) if math.isfinite(x) else x


def _floor_divide_integers(a: Interval, b: Interval) -> Interval:
    if b[0] <= 0 <= b[1] or not all(map(math.isfinite, (*a, *b))):
        return _floor_divide(a, b)
    return _sorted(*(x // y for x, y in product(a, b)))


def _remainder_of_integers(a: Interval, b: Interval) -> Interval:
    low, high = _remainder(a, b)
    # It is less than what it is divided by, which only rounding can hide.
    return (low + 1 if low == b[0] < 0 else low, high - 1 if high == b[1] > 0 else high)


def _remainder(a: Interval, b: Interval) -> Interval:
    if b[0] <= 0 <= b[1]:
        return EVERYTHING
    if b[0] > 0:
        return a if a[0] >= 0 and a[1] < b[0] else (0.0, b[1])
    return (b[0], 0.0)


def _power(a: Interval, b: Interval) -> Interval:
    whole = b[0] == b[1] and b[0] == math.floor(b[0])
    if a[0] > 0 or (a[0] == 0 and b[0] >= 0):
        return _sorted(*(_raised(x, y) for x, y in product(a, b)))
    if not whole or b[0] < 0:
        return EVERYTHING
    ends = _sorted(_raised(a[0], b[0]), _raised(a[1], b[0]))
    # An even power has its least value at 0, where the base passes it.
    return (0.0, ends[1]) if b[0] % 2 == 0 and b[0] > 0 and a[1] >= 0 else ends


def _raised(x: float, y: float) -> float:
    try:
        return float(x) ** float(y)
    except OverflowError:
        return math.inf if x > 0 or y % 2 == 0 else -math.inf


BINARY_INTERVALS: dict[str, Callable[[Interval, Interval], Interval]] = {
    "Add": _add,
    "Sub": _subtract,
    "Mult": _multiply,
    "Div": _divide,
    "FloorDiv": _floor_divide,
    "Mod": _remainder,
    "Pow": _power,
}
"""By the name of the node's type in Python's `ast`."""


DIVISIONS = frozenset(("Div", "FloorDiv", "Mod"))
"""Operators whose second operand is not 0."""

_OF_INTEGERS: dict[str, Callable[[Interval, Interval], Interval]] = {
    "FloorDiv": _floor_divide_integers,
    "Mod": _remainder_of_integers,
}


def binary_interval(name: str, a: Interval, b: Interval, *, whole: bool) -> Interval:
    """The bounds of an operator; `whole`: whose operands are integers."""
    return (_OF_INTEGERS.get(name, BINARY_INTERVALS[name]) if whole else BINARY_INTERVALS[name])(a, b)


def squared_interval(a: Interval) -> Interval:
    """The bounds of a number times itself."""
    low, high = _sorted(a[0] * a[0], a[1] * a[1])
    return (0.0 if a[0] <= 0 <= a[1] else low), high


def reaches_ends(name: str, b: Interval) -> bool:
    """Whether an operator of which one operand is constant reaches its bounds; `b` is its second."""
    return name in {"Add", "Sub", "Mult"} or (name == "Div" and not b[0] <= 0 <= b[1])


def comparison_outcomes(name: str, a: Interval, b: Interval) -> set[bool]:
    """The outcomes that a comparison can have."""
    (al, ah), (bl, bh) = a, b
    apart, one = ah < bl or bh < al, al == ah == bl == bh
    always, never = {
        "Lt": (ah < bl, al >= bh),
        "LtE": (ah <= bl, al > bh),
        "Gt": (al > bh, ah <= bl),
        "GtE": (al >= bh, ah < bl),
        "Eq": (one, apart),
        "NotEq": (apart, one),
    }[name]
    return {True} if always else {False} if never else {True, False}


def _monotone(function: Callable[[float], float]) -> Callable[[list[Interval]], Interval]:
    def run(arguments: list[Interval]) -> Interval:
        low, high = arguments[0]
        return (function(low) if math.isfinite(low) else low), (function(high) if math.isfinite(high) else high)

    return run


def _absolute(arguments: list[Interval]) -> Interval:
    low, high = arguments[0]
    if low <= 0 <= high:
        return (0.0, max(-low, high))
    return _sorted(abs(low), abs(high))


def _cosine(arguments: list[Interval]) -> Interval:
    return _wave(arguments[0], math.cos, 0.0)


def _sine(arguments: list[Interval]) -> Interval:
    return _wave(arguments[0], math.sin, math.pi / 2)


def _wave(angle: Interval, function: Callable[[float], float], crest: float) -> Interval:
    """Of a wave whose crest is at an angle; a crest or trough just outside is counted in."""
    low, high = angle
    if not (math.isfinite(low) and math.isfinite(high)) or max(-low, high) > 1e6 or high - low >= 2 * math.pi:
        return (-1.0, 1.0)
    ends = _sorted(function(low), function(high))
    return (
        -1.0 if _passes(low, high, crest + math.pi) else ends[0],
        1.0 if _passes(low, high, crest) else ends[1],
    )


def _passes(low: float, high: float, phase: float, period: float = 2 * math.pi) -> bool:
    slack = 1e-9
    return math.floor((high + slack - phase) / period) > math.floor((low - slack - phase) / period)


def _tangent(arguments: list[Interval]) -> Interval:
    low, high = arguments[0]
    if not (math.isfinite(low) and math.isfinite(high)) or max(-low, high) > 1e6:
        return EVERYTHING
    if _passes(low, high, math.pi / 2, math.pi) or high - low >= math.pi:
        return EVERYTHING
    return math.tan(low), math.tan(high)


def _rounded(arguments: list[Interval]) -> Interval:
    if len(arguments) == 1:
        return _monotone(round)(arguments)
    digits = int(min(arguments[1]))
    step = 10.0 ** -min(max(digits, -30), 30)
    low, high = arguments[0]
    return low - step, high + step


FUNCTION_INTERVALS: dict[str, Callable[[list[Interval]], Interval]] = {
    "min": lambda arguments: (min(a[0] for a in arguments), min(a[1] for a in arguments)),
    "max": lambda arguments: (max(a[0] for a in arguments), max(a[1] for a in arguments)),
    "abs": _absolute,
    # What is below 0 has no root, and is reported where it is drawn.
    "sqrt": lambda arguments: _monotone(math.sqrt)([(max(arguments[0][0], 0.0), max(arguments[0][1], 0.0))]),
    "sin": _sine,
    "cos": _cosine,
    "tan": _tangent,
    "atan2": lambda _: (-math.pi, math.pi),
    "radians": _monotone(math.radians),
    "degrees": _monotone(math.degrees),
    "floor": _monotone(math.floor),
    "ceil": _monotone(math.ceil),
    "round": _rounded,
}
"""By name, all but `len`."""


def _sorted(*ends: float) -> Interval:
    """From the least to the greatest; everything where one of them is none."""
    if any(math.isnan(end) for end in ends):
        return EVERYTHING
    return min(ends), max(ends)
