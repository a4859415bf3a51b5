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
    """Returns the Pydantic constraint for bounds of the plan. `allow_inf_nan` is None for integers."""
    positive = 0 if bounds.low == FLOAT32_MIN else None
    return Field(gt=positive, ge=bounds.low, le=bounds.high, allow_inf_nan=allow_inf_nan)


Finite = Annotated[float, within(ANY)]

Positive = Annotated[float, within(POSITIVE)]

Speed = Annotated[float, Field(gt=0, ge=SPEED.low, le=SPEED.high, allow_inf_nan=False)]

NonNegative = Annotated[float, within(NON_NEGATIVE)]

ExtendedFloat = Annotated[float, Field(ge=-math.inf, allow_inf_nan=True)]
"""A float that may be infinite. NaN is rejected."""

Unit = Annotated[float, within(UNIT_INTERVAL)]

PositiveInt = Annotated[int, Field(ge=1)]

NonNegativeInt = Annotated[int, Field(ge=0)]


PositiveInt32 = Annotated[int, Field(ge=1, le=INT32_MAX)]


NonNegativeInt32 = Annotated[int, within(COUNT, allow_inf_nan=None)]

OpeningAngle = Annotated[float, Field(gt=0, ge=FLOAT32_MIN, lt=math.pi)]

OpeningDegrees = Annotated[float, Field(gt=0, ge=FLOAT32_MIN, lt=180)]
"""Angle of view, or of a light cone [degrees]; `OpeningAngle` is in radians."""


# YAML has lists, which strict tuples reject.
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
"""The type of an error that has its diagnostic in its context."""

VALUE_NAME = "{this}"
"""Placeholder in a custom error's message for the name of the value."""


def custom_error(
    code: str,
    message: str,
    *,
    at: At = "value",
    hint: str | None = None,
    span: tuple[int, int] | None = None,
    beside: str | None = None,
) -> PydanticCustomError:
    """Returns a Pydantic error with the contents of a diagnostic.

    Args:
        code: code of the diagnostic.
        message: message of the diagnostic; `VALUE_NAME` in it is replaced.
        at: whether the diagnostic points to the key or the value.
        hint: hint of the diagnostic.
        span: part of a string that is wrong [characters, end exclusive]; None for all of it.
        beside: another key of the same mapping that the diagnostic also points to.
    """
    context = {"code": code, "message": message, "at": at, "hint": hint, "span": span, "beside": beside}
    return PydanticCustomError(CUSTOM_ERROR, "{message}", context)


class ErrorCollector:
    """Collects the errors of one validator, to raise them together."""

    def __init__(self) -> None:
        self._lines: list[InitErrorDetails] = []

    def add(self, error: PydanticCustomError, found: Any, *loc: PathKey) -> None:
        """Adds the error of the value `found`, which is at `loc` in the validated value."""
        self._lines.append({"type": error, "loc": loc, "input": found})

    def take(self, problem: ValidationError, *loc: PathKey) -> None:
        """Adds the errors of another validator, which was called for the part at `loc`."""
        self._lines += [_copy_error(error, loc) for error in problem.errors(include_url=False)]

    def stop(self) -> None:
        """Raises the collected errors.

        Raises:
            ValidationError: at least one error was added.
        """
        if self._lines:
            raise ValidationError.from_exception_data("value", self._lines)


def _copy_error(error: ErrorDetails, loc: tuple[PathKey, ...]) -> InitErrorDetails:
    kind, context = error["type"], error.get("ctx", {})
    again: Any = PydanticCustomError(kind, error["msg"], context) if kind.startswith("#") else kind  # pyright: ignore[reportArgumentType]
    return {"type": again, "loc": (*loc, *error["loc"]), "input": error["input"], "ctx": context}


NOTE_PREFIX = "x-"
"""Prefix of keys that are kept but ignored."""

NAME_PATTERN = r"^[A-Za-z_][A-Za-z0-9_.-]*$"

VARIABLE_PATTERN = r"^[A-Za-z_][A-Za-z0-9_]*$"

PREFIX_PATTERN = r"^(?:[A-Za-z_][A-Za-z0-9_.-]*(?:/[A-Za-z_][A-Za-z0-9_.-]*)*/?)?$"

PATTERN_HINTS = {
    NAME_PATTERN: "a name starts with a letter or `_` and continues with letters, digits, `_`, `.` and `-`",
    VARIABLE_PATTERN: "a name in expressions starts with a letter or `_` and continues with letters, digits and `_`",
    PREFIX_PATTERN: '"" keeps the names inside unchanged; any other value is the start of a name',
}
"""Pattern → hint for a string that does not match it."""

NOTE_SCHEMA = {"^x-": {"description": "A note or an anchor; ignored."}}
"""JSON Schema of the keys that are allowed in any mapping."""


def _allow_notes(schema: dict[str, Any]) -> None:
    schema["patternProperties"] = NOTE_SCHEMA


@dataclass(frozen=True)
class Excludes:
    """Annotation of a key that excludes other keys of its mapping. The exclusion is mutual."""

    keys: tuple[str, ...]


