"""What may stand in place of a value, in the JSON Schema: definitions that every key refers to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.spec.base import NOTES
from scenecc.spec.forms import COMPANIONS
from scenecc.spec.plain import is_mapping
from scenecc.variation.distributions import DISTRIBUTIONS

if TYPE_CHECKING:
    from scenecc.variation.distributions import Distribution

REFERENCE = "x-ref"
"""Stands for `$ref` to one of `DEFINITIONS` until the schema is whole: pydantic's generator knows only its own."""

EXPRESSION = {REFERENCE: "Expression"}

_LISTED: dict[str, Any] = {
    "per_scene": {
        "description": "One value for each scene that the entity is in, or by scene index with a `default`.",
        "anyOf": [
            {"type": "array", "minItems": 1},
            {
                "type": "object",
                "minProperties": 1,
                "properties": {"default": {"description": "Of all other scenes."}},
                "patternProperties": {"^[0-9]+$": {}, **NOTES},
                "additionalProperties": False,
            },
            EXPRESSION,
        ],
    },
    "cycle": {
        "description": "By scene index modulo the length.",
        "anyOf": [{"type": "array", "minItems": 1}, EXPRESSION],
    },
    "choice": {"description": "One of them, drawn.", "anyOf": [{"type": "array", "minItems": 1}, EXPRESSION]},
    "weights": {
        "description": "How likely each choice is.",
        "anyOf": [{"type": "array", "items": {"anyOf": [{"type": "number", "minimum": 0}, EXPRESSION]}}, EXPRESSION],
    },
}  # fmt: skip


def _operands(description: str, count: int = 2) -> dict[str, Any]:
    listed = {"type": "array", "minItems": count, "maxItems": count}
    return {"description": description, "anyOf": [listed, EXPRESSION]}


def _drawn(drawn: Distribution) -> dict[str, Any]:
    keys = {drawn.key: _operands(drawn.description, len(drawn.operands))}
    return {**keys, drawn.companion: _operands(drawn.companion_description)} if drawn.companion else keys


_NUMBERS = {key: schema for drawn in DISTRIBUTIONS.values() for key, schema in _drawn(drawn).items()}
_INTEGERS = {drawn.key: _NUMBERS[drawn.key] for drawn in DISTRIBUTIONS.values() if drawn.whole}
_COMPANIONS = {companion: form for form, companion in COMPANIONS.items()}


def _form(description: str, keys: dict[str, Any]) -> dict[str, Any]:
    forms = [key for key in keys if key not in _COMPANIONS]
    return {
        "description": description,
        "type": "object",
        "properties": keys,
        "patternProperties": NOTES,
        "additionalProperties": False,
        "oneOf": [{"required": [key]} for key in forms],
        "dependentRequired": {key: [form] for key, form in _COMPANIONS.items() if key in keys},
    }


def _varying(form: str) -> dict[str, Any]:
    return {"anyOf": [EXPRESSION, {REFERENCE: form}]}


_SCALAR = {"type": ["number", "string", "boolean", "array"]}

DEFINITIONS: dict[str, Any] = {
    "Expression": {
        "description": "`${…}`: arithmetic over parameters, loop variables and draws.",
        "type": "string",
        "pattern": r"\$\{",
    },
    "NumberForm": _form("Numbers that differ from scene to scene.", {**_LISTED, **_NUMBERS}),
    "IntegerForm": _form("Whole numbers that differ from scene to scene.", {**_LISTED, **_INTEGERS}),
    "ValueForm": _form("A value that differs from scene to scene.", _LISTED),
    "VaryingNumber": _varying("NumberForm"),
    "VaryingInteger": _varying("IntegerForm"),
    "VaryingValue": _varying("ValueForm"),
    "Parameter": {
        "description": "A default, from which the type follows, or a mapping.",
        "anyOf": [
            _SCALAR,
            {
                "type": "object",
                "properties": {
                    "type": {
                        "description": "What it takes; left out: as the default is.",
                        "enum": ["number", "integer", "string", "boolean", "vector", "color", "file", "material",
                                 "choice", "list"],
                    },
                    "default": {"description": "Its value where none is given; left out: one must be."},
                    "min": {"description": "The least number or components.", "type": ["number", "array"]},
                    "max": {"description": "The greatest number or components.", "type": ["number", "array"]},
                    "description": {"description": "For people.", "type": "string"},
                    "options": {"description": "What a choice is among.", "type": "array", "minItems": 1},
                },
                "patternProperties": NOTES,
                "additionalProperties": False,
            },
        ],
    },
}  # fmt: skip


def varying_json(plain: dict[str, Any], varying: str, component: str) -> dict[str, Any]:
    """The JSON Schema of a value that may vary.

    Args:
        plain: of one that does not.
        varying: the definition of what may stand in its place.
        component: the same for one number of a list.
    """
    branches: list[dict[str, Any]] = plain["anyOf"] if plain.keys() == {"anyOf"} else [plain]
    if varying == "Expression" and any(branch.keys() <= {"type", "minLength"} and branch.get("type") == "string"
                                       for branch in branches):  # fmt: skip
        # Any text, an expression among them.
        return plain
    return {"anyOf": [*(_components(branch, component) for branch in branches), {REFERENCE: varying}]}


def _components(plain: dict[str, Any], component: str) -> dict[str, Any]:
    """A list of numbers, each of which may vary; anything else as it is."""
    items: list[Any] = plain.get("prefixItems", [plain.get("items")])
    if plain.get("type") != "array" or not is_mapping(items[0]) or any(item != items[0] for item in items):
        return plain
    if items[0].get("type") == "array":
        each = _components(items[0], component)
    elif items[0].get("type") in {"number", "integer"}:
        each = {"anyOf": [items[0], {REFERENCE: component}]}
    else:
        return plain
    rest = {key: value for key, value in plain.items() if key != "prefixItems"}
    return {**rest, "items": each}
