"""Documents: their data, and a lazily built index of node positions.

Python data is copied to plain data, as from a text. JSON objects that repeat a key are rejected.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path as FilePath
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, cast

import yaml
from yaml.events import (
    AliasEvent,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
    StreamEndEvent,
)

from scenecc.diagnostics.collector import collector_paused
from scenecc.diagnostics.diagnostic import At, Location, Origin, Path
from scenecc.diagnostics.frozen import frozen
from scenecc.source.events import (
    MAX_INTEGER_CHARS,
    RESERVED_CHARACTER,
    RESERVED_IN_KEY_MESSAGE,
    Event,
    NodeEvent,
    has_index_keys,
    next_event,
)
from scenecc.source.limits import MAX_DEPTH
from scenecc.source.text import LONE_SURROGATES, SEPARATORS

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.source.limits import Limits
    from scenecc.source.text import TextLines


Span = tuple[int, int, int | None]
"""0-based line, first column, column after the last one (None: to the end of the line)."""

Place = tuple[int, int]
"""0-based line and column."""


class WrittenNode:
    """A node of a text.

    Attributes:
        span: span of its first line.
        end: the place after its last character; of a block, after its last key or scalar.
        text: text of a scalar, without quotes; None for a mapping or list.
        entries: entries of a mapping by key, including those of its merge keys.
        items: items of a list.
        is_block: whether it is a collection in block style.

    An alias is the same object as its node, so a node may be reached in several ways, and contain itself.
    """

    __slots__ = ("end", "entries", "is_block", "items", "span", "text")

    def __init__(self, span: Span, text: str | None = None, end: Place = (0, 0)) -> None:
        self.span = span
        self.end = end
        self.text = text
        self.entries: Mapping[str, WrittenEntry] = _NO_ENTRIES
        self.items: Sequence[WrittenNode] = ()
        self.is_block = False


class WrittenEntry(NamedTuple):
    """An entry of a mapping. `key`: span of its key; `merged`: whether it comes from a merge key."""

    key: Span
    node: WrittenNode
    merged: bool = False


_NO_ENTRIES: Mapping[str, WrittenEntry] = {}


class WrittenTree(NamedTuple):
    """The nodes of a text. `is_whole`: whether the text is valid YAML; otherwise the tree ends at the error."""

    root: WrittenNode
    is_whole: bool


def written_tree(text: str) -> WrittenTree:
    """Returns the nodes of a text, with their spans, even if the text is incomplete.

    The tree is empty if a character is a line break only in YAML 1.1, because the parser's positions are wrong then,
    and if the text contains half a character, which the parser rejects.
    """
    walk = _EventWalk("\0" if SEPARATORS.search(text) or LONE_SURROGATES.search(text) else text)
    with collector_paused():
        root = walk.root()
    return WrittenTree(root, walk.is_whole)


class PositionIndex:
    """The position index of one valid text."""

    def __init__(self, lines: TextLines) -> None:
        self._lines = lines
        with collector_paused():
            self._root = _EventWalk(lines.text).root()

    def find(self, path: Path, at: At) -> Location:
        """Returns the location of the node at a path, through aliases and merge keys; or that of its deepest existing
        parent.
        """
        node, key = self._root, None
        for step in path:
            entry = node.entries.get(step) if isinstance(step, str) else None
            if entry is not None:
                node, key = entry.node, entry.key
            elif isinstance(step, int) and 0 <= step < len(node.items):
                node, key = node.items[step], None
            else:
                break
        return self._lines.location(*(key if at == "key" and key is not None else _find_first_line(node)))


def find_duplicate_keys(text: str, last: Place) -> dict[Place, Span]:
    """Returns for each duplicate key up to the place `last`: its place → the earlier key of the same name."""
    walk = _EventWalk(text, last)
    walk.root()
    return walk.firsts


def _find_first_line(node: WrittenNode) -> Span:
    """Returns the span to underline for a node. The end mark of a block is useless, because it is after blank lines and
    comments.
    """
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
    """Ends the walk when the target is found."""


class _EventWalk:
    """One pass over the events of a text, up to its end, an error, or a place."""

    def __init__(self, text: str, last: Place | None = None) -> None:
        self._get = next_event(text)
        self._last = last
        self._anchors: dict[str, WrittenNode] = {}
        self._end: Place = (0, 0)
        self.is_whole = False
        self.firsts: dict[Place, Span] = {}

    def root(self) -> WrittenNode:
        """Returns the root node; if the walk ended early, the part that was read."""
        root = WrittenNode((0, 0, None))
        get = self._get
        try:
            get()  # the start of the stream
            if not isinstance(get(), StreamEndEvent):
                event: NodeEvent = get()
                root = self._open_node(event)
                self._fill(event, root)
            self.is_whole = True
        except (yaml.YAMLError, _WalkFinished, RecursionError):
            pass  # reached with a raised depth limit; the positions above are still found
        return root

    def _open_node(self, event: NodeEvent) -> WrittenNode:
        """Returns a node with the data of its first event."""
        if not isinstance(event, (MappingStartEvent, SequenceStartEvent)):
            self._end = event.end_mark.line, event.end_mark.column
        if isinstance(event, AliasEvent):
            return self._anchors.get(event.anchor or "", WrittenNode(_event_span(event, event)))
        node = WrittenNode(
            _event_span(event, event), event.value if isinstance(event, ScalarEvent) else None, self._end
        )
        if event.anchor is not None:
            self._anchors[event.anchor] = node
        return node

    def _fill(self, start: NodeEvent, node: WrittenNode) -> None:
        """Reads the content of a collection and its end. Each part is added before it is read."""
        if isinstance(start, (ScalarEvent, AliasEvent)):
            return
        get = self._get
        event: NodeEvent = get()
        if isinstance(start, MappingStartEvent):
            node.entries = entries = dict[str, WrittenEntry]()
            while not isinstance(event, MappingEndEvent):
                self._entry(event, entries)
                event = get()
        else:
            node.items = items = list[WrittenNode]()
            while not isinstance(event, SequenceEndEvent):
                items.append(self._open_node(event))
                self._fill(event, items[-1])
                event = get()
        node.is_block = not start.flow_style
        node.span = _event_span(start, event)
        if start.flow_style:
            self._end = event.end_mark.line, event.end_mark.column
        node.end = self._end

    def _entry(self, event: NodeEvent, entries: dict[str, WrittenEntry]) -> None:
        """Reads a key and its value. For a duplicate, the first entry stays."""
        span = _event_span(event, event)
        node = self._open_node(event)
        self._fill(event, node)
        key = node.text or ""
        known = entries.get(key)
        is_merge = isinstance(event, ScalarEvent) and event.value == "<<" and event.implicit[0]
        first = None if known is None or known.merged or is_merge else known
        if first is not None:
            self.firsts[span[:2]] = first.key
            if self._last is not None and span[:2] >= self._last:
                raise _WalkFinished
        event = self._get()
        value = self._open_node(event)
        if not is_merge and first is None:
            entries[key] = WrittenEntry(span, value)
        self._fill(event, value)
        if is_merge:
            for source in value.items or [value]:
                for name, entry in source.entries.items():
                    entries.setdefault(name, WrittenEntry(entry.key, entry.node, merged=True))


def _event_span(first: Event, last: Event) -> Span:
    start, end = first.start_mark, last.end_mark
    return start.line, start.column, end.column if end.line == start.line else None


class Document:
    """A document that was read.

    Attributes:
        name: name for messages: the path as given by the user, `<stdin>`, None for a dict.
        path: absolute path of the file; None for a stream or a dict.
        data: plain dicts with string keys, lists, strings, integers, floats and booleans. Parts that an alias names are
            shared objects, so the data must not be changed.
    """

    def __init__(self, name: str | None, path: FilePath | None, data: dict[str, Any], lines: TextLines | None) -> None:
        self.name = name
        self.path = path
        self.data = data
        self._lines = lines

    @property
    def text(self) -> str | None:
        """The text; None for a dict."""
        return None if self._lines is None else self._lines.text

    def locate(self, origin: Origin, at: At) -> Location:
        """Implements `scenecc.diagnostics.diagnostic.Locator`: returns the location of an origin in this document.

        Aliases and merge keys are followed to the anchored text. For a path that does not exist, the deepest existing
        part is returned. The index is built at the first call.
        """
        if self._positions is None:
            return Location(self.name)
        return self._positions.find(origin.path, at)

    @cached_property
    def _positions(self) -> PositionIndex | None:
        return None if self._lines is None else PositionIndex(self._lines)


_MAX_INTEGER = 10**MAX_INTEGER_CHARS


@frozen
class _CopiedValue:
    """A copied container: the copy, and its number of nodes and height with shared parts unfolded."""

    value: Any
    nodes: int
    height: int


_INVALID = _CopiedValue(None, 1, 0)
"""The copy of a value that was reported."""


class _LimitReached(Exception):
    """A limit was reached."""


def copy_mapping(data: Mapping[str, Any], sink: Sink, limits: Limits) -> dict[str, Any] | None:
    """Copies a mapping as plain dicts, lists and scalars; None, reported, if it is not valid scene data.

    A part that is shared in the input is copied once and shared in the copy.
    """
    copier = _Copier(sink, limits)
    try:
        copy = copier.copy(data, ())
    except _LimitReached:
        return None
    except RecursionError:
        hint = "use fewer levels: each takes frames of the stack"
        sink.report("SC602", "the dict is deeper than Python's stack allows", Origin(None), hint=hint)
        return None
    return None if copier.failed else copy.value


class _Copier:
    def __init__(self, sink: Sink, limits: Limits) -> None:
        self._sink = sink
        self._limits = limits
        self.failed = False
        self._open: set[int] = set()
        # id → copy and original; the original is kept alive so that its id stays unique.
        self._copies: dict[int, tuple[_CopiedValue, object]] = {}

    def copy(self, value: Any, path: Path) -> _CopiedValue:
        """Returns the copy of any value; None, reported, for invalid data."""
        if isinstance(value, (Mapping, list, tuple)):
            return self._share_value(value, path)
        numpy = sys.modules.get("numpy")
        if numpy is not None and isinstance(value, (numpy.ndarray, numpy.generic)):
            return self._array(value, path)
        return _CopiedValue(self._scalar(value, path), 1, 0)

    def _array(self, array: Any, path: Path) -> _CopiedValue:
        if array.dtype.kind not in "biufU":
            self._refuse(f"a numpy value of dtype {array.dtype}", path)
            return _INVALID
        value = array.tolist()
        if isinstance(value, list):
            return self._container(value, path)
        return _CopiedValue(self._scalar(value, path), 1, 0)

    def _share_value(self, value: Any, path: Path) -> _CopiedValue:
        known = self._copies.get(id(value))
        if known is not None:
            copy = known[0]
        elif id(value) in self._open:
            self._report("SC010", "this dict or list contains itself", path)
            return _INVALID
        else:
            self._open.add(id(value))
            copy = self._container(value, path)
            self._open.discard(id(value))
            self._copies[id(value)] = copy, value
        if len(path) + copy.height > self._limits.depth:
            self._refuse_depth(path)
        return copy

    def _container(self, value: Any, path: Path) -> _CopiedValue:
        if len(path) >= self._limits.depth:
            self._refuse_depth(path)
        if isinstance(value, Mapping):
            copies = dict(self._entries(cast("Mapping[Any, Any]", value), path))
            result: Any = {key: copy.value for key, copy in copies.items()}
            children = list(copies.values())
        else:
            children = [self.copy(item, (*path, index)) for index, item in enumerate(value)]
            result = [child.value for child in children]
        nodes = 1 + sum(child.nodes for child in children)
        if nodes > self._limits.text_bytes:
            self._refuse_length(path)
        return _CopiedValue(result, nodes, 1 + max((child.height for child in children), default=0))

    def _entries(self, mapping: Mapping[Any, Any], path: Path) -> Iterable[tuple[str, _CopiedValue]]:
        for key, value in mapping.items():
            name = _text_key(key, path)
            if name is None:
                self._report("SC005", f"the key {_format_key(key)} is not a string", path, hint="keys must be strings")
                continue
            if RESERVED_CHARACTER in name:
                self._report("SC017", RESERVED_IN_KEY_MESSAGE, (*path, name))
                continue
            below = (*path, name)
            self._check_text(name, below)
            yield name, self.copy(value, below)

    def _scalar(self, value: Any, path: Path) -> Any:
        match value:
            case bool():
                return value
            # Uses the base class's conversion, so that enumerations and other subclasses become plain values.
            case int():
                return self._check_range(int.__int__(value), path)
            case float():
                return float.__float__(value)
            case str():
                return self._check_text(str.__str__(value), path)
            case PurePath():
                return self._check_text(str(value), path)
            case None:
                hint = "give it a value, or remove the key to get its default"
                self._report("SC006", "None is not a valid value for any key", path, hint=hint)
            case _:
                self._refuse(_add_article(type(value).__qualname__), path)
        return None

    def _check_range(self, value: int, path: Path) -> int:
        if abs(value) >= _MAX_INTEGER:
            self._report("SC014", f"an integer of more than {MAX_INTEGER_CHARS} digits", path)
        return value

    def _check_text(self, text: str, path: Path) -> str:
        if not text.isascii():
            try:
                text.encode()
            except UnicodeEncodeError:
                message = f"a string contains a lone surrogate: {text!a:.60}"
                self._report("SC002", message, path)
        return text

    def _report(self, code: str, message: str, path: Path, *, hint: str | None = None) -> None:
        self.failed = True
        self._sink.report(code, message, Origin(None, path), hint=hint)

    def _refuse(self, what: str, path: Path) -> None:
        hint = "a scene contains dicts with string keys, lists, strings, numbers, booleans, numpy arrays and paths"
        self._report("SC015", f"{what} is not supported in a scene", path, hint=hint)

    def _refuse_depth(self, path: Path) -> NoReturn:
        message = f"more than {self._limits.depth} nested dicts and lists (limit depth)"
        hint = f"`--limit depth=N` or `limits={{'depth': N}}` raises the limit, to {MAX_DEPTH} at most"
        self._report("SC602", message, path[:8], hint=hint)
        raise _LimitReached

    def _refuse_length(self, path: Path) -> NoReturn:
        message = f"more than {self._limits.text_bytes} values, shared ones counted each time (limit text_bytes)"
        hint = "`--limit text_bytes=N` or `limits={'text_bytes': N}` raises the limit"
        self._report("SC601", message, path, hint=hint)
        raise _LimitReached


def _text_key(key: object, path: Path) -> str | None:
    """Returns a key as text would give it; None if it is not a string."""
    if isinstance(key, int) and not isinstance(key, bool) and has_index_keys(path):
        return str(int.__int__(key))
    return str.__str__(key) if isinstance(key, str) else None


def _add_article(name: str) -> str:
    return f"{'an' if name[:1].lower() in tuple('aeiou') else 'a'} {name}"


def _format_key(key: object) -> str:
    """Returns a key in Python notation, if that is short and printable."""
    return repr(key)[:40] if isinstance(key, (int, float, bytes, type(None))) else _add_article(type(key).__qualname__)
