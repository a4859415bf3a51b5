"""Functions and operators of expressions, with costs and errors. Each is one row of a table."""

from __future__ import annotations

import math
import operator
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from scenecc.diagnostics.frozen import frozen


class ExpressionError(Exception):
    """An expression is invalid or has no value.

    Attributes:
        message: for a diagnostic.
        start, end: the affected part of the scalar's text (characters, end exclusive).
        hint: how to fix it; None if unknown.
    """

    def __init__(self, message: str, start: int, end: int, hint: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.start = start
        self.end = end
        self.hint = hint


class DrawError(Exception):
    """A node has no value in a scene.

    Attributes:
        message: for a diagnostic.
        scene: the scene's index.
        node: the node without a value: the requested one, or one inside it.
        expression: the cause, if the node is an expression.
        seed: of the scene's draws; None if irrelevant.
    """

    def __init__(
        self,
        message: str,
        scene: int,
        node: object,
        expression: ExpressionError | None = None,
        seed: int | None = None,
    ) -> None:
        super().__init__(f"scene {scene}: {message}")
        self.message = message
        self.scene = scene
        self.seed = seed
        self.node = node
        self.expression = expression


COMPUTE_LIMIT_HINT = "compute less, in fewer scenes, or raise the limit with --limit objects=N or limits={'objects': N}"

_CHARACTERS_PER_OPERATION = 16
"""Characters of an expression that count as one operation."""

_ROWS_PER_OPERATION = 4
"""Rows of a form that NumPy computes in the time of one operation."""

_OPERATIONS_PER_ITEM = 4
"""Operations that a list item counts for, since it stays in memory."""


class ComputeLimitError(DrawError):
    """A node needs more operations than the limit."""


@dataclass(slots=True)
class OperationCounter:
    """Counts operations before they are executed. A few lines can request any number: 900 draws in 65 536 scenes.

    Attributes:
        most: limit.
        done: operations so far.
    """

    most: int
    done: int = 0

    @property
    def exhausted(self) -> bool:
        """Whether the limit was exceeded."""
        return self.done > self.most

    @property
    def message(self) -> str:
        """Message for an exceeded limit."""
        return f"the forms and expressions of all scenes count as more than {self.most} objects"

    def take(self, operations: int, node: object) -> None:
        """Adds operations.

        Raises:
            ComputeLimitError: the limit is exceeded.
        """
        self.done += operations
        if self.exhausted:
            raise ComputeLimitError(self.message, 0, node)


def expression_cost(text: str, rows: int) -> int:
    """Approximate number of operations to evaluate an expression in `rows` scenes."""
    return rows * (1 + len(text) // _CHARACTERS_PER_OPERATION)


def form_cost(rows: int) -> int:
    """Approximate number of operations to evaluate a form in `rows` scenes."""
    return rows // _ROWS_PER_OPERATION


def result_cost(value: Any) -> int:
    """Operations for the result of an expression: characters of a text, or items of nested lists."""
    if value.__class__ not in SEQUENCES:
        return 0
    return _OPERATIONS_PER_ITEM * len(value) + (0 if value.__class__ is str else sum(map(result_cost, value)))


Span = tuple[int, int]

LISTS: frozenset[type[Any]] = frozenset((list, tuple))

SEQUENCES: frozenset[type[Any]] = frozenset((str, list, tuple))

NUMBERS: frozenset[type[Any]] = frozenset((int, float))

MAX_FLOAT = sys.float_info.max

MAX_INT_BITS = 256
"""Largest size of an integer in bits."""

MAX_SIZE = 10_000
"""Largest size of a list or string: characters, and items of nested lists."""

_INT_BOUND = 1 << MAX_INT_BITS

_KINDS: dict[type[Any], str] = {
    bool: "a boolean", int: "a number", float: "a number", str: "a string", list: "a list", tuple: "a list",
    dict: "a mapping",
}  # fmt: skip


def kind_name(value: Any) -> str:
    """Name of a value's type in messages."""
    return _KINDS.get(value.__class__, "such a value")


def scalar_text(value: Any, span: Span) -> str:
    """Formats a value inside a longer text, as YAML does."""
    if type(value) is bool:
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if is_number(value):
        return repr(value)
    raise ExpressionError(f"{kind_name(value)} cannot be part of a longer string", *span)


def as_lists(value: Any) -> Any:
    """Converts tuples to lists."""
    return [as_lists(item) for item in value] if value.__class__ in LISTS else value


def is_number(value: Any) -> bool:
    """Whether a value is an int or a float."""
    return type(value) is float or type(value) is int


def check_finite(value: Any, span: Span) -> Any:
    """Returns a number if it is finite and not too large."""
    if type(value) is float:
        if -MAX_FLOAT <= value <= MAX_FLOAT:
            return value
        raise ExpressionError("the result is not a finite number", *span)
    if -_INT_BOUND < value < _INT_BOUND:
        return value
    raise ExpressionError(f"the integer has more than {MAX_INT_BITS} bits", *span)


def check_size(value: Any, span: Span) -> Any:
    """Returns a string or list if it is not too large."""
    if not fits(value, MAX_SIZE):
        raise ExpressionError(f"the {_KINDS[type(value)][2:]} is larger than {MAX_SIZE}", *span)
    return value


def fits(value: Any, limit: int) -> bool:
    """Whether the total size of a value is within a limit; stops counting there."""
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


def _number_operator(symbol: str, apply: Callable[[Any, Any], Any]) -> Callable[[Any, Any, Span], Any]:
    """Makes an operator on two numbers."""

    def run(a: Any, b: Any, span: Span) -> Any:
        """Raises ExpressionError if an operand is not a number or the result is not finite."""
        if not (is_number(a) and is_number(b)):
            raise _kinds_error(symbol, a, b, span)
        try:
            return check_finite(apply(a, b), span)
        except ZeroDivisionError:
            raise ExpressionError("division by zero", *span) from None
        except OverflowError:
            raise ExpressionError("the result is not a finite number", *span) from None

    return run


_add_numbers = _number_operator("+", operator.add)

_multiply_numbers = _number_operator("*", operator.mul)


def add(a: Any, b: Any, span: Span) -> Any:
    """Adds numbers or concatenates strings or lists."""
    if isinstance(a, str) and isinstance(b, str):
        return check_size(a + b, span)
    if type(a) in LISTS and type(b) in LISTS:
        return check_size([*a, *b], span)
    return _add_numbers(a, b, span)


def multiply(a: Any, b: Any, span: Span) -> Any:
    """Multiplies numbers or repeats a string or list."""
    for many, count in ((a, b), (b, a)):
        if type(many) in SEQUENCES and type(count) is int:
            if count > 0 and not fits(many, MAX_SIZE // count):
                raise ExpressionError(f"the {kind_name(many)[2:]} is larger than {MAX_SIZE}", *span)
            # An empty value may be repeated any number of times, and Python would loop over the count.
            return many * min(count, MAX_SIZE) if isinstance(many, str) else [*many] * min(count, MAX_SIZE)
    return _multiply_numbers(a, b, span)


def power(a: Any, b: Any, span: Span) -> Any:
    """The power a**b of numbers. The result is real."""
    if not (is_number(a) and is_number(b)):
        raise _kinds_error("**", a, b, span)
    if a == 0 and b < 0:
        raise ExpressionError("0 cannot have a negative exponent", *span)
    if a < 0 and b != int(b):
        raise ExpressionError("a negative number cannot have a fractional exponent", *span)
    if type(a) is int and type(b) is int and b > 0 and abs(a) > 1 and (abs(a).bit_length() - 1) * b >= MAX_INT_BITS:
        raise ExpressionError(f"the integer has more than {MAX_INT_BITS} bits", *span)
    if type(a) is int and type(b) is int and abs(a) <= 1 and abs(b) > 2:
        # For these bases only the parity and sign of the exponent matter.
        b = (1 if b % 2 else 2) * (1 if b > 0 else -1)
    try:
        return check_finite(a**b, span)
    except OverflowError:
        raise ExpressionError("the result is not a finite number", *span) from None


BINARY: dict[str, Callable[[Any, Any, Span], Any]] = {
    "Add": add,
    "Sub": _number_operator("-", operator.sub),
    "Mult": multiply,
    "Div": _number_operator("/", lambda a, b: a / b),
    "FloorDiv": _number_operator("//", lambda a, b: a // b),
    "Mod": _number_operator("%", operator.mod),
    "Pow": power,
}
"""Binary operators, by the name of Python's `ast` node type."""


def _sign(symbol: str, apply: Callable[[Any], Any]) -> Callable[[Any, Span], Any]:
    """Makes a sign operator for a number."""

    def run(a: Any, span: Span) -> Any:
        if not is_number(a):
            raise ExpressionError(f"`{symbol}` does not take {kind_name(a)}", *span)
        return apply(a)

    return run


SIGNS = {"USub": _sign("-", lambda a: -a), "UAdd": _sign("+", lambda a: a)}
"""By the name of Python's `ast` node type."""


def equal(a: Any, b: Any, span: Span) -> bool:
    """Whether two values of one kind are equal."""
    if kind_name(a) != kind_name(b):
        raise _kinds_error("==", a, b, span)
    return list(a) == list(b) if type(a) in LISTS else a == b


def _order_comparison(symbol: str, apply: Callable[[Any, Any], bool]) -> Callable[[Any, Any, Span], bool]:
    """Makes a comparison of two numbers or two strings."""

    def run(a: Any, b: Any, span: Span) -> bool:
        if not (is_number(a) and is_number(b)) and not (isinstance(a, str) and isinstance(b, str)):
            raise _kinds_error(symbol, a, b, span)
        return apply(a, b)

    return run


COMPARISONS: dict[str, Callable[[Any, Any, Span], bool]] = {
    "Eq": equal,
    "NotEq": lambda a, b, span: not equal(a, b, span),
    "Lt": _order_comparison("<", operator.lt),
    "LtE": _order_comparison("<=", operator.le),
    "Gt": _order_comparison(">", operator.gt),
    "GtE": _order_comparison(">=", operator.ge),
}
"""By the name of Python's `ast` node type."""


def truth(value: Any, span: Span) -> bool:
    """Whether a condition is true: a boolean, or a number other than 0."""
    if type(value) is bool:
        return value
    if is_number(value):
        return value != 0
    raise ExpressionError(f"a condition is a boolean or a number, not {kind_name(value)}", *span)


def shape_mismatch(given: Any, shape: tuple[int, ...], text: str) -> str | None:
    """The error in the shape of a value, or None. `text`: its source."""
    if not shape:
        return f"it gives {kind_name(given)} where one value is needed" if type(given) in LISTS else None
    wanted = " lists of ".join(map(str, shape)) + " numbers"
    if type(given) not in LISTS:
        return f"it gives {kind_name(given)} where {wanted} are needed"
    if has_shape(given, shape):
        return None
    repeated = len(given) > shape[0] and len(given) % shape[0] == 0 and "*" in text
    why = ": `*` repeats lists, so multiply each component" if repeated else ""
    return f"it gives a list that is not {wanted}{why}"


def has_shape(given: Any, shape: tuple[int, ...]) -> bool:
    """Whether a value is one number (shape ()), or nested lists of numbers of this shape."""
    if not shape:
        return is_number(given)
    return type(given) in LISTS and len(given) == shape[0] and all(has_shape(item, shape[1:]) for item in given)


def item_at(values: Any, index: Any, span: Span) -> Any:
    """The item of a list or the character of a string. Negative indices count from the end."""
    if type(values) not in SEQUENCES:
        raise ExpressionError(f"{kind_name(values)} has no items", *span)
    if type(index) is not int:
        what = f"{index!r}" if type(index) is float else kind_name(index)
        raise ExpressionError(f"an index is an integer, not {what}", *span)
    if not -len(values) <= index < len(values):
        raise ExpressionError(
            f"index {index} is out of range: the {kind_name(values)[2:]} has {len(values)} items", *span
        )
    return values[index]


def _kinds_error(symbol: str, a: Any, b: Any, span: Span) -> ExpressionError:
    return ExpressionError(f"`{symbol}` does not take {kind_name(a)} and {kind_name(b)}", *span)


MAX_ARGUMENTS = 255
"""Most arguments of a variadic function."""

_ROUND_DIGITS = 30


def _number_function(name: str, apply: Callable[..., Any]) -> Callable[..., Any]:
    """Makes a function of one or two numbers."""

    def run(arguments: list[Any], span: Span) -> Any:
        """Raises ExpressionError if an argument is not a number or the result is not finite."""
        for argument in arguments:
            if not is_number(argument):
                raise ExpressionError(f"`{name}` takes numbers, not {kind_name(argument)}", *span)
        try:
            return check_finite(apply(*arguments), span)
        except OverflowError:
            raise ExpressionError("the result is not a finite number", *span) from None
        except ValueError:
            raise ExpressionError(f"`{name}` is not defined for {arguments[0]!r}", *span) from None

    return run


def _extreme(name: str, apply: Callable[..., Any]) -> Callable[..., Any]:
    def run(arguments: list[Any], span: Span) -> Any:
        """Raises ExpressionError if an argument is not a number."""
        if len(arguments) == 1 and type(arguments[0]) in LISTS:
            arguments = list(arguments[0])
        if not arguments:
            raise ExpressionError(f"`{name}` needs at least one number", *span)
        for argument in arguments:
            if not is_number(argument):
                raise ExpressionError(
                    f"`{name}` takes numbers or one list of numbers, not {kind_name(argument)}", *span
                )
        return apply(arguments)

    return run


def _length(arguments: list[Any], span: Span) -> int:
    if type(arguments[0]) not in SEQUENCES:
        raise ExpressionError(f"`len` takes a list or a string, not {kind_name(arguments[0])}", *span)
    return len(arguments[0])


_round_number = _number_function("round", round)


def _round(arguments: list[Any], span: Span) -> Any:
    if len(arguments) == 2 and (type(arguments[1]) is not int or abs(arguments[1]) > _ROUND_DIGITS):
        raise ExpressionError(f"`round` takes -{_ROUND_DIGITS} to {_ROUND_DIGITS} digits", *span)
    return _round_number(arguments, span)


def _smoothstep(start: float, end: float, x: float) -> float:
    """0 up to `start`, 1 from `end` on, 3t² - 2t³ between. Falls if `end` is below `start`, a step if equal."""
    if start == end:
        return 0.0 if x < start else 1.0
    way, width = x - start, end - start
    if math.isinf(way) or math.isinf(width):  # largest numbers
        way, width = x / 2 - start / 2, end / 2 - start / 2
    t = min(max(way / width, 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


@frozen
class Function:
    """A function that expressions can call.

    Attributes:
        apply: computes the value.
        most, fewest: number of arguments.
    """

    apply: Callable[[list[Any], Span], Any]
    most: int = 1
    fewest: int = 1


FUNCTIONS: dict[str, Function] = {
    "min": Function(_extreme("min", min), most=MAX_ARGUMENTS),
    "max": Function(_extreme("max", max), most=MAX_ARGUMENTS),
    "abs": Function(_number_function("abs", abs)),
    "sqrt": Function(_number_function("sqrt", math.sqrt)),
    "sin": Function(_number_function("sin", math.sin)),
    "cos": Function(_number_function("cos", math.cos)),
    "tan": Function(_number_function("tan", math.tan)),
    "atan2": Function(_number_function("atan2", math.atan2), most=2, fewest=2),
    "hypot": Function(_number_function("hypot", math.hypot), most=3, fewest=2),
    "smoothstep": Function(_number_function("smoothstep", _smoothstep), most=3, fewest=3),
    "radians": Function(_number_function("radians", math.radians)),
    "degrees": Function(_number_function("degrees", math.degrees)),
    "floor": Function(_number_function("floor", math.floor)),
    "ceil": Function(_number_function("ceil", math.ceil)),
    "round": Function(_round, most=2),
    "len": Function(_length),
}
"""By name."""
