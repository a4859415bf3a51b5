"""Converts Pydantic's validation errors to diagnostics, one per mistake.

Pydantic's `loc` is mapped to a path in the document and to the model at this path.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, Literal

from scenecc.diagnostics.messages import LISTS_KEYS, cut, is_slip_of, keyboard_hint, listed, nearest, show
from scenecc.plan.properties import FLOAT32_MAX, FLOAT32_MIN
from scenecc.source.events import RESERVED_CHARACTER
from scenecc.spec.base import CUSTOM_ERROR, NAME_PATTERN, PATTERN_HINTS, VALUE_NAME
from scenecc.spec.body import BodySpec
from scenecc.spec.entities import ENTITY_TYPES, entity_model
from scenecc.spec.forms import quote_names
from scenecc.spec.hints import (
    BRIGHTNESS,
    HALVES,
    INSTANCE_HINT,
    KEY_SYNONYMS,
    MISSING_KEY_HINTS,
    PARAM_HINT,
    PARTS_HINT,
    PHYSICS_HINT,
    SEPARATE_ENTITIES_HINT,
    SHAPE_LIST_HINTS,
    SHARED_ROBOT_KEYS,
    UNSUPPORTED_KEYS,
    VARIANTS_HINT,
)
from scenecc.spec.key_hints import (
    entry_at,
    flow,
    half_hint,
    misplaced_hint,
    numbers,
    shape_hint,
    snake_case,
    suggest_key,
)
from scenecc.spec.keys import place_at
from scenecc.spec.nodes import (
    KEY,
    NOT_MEANT,
    TAGGED,
    WRONG_KIND,
    LazyUnion,
    child_at,
    is_mapping,
    is_meant,
    is_sequence,
    is_varying,
    value_at,
)
from scenecc.spec.notations import unit_hint
from scenecc.spec.references import NAME_SECTIONS
from scenecc.spec.repetition import RepeatKeys
from scenecc.spec.shapes import ShapeKeys
from scenecc.spec.value_hints import (
    MAPPING_OF_NAMES,
    choice_hint,
    color_hint,
    kind_hint,
    length_hint,
    name_hint,
)
from scenecc.variation.forms import FORM_KEYS

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from pydantic_core import ErrorDetails

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import At, Origin, Path, PathKey, RelatedPlace


def document_path(loc: tuple[PathKey, ...], data: Any) -> Path | None:
    """Converts Pydantic's `loc` to a path in the document. Returns None for errors of a branch that does not apply."""
    if KEY in loc:
        # An error of a mapping's key. Pydantic's own `[key]` comes before the label.
        loc = loc[: loc.index(KEY) - 1]
    path: list[PathKey] = []
    node = data
    segments = iter(loc)
    for segment in segments:
        if isinstance(segment, int) or not segment.startswith(RESERVED_CHARACTER):
            path.append(segment)
            node = child_at(node, segment)
        elif not is_meant(segment, node):
            return None
        elif segment == TAGGED:
            next(segments, None)
    return tuple(path)


_ENTITY_KEY_DEPTH = 3
"""Path length of a key directly in an entity."""

_EXPECTED_KINDS: dict[str, str] = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "string_type": "a text",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": MAPPING_OF_NAMES,
    "model_type": "a mapping",
    "model_attributes_type": "a mapping",
}
"""Pydantic's type errors → the expected kind."""

_BOUNDS: dict[str, tuple[str, str]] = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
}

_TYPED_SECTIONS = {"lights": "light", "constraints": "constraint"}
"""Sections whose entries have a `type` → the noun for messages. Elsewhere `type` belongs to shapes."""


