"""What the operators of expressions do with plain values.

A number is an int or a float, never a boolean; every number that comes out is finite and every int, string
and list bounded. Each takes the span (start, end) of the expression that it stands for, for its errors.
"""

from __future__ import annotations

import operator
import sys
from typing import TYPE_CHECKING, Any

from scenecc.values.failure import ExpressionError

if TYPE_CHECKING:
    from collections.abc import Callable

Span = tuple[int, int]
LISTS: frozenset[type[Any]] = frozenset((list, tuple))
SEQUENCES: frozenset[type[Any]] = frozenset((str, list, tuple))

LARGEST = sys.float_info.max
INT_BITS = 256
"""How many bits an int may have."""

HEAVIEST = 10_000
"""How much a list or string may hold: characters, and items of lists and of the lists in them."""

_INT_BOUND = 1 << INT_BITS
_KINDS: dict[type[Any], str] = {
    bool: "a boolean", int: "a number", float: "a number", str: "a string", list: "a list", tuple: "a list",
    dict: "a mapping",
}  # fmt: skip


def kind(value: Any) -> str:
    """What a message calls a value."""
    return _KINDS.get(value.__class__, "such a value")


def shown(value: Any, span: Span) -> str:
    """A value as it stands within a longer text: as YAML writes it."""
    if type(value) is bool:
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if is_number(value):
        return repr(value)
    raise ExpressionError(f"{kind(value)} cannot stand within a longer text", *span)


def is_number(value: Any) -> bool:
    """An int or a float."""
    return type(value) is float or type(value) is int


def finite(value: Any, span: Span) -> Any:
    """A number that is finite and not too large."""
    if type(value) is float:
        if -LARGEST <= value <= LARGEST:
            return value
        raise ExpressionError("the result is not a finite number", *span)
    if -_INT_BOUND < value < _INT_BOUND:
        return value
    raise ExpressionError(f"the integer has more than {INT_BITS} bits", *span)


def bounded(value: Any, span: Span) -> Any:
    """A string or list that is not too large."""
    if not fits(value, HEAVIEST):
        raise ExpressionError(f"the {_KINDS[type(value)][2:]} is larger than {HEAVIEST}", *span)
    return value


def fits(value: Any, limit: int) -> bool:
    """Whether a value, with all that is in it, is within a limit; looks at no more than that."""
    waiting, total = [value], 0
    while waiting:
        item = waiting.pop()
        if isinstance(item, str):
            total += len(item)
        elif type(item) in LISTS:
            total += len(item)
            if total <= limit:
                waiting.extend(item)
        if total > limit:
            return False
    return True


def numeric(symbol: str, apply: Callable[[Any, Any], Any]) -> Callable[[Any, Any, Span], Any]:
    """An operator on two numbers."""

    def run(a: Any, b: Any, span: Span) -> Any:
        if not (is_number(a) and is_number(b)):
            raise _mixed(symbol, a, b, span)
        try:
            return finite(apply(a, b), span)
        except ZeroDivisionError:
            raise ExpressionError("division by zero", *span) from None
        except OverflowError:
            raise ExpressionError("the result is not a finite number", *span) from None

    return run


_add_numbers = numeric("+", operator.add)
_multiply_numbers = numeric("*", operator.mul)


def add(a: Any, b: Any, span: Span) -> Any:
    """Numbers added, strings or lists joined."""
    if isinstance(a, str) and isinstance(b, str):
        return bounded(a + b, span)
    if type(a) in LISTS and type(b) in LISTS:
        return bounded([*a, *b], span)
    return _add_numbers(a, b, span)


