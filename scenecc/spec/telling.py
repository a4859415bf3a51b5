"""One validation error of pydantic as a diagnostic."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, listed, nearest, show, suggest
from scenecc.spec.base import NAME_PATTERN, SPELLINGS
from scenecc.spec.body import Body
from scenecc.spec.copies import Copies
from scenecc.spec.document import SceneFile
from scenecc.spec.expressions import read_names
from scenecc.spec.features import LEFT_OUT
from scenecc.spec.hints import (
    ALTERNATIVES,
    ANGLES,
    EACH_ITS_OWN,
    LACKING,
    LENGTH_HINTS,
    LISTED_ELSEWHERE,
    MISPLACED,
    OF_A_WHOLE_ROBOT,
    RENAMED,
    SETTINGS,
)
from scenecc.spec.kind_hints import kind_hint
from scenecc.spec.mistakes import THIS, TOLD
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.spec.scalars import LARGEST, SMALLEST
from scenecc.spec.shape_keys import ShapeKeys
from scenecc.spec.unions import KEY, WRONG_KIND, is_varying
from scenecc.spec.walk import model_at

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

    from scenecc.diagnostics import At, Origin, Path, Sink

_OF_ENTITY = 3
"""How long the path of an entity's own key is."""

_KINDS: dict[str, str] = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "string_type": "a text",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "model_attributes_type": "a mapping",
}
"""Pydantic's type errors and what was expected."""

_BOUNDS: dict[str, tuple[str, str]] = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
}


_TYPED = {"lights": "light", "constraints": "constraint"}
"""Sections whose entries are told apart by `type`, and what these are; elsewhere they are shapes."""


def tell(error: ErrorDetails, path: Path, place: Origin, sink: Sink) -> None:
    """Reports an error.

    Args:
        error: pydantic's.
        path: of the value in the document.
        place: the same, as an origin.
        sink: takes the diagnostic.
    """
    kind, found = error["type"], error["input"]
    if kind == TOLD:
        _told(error, path, place, sink)
    elif path == ("scenecc",) and kind != "missing":
        sink.report("SC100", f"this is scenecc 1; it does not read version {show(found)}", place)
    elif kind == "extra_forbidden":
        _unknown_key(error, str(path[-1]), place, sink)
    elif kind == "missing":
        _missing(path, place, sink)
    elif kind in _BOUNDS:
        _bound(error, path, place, sink)
    elif kind == "finite_number":
        sink.report("SC104", f"{named(path)} must be finite, not {show(found)}", place)
    elif kind == "string_too_short":
        sink.report("SC104", f"{named(path)} must not be empty", place)
    elif kind in {"too_long", "too_short"}:
        _length(error, path, place, sink)
    elif kind in {"literal_error", "union_tag_invalid", "union_tag_not_found"}:
        _choice(error, path, place, sink)
    elif kind == "string_pattern_mismatch":
        _pattern(error, place, sink)
    else:
        expected = error["msg"] if kind == WRONG_KIND else _KINDS.get(kind, error["msg"])
        _wrong_kind(expected, path, found, place, sink)


def _told(error: ErrorDetails, path: Path, place: Origin, sink: Sink) -> None:
    context = error.get("ctx", {})
    message, hint = context["message"].replace(THIS, named(path)), context["hint"]
    if context["code"] == "SC116" and hint is None:
        hint = _same_in_all(path)
    sink.report(context["code"], message, place, at=context["at"], hint=hint, span=context["span"])


def _same_in_all(path: Path) -> str | None:
    """What to do of what cannot differ from scene to scene."""
    if path[0] == "physics":
        return SETTINGS
    if path[0] == "entities" and len(path) == _OF_ENTITY and path[-1] in OF_A_WHOLE_ROBOT:
        return EACH_ITS_OWN
    return ALTERNATIVES if path[-1] in {"type", "body_type"} else None


def _bound(error: ErrorDetails, path: Path, place: Origin, sink: Sink) -> None:
    found, (words, bound) = error["input"], _BOUNDS[error["type"]]
    limit = error["ctx"][bound]  # pyright: ignore[reportTypedDictNotRequiredAccess]
    hint = None
    if limit == SMALLEST and found <= 0:
        words, limit = "greater than", 0
    elif abs(limit) in {SMALLEST, LARGEST}:
        hint = "the engine computes in single precision, which ends there"
    elif path and path[-1] in ANGLES and found > limit:
        hint = f"angles are radians; `{path[-1]}_deg` takes degrees"
    sink.report(
        "SC104",
        f"{named(path)} must be {words} {limit if isinstance(limit, int) else f'{limit:g}'}, not {show(found)}",
        place,
        hint=hint,
    )


def _unknown_key(error: ErrorDetails, key: str, place: Origin, sink: Sink) -> None:
    if key in LEFT_OUT:
        sink.report("SC110", f"version 1 of the language leaves out {LEFT_OUT[key]}", place, at="key")
        return
    known = known_keys(error)
    hint = next((hint for beside, hint in MISPLACED.get(key, ()) if beside in known), None)
    if hint is None:
        near = meant(key, known)
        hint = f"did you mean `{near}`?" if near else listed(known)
    sink.report("SC101", f"unknown key `{cut(key)}`", place, at="key", hint=hint)


