"""A document: its data, and an index of where each node is written, made at the first question."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, NamedTuple

import yaml

from scenecc.diagnostics import At, Location, Origin
from scenecc.diagnostics.collector import collector_paused
from scenecc.source.events import (
    AliasEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
    SequenceEndEvent,
    StreamEndEvent,
    next_event,
)

if TYPE_CHECKING:
    from scenecc.diagnostics import Path
    from scenecc.source.text import TextLines


Span = tuple[int, int, int | None]
"""0-based line, first column, column after the last one (None: to the line's end)."""

Place = tuple[int, int]
"""0-based line and column."""


class _Node:
    """A node, and the nodes below it by key or index; an alias is the node that it names."""

    __slots__ = ("entries", "is_block", "items", "span", "text")

    def __init__(self, span: Span, text: str = "") -> None:
        self.span = span
        self.text = text
        self.entries: Mapping[str, _Entry] = _NO_ENTRIES
        self.items: Sequence[_Node] = ()
        self.is_block = False


class _Entry(NamedTuple):
    key: Span
    node: _Node
    merged: bool = False


_NO_ENTRIES: Mapping[str, _Entry] = {}


class PositionIndex:
    """The index of one valid text."""

    def __init__(self, lines: TextLines) -> None:
        self._lines = lines
        with collector_paused():
            self._root = _EventWalk(lines.text).root()

    def find(self, path: Path, at: At) -> Location:
        """The place of the node at a path, through aliases and merges; of the deepest one that exists."""
        node, key = self._root, None
        for step in path:
            entry = node.entries.get(step) if isinstance(step, str) else None
            if entry is not None:
                node, key = entry.node, entry.key
            elif isinstance(step, int) and 0 <= step < len(node.items):
                node, key = node.items[step], None
            else:
                break
        return self._lines.location(*(key if at == "key" and key is not None else _first_line(node)))


def find_duplicate_keys(text: str, last: Place) -> dict[Place, Span]:
    """For each duplicate key up to the place `last`: its place → the key of the same name before it."""
    walk = _EventWalk(text, last)
    walk.root()
    return walk.firsts


def _first_line(node: _Node) -> Span:
    """What to underline of a node. A block's end mark runs past blank lines and comments, and is no use."""
    line, start, end = node.span
    while node.is_block and node.span[0] == line:
        if node.items:
            node = node.items[0]
        elif node.entries:
            entry = next(iter(node.entries.values()))
            key, node = entry.key, entry.node
            if key[0] != line:
                break
            end = key[2] if key[2] is None else key[2] + 1
        else:
            break
        if node.span[0] == line:
            end = node.span[2]
    return line, start, end


class _WalkFinished(Exception):
    """What was asked for is found."""


class _EventWalk:
    """One pass over the events of a text, up to its end, to what is wrong with it, or to a place."""

    def __init__(self, text: str, last: Place | None = None) -> None:
        self._get = next_event(text)
        self._last = last
        self._anchors: dict[str, _Node] = {}
        self.firsts: dict[Place, Span] = {}

    def root(self) -> _Node:
        """The document's node; what was read of it, where the walk ended early."""
        root = _Node((0, 0, None))
        get = self._get
        try:
            get()  # the start of the stream
            if isinstance(get(), StreamEndEvent):
                return root
            event: NodeEvent = get()
            root = self._opened(event)
            if not isinstance(event, ScalarEvent):
                self._fill(event, root)
        except (yaml.YAMLError, _WalkFinished, RecursionError):
            pass  # with the limit of depth raised; the places above are still found
        return root

    def _node(self, event: NodeEvent) -> _Node:
        if isinstance(event, AliasEvent):
            return self._anchors.get(event.anchor or "", _Node(_event_span(event, event)))
        node = self._opened(event)
        if not isinstance(event, ScalarEvent):
            self._fill(event, node)
        return node

    def _opened(self, event: NodeEvent) -> _Node:
        node = _Node(_event_span(event, event), event.value if isinstance(event, ScalarEvent) else "")
        if event.anchor is not None:
            self._anchors[event.anchor] = node
        return node

    def _fill(self, start: NodeEvent, node: _Node) -> None:
        """Reads what is in a collection, up to and with its end."""
        get = self._get
        event: NodeEvent = get()
        if isinstance(start, MappingStartEvent):
            node.entries = entries = dict[str, _Entry]()
            while not isinstance(event, MappingEndEvent):
                self._entry(event, entries)
                event = get()
        else:
            node.items = items = list[_Node]()
            while not isinstance(event, SequenceEndEvent):
                items.append(self._node(event))
                event = get()
        node.is_block = not start.flow_style
        node.span = _event_span(start, event)

    def _entry(self, event: NodeEvent, entries: dict[str, _Entry]) -> None:
        """Reads a key and its value. On a duplicate the first entry stays."""
        span = _event_span(event, event)
        key = self._node(event).text
        known = entries.get(key)
        is_merge = isinstance(event, ScalarEvent) and event.value == "<<" and event.implicit[0]
        first = None if known is None or known.merged or is_merge else known
        if first is not None:
            self.firsts[span[:2]] = first.key
            if self._last is not None and span[:2] >= self._last:
                raise _WalkFinished
        value = self._node(self._get())
        if is_merge:
            for source in value.items or [value]:
                for name, entry in source.entries.items():
                    entries.setdefault(name, _Entry(entry.key, entry.node, merged=True))
        elif first is None:
            entries[key] = _Entry(span, value)


def _event_span(first: Event, last: Event) -> Span:
    start, end = first.start_mark, last.end_mark
    return start.line, start.column, end.column if end.line == start.line else None


class Document:
    """What was read.

    Attributes:
        name: as shown to people: the path as the user gave it, `<stdin>`, None for a dict.
        path: absolute path of the file; None for a stream or a dict.
        data: plain dicts with string keys, lists, strings, integers, floats and booleans. Parts that an
            alias names are the same object wherever they are reached, so nothing may change them.
    """

    def __init__(self, name: str | None, path: FilePath | None, data: dict[str, Any], lines: TextLines | None) -> None:
        self.name = name
        self.path = path
        self.data = data
        self._lines = lines

    @property
    def text(self) -> str | None:
        """What was read; None for a dict."""
        return None if self._lines is None else self._lines.text

    def locate(self, origin: Origin, at: At) -> Location:
        """Where an origin in this document is written: a `scenecc.diagnostics.Locator`.

        Aliases and merge keys are followed to the text inside their anchors; of a path that does not
        exist the deepest part that does is shown. The index is made at the first question.
        """
        if self._positions is None:
            return Location(self.name)
        return self._positions.find(origin.path, at)

    @cached_property
    def _positions(self) -> PositionIndex | None:
        return None if self._lines is None else PositionIndex(self._lines)
