"""The start of a document in which too much is wrong to tell all of it."""

from __future__ import annotations

from typing import Any

from scenecc.spec.base import Model
from scenecc.spec.plain import is_mapping, is_sequence

_SHORT = 100
"""Items of a list or mapping that is never cut: more than any of the language's own has."""


class Start:
    """A copy of a document without what follows its first nodes.

    Attributes:
        data: the copy. Lists and mappings of names are cut; no key that a mapping may have is lost.
        whole: whether nothing was left out.
    """

    def __init__(self, data: dict[str, Any], nodes: int) -> None:
        self._left = nodes
        self._known = _keys_of(Model)
        self.whole = True
        self.data: dict[str, Any] = self._copy(data)

    def _copy(self, node: Any) -> Any:
        self._left -= 1
        if is_mapping(node):
            return {key: self._copy(item) for key, item in node.items() if self._kept(node, key)}
        if is_sequence(node):
            return [self._copy(item) for item in node if self._kept(node, None)]
        return node

    def _kept(self, container: Any, key: str | None) -> bool:
        if self._left > 0 or len(container) <= _SHORT or key in self._known:
            return True
        self.whole = False
        return False


def _keys_of(model: type[Model]) -> set[str]:
    keys = {field.alias or name for name, field in model.model_fields.items()}
    for special in model.__subclasses__():
        keys |= _keys_of(special)
    return keys
