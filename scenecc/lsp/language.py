"""The keys and values that the language allows at a path, with descriptions, from the JSON Schema."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from scenecc.spec.base import NOTE_PREFIX
from scenecc.variation.forms import FORM_KEYS

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Path as KeyPath

Schema = Mapping[str, Any]

Siblings = Callable[["KeyPath"], Mapping[str, "str | None"]]
"""Returns the keys of the mapping at a path that are already written, with the texts of scalar values."""

_FORMS: Final = frozenset(("NumberForm", "IntegerForm", "ValueForm"))
"""Definitions whose keys are forms, which any value accepts; they are listed last."""


class Word(NamedTuple):
    """A key or a value.

    Attributes:
        text: as written.
        description: description with unit and default; "" if there is none.
        is_form: whether it makes a value differ between scenes.
    """

    text: str
    description: str
    is_form: bool = False


@cache
def _schema() -> Schema:
    from scenecc.spec.json_schema import json_schema  # noqa: PLC0415 - builds all models, which takes a second

    return json_schema()


def load_language() -> None:
    """Builds the JSON Schema in advance, so that the first request need not wait."""
    _schema()


def keys_at(path: KeyPath, siblings: Siblings) -> list[Word]:
    """Returns the keys that the mapping at a path may have."""
    words: dict[str, Word] = {}
    for branch, is_form in _branches_at(path, siblings):
        for key, schema in branch.get("properties", {}).items():
            words.setdefault(key, Word(key, _describe(schema), is_form))
    return sorted(words.values(), key=lambda word: word.is_form)


def values_at(path: KeyPath, siblings: Siblings) -> list[Word]:
    """Returns the words that may be the value at a path: those of an enumeration, and true and false."""
    words: dict[str, Word] = {}
    for branch, _ in _branches_at(path, siblings):
        allowed = branch.get("enum", [branch["const"]] if "const" in branch else [])
        if _types(branch) == {"boolean"}:
            allowed = [True, False]
        for value in allowed:
            text = value if isinstance(value, str) else json.dumps(value)
            words.setdefault(text, Word(text, str(branch.get("description", ""))))
    return list(words.values())


def describe_key(path: KeyPath, siblings: Siblings) -> str | None:
    """Returns the Markdown description of the key at the end of a path; None if the language has no such key."""
    if not path or not isinstance(path[-1], str):
        return None
    found = (_step(branch, path[-1]) for branch, _ in _branches_at(path[:-1], siblings))
    texts = dict.fromkeys(_describe(schema) for schema in found if schema is not None)
    shown = [text for text in texts if text]
    return "\n\n".join(shown[:3]) or (_describe_kind(path[:-1], siblings) if path[-1] == "type" else None)


def _describe_kind(path: KeyPath, siblings: Siblings) -> str | None:
    """Returns the description of the kind of a mapping that has a `type`, and the words for the other kinds."""
    chosen = [branch for branch, is_form in _branches_at(path, siblings) if not is_form]
    words = values_at((*path, "type"), lambda below: {} if below == path else siblings(below))
    described = str(chosen[0].get("description", "")) if len(chosen) == 1 else ""
    listed = "One of " + ", ".join(f"`{word.text}`" for word in words) + "." if words else ""
    return " ".join(part for part in (described, listed) if part) or None


def is_mapping_key(path: KeyPath, siblings: Siblings) -> bool:
    """Returns whether the value at a path must be a mapping or a list, which begins on the next line."""
    branches = [branch for branch, is_form in _branches_at(path, siblings) if not is_form]
    return bool(branches) and all(_types(branch) <= {"object", "array"} for branch in branches)


def _types(schema: Schema) -> set[str]:
    """Returns the JSON types that a value may have."""
    given = schema.get("type", "object" if "properties" in schema else "any")
    return {given} if isinstance(given, str) else {*given}


def _describe(schema: Schema) -> str:
    """Returns description, default and enumeration of a key."""
    text = str(schema.get("description") or _resolve(schema).get("description", ""))
    parts = [text] if text else []
    if "default" in schema and schema["default"] not in ([], {}, ""):
        parts.append(f"Default: `{json.dumps(schema['default'], ensure_ascii=False)}`.")
    words = [value for branch, _ in _alternatives(schema, {}) for value in branch.get("enum", ())]
    if words:
        parts.append("One of " + ", ".join(f"`{word}`" for word in dict.fromkeys(words)) + ".")
    return " ".join(parts)


def _branches_at(path: KeyPath, siblings: Siblings) -> list[tuple[Schema, bool]]:
    """Returns the schemas allowed at a path, each with whether it is a form."""
    branches = list(_alternatives(_schema(), siblings(())))
    for end, step in enumerate(path, 1):
        present = siblings(path[:end])
        stepped = [found for branch, _ in branches if (found := _step(branch, step)) is not None]
        branches = [one for found in stepped for one in _alternatives(found, present)]
        unique = {id(branch): (branch, is_form) for branch, is_form in branches}
        branches = list(unique.values())
    return branches


def _step(schema: Schema, step: str | int) -> Schema | None:
    """Returns the schema below a key or an index."""
    if isinstance(step, int):
        items: list[Schema] = schema.get("prefixItems", [])
        return items[step] if step < len(items) else schema.get("items")
    if step in schema.get("properties", {}):
        return schema["properties"][step]
    if step.startswith(NOTE_PREFIX):
        return None
    for pattern, below in schema.get("patternProperties", {}).items():
        # An incomplete name is valid here.
        if pattern != f"^{NOTE_PREFIX}" and (not step or _compile_pattern(pattern).search(step[:200])):
            return below
    below: Any = schema.get("additionalProperties")
    return None if isinstance(below, bool) else below


@lru_cache(maxsize=64)
def _compile_pattern(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern)


def _resolve(schema: Schema) -> Schema:
    while "$ref" in schema:
        schema = _schema()["$defs"][schema["$ref"].rpartition("/")[2]]
    return schema


def _alternatives(schema: Schema, present: Mapping[str, str | None]) -> Iterator[tuple[Schema, bool]]:
    """Yields the resolved alternatives of a schema for a mapping with some keys."""
    is_form = schema.get("$ref", "").rpartition("/")[2] in _FORMS
    schema = _resolve(schema)
    choices: list[Schema] = [*schema.get("anyOf", ()), *schema.get("oneOf", ())]
    if choices and "properties" not in schema:
        yield from _select_by_type(choices, present)
        return
    if "if" in schema:
        yield from _conditional(schema, present)
        return
    # A mapping with a key of a form is that form.
    if not is_form or not present or not FORM_KEYS.isdisjoint(present):
        yield schema, is_form


def _select_by_type(choices: list[Schema], present: Mapping[str, str | None]) -> Iterator[tuple[Schema, bool]]:
    """Yields the alternative with the written `type`, or all of them."""
    kind = present.get("type")
    wanted = [one for one in choices if _resolve(one).get("properties", {}).get("type", {}).get("const") == kind]
    for choice in wanted if kind is not None and wanted else choices:
        yield from _alternatives(choice, present)


def _conditional(schema: Schema, present: Mapping[str, str | None]) -> Iterator[tuple[Schema, bool]]:
    """Resolves `if`, `then` and `else`: the present keys decide the kind of a mapping."""
    deciding: list[str] = schema["if"].get("required", [])
    if "properties" in schema["if"]:  # the type is an expression, so anything may follow
        yield from _alternatives(schema["else"], present)
        return
    if all(key in present for key in deciding):
        yield from _alternatives(schema["then"], present)
        return
    then = _resolve(schema["then"])
    if not {"if", "properties"} & {*_resolve(schema["else"])}:
        yield from _alternatives(then, present)  # no kind without a deciding key
        return
    if not present.keys() & _DECIDED:
        yield {"properties": {key: then["properties"][key] for key in deciding if key in then["properties"]}}, False
    yield from _alternatives(schema["else"], present)


_DECIDED: Final = frozenset(("shapes", "collisions", "visuals", "body_type"))
"""Keys of an entity that is a body."""
