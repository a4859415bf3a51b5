"""Validates a document: converts plain data to the models of the language.

A document with very many errors is validated again in a truncated copy, since Pydantic lists all errors or none.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from scenecc.diagnostics.diagnostic import MAX_REPORTS, Origin
from scenecc.spec.base import NOTE_PREFIX, SpecModel
from scenecc.spec.document import SceneFile
from scenecc.spec.nodes import EXPANDED, is_mapping, is_sequence
from scenecc.spec.values import READ_VALUES

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink

_MAX_UNCUT_ITEMS = 100
"""Containers of at most this many items are never truncated. No mapping of fixed keys has more."""


class TruncatedDocument:
    """A copy of the first nodes of a document.

    Attributes:
        data: the copy. Lists and mappings of names are truncated; known keys are always kept.
        whole: whether the copy is complete.
    """

    def __init__(self, data: dict[str, Any], nodes: int) -> None:
        self._left = nodes
        self._known = _model_keys(SpecModel)
        self.whole = True
        self.data: dict[str, Any] = self._copy(data)

    def _copy(self, node: Any) -> Any:
        self._left -= 1
        if is_mapping(node):
            return {key: self._copy(item) for key, item in node.items() if self._keep_item(node, key)}
        if is_sequence(node):
            return [self._copy(item) for item in node if self._keep_item(node, None)]
        return node

    def _keep_item(self, container: Any, key: str | None) -> bool:
        if self._left > 0 or len(container) <= _MAX_UNCUT_ITEMS or key in self._known:
            return True
        self.whole = False
        return False


def _model_keys(model: type[SpecModel]) -> set[str]:
    keys = {field.alias or name for name, field in model.model_fields.items()}
    for special in model.__subclasses__():
        keys |= _model_keys(special)
    return keys


MAX_PYDANTIC_ERRORS = 6 * MAX_REPORTS
"""Number of Pydantic errors that holds enough distinct mistakes, since each branch of a union adds an error."""


def parse(data: dict[str, Any], origin: Origin, sink: Sink, *, expanded: bool = False) -> SceneFile | None:
    """Converts a document to models. Returns None if a mistake was reported.

    Args:
        data: plain data from the reader or from expansion; not changed.
        origin: origin of the document's root.
        sink: receives diagnostics.
        expanded: whether the document is expanded. `${` in a string is then literal, and expressions are `Template`s.
    """
    token, seen = EXPANDED.set(expanded), READ_VALUES.set({} if expanded else None)
    try:
        return _validate(data, origin, sink)
    finally:
        EXPANDED.reset(token)
        READ_VALUES.reset(seen)


def _validate(data: dict[str, Any], origin: Origin, sink: Sink) -> SceneFile | None:
    try:
        return SceneFile.model_validate(data)
    except ValidationError as problem:
        many = problem.error_count() > MAX_PYDANTIC_ERRORS
        errors = [] if many else problem.errors(include_url=False)
    if many:
        clean = strip_notes(data)
        return None if _report_first_errors(clean, origin, sink) else SceneFile.model_validate(clean)
    if any(_is_note(segment) for error in errors for segment in error["loc"]):
        # Notes are removed only if they cause errors.
        return _validate(strip_notes(data), origin, sink)
    from scenecc.spec.validation_errors import report_errors

    report_errors(errors, data, origin, sink)
    return None


def _report_first_errors(data: dict[str, Any], origin: Origin, sink: Sink) -> bool:
    """Reports the first of very many errors. Returns whether there are any.

    Pydantic lists all errors or none, and needs a kilobyte for each.
    """
    from scenecc.spec.validation_errors import report_errors

    nodes = 4 * MAX_REPORTS
    while True:
        start = TruncatedDocument(data, nodes)
        try:
            SceneFile.model_validate(start.data)
        except ValidationError as problem:
            if start.whole or problem.error_count() >= MAX_PYDANTIC_ERRORS:
                report_errors(problem.errors(include_url=False), start.data, origin, sink)
                if not start.whole:
                    hint = "fix these first; the rest of the file was not checked"
                    sink.report("SC016", f"checking stopped after {MAX_REPORTS} errors", origin, hint=hint)
                return True
        else:
            if start.whole:
                return False
        nodes *= 2


def _is_note(segment: object) -> bool:
    return isinstance(segment, str) and segment.startswith(NOTE_PREFIX)


def strip_notes(node: Any) -> Any:
    """Returns a copy without the keys that start with `x-`, at any depth."""
    if is_mapping(node):
        return {key: strip_notes(item) for key, item in node.items() if not key.startswith(NOTE_PREFIX)}
    return [strip_notes(item) for item in node] if is_sequence(node) else node
