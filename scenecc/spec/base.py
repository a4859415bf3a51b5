"""What all models of the language share: strictness, keys that may be left out, and scalars."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict, StringConstraints
from pydantic_core import PydanticCustomError

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler
    from pydantic_core import CoreSchema

NOTE_PREFIX = "x-"
"""Keys that start so are carried and ignored."""

NAME_PATTERN = r"^[A-Za-z_][A-Za-z0-9_.-]*$"


NOTES = {"^x-": {"description": "A note or an anchor; ignored."}}
"""Keys that may stand in any mapping, for the JSON Schema."""


def _allow_notes(schema: dict[str, Any]) -> None:
    schema["patternProperties"] = NOTES


class Model(BaseModel):
    """A mapping of the language: unknown keys refused, nothing coerced, nothing changed later."""

    # Deferred: a document is one model, and what builds it builds all that it holds. Each for itself as well, and
    # from annotations that are text, took a third of the time of a small check; so does a union written out at every
    # use of it, hence the aliases (`TypeAliasType`) of those that are used often.
    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, defer_build=True, json_schema_extra=_allow_notes
    )


class _LeftOut:
    """Makes `T | None` mean that the key may be left out, not that it may be null."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema = handler(source)
        return schema["schema"] if schema["type"] == "nullable" else schema


T = TypeVar("T")
Maybe = Annotated[T | None, _LeftOut()]
"""A key that may be left out: then None, and the engine's own default stands."""


def key(description: str, *, default: Any = None, examples: list[Any] | None = None) -> Any:
    """A key that may be left out, with what is built without it, for the schema's readers.

    Args:
        description: what it means, with its unit.
        default: what is built without the key; shown in the schema, never filled in.
        examples: values that an editor may offer.
    """
    extra = {"default": default} if default is not None else None
    return Field(default=None, description=description, examples=examples, json_schema_extra=extra)


EXPRESSION = "${"


def _literal(text: str) -> str:
    """Refuses an expression where any text is right: it would be taken as it is written."""
    if EXPRESSION in text:
        raise PydanticCustomError("expression", "a text without `${{`")
    return text


Name = Annotated[str, StringConstraints(pattern=NAME_PATTERN)]
AnyText = Annotated[str, AfterValidator(_literal)]
Text = Annotated[str, StringConstraints(min_length=1), AfterValidator(_literal)]

LARGEST = 3.4028234663852886e38
SMALLEST = 1.1754943508222875e-38
"""The largest and the smallest normal number of single precision, in which the engine computes: beyond
them a length becomes infinite or zero there."""

Finite = Annotated[float, Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, ge=SMALLEST, le=LARGEST, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, le=LARGEST, allow_inf_nan=False)]
Unit = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
PositiveInt = Annotated[int, Field(ge=1)]
NonNegativeInt = Annotated[int, Field(ge=0)]

MOST = 2**31 - 1
"""The engine's integers have 32 bits."""

Count = Annotated[int, Field(ge=1, le=MOST)]
CountOrNone = Annotated[int, Field(ge=0, le=MOST)]

# YAML gives lists; strict tuples would refuse them.
Vec2 = Annotated[tuple[Finite, Finite], Strict(strict=False)]
Vec3 = Annotated[tuple[Finite, Finite, Finite], Strict(strict=False)]
Vec4 = Annotated[tuple[Finite, Finite, Finite, Finite], Strict(strict=False)]
Positive2 = Annotated[tuple[Positive, Positive], Strict(strict=False)]
Positive3 = Annotated[tuple[Positive, Positive, Positive], Strict(strict=False)]