def multiply(a: Any, b: Any, span: Span) -> Any:
    """Numbers multiplied, a string or list repeated."""
    for many, count in ((a, b), (b, a)):
        if type(many) in SEQUENCES and type(count) is int:
            if count > 0 and not fits(many, HEAVIEST // count):
                raise ExpressionError(f"the {kind(many)[2:]} is larger than {HEAVIEST}", *span)
            # What is empty may be repeated as often as one likes, which Python would still count.
            return many * min(count, HEAVIEST) if isinstance(many, str) else [*many] * min(count, HEAVIEST)
    return _multiply_numbers(a, b, span)


def power(a: Any, b: Any, span: Span) -> Any:
    """The power a**b of numbers; the result is real."""
    if not (is_number(a) and is_number(b)):
        raise _mixed("**", a, b, span)
    if a == 0 and b < 0:
        raise ExpressionError("0 has no negative power", *span)
    if a < 0 and b != int(b):
        raise ExpressionError("a negative number has whole powers only", *span)
    if type(a) is int and type(b) is int and b > 0 and abs(a) > 1 and (abs(a).bit_length() - 1) * b >= INT_BITS:
        raise ExpressionError(f"the integer has more than {INT_BITS} bits", *span)
    if type(a) is int and type(b) is int and abs(a) <= 1 and abs(b) > 2:
        # Of these only whether the exponent is odd counts, however large it is.
        b = (1 if b % 2 else 2) * (1 if b > 0 else -1)
    try:
        return finite(a**b, span)
    except OverflowError:
        raise ExpressionError("the result is not a finite number", *span) from None


def _over(a: float, b: float) -> float:
    return a / b


def _over_floor(a: float, b: float) -> float:
    return a // b


_subtract = numeric("-", operator.sub)
_divide = numeric("/", _over)
_floor_divide = numeric("//", _over_floor)
_remainder = numeric("%", operator.mod)

BINARY: dict[str, Callable[[Any, Any, Span], Any]] = {
    "Add": add,
    "Sub": _subtract,
    "Mult": multiply,
    "Div": _divide,
    "FloorDiv": _floor_divide,
    "Mod": _remainder,
    "Pow": power,
}
"""By the name of the node's type in Python's `ast`."""


def negative(a: Any, span: Span) -> Any:
    """The number with the other sign."""
    if not is_number(a):
        raise ExpressionError(f"`-` does not take {kind(a)}", *span)
    return -a


def positive(a: Any, span: Span) -> Any:
    """The number itself."""
    if not is_number(a):
        raise ExpressionError(f"`+` does not take {kind(a)}", *span)
    return a


def equal(a: Any, b: Any, span: Span) -> bool:
    """Whether two values of one kind are equal."""
    if kind(a) != kind(b):
        raise _mixed("==", a, b, span)
    return list(a) == list(b) if type(a) in LISTS else a == b


def unequal(a: Any, b: Any, span: Span) -> bool:
    """Whether two values of one kind differ."""
    return not equal(a, b, span)


def ordered(symbol: str, apply: Callable[[Any, Any], bool]) -> Callable[[Any, Any, Span], bool]:
    """A comparison of two numbers or two strings."""

    def run(a: Any, b: Any, span: Span) -> bool:
        if not (is_number(a) and is_number(b)) and not (isinstance(a, str) and isinstance(b, str)):
            raise _mixed(symbol, a, b, span)
        return apply(a, b)

    return run


COMPARISONS: dict[str, Callable[[Any, Any, Span], bool]] = {
    "Eq": equal,
    "NotEq": unequal,
    "Lt": ordered("<", operator.lt),
    "LtE": ordered("<=", operator.le),
    "Gt": ordered(">", operator.gt),
    "GtE": ordered(">=", operator.ge),
}
"""By the name of the node's type in Python's `ast`."""


def truth(value: Any, span: Span) -> bool:
    """Whether a condition holds: a boolean, or a number other than 0."""
    if type(value) is bool:
        return value
    if is_number(value):
        return value != 0
    raise ExpressionError(f"a condition is a boolean or a number, not {kind(value)}", *span)


def unlike(given: Any, shape: tuple[int, ...], text: str) -> str | None:
    """What is wrong with the shape of a value, where one value or lists of numbers are wanted; `text`: what gave it."""
    if not shape:
        return f"it gives {kind(given)} where one value is wanted" if type(given) in LISTS else None
    wanted = " lists of ".join(map(str, shape)) + " numbers"
    if type(given) not in LISTS:
        return f"it gives {kind(given)} where {wanted} are wanted"
    if _has_shape(given, shape):
        return None
    repeated = len(given) > shape[0] and len(given) % shape[0] == 0 and "*" in text
    why = ": `*` repeats lists, so multiply each component" if repeated else ""
    return f"it gives a list that is not {wanted}{why}"


def _has_shape(given: Any, shape: tuple[int, ...]) -> bool:
    if not shape:
        return is_number(given)
    return type(given) in LISTS and len(given) == shape[0] and all(_has_shape(item, shape[1:]) for item in given)


def item(values: Any, index: Any, span: Span) -> Any:
    """The item of a list or the character of a string; from the end where the index is negative."""
    if type(values) not in SEQUENCES:
        raise ExpressionError(f"{kind(values)} has no items", *span)
    if type(index) is not int:
        what = f"{index!r}" if type(index) is float else kind(index)
        raise ExpressionError(f"an index is an integer, not {what}", *span)
    if not -len(values) <= index < len(values):
        raise ExpressionError(f"index {index} is out of range: the {kind(values)[2:]} has {len(values)} items", *span)
    return values[index]


def _mixed(symbol: str, a: Any, b: Any, span: Span) -> ExpressionError:
    return ExpressionError(f"`{symbol}` does not take {kind(a)} and {kind(b)}", *span)
