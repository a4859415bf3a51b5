"""A text in an editor: its leaves by position, and its nodes by path, even if the text is incomplete."""

from __future__ import annotations

from bisect import bisect_right
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple

from scenecc.source.document import written_tree
from scenecc.spec.base import NOTE_PREFIX

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from scenecc.diagnostics.diagnostic import At
    from scenecc.diagnostics.diagnostic import Path as KeyPath
    from scenecc.source.document import Span, WrittenNode, WrittenTree

MAX_CHARACTERS: Final = 2**20
"""Longer texts get only findings, because a request must not take a second."""


class Leaf(NamedTuple):
    """A key or a scalar.

    Attributes:
        line, start: 0-based, in characters.
        end: the column after it; None: to the end of the line.
        path: path of its entry or node.
        at: whether it is the key or the value.
        text: its value, without quotes.
    """

    line: int
    start: int
    end: int | None
    path: KeyPath
    at: At
    text: str


class SceneText:
    """A text and its structure.

    Attributes:
        path: path of its file.
        text: the whole text.
        lines: its lines without line breaks, as YAML and editors split them.
    """

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        self.text = text
        self.lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")

    @cached_property
    def tree(self) -> WrittenTree:
        """Its nodes. For invalid YAML, those before the error; for a text that is too long, none."""
        return written_tree(self.text if len(self.text) <= MAX_CHARACTERS else "")

    @cached_property
    def leaves(self) -> list[Leaf]:
        """All leaves, in text order."""
        return sorted(_leaves(self.tree.root), key=lambda one: one[:2])

    def leaf_at(self, line: int, column: int) -> Leaf | None:
        """Returns the leaf at a 0-based position, or ending there."""
        at = bisect_right(self.leaves, (line, column), key=lambda one: one[:2])
        for leaf in self.leaves[max(at - 2, 0) : at][::-1]:
            end = len(self.line(line)) if leaf.end is None else leaf.end
            if leaf.line == line and leaf.start <= column <= end:
                return leaf
        return None

    def path_at(self, line: int, column: int) -> KeyPath:
        """Returns the path of the leaf at or before a 0-based position; in indentation, of the line's first leaf."""
        text = self.line(line)
        indentation = len(text) - len(text.lstrip())
        at = bisect_right(self.leaves, (line, max(column, indentation)), key=lambda one: one[:2])
        return self.leaves[at - 1].path if at else ()

    def line(self, number: int) -> str:
        """Returns a 0-based line; "" past the end."""
        return self.lines[number] if 0 <= number < len(self.lines) else ""

    def place_of(self, index: int) -> tuple[int, int]:
        """Returns the 0-based line and column of a character of the text."""
        before = self.text[:index].replace("\r\n", "\n").replace("\r", "\n")
        return before.count("\n"), len(before) - (before.rfind("\n") + 1)

    def node(self, path: KeyPath) -> WrittenNode | None:
        """Returns the node at a path."""
        node = self.tree.root
        for step in path:
            if isinstance(step, str) and step in node.entries:
                node = node.entries[step].node
            elif isinstance(step, int) and 0 <= step < len(node.items):
                node = node.items[step]
            else:
                return None
        return node

    def scalar(self, path: KeyPath) -> str | None:
        """Returns the text of the scalar at a path; None if there is none."""
        node = self.node(path)
        return None if node is None else node.text

    def scalars(self, path: KeyPath) -> dict[str, str | None]:
        """Returns the keys of the mapping at a path, with the texts of scalar values."""
        node = self.node(path)
        return {} if node is None else {key: entry.node.text for key, entry in node.entries.items()}

    def key_span(self, path: KeyPath) -> Span | None:
        """Returns the span of an entry's key, or of a list item."""
        parent = self.node(path[:-1]) if path else None
        if parent is None:
            return None
        last = path[-1]
        if isinstance(last, str):
            return parent.entries[last].key if last in parent.entries else None
        return parent.items[last].span if 0 <= last < len(parent.items) else None

    def names(self, section: str) -> list[str]:
        """Returns the names in a section."""
        return [name for name in self.scalars((section,)) if not name.startswith(NOTE_PREFIX)]

    def texts(self, path: KeyPath) -> list[str]:
        """Returns the scalars of the list at a path, or the single scalar there."""
        node = self.node(path)
        return [] if node is None else [one.text for one in (node.items or [node]) if one.text is not None]


def _leaves(root: WrittenNode) -> Iterator[Leaf]:
    """Yields each leaf once, at the first path that leads to it."""
    seen: set[int] = set()
    todo: list[tuple[KeyPath, WrittenNode]] = [((), root)]
    while todo:
        path, node = todo.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        if node.text is not None:
            yield Leaf(*node.span, path, "value", node.text)
        for key, entry in node.entries.items():
            if not entry.merged:
                yield Leaf(*entry.key, (*path, key), "key", key)
                todo.append(((*path, key), entry.node))
        todo += (((*path, index), item) for index, item in enumerate(node.items))
