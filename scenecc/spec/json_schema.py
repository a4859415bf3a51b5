"""Generates the JSON Schema of the language, for editors."""

from __future__ import annotations

from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from scenecc.plan.properties import FLOAT32_MAX, FLOAT32_MIN
from scenecc.spec.articulation import ChildLink
from scenecc.spec.base import NOTE_SCHEMA
from scenecc.spec.document import SceneFile
from scenecc.spec.forms import COMPANIONS
from scenecc.spec.nodes import REF_KEY, is_mapping, is_sequence
from scenecc.variation.distributions import DISTRIBUTIONS, Distribution

EXPRESSION_REF = {REF_KEY: "Expression"}

_LIST_FORMS: dict[str, Any] = {
    "per_scene": {
        "description": "One value for each scene that the entity is in, or by scene index with a `default`.",
        "anyOf": [
            {"type": "array", "minItems": 1},
            {
                "type": "object",
                "minProperties": 1,
                "properties": {"default": {"description": "The value in all other scenes."}},
                "patternProperties": {"^[0-9]+$": {}, **NOTE_SCHEMA},
                "additionalProperties": False,
            },
            EXPRESSION_REF,
        ],
    },
    "cycle": {
        "description": "By scene index modulo the length.",
        "anyOf": [{"type": "array", "minItems": 1}, EXPRESSION_REF],
    },
    "choice": {"description": "One of the items, drawn.", "anyOf": [{"type": "array", "minItems": 1}, EXPRESSION_REF]},
    "shuffle": {
        "description": "A random order of a list.",
        "anyOf": [{"type": "array", "minItems": 1}, EXPRESSION_REF],
    },
    "once": {
        "description": "A form whose value a reset does not redraw.",
        "anyOf": [{"type": ["object", "array"]}, EXPRESSION_REF],
    },
    "weights": {
        "description": "Weight of each choice.",
        "anyOf": [
            {"type": "array", "items": {"anyOf": [{"type": "number", "minimum": 0}, EXPRESSION_REF]}},
            EXPRESSION_REF,
        ],
    },
}  # fmt: skip


def _operands(description: str, count: int = 2) -> dict[str, Any]:
    listed = {"type": "array", "minItems": count, "maxItems": count}
    return {"description": description, "anyOf": [listed, EXPRESSION_REF]}


def _draw_schema(drawn: Distribution) -> dict[str, Any]:
    keys = {drawn.key: _operands(drawn.description, len(drawn.operands))}
    return {**keys, drawn.companion: _operands(drawn.companion_description)} if drawn.companion else keys


_NUMBER_FORMS = {key: schema for drawn in DISTRIBUTIONS.values() for key, schema in _draw_schema(drawn).items()}

_INTEGER_FORMS = {drawn.key: _NUMBER_FORMS[drawn.key] for drawn in DISTRIBUTIONS.values() if drawn.whole}

_COMPANIONS = {
    companion: [form for form, beside in COMPANIONS.items() if beside == companion] for companion in COMPANIONS.values()
}
"""Companion key → its forms."""

_NEEDED = {drawn.key: [drawn.companion] for drawn in DISTRIBUTIONS.values() if drawn.needs_companion}


def _form_schema(description: str, keys: dict[str, Any]) -> dict[str, Any]:
    forms = [key for key in keys if key not in _COMPANIONS]
    return {
        "description": description,
        "type": "object",
        "properties": keys,
        "patternProperties": NOTE_SCHEMA,
        "additionalProperties": False,
        "oneOf": [{"required": [key]} for key in forms],
        "dependentRequired": {key: needed for key, needed in _NEEDED.items() if key in keys},
        "dependentSchemas": {
            key: {"anyOf": [{"required": [form]} for form in forms]}
            for key, forms in _COMPANIONS.items()
            if key in keys
        },
    }


def _allow_form(form: str) -> dict[str, Any]:
    return {"anyOf": [EXPRESSION_REF, {REF_KEY: form}]}


_SCALAR = {"type": ["number", "string", "boolean", "array"]}

