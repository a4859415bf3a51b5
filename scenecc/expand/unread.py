"""Parameters and shared draws that nothing reads."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Origin
from scenecc.diagnostics.messages import cut
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.plain import EXPRESSION, is_mapping, is_sequence

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.source import Document

_WHAT = {"params": ("SC322", "parameter"), "draws": ("SC319", "draw")}
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def report_unread(documents: Sequence[Document], lowered: Collection[str], sink: Sink) -> None:
    """A warning for each parameter and each shared draw that no expression reads.

    Args:
        documents: the top one and those that it includes, which share its parameters.
        lowered: the draws that are still there once expanded, of which it is told when they are lowered.
        sink: takes the warnings.
    """
    declared = [
        (section, name, document.name)
        for document in documents
        for section in _WHAT
        if is_mapping(entries := document.data.get(section))
        for name in entries
        if not name.startswith(NOTE_PREFIX) and (section != "draws" or name not in lowered)
    ]
    if not declared:
        return
    read: set[str] = set()
    for document in documents:
        for text in _texts(document.data):
            # Every word of it: what is read is among them, and no expression need be taken apart again.
            read.update(_WORD.findall(text))
    for section, name, file in declared:
        if name not in read:
            code, what = _WHAT[section]
            sink.report(code, f"the {what} `{cut(name)}` is never read", Origin(file, (section, name)), at="key")


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