def _report_error(error: ErrorDetails, path: Path, place: Origin, data: dict[str, Any], sink: Sink) -> None:
    """Reports one of Pydantic's errors at a path of the document. `place` is the origin of that path."""
    kind, found = error["type"], error["input"]
    if kind == CUSTOM_ERROR:
        _report_custom_error(error, path, place, sink)
    elif path == ("scenecc",) and kind != "missing":
        sink.report(
            "SC100", f"this is scenecc 1; it does not read version {show(found)}", place, hint="write `scenecc: 1`"
        )
    elif kind == "extra_forbidden":
        _report_unknown_key(path, data, place, sink)
    elif kind == "missing":
        _report_missing_key(path, data, place, sink)
    elif kind in _BOUNDS:
        _report_bound(error, path, data, place, sink)
    elif kind == "finite_number":
        sink.report("SC104", f"{value_name(path)} must be finite, not {show(found)}", place)
    elif kind == "string_too_short":
        sink.report("SC104", f"{value_name(path)} must not be empty", place)
    elif kind in {"too_long", "too_short"}:
        _report_length(error, path, place, sink)
    elif kind in {"literal_error", "union_tag_invalid", "union_tag_not_found"}:
        _report_choice(error, path, place, data, sink)
    elif kind == "string_pattern_mismatch":
        _report_pattern(error, place, sink)
    else:
        expected = error["msg"] if kind == WRONG_KIND else _EXPECTED_KINDS.get(kind, error["msg"])
        _report_wrong_kind(expected, path, found, place, sink)


def _report_custom_error(error: ErrorDetails, path: Path, place: Origin, sink: Sink) -> None:
    context = error.get("ctx", {})
    message, hint = context["message"].replace(VALUE_NAME, value_name(path)), context["hint"]
    if context["code"] == "SC116" and hint is None:
        hint = _variation_hint(path)
    if context["code"] == "SC103" and isinstance(error["input"], str):
        hint = unit_hint(path, error["input"]) or hint  # the form does not know whose bound it is
    related: list[RelatedPlace] = []
    if context["beside"] is not None:
        related = [("the first", replace(place, path=(*place.path[:-1], context["beside"])), "key")]
    sink.report(context["code"], message, place, at=context["at"], hint=hint, span=context["span"], related=related)


def _variation_hint(path: Path) -> str | None:
    """Returns a hint for a value that cannot differ between scenes."""
    if path[0] == "physics":
        return PHYSICS_HINT
    if path[0] == "entities" and len(path) == _ENTITY_KEY_DEPTH and path[-1] in SHARED_ROBOT_KEYS:
        return SEPARATE_ENTITIES_HINT
    is_terrain = path[0] == "entities" and (path[-1] == "file" or "heights" in path[2:])
    return VARIANTS_HINT if is_terrain or path[-1] in {"type", "body_type"} else None


def _report_bound(error: ErrorDetails, path: Path, data: Any, place: Origin, sink: Sink) -> None:
    found, (words, bound) = error["input"], _BOUNDS[error["type"]]
    limit = error["ctx"][bound]  # pyright: ignore[reportTypedDictNotRequiredAccess]
    hint = None
    if limit == FLOAT32_MIN and found <= 0:
        words, limit = "greater than", 0
        if found < 0 and path:
            hint = f"write {entry_at(path, -found)}, without the minus"
        elif path and path[-1] == "mass":
            hint = "remove it to get it from `density`; a body that never moves is `body_type: static`"
    elif abs(limit) in {FLOAT32_MIN, FLOAT32_MAX}:
        hint = "this is the range of single precision, in which the engine computes"
    elif limit == 1 and found > 1 and any(str(key).endswith("color") for key in path[-2:]):
        whole = next(length for length in (1, 2) if str(path[-length]).endswith("color"))
        hint = color_hint(path[: len(path) - whole + 1], value_at(data, path[: len(path) - whole + 1]))
    elif isinstance(found, int | float) and found < 0 <= limit <= -found and path:
        hint = f"write {entry_at(path, -found)}, without the minus"
    elif limit == 1 < found <= _PERCENT and path:
        hint = f"write {entry_at(path, found / _PERCENT)}: it is not in percent"
    elif path and limit == math.pi:
        hint = f"write `{path[-1]}_deg: {flow(found)}`: angles are radians"
    sink.report(
        "SC104",
        f"{value_name(path)} must be {words} {limit if isinstance(limit, int) else f'{limit:g}'}, not {show(found)}",
        place,
        hint=hint,
    )


_PERCENT: Final = 100


