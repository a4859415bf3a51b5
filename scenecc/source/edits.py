"""Edits of a YAML text at the positions of its nodes. All other characters, including comments, are kept."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import yaml

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Path


class EditError(Exception):
    """A place in a text cannot be edited; the message gives the reason."""


class TextEdits:
    """Edits of one text, which are applied together."""

    def __init__(self, text: str) -> None:
        """`text`: valid YAML."""
        self._text = text
        self._root: Any = yaml.compose(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        self._splices: list[tuple[int, int, str]] = []

    def set_scalar(self, path: Path, value: str) -> None:
        """Replaces a number, a word or a string.

        Raises:
            EditError: there is no such value, or it is written in another place.
        """
        node = self._find(path)
        if not isinstance(node, yaml.ScalarNode):
            raise EditError(f"`{path[-1]}` is not a single value")
        self._splice(node.start_mark.index, node.end_mark.index, value)

    def wrap(self, path: Path, before: str, after: str) -> None:
        """Inserts text before and after a list or mapping in brackets.

        Raises:
            EditError: it has no brackets, or is written in another place.
        """
        node = self._find(path)
        if isinstance(node, yaml.ScalarNode) or not node.flow_style:
            raise EditError(f"`{path[-1]}` has no brackets")
        self._splice(node.start_mark.index, node.start_mark.index, before)
        self._splice(node.end_mark.index, node.end_mark.index, after)

    def add_key(self, path: Path, key: str, value: str) -> None:
        """Inserts a key at the start of a mapping that has other keys.

        Raises:
            EditError: there is no such mapping in this place.
        """
        node = self._find(path)
        if not isinstance(node, yaml.MappingNode) or not node.value:
            raise EditError(f"`{path[-1]}` is not a mapping")
        first = node.value[0][0].start_mark
        if node.flow_style:
            self._splice(first.index, first.index, f"{key}: {value}, ")
        else:
            end = "\r\n" if "\r\n" in self._text else "\n"
            self._splice(first.index, first.index, f"{key}: {value}{end}{' ' * first.column}")

    def result(self) -> str:
        """Returns the text with all edits."""
        text = self._text
        for start, end, new in sorted(self._splices, reverse=True):
            text = text[:start] + new + text[end:]
        return text

    def _splice(self, start: int, end: int, new: str) -> None:
        self._splices.append((start, end, new))

    def _find(self, path: Path) -> Any:
        node = self._root
        for step in path:
            below = _step_below(node, step)
            if below is None:
                raise EditError(f"`{step}` is not written there: it comes from a merge key or a prefab")
            # An alias leads to a node in another place.
            if not node.start_mark.index <= below.start_mark.index <= node.end_mark.index:
                raise EditError(f"`{step}` is written elsewhere, at an anchor")
            node = below
        return node


def _step_below(node: Any, step: str | int) -> Any:
    if isinstance(node, yaml.MappingNode):
        return next((value for key, value in node.value if key.value == step), None)
    if isinstance(node, yaml.SequenceNode) and isinstance(step, int) and step < len(node.value):
        return node.value[step]
    return None