DEFINITIONS: dict[str, Any] = {
    "Expression": {
        "description": "`${…}`: arithmetic over parameters, loop variables and draws.",
        "type": "string",
        "pattern": r"\$\{",
    },
    "NumberForm": _form_schema("Numbers that differ from scene to scene.", {**_LIST_FORMS, **_NUMBER_FORMS}),
    "IntegerForm": _form_schema("Integers that differ from scene to scene.", {**_LIST_FORMS, **_INTEGER_FORMS}),
    "ValueForm": _form_schema("A value that differs from scene to scene.", _LIST_FORMS),
    "VaryingNumber": _allow_form("NumberForm"),
    "VaryingInteger": _allow_form("IntegerForm"),
    "VaryingValue": _allow_form("ValueForm"),
    "Parameter": {
        "description": "A default, from which the type follows, or a mapping.",
        "anyOf": [
            _SCALAR,
            {
                "type": "object",
                "properties": {
                    "type": {
                        "description": "Type of the value. Default: that of the default value.",
                        "enum": ["number", "integer", "string", "boolean", "vector", "color", "file", "material",
                                 "entity", "choice", "list"],
                    },
                    "default": {"description": "Default value. Without it, a value is required."},
                    "min": {"description": "Minimum of the number or of each component.", "type": ["number", "array"]},
                    "max": {"description": "Maximum of the number or of each component.", "type": ["number", "array"]},
                    "description": {"description": "Description of the parameter.", "type": "string"},
                    "options": {"description": "Options of a choice.", "type": "array", "minItems": 1},
                },
                "patternProperties": NOTE_SCHEMA,
                "additionalProperties": False,
            },
        ],
    },
}  # fmt: skip


DIALECT = "https://json-schema.org/draft/2020-12/schema"


class _SchemaGenerator(GenerateJsonSchema):
    """Pydantic's generator with optional keys that are not nullable, and without titles."""

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        """Leaves out the default `null` of optional keys, because null is rejected."""
        if schema.get("default", ...) is None:
            return self.generate_inner(schema["schema"])
        return super().default_schema(schema)

    def get_title_from_name(self, name: str) -> str:
        """Returns the key as its title."""
        return name


def json_schema() -> dict[str, Any]:
    """Returns the JSON Schema of a scene file."""
    schema = SceneFile.model_json_schema(schema_generator=_SchemaGenerator)
    definitions = {**schema.pop("$defs"), **DEFINITIONS}
    # Children refer to `ChildLink` by name, because the schema of a link would contain itself.
    link, copies = definitions["TreeLink"], definitions["RepeatedBody"]["properties"]
    keys = {**link["properties"], "repeat": copies["repeat"], "if": copies["if"]}
    definitions["ChildLink"] = {**link, "description": ChildLink.__doc__, "properties": keys}
    ordered = {name: _tidy(definitions[name]) for name in sorted(definitions)}
    return {"$schema": DIALECT, "title": "scenecc scene", **_tidy(schema), "$defs": ordered}


def _tidy(node: Any) -> Any:
    """Removes titles and the range of float32, replaces placeholders, and restricts names."""
    if is_mapping(node):
        out = {key: _tidy(item) for key, item in node.items() if not _is_noise(key, item)}
        if REF_KEY in out:
            out["$ref"] = f"#/$defs/{out.pop(REF_KEY)}"
        return _restrict_names(out) if "patternProperties" in out and "properties" not in out else out
    return [_tidy(item) for item in node] if is_sequence(node) else node


def _is_noise(key: str, item: Any) -> bool:
    if key in {"minimum", "maximum"} and isinstance(item, (int, float)):
        return abs(item) in {FLOAT32_MAX, FLOAT32_MIN}
    return key == "title" and isinstance(item, str)


def _restrict_names(mapping: dict[str, Any]) -> dict[str, Any]:
    """Makes a mapping of names reject other keys and accept notes."""
    ((pattern, entry),) = mapping["patternProperties"].items()
    patterns = {pattern.replace("^", "^(?!x-)", 1): entry, **NOTE_SCHEMA}
    return {**mapping, "patternProperties": patterns, "additionalProperties": False}