def _report_unknown_key(path: Path, data: Any, place: Origin, sink: Sink) -> None:
    key = str(path[-1])
    if _report_unsupported(key, place, sink, at="key"):
        return
    if key == "type" and _report_unsupported(value_at(data, path), place, sink):
        return
    known, free = known_keys(path, data)
    model = place_at(path[:-1], partial(value_at, data)).model(value_at(data, path[:-1]))
    models = {one.__name__ for one in model.__mro__} if model else set[str]()
    word = snake_case(key)
    owner = value_at(data, path[:-1])
    if above := _mapping_above(path, data):
        _report_dedented(path, above, place, sink)
        return
    hint = misplaced_hint(key, owner, known, str(path[-2]) if len(path) > 1 else "", models)
    if hint is None:
        hint = _other_place(path, data, known, free)
    if hint is None and "use" in known and not suggest_key(key, known):
        form = INSTANCE_HINT if _is_key_of_entities(key) else PARAM_HINT
        hint = form.format(entry=f"{key}: {flow(owner[key])}")
    fix: tuple[Literal["key"], str] | None = None
    if hint is None:
        near = suggest_key(key, known, free)
        hint = f"did you mean `{near}`?" if near else listed(free, key, LISTS_KEYS)
        if near in HALVES.get(word, ()):
            hint = half_hint(word, near, owner[key], is_shape="type" in owner)
        # No fix for a synonym with another convention (`quat` may be [x, y, z, w]), only for another spelling.
        is_synonym = word in {*KEY_SYNONYMS, *HALVES}
        if near in free and is_slip_of(key, free) and (not is_synonym or nearest(word, (near,), _SAME_WORD)):
            fix = "key", near
    sink.report("SC101", f"unknown key `{cut(key)}`", place, at="key", hint=hint, fix=fix)


def _other_place(path: Path, data: Any, known: Sequence[str], free: Sequence[str]) -> str | None:
    """Returns a hint for a key that a mapping beside it, or one around it, may have; for another name of it too.
    `free`: those of the `known` keys that the mapping does not have.
    """
    owner, word = value_at(data, path[:-1]), snake_case(str(path[-1]))
    value, meanings = flow(owner[path[-1]]), KEY_SYNONYMS.get(word, ())
    if not {*meanings}.isdisjoint(free) or nearest(word, known, _SAME_WORD):
        return None
    names = [str(path[-1]), *(() if suggest_key(str(path[-1]), known) else meanings)]
    beside = [one for one in dict.fromkeys((*owner, *known)) if one not in FORM_KEYS and is_mapping(owner.get(one, {}))]
    for key in names:
        for name in beside:
            inside = owner.get(name, {})
            moved = replaced(data, path[:-1], {**owner, name: {**inside, key: owner[path[-1]]}})
            if key not in inside and key in known_keys((*path[:-1], name, key), moved)[0]:
                return f"write it under `{name}`: `{name}: {{{key}: {value}}}`"
        for depth in reversed(range(len(path) - 1)):
            around = value_at(data, path[:depth])
            is_free = is_mapping(around) and isinstance(path[depth], str) and key not in around
            if is_free and key in known_keys((*path[:depth], key), data)[0]:
                return f"write `{key}: {value}` beside `{path[depth]}`"
    return None


def replaced(data: Any, path: Path, value: Any) -> Any:
    """Returns a copy of data with another value at a path."""
    if not path:
        return value
    key, *below = path
    if is_mapping(data):
        return {**data, key: replaced(data[str(key)], tuple(below), value)}
    return [replaced(one, tuple(below), value) if index == key else one for index, one in enumerate(data)]


def _mapping_above(path: Path, data: Any) -> str | None:
    """Returns the key above a key that belongs inside of it, but is not indented so far; None if there is none."""
    key, owner = str(path[-1]), value_at(data, path[:-1])
    above: str | None = next((one for one, after in pairwise(owner) if after == key), None)
    inside = None if above is None else owner[above]
    if above is None or not is_mapping(inside) or key in inside or above in FORM_KEYS:
        return None
    place = (*path[:-1], above)
    if place in _NAME_MAPPING_PATHS and is_mapping(owner[key]) and owner[key]:
        moved = {**data, above: {**inside, key: owner[key]}}
        known, _ = known_keys((*place, key, ""), moved)
        return above if next(iter(owner[key])) in known else None
    return above if key in known_keys((*place, key), data)[0] and path[:-1] in _NAME_MAPPING_PATHS[1:] else None


