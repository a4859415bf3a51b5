"""The section `entities`. The keys of an entity determine its model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import ValidationError
from pydantic_core import PydanticCustomError, core_schema

from scenecc.spec.base import ErrorCollector, custom_error, exclusions
from scenecc.spec.body import BodySpec
from scenecc.spec.nodes import BODY, COPIES, ENTITY_LABELS, NOT_MEANT, LazyType, ModelChoice, entity_kind, ordered_union

if TYPE_CHECKING:
    from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

    from scenecc.spec.articulation import Mjcf, Tree, Urdf
    from scenecc.spec.instances import Instance, RepeatedBody, Variants


ENTITY_TYPES = {
    ENTITY_LABELS["use"]: LazyType("scenecc.spec.instances", "Instance"),
    ENTITY_LABELS["variants"]: LazyType("scenecc.spec.instances", "Variants"),
    ENTITY_LABELS["urdf"]: LazyType("scenecc.spec.articulation", "Urdf"),
    ENTITY_LABELS["mjcf"]: LazyType("scenecc.spec.articulation", "Mjcf"),
    ENTITY_LABELS["root"]: LazyType("scenecc.spec.articulation", "Tree"),
    COPIES: LazyType("scenecc.spec.instances", "RepeatedBody"),
}
"""Label of an entity other than a plain body → its model."""


def entity_model(label: str) -> type[BaseModel]:
    """Returns the model for the label of an entity other than a plain body."""
    return ENTITY_TYPES[label].type


class _Entity(ModelChoice):
    """Annotation of an entity. Models other than that of a plain body are built on first use."""

    def choose(self, node: Any) -> type[BaseModel]:
        """Returns the model of an entity."""
        label = entity_kind(node)
        return BodySpec if label == BODY else entity_model(label)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return ordered_union(
            [(handler(source), BODY)], core_schema.no_info_plain_validator_function(_read_special_entity)
        )

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        schemas = {label: later.json_schema(handler) for label, later in ENTITY_TYPES.items()}
        found: JsonSchemaValue = schemas[COPIES]
        for key, label in reversed(ENTITY_LABELS.items()):
            found = {"if": {"required": [key]}, "then": schemas[label], "else": found}
        return found


def _read_special_entity(node: Any) -> Any:
    label = entity_kind(node)
    if label == BODY:
        raise PydanticCustomError(NOT_MEANT, "a plain body")
    mistakes = ErrorCollector()
    made: Any = None
    try:
        made = ENTITY_TYPES[label].validate(node)
    except ValidationError as problem:
        mistakes.take(problem, label)
    else:
        if label == ENTITY_LABELS["variants"]:
            _check_common_keys(made, mistakes)
    mistakes.stop()
    return made


def _check_common_keys(entity: Variants, mistakes: ErrorCollector) -> None:
    """Rejects a key of a variant that the entity also has or excludes. Lists of shapes are concatenated instead."""
    common, excluded = entity.model_fields_set, exclusions(entity.__class__)
    for i, variant in enumerate(entity.variants):
        for key in sorted(variant.model_fields_set - {"shapes", "collisions", "visuals"}):
            for other in sorted(common & {key, *excluded.get(key, ())}):
                message = f"`{key}` is already set next to `variants`, for all variants"
                if other != key:
                    message = f"`{other}` beside `variants` and `{key}` exclude each other"
                error = custom_error("SC111", message, at="key")
                mistakes.add(error, key, ENTITY_LABELS["variants"], "variants", i, key)


if TYPE_CHECKING:
    Entity = BodySpec | RepeatedBody | Instance | Variants | Urdf | Mjcf | Tree
else:
    Entity = Annotated[BodySpec, _Entity()]
