"""Pydantic's validation errors as diagnostics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.words import cut, nearest, show, suggest
from scenecc.spec.document import SceneFile
from scenecc.spec.features import LEFT_OUT, NOT_YET, OTHER_KIND, VARIATION_FORMS
from scenecc.spec.hints import LENGTH_HINTS, LISTED_ELSEWHERE, MISPLACED, RENAMED
from scenecc.spec.mistakes import THIS, TOLD
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.spec.scalars import LARGEST, SMALLEST
from scenecc.spec.unions import NOT_MEANT, WRONG_KIND
from scenecc.spec.walk import KEY_MARK, document_path, follow, model_at, step

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pydantic_core import ErrorDetails

    from scenecc.diagnostics import At, Origin, Path, Sink

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


Located = list[tuple["ErrorDetails", "Path"]]


def report_errors(
    errors: Iterable[ErrorDetails], data: dict[str, Any], origin: Origin, sink: Sink, *, expanded: bool = False
) -> None:
    """Reports each mistake at its place in the document.

    Args:
        errors: pydantic's.
        data: the document.
        origin: of its root.
        sink: takes the diagnostics.
        expanded: it is an expanded one.
    """
    judged_otherwise: set[Path] = set()
    located: Located = []
    for error in errors:
        path = document_path(error["loc"], data, expanded=expanded)
        if path is not None and error["type"] != NOT_MEANT:
            located.append((error, path))
    misspelt = _misspelt(located)
    short = _short(located)
    formed = _formed(located, data)
    for error, path in located:
        entity = path[:2]
        if len(path) > 1 and path[0] == "entities" and (key := _other_kind(step(data["entities"], path[1]))):
            if entity not in judged_otherwise:
                judged_otherwise.add(entity)
                _not_yet(NOT_YET[key], origin.child(*entity, key), sink)
            continue
        if error["type"] == "missing" and path in misspelt:
            # The unknown key beside it is told, with this one as its hint.
            continue
        if path[-1:] == ("name",) and "repeat" in (follow(data, path[:-1]) or ()):
            # The name of the copies: `repeat` itself is reported.
            continue
        owner = path[:-1] if error["type"] in {"extra_forbidden", "missing"} else path
        if owner in formed:
            if formed[owner] is not None:
                _no_place(owner, str(formed[owner]), origin.child(*owner), sink)
                formed[owner] = None
            continue
        if error["type"] == "missing" and path[:-1] in short:
            _wrong_length(path[:-1], short[path[:-1]], len(error["input"]), origin.child(*path[:-1]), sink)
            continue
        _report(error, path, origin.child(*path), sink)


def _formed(located: Located, data: dict[str, Any]) -> dict[Path, str | None]:
    """The mappings that are forms where none may stand, and their keys."""
    formed: dict[Path, str | None] = {}
    for error, path in located:
        if error["type"] in {TOLD, WRONG_KIND} or KEY_MARK in error["loc"]:
            continue
        owner = path[:-1] if error["type"] in {"extra_forbidden", "missing"} else path
        node = follow(data, owner)
        if owner not in _NAMED and is_mapping(node):
            form = next((key for key in node if key in VARIATION_FORMS), None)
            if form is not None:
                formed[owner] = form
    return formed


_NAMED = {("entities",), ("materials",), ("frames",), ("collision_groups",), ()}
"""Mappings of names, and the document itself: what is in them may be called like a form."""

_ALTERNATIVES = "what differs in structure from scene to scene is written as `variants` of the entity"


def _no_place(path: Path, form: str, place: Origin, sink: Sink) -> None:
    named = _named(path)
    whole = {"shapes", "collisions", "visuals"} & set(path[-2:])
    hint = _ALTERNATIVES if whole else "what may differ are the numbers, files, colours and materials in it, each alone"
    sink.report("SC116", f"{named} cannot differ from scene to scene as a whole: `{form}`", place, hint=hint)


def _short(located: Located) -> dict[Path, int]:
    """The lists that are too short, and how many values they must have: each missing one is an error of its own."""
    lengths: dict[Path, int] = {}
    for error, path in located:
        if error["type"] == "missing" and path and isinstance(path[-1], int):
            lengths[path[:-1]] = max(lengths.get(path[:-1], 0), path[-1] + 1)
    return lengths


def _wrong_length(path: Path, must: int, count: int, place: Origin, sink: Sink) -> None:
    hint = LENGTH_HINTS.get((str(path[-1]), count)) if path else None
    sink.report("SC106", f"{_named(path)} must have {must} values, not {count}", place, hint=hint)


def _misspelt(located: Located) -> set[Path]:
    """The paths of keys that unknown ones beside them were probably meant to be."""
    meant: set[Path] = set()
    for error, path in located:
        if error["type"] == "extra_forbidden" and (near := _meant(str(path[-1]), _known(error))):
            meant.add((*path[:-1], near))
    return meant


def _other_kind(entity: Any) -> str | None:
    return next((key for key in OTHER_KIND if key in entity), None) if is_mapping(entity) else None


def _report(error: ErrorDetails, path: Path, place: Origin, sink: Sink) -> None:
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
        sink.report("SC104", f"{_named(path)} must be finite, not {show(found)}", place)
    elif kind == "string_too_short":
        sink.report("SC104", f"{_named(path)} must not be empty", place)
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
    message = context["message"].replace(THIS, _named(path))
    sink.report(context["code"], message, place, at=context["at"], hint=context["hint"], span=context["span"])


def _bound(error: ErrorDetails, path: Path, place: Origin, sink: Sink) -> None:
    found, (words, bound) = error["input"], _BOUNDS[error["type"]]
    limit = error["ctx"][bound]  # pyright: ignore[reportTypedDictNotRequiredAccess]
    hint = None
    if limit == SMALLEST and found <= 0:
        words, limit = "greater than", 0
    elif abs(limit) in {SMALLEST, LARGEST}:
        hint = "the engine computes in single precision, which ends there"
    sink.report(
        "SC104",
        f"{_named(path)} must be {words} {limit if isinstance(limit, int) else f'{limit:g}'}, not {show(found)}",
        place,
        hint=hint,
    )


def _not_yet(feature: str, place: Origin, sink: Sink) -> None:
    sink.report("SC109", f"{feature} are not supported yet", place, at="key")


def _unknown_key(error: ErrorDetails, key: str, place: Origin, sink: Sink) -> None:
    if key in LEFT_OUT:
        sink.report("SC110", f"version 1 of the language leaves out {LEFT_OUT[key]}", place, at="key")
        return
    if key in NOT_YET:
        _not_yet(NOT_YET[key], place, sink)
        return
    known = _known(error)
    hint = next((hint for beside, hint in MISPLACED.get(key, ()) if beside in known), None)
    if hint is None:
        meant = _meant(key, known)
        hint = f"did you mean `{meant}`?" if meant else suggest(key, known)
    sink.report("SC101", f"unknown key `{cut(key)}`", place, at="key", hint=hint)


def _meant(key: str, known: tuple[str, ...]) -> str | None:
    """The known key that an unknown one was probably meant to be."""
    renamed = RENAMED.get(key)
    return renamed if renamed in known else nearest(key, known)


def _known(error: ErrorDetails) -> tuple[str, ...]:
    """The keys that the mapping of an unknown one may have."""
    model = model_at(SceneFile, error["loc"])
    return tuple(model.model_fields) if model else ()


def _missing(path: Path, place: Origin, sink: Sink) -> None:
    parent = type(place)(place.file, place.path[:-1], place.copy, place.parent)
    hint = "a scene file starts with `scenecc: 1`" if path == ("scenecc",) else None
    sink.report("SC102", f"{_named(path[:-1])} lacks the key `{path[-1]}`", parent, at="key", hint=hint)


def _length(error: ErrorDetails, path: Path, place: Origin, sink: Sink) -> None:
    context = error.get("ctx", {})
    if error["type"] == "too_long" and context.get("field_type") == "Tuple":
        _wrong_length(path, context["max_length"], len(error["input"]), place, sink)
        return
    bound = context.get("max_length", context.get("min_length"))
    words = "at most" if "max_length" in context else "at least"
    count = context.get("actual_length")
    sink.report("SC106", f"{_named(path)} must have {words} {bound} values, not {count}", place)


def _choice(error: ErrorDetails, path: Path, place: Origin, sink: Sink) -> None:
    found, context = error["input"], error.get("ctx", {})
    if error["type"] == "literal_error":
        choices = [word.strip("'") for word in context["expected"].replace(" or ", ", ").split(", ")]
        if not isinstance(found, str):
            _wrong_kind("one of " + ", ".join(choices), path, found, place, sink)
            return
        sink.report("SC105", f"{_named(path)} cannot be {show(found)}", place, hint=suggest(found, choices))
        return
    tag = found.get("type") if is_mapping(found) else None
    if not is_mapping(found):
        _wrong_kind("a mapping", path, found, place, sink)
    elif "type" not in found:
        sink.report("SC102", f"{_named(path)} lacks the key `type`", place)
    elif not isinstance(tag, str):
        _wrong_kind("a text", (*path, "type"), tag, place.child("type"), sink)
    else:
        choices = [word.strip("'") for word in context["expected_tags"].split(", ")]
        hint = LISTED_ELSEWHERE.get(tag) or suggest(tag, choices)
        sink.report("SC105", f"there is no shape type {show(tag)} here", place.child("type"), hint=hint)


def _pattern(error: ErrorDetails, place: Origin, sink: Sink) -> None:
    found = error["input"]
    if error["ctx"]["pattern"].startswith("^#"):  # pyright: ignore[reportTypedDictNotRequiredAccess]
        sink.report(
            "SC108", f"{show(found)} is not a colour", place, hint='three or four numbers in 0..1, or "#rrggbb[aa]"'
        )
        return
    at: At = "key" if KEY_MARK in error["loc"] else "value"
    sink.report(
        "SC107",
        f"{show(found)} is not a name",
        place,
        at=at,
        hint="a name starts with a letter or `_` and goes on with letters, digits, `_`, `.` and `-`",
    )


def _wrong_kind(expected: str, path: Path, found: Any, place: Origin, sink: Sink) -> None:
    hint = None
    if expected in {"a number", "a whole number"} and isinstance(found, str) and _reads_as_number(found):
        hint = "take the quotes off"
    elif expected == "true or false" and isinstance(found, str):
        hint = "YAML 1.2 has only `true` and `false`, without quotes"
    elif is_mapping(found) and (form := next((near for key in found if (near := nearest(key, VARIATION_FORMS))), None)):
        hint = f"did you mean `{form}`?"
    sink.report("SC103", f"{_named(path)} must be {expected}, not {describe(found)}", place, hint=hint)


def _reads_as_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    # Python reads 1_000, YAML does not.
    return "_" not in text


def describe(found: Any) -> str:
    """A value with its kind, as a message names it."""
    if isinstance(found, str):
        return f"the text {show(found)}"
    if isinstance(found, int | float) and not isinstance(found, bool):
        return f"the number {show(found)}"
    if is_sequence(found):
        return f"a list of {len(found)}"
    return "a mapping" if is_mapping(found) else show(found)


def _named(path: Path) -> str:
    """What a message calls the value at a path: its key, or the item of a list."""
    if not path:
        return "the document"
    last = path[-1]
    if isinstance(last, str):
        return f"`{cut(last)}`"
    owner = next((key for key in reversed(path) if isinstance(key, str)), "")
    return f"item {last} of `{owner}`"
