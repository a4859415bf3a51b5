"""How much a text holds, before a model is made of each thing in it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics import Origin
from scenecc.expand.contents import weight
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.plain import is_mapping

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.source import Document, Limits

_LEAST = 10
"""How long the text of an object is at least [characters]."""


def holds_no_more(document: Document, limits: Limits, sink: Sink) -> bool:
    """Whether a text holds no more objects than there may be; otherwise that is reported."""
    if len(document.text or "") < _LEAST * limits.objects:
        return True
    sections = (node for key, node in document.data.items() if not key.startswith(NOTE_PREFIX))
    count = sum(sum(map(weight, node.values())) if is_mapping(node) else weight(node) for node in sections)
    if count <= limits.objects:
        return True
    message = f"{count} objects, or as much as these hold, are more than the limit of {limits.objects}"
    hint = "raise it with --limit objects=N or limits={'objects': N}"
    sink.report("SC604", message, Origin(document.name), hint=hint)
    return False
