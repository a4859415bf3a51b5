"""Shared draws: values that differ from scene to scene and are read in several places."""

from typing import Annotated, Any

from pydantic import Field, Tag, ValidatorFunctionWrapHandler, WrapValidator
from typing_extensions import TypeAliasType

from scenecc.spec.base import AnyText
from scenecc.spec.leaf import Leaf
from scenecc.spec.scalars import Finite
from scenecc.spec.unions import COMPONENTS, FLAG, NUMBER, WORD, by_kind

LONGEST = 10_000
"""Components of one drawn vector."""


def _as_written(value: Any, validate: ValidatorFunctionWrapHandler) -> float:
    """A whole number stays one: in a text it reads `1` and not `1.0`. What 64 bits do not hold is no index."""
    number: float = validate(value)
    return value if type(value) is int and -(2**63) <= value < 2**63 else number


Number = Annotated[Finite, WrapValidator(_as_written)]

Draw = TypeAliasType(
    "Draw",
    Leaf[
        Annotated[
            Annotated[Number, Tag(NUMBER)]
            | Annotated[bool, Tag(FLAG)]
            | Annotated[AnyText, Tag(WORD)]
            | Annotated[list[Number], Field(min_length=1, max_length=LONGEST), Tag(COMPONENTS)],
            by_kind("a form, an expression, a number, true or false, a text or a list of numbers"),
        ]
    ],
)
"""A form, an expression or a plain value."""
