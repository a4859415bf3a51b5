"""Types of parameters, and shared draws: the sections `params` and `draws`."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, Tag, ValidatorFunctionWrapHandler, WrapValidator
from typing_extensions import TypeAliasType

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import show
from scenecc.spec.base import AnyText, Finite
from scenecc.spec.nodes import COMPONENTS, FLAG, NUMBER, WORD, is_mapping, is_sequence, union_by_kind
from scenecc.spec.values import MAX_DRAW_COMPONENTS, Leaf
from scenecc.variation.conversions import is_color_text

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Origin


def is_finite_number(value: Any) -> bool:
    """Returns whether a value is a finite number."""
    return type(value) is int or (type(value) is float and math.isfinite(value))


def is_vector(value: Any) -> bool:
    """Returns whether a value is a list of finite numbers."""
    return is_sequence(value) and len(value) > 0 and all(map(is_finite_number, value))


def is_color(value: Any) -> bool:
    """Returns whether a value is three or four numbers in 0..1, or "#rrggbb[aa]"."""
    if isinstance(value, str):
        return is_color_text(value) is not None
    return is_vector(value) and len(value) in {3, 4} and all(0 <= part <= 1 for part in value)


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_path(value: Any) -> bool:
    return isinstance(value, str) and bool(value.strip())


def _is_material(value: Any) -> bool:
    return (isinstance(value, str) and bool(value)) or is_mapping(value)


def _is_whole(value: Any) -> bool:
    return type(value) is int


def _is_flag(value: Any) -> bool:
    return type(value) is bool


def _is_scalar(value: Any) -> bool:
    return isinstance(value, str | bool) or is_finite_number(value)


PARAM_KINDS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "number": (is_finite_number, "a number"),
    "integer": (_is_whole, "a whole number"),
    "string": (_is_text, "a text"),
    "boolean": (_is_flag, "true or false"),
    "vector": (is_vector, "a list of numbers"),
    "color": (is_color, 'a colour: three or four numbers in 0..1, or "#rrggbb[aa]"'),
    "file": (_is_path, "a file"),
    "material": (_is_material, "the name of a material, or a mapping"),
    "entity": (_is_path, "the name of an entity"),
    "choice": (_is_scalar, "one of its options"),
    "list": (is_sequence, "a list"),
}
"""Parameter type → its test, and its description for messages."""

RANGED_KINDS = frozenset(("number", "integer", "vector"))
"""Types that may have `min` and `max`."""


def infer_param_kind(default: Any) -> str | None:
    """Returns the parameter type of a default, or None."""
    if type(default) is bool:
        return "boolean"
    if is_finite_number(default):
        return "number"
    if isinstance(default, str):
        return "color" if is_color_text(default) else "string"
    if is_vector(default):
        return "vector"
    return "list" if is_sequence(default) else None


def describe_range_error(value: Any, low: Any, high: Any) -> str | None:
    """Returns the message for a number or vector out of range, or None. A bound may be a number or a vector."""
    for bound, words, is_beyond in ((low, "at least", operator.lt), (high, "at most", operator.gt)):
        if bound is None:
            continue
        bounds = bound if is_sequence(bound) else None
        for index, part in enumerate(value) if is_sequence(value) else ((None, value),):
            limit = bound if bounds is None else bounds[index or 0] if (index or 0) < len(bounds) else None
            if limit is not None and is_beyond(part, limit):
                where = "" if index is None else f" in component {index}"
                return f"must be {words} {show(limit)}{where}, not {show(part)}"
    return None


ParamIssue = tuple[str, str]
"""Code and message of an error."""


@frozen
class ParamType:
    """The type of a parameter.

    Attributes:
        name: name of the parameter.
        kind: one of `PARAM_KINDS`.
        low, high: the range: a number, or one per component of a vector; None for no bound.
        options: options of a choice.
        components: length of a vector; None for any length.
        declared: origin of the declaration; None if the value is the default.
    """

    name: str
    kind: str
    low: Any = None
    high: Any = None
    options: tuple[Any, ...] = ()
    components: int | None = None
    declared: Origin | None = None

    @property
    def ranged(self) -> bool:
        """Whether it has a range."""
        return self.low is not None or self.high is not None

    def misfit(self, value: Any) -> ParamIssue | None:
        """Returns the error of a plain value, or None."""
        fits, words = PARAM_KINDS[self.kind]
        if not fits(value):
            return "SC211", f"must be {words}, not {show(value)}"
        if self.kind == "choice" and not any(_is_same(value, option) for option in self.options):
            return "SC211", f"must be one of {', '.join(map(show, self.options))}, not {show(value)}"
        if self.kind == "vector" and self.components not in {None, len(value)}:
            return "SC211", f"must have {self.components} components, not {len(value)}"
        return self.outside(value, value) if self.kind in RANGED_KINDS else None

    def drawn_misfit(self, value: Any) -> ParamIssue | None:
        """Returns the error of a drawn value, or None. Draws return floats, even for integer alternatives."""
        if self.kind == "integer" and type(value) is float and value.is_integer():
            value = int(value)
        elif self.kind == "choice" and is_finite_number(value):
            value = next((option for option in self.options if is_finite_number(option) and option == value), value)
        return self.misfit(value)

    def outside(self, low: Any, high: Any) -> ParamIssue | None:
        """Returns the error of a range of values, from `low` to `high`, or None."""
        wrong = describe_range_error(low, self.low, None) or describe_range_error(high, None, self.high)
        return None if wrong is None else ("SC212", wrong)


def _is_same(value: Any, option: Any) -> bool:
    return type(value) is type(option) and value == option


def _keep_integer(value: Any, validate: ValidatorFunctionWrapHandler) -> float:
    """Keeps an integer of 64 bits as int, so that it prints as `1` and can be an index."""
    number: float = validate(value)
    return value if type(value) is int and -(2**63) <= value < 2**63 else number


Number = Annotated[Finite, WrapValidator(_keep_integer)]

Draw = TypeAliasType(
    "Draw",
    Leaf[
        Annotated[
            Annotated[Number, Tag(NUMBER)]
            | Annotated[bool, Tag(FLAG)]
            | Annotated[AnyText, Tag(WORD)]
            | Annotated[list[Number], Field(min_length=1, max_length=MAX_DRAW_COMPONENTS), Tag(COMPONENTS)],
            union_by_kind("a form, an expression, a number, true or false, a string or a list of numbers"),
        ]
    ],
)
"""A form, an expression or a plain value."""
