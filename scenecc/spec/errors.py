"""Pydantic's validation errors as diagnostics, one for each mistake."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.spec.hints import ALTERNATIVES, PARTS, SETTINGS
from scenecc.spec.mistakes import TOLD
from scenecc.spec.plain import is_mapping
from scenecc.spec.telling import known_keys, meant, named, tell, wrong_length
from scenecc.spec.unions import KEY, NOT_MEANT, WRONG_KIND
from scenecc.spec.walk import document_path, follow
from scenecc.variation.forms import FORM_KEYS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pydantic_core import ErrorDetails

    from scenecc.diagnostics import Origin, Path, Sink

Located = list[tuple["ErrorDetails", "Path"]]


def report_errors(errors: Iterable[ErrorDetails], data: dict[str, Any], origin: Origin, sink: Sink) -> None:
    """Reports each mistake at its place in the document.

    Args:
        errors: pydantic's.
        data: the document.
        origin: of its root.
        sink: takes the diagnostics.
    """
    located: Located = []
    for error in errors:
        path = document_path(error["loc"], data)
        if path is not None and error["type"] != NOT_MEANT:
            located.append((error, path))
    misspelt = _misspelt(located)
    short = _short(located)
    formed = _formed(located, data)
    for error, path in located:
        if sink.full:
            return
        if error["type"] == "missing" and path in misspelt:
            # The unknown key beside it is told, with this one as its hint.
            continue
        owner = path[:-1] if error["type"] in {"extra_forbidden", "missing"} else path
        if owner in formed:
            if formed[owner] is not None:
                _no_place(owner, str(formed[owner]), origin.child(*owner), sink)
                formed[owner] = None
            continue
        if error["type"] == "missing" and path[:-1] in short:
            wrong_length(path[:-1], short[path[:-1]], len(error["input"]), origin.child(*path[:-1]), sink)
            continue
        tell(error, path, origin.child(*path), sink)


def _formed(located: Located, data: dict[str, Any]) -> dict[Path, str | None]:
    """The mappings that are forms where none may stand, and their keys."""
    formed: dict[Path, str | None] = {}
    for error, path in located:
        kind = error["type"]
        if kind in {TOLD, WRONG_KIND, "missing"} or KEY in error["loc"]:
            continue
        if kind == "extra_forbidden":
            owner, form = path[:-1], str(path[-1])
        else:
            node = follow(data, path)
            # A shape without a type may have a normal.
            forms = FORM_KEYS - {"normal"} if kind == "union_tag_not_found" else FORM_KEYS
            owner, form = path, next((key for key in node if key in forms), "") if is_mapping(node) else ""
        if form in FORM_KEYS and owner not in _NAMED:
            formed.setdefault(owner, form)
    return formed


_NAMED: frozenset[Path] = frozenset(
    (
        (),
        *((name,) for name in ("entities", "materials", "frames", "collision_groups", "params", "draws")),
        *((name,) for name in ("constraints", "lights", "cameras")),
    )
)
"""Mappings of names, and the document itself: what is in them may be called like a form."""


def _no_place(path: Path, form: str, place: Origin, sink: Sink) -> None:
    whole = {"shapes", "collisions", "visuals"} & set(path[-2:])
    hint = SETTINGS if path[0] == "physics" else ALTERNATIVES if whole else PARTS
    sink.report("SC116", f"{named(path)} cannot differ from scene to scene as a whole: `{form}`", place, hint=hint)


def _short(located: Located) -> dict[Path, int]:
    """The lists that are too short, and how many values they must have: each missing one is an error of its own."""
    lengths: dict[Path, int] = {}
    for error, path in located:
        if error["type"] == "missing" and path and isinstance(path[-1], int):
            lengths[path[:-1]] = max(lengths.get(path[:-1], 0), path[-1] + 1)
    return lengths


def _misspelt(located: Located) -> set[Path]:
    """The paths of missing keys that unknown ones beside them were probably meant to be."""
    missing: dict[Path, tuple[str, ...]] = {}
    for error, path in located:
        if error["type"] == "missing":
            missing[path[:-1]] = (*missing.get(path[:-1], ()), str(path[-1]))
    misspelt: set[Path] = set()
    for error, path in located:
        # Comparing letters takes its time, and most unknown keys are like none of the few that are missing.
        if error["type"] == "extra_forbidden" and meant(str(path[-1]), missing.get(path[:-1], ())):
            near = meant(str(path[-1]), known_keys(error))
            misspelt.update([(*path[:-1], near)] if near else [])
    return misspelt
