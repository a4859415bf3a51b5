"""The JSON Schema of the language, for editors."""

from __future__ import annotations

from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from scenecc.spec.base import NOTES
from scenecc.spec.document import SceneFile
from scenecc.spec.json_forms import DEFINITIONS, REFERENCE
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.spec.scalars import LARGEST, SMALLEST

DIALECT = "https://json-schema.org/draft/2020-12/schema"


class _Generator(GenerateJsonSchema):
    """Pydantic's generator, for people who write YAML."""

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        """A key that may be left out has no default `null`: null is refused."""
        if schema.get("default", ...) is None:
            return self.generate_inner(schema["schema"])
        return super().default_schema(schema)

    def get_title_from_name(self, name: str) -> str:
        """Keys are their own titles."""
        return name


def json_schema() -> dict[str, Any]:
    """The JSON Schema of a scene file."""
    schema = SceneFile.model_json_schema(schema_generator=_Generator)
    definitions = {**schema.pop("$defs"), **DEFINITIONS}
    ordered = {name: definitions[name] for name in sorted(definitions)}
    return {"$schema": DIALECT, "title": "scenecc scene", **_tidied(schema), "$defs": _definitions(ordered)}


def _definitions(definitions: dict[str, Any]) -> dict[str, Any]:
    return {name: _tidied(definition) for name, definition in definitions.items()}


def _tidied(node: Any) -> Any:
    """Without titles that repeat a key and the range of single precision, and with names checked as names."""
    if is_mapping(node):
        out = {key: _tidied(item) for key, item in node.items() if not _is_noise(key, item)}
        if REFERENCE in out:
            out["$ref"] = f"#/$defs/{out.pop(REFERENCE)}"
        return _named(out) if "patternProperties" in out and "properties" not in out else out
    return [_tidied(item) for item in node] if is_sequence(node) else node


def _is_noise(key: str, item: Any) -> bool:
    if key in {"minimum", "maximum"} and isinstance(item, (int, float)):
        return abs(item) in {LARGEST, SMALLEST}
    return key == "title" and isinstance(item, str)


def _named(mapping: dict[str, Any]) -> dict[str, Any]:
    """A mapping whose keys are names: others are refused, and notes are no names."""
    ((pattern, entry),) = mapping["patternProperties"].items()
    patterns = {pattern.replace("^", "^(?!x-)", 1): entry, **NOTES}
    return {**mapping, "patternProperties": patterns, "additionalProperties": False}
