"""How much a text holds, before a model is made of each thing in it."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Origin
from scenecc.expand.contents import CHARACTERS, FORM, PER_OBJECT, ROBOT, ROBOTS, weight
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.features import VARIATION_FORMS
from scenecc.spec.plain import is_mapping

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.source import Document, Limits

_LEAST = 10
"""How long the text of an object is at least [characters]."""


def holds_no_more(document: Document, limits: Limits, sink: Sink) -> bool:
    """Whether a text holds no more objects than there may be; otherwise that is reported."""
    text = document.text or ""
    if len(text) < _LEAST * limits.objects or _at_most(text, document.data) <= limits.objects:
        return True
    sections = (node for key, node in document.data.items() if not key.startswith(NOTE_PREFIX))
    count = sum(sum(map(weight, node.values())) if is_mapping(node) else weight(node) for node in sections)
    if count <= limits.objects:
        return True
    message = f"{count} objects, or as much as these hold, are more than the limit of {limits.objects}"
    hint = "raise it with --limit objects=N or limits={'objects': N}"
    sink.report("SC604", message, Origin(document.name), hint=hint)
    return False


def _at_most(text: str, data: dict[str, Any]) -> float:
    """No fewer objects than a text holds, found by its letters alone: walking its data takes a tenth of all checks."""
    if "\\" in text:  # a key may be written in escapes
        return inf
    values = sum(map(text.count, (",", "\n", "[", "{", "- ")))
    forms, robots, shapes = (sum(map(text.count, keys)) for keys in (VARIATION_FORMS, ROBOTS, ("type",)))
    named = sum(len(node) for node in data.values() if is_mapping(node))
    expressions = len(text) / CHARACTERS if "${" in text else 0
    return named + shapes + ROBOT * robots + (values + FORM * forms) / PER_OBJECT + expressions
