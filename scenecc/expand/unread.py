"""Parameters that nothing reads."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Origin
from scenecc.diagnostics.words import cut
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.plain import EXPRESSION, is_mapping, is_sequence

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.source import Document

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def report_unread(documents: Sequence[Document], sink: Sink) -> None:
    """A warning for each parameter that no expression reads.

    Args:
        documents: the top one and those that it includes, which share its parameters.
        sink: takes the warnings.
    """
    declared = [
        (name, document.name)
        for document in documents
        if is_mapping(params := document.data.get("params"))
        for name in params
        if not name.startswith(NOTE_PREFIX)
    ]
    if not declared:
        return
    read: set[str] = set()
    for document in documents:
        for text in _texts(document.data):
            # Every word of it: what is read is among them, and no expression need be taken apart again.
            read.update(_WORD.findall(text))
    for name, file in declared:
        if name not in read:
            message = f"the parameter `{cut(name)}` is never read"
            sink.report("SC322", message, Origin(file, ("params", name)), at="key")


def _texts(node: Any) -> Iterator[str]:
    """The texts with an expression."""
    todo = [node]
    while todo:
        item = todo.pop()
        if isinstance(item, str):
            if EXPRESSION in item:
                yield item
        elif is_mapping(item):
            todo += item.values()
        elif is_sequence(item):
            todo += item
