"""Common parts of all models: the base model, optional keys, names, numeric types and custom errors."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict, StringConstraints, ValidationError
from pydantic_core import PydanticCustomError, core_schema

from scenecc.plan.properties import (
    ANY,
    COUNT,
    FLOAT32_MIN,
    INT32_MAX,
    NON_NEGATIVE,
    POSITION_ITERATIONS,
    POSITIVE,
    SPEED,
    UNIT_INTERVAL,
    VELOCITY_ITERATIONS,
    Bounds,
)
from scenecc.spec.nodes import (
    EXPANDED,
    EXPRESSION_START,
    KEY,
    NOT_MEANT,
    VALUE,
    ordered_union,
    plain_json_schema,
    with_label,
)

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema, ErrorDetails, InitErrorDetails

    from scenecc.diagnostics.diagnostic import At, PathKey


def within(bounds: Bounds, *, allow_inf_nan: bool | None = False) -> Any:
    """The constraint of a number that a plan holds within some bounds. `allow_inf_nan`: None for integers."""
    positive = 0 if bounds.low == FLOAT32_MIN else None
    return Field(gt=positive, ge=bounds.low, le=bounds.high, allow_inf_nan=allow_inf_nan)


Finite = Annotated[float, within(ANY)]

Positive = Annotated[float, within(POSITIVE)]

Speed = Annotated[float, Field(gt=0, ge=SPEED.low, le=SPEED.high, allow_inf_nan=False)]

NonNegative = Annotated[float, within(NON_NEGATIVE)]

ExtendedFloat = Annotated[float, Field(ge=-math.inf, allow_inf_nan=True)]
"""Infinite ones too; what is no number at all is less than nothing."""

Unit = Annotated[float, within(UNIT_INTERVAL)]

PositiveInt = Annotated[int, Field(ge=1)]

NonNegativeInt = Annotated[int, Field(ge=0)]


PositiveInt32 = Annotated[int, Field(ge=1, le=INT32_MAX)]


NonNegativeInt32 = Annotated[int, within(COUNT, allow_inf_nan=None)]

OpeningAngle = Annotated[float, Field(gt=0, ge=FLOAT32_MIN, lt=math.pi)]

OpeningDegrees = Annotated[float, Field(gt=0, ge=FLOAT32_MIN, lt=180)]
"""Angles of views and of cones of light [rad], [degrees]."""


# YAML gives lists; strict tuples would refuse them.
Vec3 = Annotated[tuple[Finite, Finite, Finite], Strict(strict=False)]


Vec4 = Annotated[tuple[Finite, Finite, Finite, Finite], Strict(strict=False)]


NonNegative2 = Annotated[tuple[NonNegative, NonNegative], Strict(strict=False)]


NonNegative3 = Annotated[tuple[NonNegative, NonNegative, NonNegative], Strict(strict=False)]


Positive2 = Annotated[tuple[Positive, Positive], Strict(strict=False)]


Positive3 = Annotated[tuple[Positive, Positive, Positive], Strict(strict=False)]

Iterations = Annotated[int, within(POSITION_ITERATIONS, allow_inf_nan=None)]

VelocityIterations = Annotated[int, within(VELOCITY_ITERATIONS, allow_inf_nan=None)]
"""PhysX takes 1 to 255 position iterations and 0 to 255 velocity iterations (PxRigidDynamic)."""

CUSTOM_ERROR = "#told"
"""The error type of a mistake that brings its own diagnostic in its context."""

VALUE_NAME = "{this}"
"""Stands in such a message for what the value at the mistake's place is called."""


def custom_error(
    code: str,
    message: str,
    *,
    at: At = "value",
    hint: str | None = None,
    span: tuple[int, int] | None = None,
    beside: str | None = None,
) -> PydanticCustomError:
    """A mistake with its code, message and hint.

    Args:
        code: a row of the table of codes.
        message: of the diagnostic; `VALUE_NAME` in it is replaced.
        at: which half of the entry is meant.
        hint: of the diagnostic.
        span: the part of a text that is meant (characters, end exclusive); None: all of it.
        beside: another key of the same mapping, to which the diagnostic points too.
    """
    context = {"code": code, "message": message, "at": at, "hint": hint, "span": span, "beside": beside}
    return PydanticCustomError(CUSTOM_ERROR, "{message}", context)


