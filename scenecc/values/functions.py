"""What the functions of expressions do with plain values.

What comes out is bounded as `scenecc.values.operations` has it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.values.failure import ExpressionError
from scenecc.values.operations import LISTS, SEQUENCES, Span, finite, is_number, kind

if TYPE_CHECKING:
    from collections.abc import Callable

MANY = 255
"""The most arguments of a function that takes any number of them."""

_ROUND_DIGITS = 30


def function(name: str, apply: Callable[..., Any]) -> Callable[..., Any]:
    """A function of one number or two."""

    def run(arguments: list[Any], span: Span) -> Any:
        """Its value; ExpressionError where an argument is no number, or there is no finite value."""
        for argument in arguments:
            if not is_number(argument):
                raise ExpressionError(f"`{name}` takes numbers, not {kind(argument)}", *span)
        try:
            return finite(apply(*arguments), span)
        except OverflowError:
            raise ExpressionError("the result is not a finite number", *span) from None
        except ValueError:
            raise ExpressionError(f"`{name}` has no value for {arguments[0]!r}", *span) from None

    return run


def _extreme(name: str, apply: Callable[..., Any]) -> Callable[..., Any]:
    def run(arguments: list[Any], span: Span) -> Any:
        if len(arguments) == 1 and type(arguments[0]) in LISTS:
            arguments = list(arguments[0])
        if not arguments:
            raise ExpressionError(f"`{name}` of nothing has no value", *span)
        for argument in arguments:
            if not is_number(argument):
                raise ExpressionError(f"`{name}` takes numbers or one list of numbers, not {kind(argument)}", *span)
        return apply(arguments)

    return run


def _length(arguments: list[Any], span: Span) -> int:
    if type(arguments[0]) not in SEQUENCES:
        raise ExpressionError(f"`len` takes a list or a string, not {kind(arguments[0])}", *span)
    return len(arguments[0])


_round_number = function("round", round)


def _rounded(arguments: list[Any], span: Span) -> Any:
    if len(arguments) == 2 and (type(arguments[1]) is not int or abs(arguments[1]) > _ROUND_DIGITS):
        raise ExpressionError(f"`round` takes -{_ROUND_DIGITS} to {_ROUND_DIGITS} digits", *span)
    return _round_number(arguments, span)


FUNCTIONS: dict[str, tuple[int, int, Callable[[list[Any], Span], Any]]] = {
    "min": (1, MANY, _extreme("min", min)),
    "max": (1, MANY, _extreme("max", max)),
    "abs": (1, 1, function("abs", abs)),
    "sqrt": (1, 1, function("sqrt", math.sqrt)),
    "sin": (1, 1, function("sin", math.sin)),
    "cos": (1, 1, function("cos", math.cos)),
    "tan": (1, 1, function("tan", math.tan)),
    "atan2": (2, 2, function("atan2", math.atan2)),
    "radians": (1, 1, function("radians", math.radians)),
    "degrees": (1, 1, function("degrees", math.degrees)),
    "floor": (1, 1, function("floor", math.floor)),
    "ceil": (1, 1, function("ceil", math.ceil)),
    "round": (1, 2, _rounded),
    "len": (1, 1, _length),
}
"""By name: the fewest and the most arguments, and what it does with them."""
