"""What stands under `entities`: a body, or what other keys make of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import ValidationError
from pydantic_core import PydanticCustomError, core_schema

from scenecc.spec.body import Body
from scenecc.spec.later import Later
from scenecc.spec.mistakes import Mistakes, told
from scenecc.spec.unions import BODY, COPIES, KIND_KEYS, NOT_MEANT, entity_kind, in_order

if TYPE_CHECKING:
    from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

    from scenecc.spec.articulation import Mjcf, Tree, Urdf
    from scenecc.spec.instance import BodyCopies, Instance
    from scenecc.spec.variants import Variants


MODELS = {
    KIND_KEYS["use"]: Later("scenecc.spec.instance", "Instance"),
    KIND_KEYS["variants"]: Later("scenecc.spec.variants", "Variants"),
    KIND_KEYS["urdf"]: Later("scenecc.spec.articulation", "Urdf"),
    KIND_KEYS["mjcf"]: Later("scenecc.spec.articulation", "Mjcf"),
    KIND_KEYS["root"]: Later("scenecc.spec.articulation", "Tree"),
    COPIES: Later("scenecc.spec.instance", "BodyCopies"),
}
"""The models of entities that are no plain bodies, by their labels."""


def entity_model(label: str) -> type[BaseModel]:
    """The model of an entity that is no plain body, by its label."""
    return MODELS[label].type


class _Entity:
    """The annotation of an entity. Models of all but plain bodies are made only where there is such an entity."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return in_order([(handler(source), BODY)], core_schema.no_info_plain_validator_function(_otherwise))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        schemas = {label: later.json_schema(handler) for label, later in MODELS.items()}
        found: JsonSchemaValue = schemas[COPIES]
        for key, label in reversed(KIND_KEYS.items()):
            found = {"if": {"required": [key]}, "then": schemas[label], "else": found}
        return found


def _otherwise(node: Any) -> Any:
    label = entity_kind(node)
    if label == BODY:
        raise PydanticCustomError(NOT_MEANT, "a plain body")
    mistakes = Mistakes()
    made: Any = None
    try:
        made = MODELS[label].validate(node)
    except ValidationError as problem:
        mistakes.take(problem, label)
    else:
        if label == KIND_KEYS["variants"]:
            _said_twice(made, mistakes)
    mistakes.stop()
    return made


def _said_twice(entity: Variants, mistakes: Mistakes) -> None:
    """What a variant has, the variants have not in common; lists of shapes are joined."""
    common = entity.model_fields_set
    for i, variant in enumerate(entity.variants):
        for key in sorted(common & variant.model_fields_set - {"shapes", "collisions", "visuals"}):
            message = f"`{key}` stands beside `variants` too, where it is common to all"
            mistakes.add(told("SC111", message, at="key"), key, KIND_KEYS["variants"], "variants", i, key)


if TYPE_CHECKING:
    Entity = Body | BodyCopies | Instance | Variants | Urdf | Mjcf | Tree
else:
    Entity = Annotated[Body, _Entity()]
