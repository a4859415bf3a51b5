"""Which parameters of a use a mistake inside a prefab comes from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Origin
from scenecc.spec.features import VARIATION_FORMS
from scenecc.spec.plain import EXPRESSION, is_mapping, is_sequence
from scenecc.spec.walk import step
from scenecc.values.failure import ExpressionError
from scenecc.values.template import Template

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenecc.diagnostics import Path
    from scenecc.source import Document

_USE = ("use",)
_OF_SECTIONS = 2
"""How long the path of a named node is: its section, its name."""
_MOST = 200
"""Among so many scalars names are looked for: what is larger is no value of a field."""


def given_by(documents: Mapping[str | None, Document], origin: Origin) -> tuple[Origin, ...]:
    """Where the parameters are given that the value at fault reads; empty for what is in no prefab, or reads none.

    It is empty for an entity, a light, a link, too: what is told of it as a whole comes from no one value in it, and
    what is wrong with a value is told at that.

    Args:
        documents: by the name that origins have.
        origin: of the node, as written.
    """
    if origin.parent is None or origin.file not in documents:
        return ()
    if _is_whole(_at(documents[origin.file].data, origin.path), origin.path):
        return ()
    return _given(documents, origin)


def _is_whole(node: Any, path: Path) -> bool:
    """Whether a node is a whole: one of a section's, which have names, or a link of a tree."""
    if not is_mapping(node) or any(key in VARIATION_FORMS for key in node):
        return False
    return len(path) == _OF_SECTIONS or path[-1:] == ("root",) or path[-2:-1] == ("children",)


def _given(documents: Mapping[str | None, Document], origin: Origin) -> tuple[Origin, ...]:
    """Where the parameters are given that a node reads. What is given there may read others in its turn: where these
    are given follows.
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
    return (*found, *dict.fromkeys(outer for one in found for outer in _given(documents, one)))


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
