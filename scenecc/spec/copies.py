"""Repetition and conditions: keys that say which shapes and entities there are. Expansion takes them out."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, StringConstraints, Tag, ValidationError
from pydantic_core import PydanticCustomError, core_schema
from typing_extensions import TypeAliasType

from scenecc.spec.base import MAPPING_KEY, VARIABLE_PATTERN, Maybe, Model, Name, Scoped, key
from scenecc.spec.later import Later
from scenecc.spec.leaf import Fixed
from scenecc.spec.mistakes import Mistakes
from scenecc.spec.plain import is_mapping
from scenecc.spec.scalars import NonNegativeInt
from scenecc.spec.unions import (
    EXPANDED,
    LIST,
    MAPPING,
    NOT_MEANT,
    SHAPE,
    TYPE,
    Validator,
    by_kind,
    in_order,
    is_varying,
    plain_json,
)

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

_Variable = Annotated[str, StringConstraints(pattern=VARIABLE_PATTERN)]
Variable = Annotated[_Variable, MAPPING_KEY]
"""The name of a parameter, a loop variable or a draw."""

NewVariable = Annotated[_Variable, Scoped(), MAPPING_KEY]
"""The same, which an expanded document may have inside an instance."""


class Count(Model):
    """The numbers from 0 to count - 1."""

    count: Fixed[NonNegativeInt] = Field(description="How many.")


Axis = Fixed[
    Annotated[
        Annotated[list[Any], Tag(LIST)] | Annotated[Count, Tag(MAPPING)],
        by_kind("a list of values or {count: n}"),
    ]
]
Repeat = TypeAliasType("Repeat", Annotated[dict[Variable, Axis], Field(min_length=1)])
"""Variable → its values, or {count: n}; the product of all, the last varying fastest."""


class Copies(Model):
    """Keys that say how often an entity is there."""

    repeat: Maybe[Repeat] = key(
        "Loop variable → its values, or {count: n}; one copy for each of their product, the last varying fastest.",
        examples=[{"i": [-1, 1], "j": {"count": 3}}],
    )
    if_: Maybe[Fixed[bool]] = Field(
        default=None, alias="if", description="An expression over parameters; false leaves it out."
    )
    name: Maybe[Fixed[Name]] = key(
        "What the copies are called; left out: NAME_0, NAME_1, …", examples=["leg_${i}_${j}"]
    )


class _Repeated:
    """The annotation of a shape, which may be repeated, and whose type may be an expression."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema = handler(source)
        read = partial(_shape, Validator(schema))
        return in_order([(schema, SHAPE)], core_schema.no_info_plain_validator_function(read))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        is_open = {"properties": {TYPE: {"pattern": r"\$\{"}}, "required": [TYPE]}
        return {"if": is_open, "then": {"type": "object"}, "else": plain_json(schema, handler)}


Repeated = _Repeated()

_repeat = Later("scenecc.spec.copies", "Repeat")


def _shape(plain: Validator, node: Any) -> Any:
    """A shape as written that only expansion understands. What its type decides about is judged after that."""
    kind = node.get(TYPE) if is_mapping(node) else None
    is_open = is_varying(kind)
    if EXPANDED.get() or not is_mapping(node) or not (is_open or "repeat" in node):
        raise PydanticCustomError(NOT_MEANT, "a plain shape")
    mistakes = Mistakes()
    if "repeat" in node:
        try:
            _repeat.validate(node["repeat"])
        except ValidationError as problem:
            mistakes.take(problem, "repeat")
    shape: Any = None
    try:
        if is_open and isinstance(kind, str):
            from scenecc.spec.expressions import written

            written(kind)
        else:
            shape = plain.validate({key: item for key, item in node.items() if key != "repeat"})
    except PydanticCustomError as problem:
        mistakes.add(problem, kind, TYPE)
    except ValidationError as problem:
        mistakes.take(problem)
    mistakes.stop()
    return shape