class ErrorCollector:
    """The errors of one validator, raised together."""

    def __init__(self) -> None:
        self._lines: list[InitErrorDetails] = []

    def add(self, error: PydanticCustomError, found: Any, *loc: PathKey) -> None:
        """Adds one.

        Args:
            error: what is wrong.
            found: the value.
            loc: where it is in the value that is validated.
        """
        self._lines.append({"type": error, "loc": loc, "input": found})

    def take(self, problem: ValidationError, *loc: PathKey) -> None:
        """Adds the errors of a validator that was called for a part of the value."""
        self._lines += [_copy_error(error, loc) for error in problem.errors(include_url=False)]

    def stop(self) -> None:
        """Raises what there is.

        Raises:
            ValidationError: there was a mistake.
        """
        if self._lines:
            raise ValidationError.from_exception_data("value", self._lines)


def _copy_error(error: ErrorDetails, loc: tuple[PathKey, ...]) -> InitErrorDetails:
    kind, context = error["type"], error.get("ctx", {})
    again: Any = PydanticCustomError(kind, error["msg"], context) if kind.startswith("#") else kind  # pyright: ignore[reportArgumentType]
    return {"type": again, "loc": (*loc, *error["loc"]), "input": error["input"], "ctx": context}


NOTE_PREFIX = "x-"
"""Keys that start so are carried and ignored."""

NAME_PATTERN = r"^[A-Za-z_][A-Za-z0-9_.-]*$"

VARIABLE_PATTERN = r"^[A-Za-z_][A-Za-z0-9_]*$"

PREFIX_PATTERN = r"^(?:[A-Za-z_][A-Za-z0-9_.-]*(?:/[A-Za-z_][A-Za-z0-9_.-]*)*/?)?$"

PATTERN_HINTS = {
    NAME_PATTERN: "a name starts with a letter or `_` and continues with letters, digits, `_`, `.` and `-`",
    VARIABLE_PATTERN: "a name in expressions starts with a letter or `_` and continues with letters, digits and `_`",
    PREFIX_PATTERN: '"" keeps the names inside unchanged; any other value is the start of a name',
}
"""What may stand where a text does not fit its pattern."""

NOTE_SCHEMA = {"^x-": {"description": "A note or an anchor; ignored."}}
"""Keys that may stand in any mapping, for the JSON Schema."""


def _allow_notes(schema: dict[str, Any]) -> None:
    schema["patternProperties"] = NOTE_SCHEMA


@dataclass(frozen=True)
class Excludes:
    """The annotation of a key beside which some other keys of its mapping are an error; they exclude it too."""

    keys: tuple[str, ...]


NameKind = Literal["entity", "frame", "material", "group"]


@dataclass(frozen=True)
class Names:
    """The annotation of a text that names something: an `entity` (or a frame or camera, or a link of an entity), a
    `frame` with a region, a `material` or a `group`.
    """

    kind: NameKind


WHOLE = object()
"""The annotation of a key whose mapping an override replaces, and does not merge."""

PATTERN = object()
"""The annotation of a text that is a pattern of names."""


@cache
def exclusions(model: type[BaseModel]) -> dict[str, frozenset[str]]:
    """Key of a model → the keys that it excludes; in order, those after which another is a mistake first."""
    declared = {
        field.alias or name: {key for one in field.metadata if isinstance(one, Excludes) for key in one.keys}
        for name, field in model.model_fields.items()
    }
    found: dict[str, set[str]] = {key: keys - {key} for key, keys in declared.items()}
    for first, keys in declared.items():
        for second in keys - {first}:
            found.setdefault(second, set()).add(first)
    return {key: frozenset(found[key]) for key in sorted(found, key=lambda key: bool(declared.get(key))) if found[key]}


