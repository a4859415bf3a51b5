"""Documents: their data, and an index of where each node is written, made at the first question.

Of Python data, plain data as a text would give it; JSON objects that repeat a key are rejected.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path as FilePath
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, cast

import yaml

from scenecc.diagnostics.collector import collector_paused
from scenecc.diagnostics.diagnostic import At, Location, Origin, Path
from scenecc.diagnostics.frozen import frozen
from scenecc.source.events import (
    MAX_INTEGER_CHARS,
    RESERVED_CHARACTER,
    RESERVED_IN_KEY_MESSAGE,
    AliasEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
    SequenceEndEvent,
    StreamEndEvent,
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
"""0-based line, first column, column after the last one (None: to the line's end)."""

Place = tuple[int, int]
"""0-based line and column."""


class WrittenNode:
    """A node as it is written.

    Attributes:
        span: of the first line of it.
        text: of a scalar, without its quotes; None of a mapping or a list.
        entries: of a mapping, by key; those of its merge keys too.
        items: of a list.
        is_block: whether it is a collection in block style.

    An alias is the node that it names, so that a node may be reached in several ways, and be inside itself.
    """

    __slots__ = ("entries", "is_block", "items", "span", "text")

    def __init__(self, span: Span, text: str | None = None) -> None:
        self.span = span
        self.text = text
        self.entries: Mapping[str, WrittenEntry] = _NO_ENTRIES
        self.items: Sequence[WrittenNode] = ()
        self.is_block = False


class WrittenEntry(NamedTuple):
    """An entry of a mapping. `key`: where its key is; `merged`: whether a merge key brought it in."""

    key: Span
    node: WrittenNode
    merged: bool = False


_NO_ENTRIES: Mapping[str, WrittenEntry] = {}


class WrittenTree(NamedTuple):
    """What is written in a text. `is_whole`: whether it is YAML; otherwise the tree ends where that is wrong."""

    root: WrittenNode
    is_whole: bool


def written_tree(text: str) -> WrittenTree:
    """The nodes of a text, with their places, also of one that is half typed.

    There are none where a character breaks lines for YAML 1.1 alone: what the parser tells of places is wrong there.
    Nor are there any where half a character is typed, which the parser does not take.
    """
    walk = _EventWalk("\0" if SEPARATORS.search(text) or LONE_SURROGATES.search(text) else text)
    with collector_paused():
        root = walk.root()
    return WrittenTree(root, walk.is_whole)


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


def _first_line(node: WrittenNode) -> Span:
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
        self._anchors: dict[str, WrittenNode] = {}
        self.is_whole = False
        self.firsts: dict[Place, Span] = {}

    def root(self) -> WrittenNode:
        """The document's node; what was read of it, where the walk ended early."""
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
            pass  # with the limit of depth raised; the places above are still found
        return root

    def _open_node(self, event: NodeEvent) -> WrittenNode:
        """A node as far as its first event tells."""
        if isinstance(event, AliasEvent):
            return self._anchors.get(event.anchor or "", WrittenNode(_event_span(event, event)))
        node = WrittenNode(_event_span(event, event), event.value if isinstance(event, ScalarEvent) else None)
        if event.anchor is not None:
            self._anchors[event.anchor] = node
        return node

    def _fill(self, start: NodeEvent, node: WrittenNode) -> None:
        """Reads what is in a collection, up to and with its end. Each part is in it before it is read itself."""
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

    def _entry(self, event: NodeEvent, entries: dict[str, WrittenEntry]) -> None:
        """Reads a key and its value. On a duplicate the first entry stays."""
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
        """Where an origin in this document is written: a `scenecc.diagnostics.diagnostic.Locator`.

        Aliases and merge keys are followed to the text inside their anchors; of a path that does not
        exist the deepest part that does is shown. The index is made at the first question.
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
    """A container that was copied: the copy, and its nodes and height with shared parts unfolded."""

    value: Any
    nodes: int
    height: int


_INVALID = _CopiedValue(None, 1, 0)
"""The copy of what was reported."""


class _LimitReached(Exception):
    """A limit was reached."""


def copy_mapping(data: Mapping[str, Any], sink: Sink, limits: Limits) -> dict[str, Any] | None:
    """A copy of a mapping as plain dicts, lists and scalars; None, reported, if no scene can hold it.

    A part that the input shares is one object in the copy too, copied once.
    """
    copier = _Copier(sink, limits)
    try:
        copy = copier.copy(data, ())
    except _LimitReached:
        return None
    except RecursionError:
        hint = "nest less: each level takes frames of the stack"
        sink.report("SC602", "the dict is deeper than Python's stack allows", Origin(None), hint=hint)
        return None
    return None if copier.failed else copy.value


class _Copier:
    def __init__(self, sink: Sink, limits: Limits) -> None:
        self._sink = sink
        self._limits = limits
        self.failed = False
        self._open: set[int] = set()
        # id → copy, and the original, which must live as long as its id means it.
        self._copies: dict[int, tuple[_CopiedValue, object]] = {}

    def copy(self, value: Any, path: Path) -> _CopiedValue:
        """The copy of any value; None, reported, of what no scene can hold."""
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
            self._too_deep(path)
        return copy

    def _container(self, value: Any, path: Path) -> _CopiedValue:
        if len(path) >= self._limits.depth:
            self._too_deep(path)
        if isinstance(value, Mapping):
            copies = dict(self._entries(cast("Mapping[Any, Any]", value), path))
            result: Any = {key: copy.value for key, copy in copies.items()}
            children = list(copies.values())
        else:
            children = [self.copy(item, (*path, index)) for index, item in enumerate(value)]
            result = [child.value for child in children]
        nodes = 1 + sum(child.nodes for child in children)
        if nodes > self._limits.text_bytes:
            self._too_long(path)
        return _CopiedValue(result, nodes, 1 + max((child.height for child in children), default=0))

    def _entries(self, mapping: Mapping[Any, Any], path: Path) -> Iterable[tuple[str, _CopiedValue]]:
        for key, value in mapping.items():
            name = _text_key(key, path)
            if name is None:
                self._report("SC005", f"the key {_format_key(key)} is not a string", path, hint="keys are strings")
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
            # The base class's own conversion, so that enumerations and other subclasses leave no trace.
            case int():
                return self._in_range(int.__int__(value), path)
            case float():
                return float.__float__(value)
            case str():
                return self._check_text(str.__str__(value), path)
            case PurePath():
                return self._check_text(str(value), path)
            case None:
                hint = "give it a value, or remove the key to get its default"
                self._report("SC006", "None is not a value of any key", path, hint=hint)
            case _:
                self._refuse(_with_article(type(value).__qualname__), path)
        return None

    def _in_range(self, value: int, path: Path) -> int:
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

    def _too_deep(self, path: Path) -> NoReturn:
        message = f"more than {self._limits.depth} dicts and lists inside one another (limit depth)"
        hint = f"`limits={{'depth': N}}` raises the limit, to {MAX_DEPTH} at most"
        self._report("SC602", message, path[:8], hint=hint)
        raise _LimitReached

    def _too_long(self, path: Path) -> NoReturn:
        message = f"more than {self._limits.text_bytes} values, shared ones counted each time (limit text_bytes)"
        hint = "`limits={'text_bytes': N}` raises the limit"
        self._report("SC601", message, path, hint=hint)
        raise _LimitReached


def _text_key(key: object, path: Path) -> str | None:
    """A key as a text would give it; None if it is no string."""
    if isinstance(key, int) and not isinstance(key, bool) and has_index_keys(path):
        return str(int.__int__(key))
    return str.__str__(key) if isinstance(key, str) else None


def _with_article(name: str) -> str:
    return f"{'an' if name[:1].lower() in tuple('aeiou') else 'a'} {name}"


def _format_key(key: object) -> str:
    """A key as Python writes it, if that is short and harmless."""
    return repr(key)[:40] if isinstance(key, (int, float, bytes, type(None))) else _with_article(type(key).__qualname__)
