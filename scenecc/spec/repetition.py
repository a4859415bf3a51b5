"""Keys for repetition and conditions: `repeat`, `if`, `name`. Expansion removes them."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, StringConstraints, Tag, ValidationError
from pydantic_core import PydanticCustomError, core_schema
from typing_extensions import TypeAliasType

from scenecc.spec.base import (
    MAPPING_KEY,
    VARIABLE_PATTERN,
    ErrorCollector,
    Maybe,
    Name,
    NonNegativeInt,
    ScopedName,
    SpecModel,
    key,
)
from scenecc.spec.nodes import (
    EXPANDED,
    LIST,
    MAPPING,
    NOT_MEANT,
    SHAPE,
    TYPE,
    LazyType,
    LazyValidator,
    is_mapping,
    is_varying,
    ordered_union,
    plain_json_schema,
    union_by_kind,
)
from scenecc.spec.values import Fixed

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

_Variable = Annotated[str, StringConstraints(pattern=VARIABLE_PATTERN)]

Variable = Annotated[_Variable, MAPPING_KEY]
"""The name of a parameter, loop variable or draw."""

NewVariable = Annotated[_Variable, ScopedName(), MAPPING_KEY]
"""A `Variable` that may have a scope in an expanded document."""


class RepeatCount(SpecModel):
    """The numbers from 0 to count - 1."""

    count: Fixed[NonNegativeInt] = Field(description="Number of copies.")


RepeatValues = Fixed[
    Annotated[
        Annotated[list[Any], Tag(LIST)] | Annotated[RepeatCount, Tag(MAPPING)],
        union_by_kind("a list of values or {count: n}"),
    ]
]

Repeat = TypeAliasType("Repeat", Annotated[dict[Variable, RepeatValues], Field(min_length=1)])
"""Loop variable → its values, or {count: n}. The last variable varies fastest."""


class CopyKeys(SpecModel):
    """Keys of nodes that may be repeated or conditional."""

    repeat: Maybe[Repeat] = key(
        "Loop variable → its values, or {count: n}. One copy for each combination; the last variable varies fastest.",
        examples=[{"i": [-1, 1], "j": {"count": 3}}],
    )
    if_: Maybe[Fixed[bool]] = Field(
        default=None, alias="if", description="An expression over parameters; false omits it."
    )


class RepeatKeys(CopyKeys):
    """Keys of entities that may be repeated or conditional."""

    name: Maybe[Fixed[Name]] = key("Names of the copies; default: NAME_0, NAME_1, …", examples=["leg_${i}_${j}"])


class _Repeatable:
    """Annotation of a shape that may have `repeat`, or an expression as its type."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema = handler(source)
        read = partial(_read_repeatable, LazyValidator(schema))
        return ordered_union([(schema, SHAPE)], core_schema.no_info_plain_validator_function(read))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        is_open = {"properties": {TYPE: {"pattern": r"\$\{"}}, "required": [TYPE]}
        return {"if": is_open, "then": {"type": "object"}, "else": plain_json_schema(schema, handler)}


REPEATABLE = _Repeatable()

_REPEAT = LazyType("scenecc.spec.repetition", "Repeat")


def _read_repeatable(plain: LazyValidator, node: Any) -> Any:
    """Validates an unexpanded shape with `repeat` or a varying type. Its type's keys are checked after expansion."""
    kind = node.get(TYPE) if is_mapping(node) else None
    is_open = is_varying(kind)
    if EXPANDED.get() or not is_mapping(node) or not (is_open or "repeat" in node):
        raise PydanticCustomError(NOT_MEANT, "a plain shape")
    mistakes = ErrorCollector()
    if "repeat" in node:
        try:
            _REPEAT.validate(node["repeat"])
        except ValidationError as problem:
            mistakes.take(problem, "repeat")
    shape: Any = None
    try:
        if is_open and isinstance(kind, str):
            from scenecc.spec.forms import parse_template

            parse_template(kind)
        else:
            shape = plain.validate({key: item for key, item in node.items() if key != "repeat"})
    except PydanticCustomError as problem:
        mistakes.add(problem, kind, TYPE)
    except ValidationError as problem:
        mistakes.take(problem)
    mistakes.stop()
    return shape