class SpecModel(BaseModel):
    """A mapping of the language: unknown keys refused, nothing coerced, nothing changed later."""

    # Deferred: a document is one model, and what builds it builds all that it holds. Each for itself as well, and
    # from annotations that are text, took a third of the time of a small check; so does a union written out at every
    # use of it, hence the aliases (`TypeAliasType`) of those that are used often.
    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, defer_build=True, json_schema_extra=_allow_notes
    )

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema = handler(source)
        if exclusions(cls):
            model: Any = handler.resolve_ref_schema(schema)
            model["post_init"] = "check_exclusions"
        return schema

    def check_exclusions(self, _context: Any) -> None:
        """Refuses keys that exclude each other: the one that says so, or the later one where both do.

        Raises:
            ValidationError: there are two such keys.
        """
        given, excluded = self.model_fields_set, exclusions(self.__class__)
        if len(given) < _PAIR or len(both := [key for key in excluded if key in given]) < _PAIR:
            return
        mistakes = ErrorCollector()
        while both:
            first, *both = both
            wrong = [key for key in both if key in excluded[first]]
            if wrong:
                both = [key for key in both if key not in wrong]
                message = f"`{first}` and `{wrong[0]}` exclude each other"
                error = custom_error("SC111", message, at="key", beside=first)
                mistakes.add(error, getattr(self, wrong[0]), wrong[0])
        mistakes.stop()


_PAIR = 2


class _NotNullable:
    """Makes `T | None` mean that the key may be left out, not that it may be null."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema = handler(source)
        return schema["schema"] if schema["type"] == "nullable" else schema


T = TypeVar("T")

Maybe = Annotated[T | None, _NotNullable()]
"""A key that may be left out: then None, and the engine's own default stands."""


def key(
    description: str,
    *,
    default: Any = None,
    examples: list[Any] | None = None,
    excludes: tuple[str, ...] = (),
) -> Any:
    """A key that may be left out, with what is built without it, for the schema's readers.

    Args:
        description: what it means, with its unit.
        default: what is built without the key; shown in the schema, never filled in.
        examples: values that an editor may offer.
        excludes: keys that cannot be beside it; itself may be among them.
    """
    extra = {"default": default} if default is not None else None
    made: Any = Field(default=None, description=description, examples=examples, json_schema_extra=extra)
    made.metadata += [Excludes(excludes)] if excludes else []
    return made


def list_key(description: str) -> Any:
    """A list that may be left out, then empty."""
    return Field(default_factory=list, description=description, json_schema_extra={"default": []})


def names_key(description: str, *, alias: str | None = None, examples: list[Any] | None = None) -> Any:
    """A mapping of names that may be left out, then empty."""
    return Field(default_factory=dict, alias=alias, description=description, examples=examples)


def _check_literal(text: str) -> str:
    """Refuses an expression where any text is right: it would be taken as it is written."""
    if EXPRESSION_START in text and not EXPANDED.get():
        raise PydanticCustomError(NOT_MEANT, "a string without `${{`")
    return text


REFERENCE_PATTERN = r"^[A-Za-z_][A-Za-z0-9_.-]*(?:/[^/]+)*$"
"""An entity or a frame, which may be inside an instance, or a link of an entity. A file may call its links anything."""


class _MappingKey:
    """The annotation of a mapping's key. A note is refused: then the document is read again, without its notes.

    Pydantic marks the errors of keys by `[key]`, which itself may be a key.
    """

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return with_label(core_schema.no_info_after_validator_function(_refuse_note, handler(source)), KEY)


def _refuse_note(name: str) -> str:
    if name.startswith(NOTE_PREFIX):
        raise PydanticCustomError(NOT_MEANT, "a note")
    return name


MAPPING_KEY = _MappingKey()


class ScopedName:
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

        return ordered_union([(handler(source), VALUE)], core_schema.no_info_plain_validator_function(otherwise))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return plain_json_schema(schema, handler)


Name = Annotated[str, StringConstraints(pattern=NAME_PATTERN)]
"""What names something of the file's own."""

NewName = Annotated[Name, ScopedName(), MAPPING_KEY]
"""What something is called from here on."""

Reference = Annotated[str, StringConstraints(pattern=REFERENCE_PATTERN)]
"""What names an entity, a frame or a link, which may be inside an instance. A file may call its links anything."""

OuterName = Annotated[Name, ScopedName(whole=True)]
"""A name that a prefab may be given by the file that uses it."""

GroupName = Annotated[OuterName, Names("group")]

EntityName = Annotated[Reference, ScopedName(whole=True), Names("entity")]
"""ENTITY, ENTITY/LINK, a frame or a camera."""

AnyText = Annotated[str, AfterValidator(_check_literal)]

Text = Annotated[str, StringConstraints(min_length=1), AfterValidator(_check_literal)]

FrameName = Annotated[Reference, ScopedName(whole=True), Names("frame")]
"""A frame with a region."""

BodyName = Annotated[Text, Names("entity")]
"""ENTITY or ENTITY/LINK, looked up when it is lowered."""