def _report_dedented(path: Path, above: str, place: Origin, sink: Sink) -> None:
    hint = "indent it and what belongs to it by two more spaces"
    sink.report("SC101", f"`{cut(str(path[-1]))}` belongs inside `{cut(above)}`, above it", place, at="key", hint=hint)


def _report_unsupported(word: Any, place: Origin, sink: Sink, *, at: Literal["key", "value"] = "value") -> bool:
    """Reports a key or a value that names something that the language leaves out; returns whether it does."""
    what = UNSUPPORTED_KEYS.get(snake_case(word)) if isinstance(word, str) else None
    if what is not None:
        sink.report("SC110", f"version 1 of the language does not support {what}", place, at=at)
    return what is not None


_SAME_WORD: Final = 0.8
"""Smallest `difflib` ratio of two spellings of the same word."""


def _is_key_of_entities(key: str) -> bool:
    """Whether a key belongs to any entity other than an instance."""
    return any(key in model.model_fields for model in (BodySpec, *map(entity_model, ENTITY_TYPES)))


def known_keys(path: Path, data: Any) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Returns the keys that the mapping of an unknown key may have, and the unused ones among them."""
    owner = value_at(data, path[:-1])
    model = place_at(path[:-1], partial(value_at, data)).model(owner)
    if model is None:
        return (), ()
    # `repeat`, `if` and `name` turn a plain body into another model.
    models = (model, RepeatKeys) if model is BodySpec else (model,)
    keys = [field.alias or name for known in models for name, field in known.model_fields.items()]
    known = (*keys, "repeat") if issubclass(model, ShapeKeys) else tuple(keys)
    return known, tuple(key for key in known if key not in owner)


def _report_missing_key(path: Path, data: Any, place: Origin, sink: Sink) -> None:
    if path[-1] == "color" and not BRIGHTNESS.isdisjoint(value_at(data, path[:-1])):
        return  # the hint of that unknown key says which colour to write
    parent = type(place)(place.file, place.path[:-1], place.copy, place.parent)
    hint = "a scene file starts with `scenecc: 1`" if path == ("scenecc",) else MISSING_KEY_HINTS.get(str(path[-1]))
    sink.report("SC102", f"{value_name(path[:-1])} lacks the key `{path[-1]}`", parent, at="key", hint=hint)


def report_wrong_length(path: Path, must: int, found: Sequence[Any], place: Origin, sink: Sink) -> None:
    """Reports a list that must have `must` values."""
    hint = length_hint(path, found)
    if len(found) == 1 and isinstance(found[0], str):
        hint = kind_hint("a number", path, found[0])
    sink.report("SC106", f"{value_name(path)} must have {must} values, not {len(found)}", place, hint=hint)


def _report_length(error: ErrorDetails, path: Path, place: Origin, sink: Sink) -> None:
    context = error.get("ctx", {})
    if error["type"] == "too_long" and context.get("field_type") == "Tuple":
        report_wrong_length(path, context["max_length"], error["input"], place, sink)
        return
    bound = context.get("max_length", context.get("min_length"))
    words = "at most" if "max_length" in context else "at least"
    count = context.get("actual_length")
    values = "value" if bound == 1 else "values"
    hint = length_hint(path, error["input"])
    sink.report("SC106", f"{value_name(path)} must have {words} {bound} {values}, not {count}", place, hint=hint)


def _report_choice(error: ErrorDetails, path: Path, place: Origin, data: Any, sink: Sink) -> None:
    found, context = error["input"], error.get("ctx", {})
    if error["type"] == "literal_error":
        choices = _split_words(context["expected"].replace(" or ", ", "))
        if not isinstance(found, str):
            _report_wrong_kind("one of " + ", ".join(choices), path, found, place, sink)
        elif not _report_unsupported(found, place, sink):
            hint = choice_hint(found, choices, path) or listed(choices, found, LISTS_KEYS)
            sink.report("SC105", f"{value_name(path)} cannot be {show(found)}", place, hint=hint)
        return
    tag: Any = found.get("type") if is_mapping(found) else None
    if not is_mapping(found):
        _report_wrong_kind("a mapping", path, found, place, sink)
    elif "type" not in found:
        union = place_at(path, partial(value_at, data)).choice
        choices = union.types() if isinstance(union, LazyUnion) else ()
        hint = shape_hint(found, choices)
        message = f"{value_name(path)} lacks the key `type`"
        sink.report("SC102", message, place, hint=hint or listed(choices, "", LISTS_KEYS))
    elif is_varying(tag):
        reads = "" if is_mapping(tag) else f": it reads {quote_names(tag)}"
        message = f"`type` cannot differ from scene to scene{reads}"
        sink.report("SC116", message, place.child("type"), hint=VARIANTS_HINT)
    elif not isinstance(tag, str):
        _report_wrong_kind("a text", (*path, "type"), tag, place.child("type"), sink)
    elif not _report_unsupported(tag, place.child("type"), sink):
        choices = _split_words(context["expected_tags"])
        hint = SHAPE_LIST_HINTS.get(tag) or choice_hint(tag, choices) or listed(choices, tag, LISTS_KEYS)
        kind = _TYPED_SECTIONS.get(str(path[0]), "shape")
        sink.report("SC105", f"there is no {kind} type {show(tag)} here", place.child("type"), hint=hint)


def _split_words(text: str) -> list[str]:
    return [word.strip("'") for word in text.split(", ")]


def _report_pattern(error: ErrorDetails, place: Origin, sink: Sink) -> None:
    found = error["input"]
    if error["ctx"]["pattern"].startswith("^#"):  # pyright: ignore[reportTypedDictNotRequiredAccess]
        hint = keyboard_hint(found) or color_hint(place.path, found)
        sink.report("SC108", f"{show(found)} is not a colour", place, hint=hint)
        return
    at: At = "key" if KEY in error["loc"] else "value"
    sink.report(
        "SC107",
        f"{show(found)} is not a name",
        place,
        at=at,
        hint=name_hint(found) + PATTERN_HINTS.get(error["ctx"]["pattern"], PATTERN_HINTS[NAME_PATTERN]),  # pyright: ignore[reportTypedDictNotRequiredAccess]
    )


def _report_wrong_kind(expected: str, path: Path, found: Any, place: Origin, sink: Sink) -> None:
    message = f"{value_name(path)} must be {expected}, not {describe_value(found)}"
    sink.report("SC103", message, place, hint=kind_hint(expected, path, found))


def describe_value(found: Any) -> str:
    """Returns a value with its kind, for a message."""
    if isinstance(found, str):
        return f"the string {show(found)}"
    if isinstance(found, int | float) and not isinstance(found, bool):
        return f"the number {show(found)}"
    if is_sequence(found):
        return f"a list of {len(found)}"
    return "a mapping" if is_mapping(found) else show(found)


def value_name(path: Path) -> str:
    """Returns the name of the value at a path for a message: its key, or the item of a list."""
    if not path:
        return "the document"
    last = path[-1]
    if isinstance(last, str):
        return f"`{cut(last)}`"
    owner = next((key for key in reversed(path) if isinstance(key, str)), "")
    return f"item {last} of `{owner}`"


LocatedErrors = list[tuple["ErrorDetails", "Path"]]


def report_errors(errors: Iterable[ErrorDetails], data: dict[str, Any], origin: Origin, sink: Sink) -> None:
    """Reports Pydantic's errors at their places in the document. `origin` is that of the document's root."""
    located: LocatedErrors = []
    for error in errors:
        path = document_path(error["loc"], data)
        if path is not None and error["type"] != NOT_MEANT:
            located.append((error, path))
    misspelt = _find_misspelt_keys(located, data)
    short = _find_short_lists(located)
    formed = _find_misplaced_forms(located, data)
    dedented: dict[Path, str | None] = {}
    for error, path in located:
        if sink.full:
            return
        if error["type"] == "missing" and path in misspelt:
            # Reported as an unknown key, with the missing one as its hint.
            continue
        name = path[:2]
        if len(name) == len((*_NAME_MAPPING_PATHS[1], "")) and name[:1] in _NAME_MAPPING_PATHS:
            if name not in dedented and (above := dedented.setdefault(name, _mapping_above(name, data))):
                _report_dedented(name, above, origin.child(*name), sink)
            if dedented[name]:
                continue
        owner = path[:-1] if error["type"] in {"extra_forbidden", "missing"} else path
        if owner in formed:
            if formed[owner] is not None:
                _report_misplaced_form(owner, str(formed[owner]), origin.child(*owner, str(formed[owner])), sink)
                formed[owner] = None
            continue
        if error["type"] == "missing" and path[:-1] in short:
            report_wrong_length(path[:-1], short[path[:-1]], error["input"], origin.child(*path[:-1]), sink)
            continue
        _report_error(error, path, origin.child(*path), data, sink)


def _find_misplaced_forms(located: LocatedErrors, data: dict[str, Any]) -> dict[Path, str | None]:
    """Returns the paths of mappings that are forms where forms are not allowed → the form."""
    formed: dict[Path, str | None] = {}
    for error, path in located:
        kind = error["type"]
        if kind in {CUSTOM_ERROR, WRONG_KIND, "missing"} or KEY in error["loc"]:
            continue
        if kind == "extra_forbidden":
            owner, form = path[:-1], str(path[-1])
        else:
            node = value_at(data, path)
            # `normal` is also a key of shapes, so it does not make a shape without a type a form.
            forms = FORM_KEYS - {"normal"} if kind == "union_tag_not_found" else FORM_KEYS
            owner, form = path, next((key for key in node if key in forms), "") if is_mapping(node) else ""
        if form in FORM_KEYS and owner not in _NAME_MAPPING_PATHS:
            formed.setdefault(owner, form)
    return formed


_NAME_MAPPING_PATHS: tuple[Path, ...] = ((), *((name,) for name in NAME_SECTIONS))
"""The document and its mappings of names, where an entry may have the name of a form."""


def _report_misplaced_form(path: Path, form: str, place: Origin, sink: Sink) -> None:
    whole = {"shapes", "collisions", "visuals"} & set(path[-2:])
    hint = PHYSICS_HINT if path[0] == "physics" else VARIANTS_HINT if whole else PARTS_HINT
    message = f"{value_name(path)} cannot differ from scene to scene as a whole: `{form}`"
    sink.report("SC116", message, place, at="key", hint=hint)


def _find_short_lists(located: LocatedErrors) -> dict[Path, int]:
    """Returns the lists that are too short → their required length. Pydantic reports each missing item."""
    lengths: dict[Path, int] = {}
    for error, path in located:
        if error["type"] == "missing" and path and isinstance(path[-1], int):
            lengths[path[:-1]] = max(lengths.get(path[:-1], 0), path[-1] + 1)
    return lengths


def _find_misspelt_keys(located: LocatedErrors, data: dict[str, Any]) -> set[Path]:
    """Returns the paths of missing keys that an unknown key beside them probably means."""
    missing: dict[Path, tuple[str, ...]] = {}
    for error, path in located:
        if error["type"] == "missing":
            missing[path[:-1]] = (*missing.get(path[:-1], ()), str(path[-1]))
    misspelt: set[Path] = set()
    for error, path in located:
        # Fuzzy matching is slow, so compare with the few missing keys before all known keys.
        if error["type"] == "extra_forbidden" and suggest_key(str(path[-1]), missing.get(path[:-1], ())):
            near = suggest_key(str(path[-1]), *known_keys(path, data))
            misspelt.update([(*path[:-1], near)] if near else [])
            if near == "radius" and len(numbers(error["input"])) == 2:
                misspelt.add((*path[:-1], "half_length"))  # MuJoCo's `size` has both
    return misspelt
