"""Shared draws: values that differ from scene to scene and are read in several places."""

from typing import Annotated

from pydantic import Field, Tag
from typing_extensions import TypeAliasType

from scenecc.spec.base import AnyText
from scenecc.spec.leaf import Leaf
from scenecc.spec.scalars import Finite
from scenecc.spec.unions import COMPONENTS, by_kind

LONGEST = 10_000
"""Components of one drawn vector."""

Draw = TypeAliasType(
    "Draw",
    Leaf[
        Annotated[
            Annotated[Finite, Tag("#number")]
            | Annotated[bool, Tag("#flag")]
            | Annotated[AnyText, Tag("#word")]
            | Annotated[list[Finite], Field(min_length=1, max_length=LONGEST), Tag(COMPONENTS)],
            by_kind("a form, an expression, a number, true or false, a text or a list of numbers"),
        ]
    ],
)
"""A form, an expression or a plain value."""
