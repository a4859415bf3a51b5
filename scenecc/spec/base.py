"""What all models of the language share: strictness, keys that may be left out, and scalars."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints
from pydantic_core import PydanticCustomError, core_schema

from scenecc.spec.plain import EXPRESSION
from scenecc.spec.unions import EXPANDED, KEY, NOT_MEANT, VALUE, in_order, labelled, plain_json

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

NOTE_PREFIX = "x-"
"""Keys that start so are carried and ignored."""

NAME_PATTERN = r"^[A-Za-z_][A-Za-z0-9_.-]*$"


VARIABLE_PATTERN = r"^[A-Za-z_][A-Za-z0-9_]*$"
PREFIX_PATTERN = r"^(?:[A-Za-z_][A-Za-z0-9_.-]*(?:/[A-Za-z_][A-Za-z0-9_.-]*)*/?)?$"
SPELLINGS = {
    NAME_PATTERN: "a name starts with a letter or `_` and goes on with letters, digits, `_`, `.` and `-`",
    VARIABLE_PATTERN: "a name in expressions starts with a letter or `_` and goes on with letters, digits and `_`",
    PREFIX_PATTERN: '"" leaves the names inside as they are; anything else is the start of a name',
}
"""What may stand where a text does not fit its pattern."""

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


def _literal(text: str) -> str:
    """Refuses an expression where any text is right: it would be taken as it is written."""
    if EXPRESSION in text and not EXPANDED.get():
        raise PydanticCustomError(NOT_MEANT, "a text without `${{`")
    return text


REFERENCE_PATTERN = r"^[A-Za-z_][A-Za-z0-9_.-]*(?:/[A-Za-z_][A-Za-z0-9_.-]*)*$"


class _MappingKey:
    """The annotation of what is a mapping's key. Pydantic marks its errors by `[key]`, which itself may be a key."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return labelled(handler(source), KEY)


MAPPING_KEY = _MappingKey()


class Scoped:
    """The annotation of names that an expanded document may have with slashes in them.

    Args:
        whole: they may begin with one too, and are then names of the whole document.
    """

    def __init__(self, *, whole: bool = False) -> None:
        self._pattern = REFERENCE_PATTERN.replace("^", "^/?", 1) if whole else REFERENCE_PATTERN

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        def otherwise(node: object) -> str:
            if EXPANDED.get() and isinstance(node, str) and re.fullmatch(self._pattern, node):
                return node
            raise PydanticCustomError(NOT_MEANT, "a name as written")

        return in_order([(handler(source), VALUE)], core_schema.no_info_plain_validator_function(otherwise))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return plain_json(schema, handler)


Name = Annotated[str, StringConstraints(pattern=NAME_PATTERN)]
"""What names something of the file's own."""

NewName = Annotated[Name, Scoped(), MAPPING_KEY]
"""What something is called from here on."""

Reference = Annotated[str, StringConstraints(pattern=REFERENCE_PATTERN)]
"""What names an entity or a frame, which may be inside an instance."""

GivenName = Annotated[Name, Scoped(whole=True)]
"""What names something that a prefab may be given by the file that uses it."""

AnyText = Annotated[str, AfterValidator(_literal)]
Text = Annotated[str, StringConstraints(min_length=1), AfterValidator(_literal)]