NameKind = Literal["entity", "frame", "material", "group", "link", "joint", "member", "argument", "scene file",
                   "URDF file", "MJCF file", "SRDF file", "mesh file", "image file", "starts file"]  # fmt: skip
"""Kinds of named objects: an entity, frame or camera, or a link of one; a frame with a region; a material; a collision
group; a link or joint of the entity itself; an object inside an instance; a parameter of a prefab; files."""


@dataclass(frozen=True)
class NameRole:
    """Annotation of a string that is the name of something."""

    kind: NameKind


WHOLE = object()
"""Annotation of a key whose mapping an override replaces instead of merging."""

PATTERN = object()
"""Annotation of a string that is a name pattern."""


@cache
def exclusions(model: type[BaseModel]) -> dict[str, frozenset[str]]:
    """Returns the keys of a model → the keys that they exclude. Keys that declare an exclusion come last."""
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
    """Base of all mappings of the language: strict, frozen, and without unknown keys."""

    # `defer_build`: the document's model builds all nested models. Building each model separately as well took a
    # third of the time of a small check. So did inlining a union at each use; hence `TypeAliasType` for common ones.
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
        """Rejects keys that exclude each other. The error is at the key that declares the exclusion.

        Raises:
            ValidationError: two keys exclude each other.
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
    """Makes `T | None` an optional key that cannot be null."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema = handler(source)
        return schema["schema"] if schema["type"] == "nullable" else schema


T = TypeVar("T")

Maybe = Annotated[T | None, _NotNullable()]
"""An optional key. None means missing, so the engine's default applies."""


def key(
    description: str,
    *,
    default: Any = None,
    examples: list[Any] | None = None,
    excludes: tuple[str, ...] = (),
) -> Any:
    """Returns the field of an optional key.

    Args:
        description: description with unit.
        default: the engine's default. It is only shown in the JSON Schema, never filled in.
        examples: suggestions for editors.
        excludes: keys that it excludes; the key itself in this list is ignored.
    """
    extra = {"default": default} if default is not None else None
    made: Any = Field(default=None, description=description, examples=examples, json_schema_extra=extra)
    made.metadata += [Excludes(excludes)] if excludes else []
    return made


def list_key(description: str) -> Any:
    """Returns the field of an optional list, empty by default."""
    return Field(default_factory=list, description=description, json_schema_extra={"default": []})


def names_key(description: str, *, alias: str | None = None, examples: list[Any] | None = None) -> Any:
    """Returns the field of an optional mapping of names, empty by default."""
    return Field(default_factory=dict, alias=alias, description=description, examples=examples)


def _check_literal(text: str) -> str:
    """Rejects an expression where any string is valid, since it would be taken literally."""
    if EXPRESSION_START in text and not EXPANDED.get():
        raise PydanticCustomError(NOT_MEANT, "a string without `${{`")
    return text


REFERENCE_PATTERN = r"^[A-Za-z_][A-Za-z0-9_.-]*(?:/[^/]+)*$"
"""Path of an entity, frame or link. A robot's file may give its links any names."""


class _MappingKey:
    """Annotation of a mapping's key. Notes are rejected; the document is then validated again without notes.

    The label is needed because Pydantic marks errors of keys with `[key]`, which may itself be a key.
    """

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return with_label(core_schema.no_info_after_validator_function(_refuse_note, handler(source)), KEY)


def _refuse_note(name: str) -> str:
    if name.startswith(NOTE_PREFIX):
        raise PydanticCustomError(NOT_MEANT, "a note")
    return name


MAPPING_KEY = _MappingKey()


class ScopedName:
    """Annotation of names that may contain slashes in an expanded document.

    Args:
        whole: whether the name may also start with a slash, which makes it absolute.
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
"""A name within the file."""

NewName = Annotated[Name, ScopedName(), MAPPING_KEY]
"""The name that a key defines."""

Reference = Annotated[str, StringConstraints(pattern=REFERENCE_PATTERN)]
"""A reference to an entity, frame or link."""

OuterName = Annotated[Name, ScopedName(whole=True)]
"""A name that may also be an argument of a prefab, and then belongs to the outer file."""

GroupName = Annotated[OuterName, NameRole("group")]

EntityName = Annotated[Reference, ScopedName(whole=True), NameRole("entity")]
"""ENTITY, ENTITY/LINK, a frame or a camera."""

AnyText = Annotated[str, AfterValidator(_check_literal)]

Text = Annotated[str, StringConstraints(min_length=1), AfterValidator(_check_literal)]

FrameName = Annotated[Reference, ScopedName(whole=True), NameRole("frame")]
"""A frame with a region."""

BodyName = Annotated[Text, NameRole("entity")]
"""ENTITY or ENTITY/LINK, resolved by lowering."""

LinkName = Annotated[Text, NameRole("link")]

SceneName = Annotated[Text, NameRole("scene file")]

ImageName = Annotated[Text, NameRole("image file")]

StartsName = Annotated[Text, NameRole("starts file")]
