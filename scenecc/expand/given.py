"""Which parameters of a use a mistake inside a prefab comes from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Origin
from scenecc.spec.plain import EXPRESSION, is_mapping, is_sequence
from scenecc.spec.walk import step
from scenecc.values.failure import ExpressionError
from scenecc.values.template import Template

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenecc.diagnostics import Path
    from scenecc.source import Document

_USE = ("use",)
_MOST = 200
"""Among so many scalars names are looked for: what is larger is no value of a field."""


def given_by(documents: Mapping[str | None, Document], origin: Origin) -> tuple[Origin, ...]:
    """Where the parameters are given that the node at fault reads; empty for what is in no prefab, or reads none.

    What is given there may read parameters in its turn: where these are given follows.

    Args:
        documents: by the name that origins have.
        origin: of the node, as written.
    """
    use = origin.parent
    if use is None or use.path[-1:] != _USE or origin.file not in documents or use.file not in documents:
        return ()
    instance = _at(documents[use.file].data, use.path[:-1])
    given = instance.get("with") if is_mapping(instance) else None
    if not is_mapping(given):
        return ()
    read: set[str] = set()
    for number, text in enumerate(_texts(_at(documents[origin.file].data, origin.path))):
        if number == _MOST:
            return ()
        read |= _names(text)
    place = (*use.path[:-1], "with")
    found = [Origin(use.file, (*place, name), use.copy, use.parent) for name in given if name in read]
    return (*found, *dict.fromkeys(outer for one in found for outer in given_by(documents, one)))


def _at(node: Any, path: Path) -> Any:
    """What stands at a path, or the scalar above it: an expression may give what has parts."""
    for segment in path:
        if not is_mapping(node) and not is_sequence(node):
            break
        node = step(node, segment)
    return node


def _texts(node: Any) -> Iterator[str]:
    todo = [node]
    while todo:
        item = todo.pop()
        if isinstance(item, str):
            yield item
        elif is_mapping(item):
            todo += item.values()
        elif is_sequence(item):
            todo += item


def _names(text: str) -> frozenset[str]:
    if EXPRESSION not in text:
        return frozenset()
    try:
        return frozenset(Template.parse(text).names)
    except ExpressionError:
        return frozenset()