def meant(key: str, known: tuple[str, ...]) -> str | None:
    """The known key that an unknown one was probably meant to be."""
    renamed = RENAMED.get(key)
    return renamed if renamed in known else nearest(key, known)


def known_keys(error: ErrorDetails) -> tuple[str, ...]:
    """The keys that the mapping of an unknown one may have."""
    model = model_at(SceneFile, error["loc"])
    if model is None:
        return ()
    # A plain body becomes another model by the keys of copies.
    models = (model, Copies) if model is Body else (model,)
    keys = [field.alias or name for known in models for name, field in known.model_fields.items()]
    return (*keys, "repeat") if issubclass(model, ShapeKeys) else tuple(keys)


def _missing(path: Path, place: Origin, sink: Sink) -> None:
    parent = type(place)(place.file, place.path[:-1], place.copy, place.parent)
    hint = "a scene file starts with `scenecc: 1`" if path == ("scenecc",) else LACKING.get(str(path[-1]))
    sink.report("SC102", f"{named(path[:-1])} lacks the key `{path[-1]}`", parent, at="key", hint=hint)


def wrong_length(path: Path, must: int, count: int, place: Origin, sink: Sink) -> None:
    """Reports a list of a wrong length.

    Args:
        path: of the list.
        must: how many values it must have.
        count: how many it has.
        place: the same path, as an origin.
        sink: takes the diagnostic.
    """
    hint = LENGTH_HINTS.get((str(path[-1]), count)) if path else None
    sink.report("SC106", f"{named(path)} must have {must} values, not {count}", place, hint=hint)


def _length(error: ErrorDetails, path: Path, place: Origin, sink: Sink) -> None:
    context = error.get("ctx", {})
    if error["type"] == "too_long" and context.get("field_type") == "Tuple":
        wrong_length(path, context["max_length"], len(error["input"]), place, sink)
        return
    bound = context.get("max_length", context.get("min_length"))
    words = "at most" if "max_length" in context else "at least"
    count = context.get("actual_length")
    values = "value" if bound == 1 else "values"
    sink.report("SC106", f"{named(path)} must have {words} {bound} {values}, not {count}", place)


def _choice(error: ErrorDetails, path: Path, place: Origin, sink: Sink) -> None:
    found, context = error["input"], error.get("ctx", {})
    if error["type"] == "literal_error":
        choices = [word.strip("'") for word in context["expected"].replace(" or ", ", ").split(", ")]
        if not isinstance(found, str):
            _wrong_kind("one of " + ", ".join(choices), path, found, place, sink)
            return
        sink.report("SC105", f"{named(path)} cannot be {show(found)}", place, hint=suggest(found, choices))
        return
    tag: Any = found.get("type") if is_mapping(found) else None
    if not is_mapping(found):
        _wrong_kind("a mapping", path, found, place, sink)
    elif "type" not in found:
        sink.report("SC102", f"{named(path)} lacks the key `type`", place)
    elif is_varying(tag):
        reads = "" if is_mapping(tag) else f": it reads {read_names(tag)}"
        message = f"`type` cannot differ from scene to scene{reads}"
        sink.report("SC116", message, place.child("type"), hint=ALTERNATIVES)
    elif not isinstance(tag, str):
        _wrong_kind("a text", (*path, "type"), tag, place.child("type"), sink)
    else:
        choices = [word.strip("'") for word in context["expected_tags"].split(", ")]
        hint = LISTED_ELSEWHERE.get(tag) or suggest(tag, choices)
        kind = _TYPED.get(str(path[0]), "shape")
        sink.report("SC105", f"there is no {kind} type {show(tag)} here", place.child("type"), hint=hint)


def _pattern(error: ErrorDetails, place: Origin, sink: Sink) -> None:
    found = error["input"]
    if error["ctx"]["pattern"].startswith("^#"):  # pyright: ignore[reportTypedDictNotRequiredAccess]
        sink.report(
            "SC108", f"{show(found)} is not a colour", place, hint='three or four numbers in 0..1, or "#rrggbb[aa]"'
        )
        return
    at: At = "key" if KEY in error["loc"] else "value"
    sink.report(
        "SC107",
        f"{show(found)} is not a name",
        place,
        at=at,
        hint=SPELLINGS.get(error["ctx"]["pattern"], SPELLINGS[NAME_PATTERN]),  # pyright: ignore[reportTypedDictNotRequiredAccess]
    )


def _wrong_kind(expected: str, path: Path, found: Any, place: Origin, sink: Sink) -> None:
    message = f"{named(path)} must be {expected}, not {describe(found)}"
    sink.report("SC103", message, place, hint=kind_hint(expected, path, found))


def describe(found: Any) -> str:
    """A value with its kind, as a message names it."""
    if isinstance(found, str):
        return f"the text {show(found)}"
    if isinstance(found, int | float) and not isinstance(found, bool):
        return f"the number {show(found)}"
    if is_sequence(found):
        return f"a list of {len(found)}"
    return "a mapping" if is_mapping(found) else show(found)


def named(path: Path) -> str:
    """What a message calls the value at a path: its key, or the item of a list."""
    if not path:
        return "the document"
    last = path[-1]
    if isinstance(last, str):
        return f"`{cut(last)}`"
    owner = next((key for key in reversed(path) if isinstance(key, str)), "")
    return f"item {last} of `{owner}`"
