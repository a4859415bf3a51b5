"""Plain data to the models of the language."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from scenecc.diagnostics.diagnostic import MAX_REPORTS
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.document import SceneFile
from scenecc.spec.leaf import SEEN
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.spec.unions import EXPANDED

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink

_NAMED = (
    "entities", "materials", "frames", "collision_groups", "params", "draws", "constraints", "lights", "cameras",
)  # fmt: skip
"""Mappings whose keys are names, so that a note among them would read as an entry."""

MOST_ERRORS = 6 * MAX_REPORTS
"""Errors of pydantic's among which there are as many mistakes as are told: each branch of a union has its own."""


def parse(data: dict[str, Any], origin: Origin, sink: Sink, *, expanded: bool = False) -> SceneFile | None:
    """The document as models; every mistake in its shape is reported.

    Args:
        data: plain data as the reader gives it, or as expansion does; not changed.
        origin: of the document's root.
        sink: takes the diagnostics.
        expanded: it is an expanded document: `${` in a text is literal, and a `Template` is what is left of one.
    """
    token, seen = EXPANDED.set(expanded), SEEN.set({} if expanded else None)
    try:
        return _parsed(data, origin, sink)
    finally:
        EXPANDED.reset(token)
        SEEN.reset(seen)


def _parsed(data: dict[str, Any], origin: Origin, sink: Sink) -> SceneFile | None:
    if any(key.startswith(NOTE_PREFIX) for name in _NAMED for key in _keys(data.get(name))):
        data = without_notes(data)
    try:
        return SceneFile.model_validate(data)
    except ValidationError as problem:
        many = problem.error_count() > MOST_ERRORS
        errors = [] if many else problem.errors(include_url=False)
    if many:
        clean = without_notes(data)
        return None if _report_first(clean, origin, sink) else SceneFile.model_validate(clean)
    if any(_is_note(segment) for error in errors for segment in error["loc"]):
        # Only a file that holds notes pays for their removal.
        return _parsed(without_notes(data), origin, sink)
    from scenecc.spec.errors import report_errors

    report_errors(errors, data, origin, sink)
    return None


def _report_first(data: dict[str, Any], origin: Origin, sink: Sink) -> bool:
    """Reports the first of very many errors, if there are any without the notes.

    Pydantic lists all or none, and takes a kilobyte for each.
    """
    from scenecc.spec.errors import report_errors
    from scenecc.spec.start import Start

    nodes = 4 * MAX_REPORTS
    while True:
        start = Start(data, nodes)
        try:
            SceneFile.model_validate(start.data)
        except ValidationError as problem:
            if start.whole or problem.error_count() >= MOST_ERRORS:
                report_errors(problem.errors(include_url=False), start.data, origin, sink)
                if not start.whole:
                    hint = "mend these first; the rest of the file was not looked at"
                    sink.report("SC016", f"checking stopped after {MAX_REPORTS} errors", origin, hint=hint)
                return True
        else:
            if start.whole:
                return False
        nodes *= 2


def _keys(node: Any) -> list[str]:
    return list(node) if is_mapping(node) else []


def _is_note(segment: object) -> bool:
    return isinstance(segment, str) and segment.startswith(NOTE_PREFIX)


def without_notes(node: Any) -> Any:
    """A copy without the keys that start with `x-`, at any depth."""
    if is_mapping(node):
        return {key: without_notes(item) for key, item in node.items() if not key.startswith(NOTE_PREFIX)}
    return [without_notes(item) for item in node] if is_sequence(node) else node
