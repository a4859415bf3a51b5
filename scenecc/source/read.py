"""Reads files, text, dicts and single values.

The reader walks the parser's events and creates only dicts, lists and scalars. It uses marks only for errors.
`yaml.load` takes three times as long as this walk.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import yaml
from yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
    StreamEndEvent,
)

from scenecc.diagnostics.collector import collector_paused
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.diagnostic import Path as KeyPath
from scenecc.source.comments import find_yaml_silencings
from scenecc.source.document import Document, copy_mapping, find_duplicate_keys
from scenecc.source.events import (
    RESERVED_CHARACTER,
    RESERVED_IN_KEY_MESSAGE,
    NextEvent,
    NodeError,
    NodeEvent,
    PlainKeys,
    PlainValues,
    check_collection_tag,
    describe_type,
    format_scalar,
    has_index_keys,
    next_event,
    scalar_value,
)
from scenecc.source.limits import Limits
from scenecc.source.syntax_errors import (
    AnchorTable,
    Container,
    MergeKeys,
    ReadAborted,
    SourceReporter,
    abort_at_depth,
    report_syntax,
)
from scenecc.source.text import TextLines, check_value_count, decode_text, read_bytes

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink


_SPREAD_FORM = re.compile(
    r"\{ *(uniform|log_uniform|integers|normal|choice|cycle|per_scene) *: *([-+.\w]+(?: *, *[-+.\w]+)+) *\}"
)
"""A form whose list has no brackets."""


_SPREAD_NUMBERS = re.compile(r"([\w.]+): *[{(<]? *([-+]?[\d.]+(?: *, *[-+]?[\d.]+)+) *[})>]?")
"""A list of numbers without brackets, or with others."""


_NEAR = 100
"""Number of characters on each side of a place in which a hint looks for a pattern: a line may be very long."""


def _around(lines: TextLines, event: NodeEvent) -> str:
    """Returns the part of a line around an event."""
    column = event.start_mark.column
    return lines.line(event.start_mark.line)[max(column - _NEAR, 0) : column + _NEAR]


_NAMES_DEPTH: Final = 2
"""Number of keys above which a mapping is a section or names things."""


def _is_key_at(line: str, column: int) -> bool:
    """Returns whether a line begins with a key at a column."""
    return len(line) - len(line.lstrip(" ")) == column and ":" in line and not line.lstrip().startswith("-")


_COMMENTED_COLOUR = re.compile(r"[ \t]*:[ \t]+(#[0-9A-Fa-f]{3,8})[ \t,}\]\"']*$")
_WITHOUT_COLON = re.compile(r"([A-Za-z_]\w*)(?: ?[=-])? +(\S.{0,60})")
"""A key of a mapping in brackets that has its value in it."""


_TYPE_OF: Callable[[object], object] = type


def read_yaml(faults: SourceReporter, limits: Limits) -> dict[str, Any] | None:
    """Reads the mapping of a text, and reports every error; None if there is none."""
    try:
        return _read_events(next_event(faults.lines.text), faults, limits)
    except yaml.YAMLError as error:
        report_syntax(error, faults)
        return None


def _read_events(get: NextEvent, faults: SourceReporter, limits: Limits) -> dict[str, Any] | None:
    """Reads the mapping of a parser's events. Raises yaml.YAMLError for invalid YAML."""
    reader = _Reader(get, faults, limits)
    try:
        return reader.document()
    except ReadAborted:
        return None
    except RecursionError:
        message = "the document is deeper than Python's stack allows"
        hint = "use fewer levels: each takes a frame of the stack"
        faults.report("SC602", message, Location(faults.lines.file), hint=hint)
        return None
    finally:
        reader.report_duplicates()


class _Reader:
    def __init__(self, get: NextEvent, faults: SourceReporter, limits: Limits) -> None:
        self._get = get
        self._faults = faults
        self._limits = limits
        self._plain = PlainValues()
        self._keys = PlainKeys()
        self._aliases = AnchorTable(faults, limits)
        self._depth = limits.depth
        self._open: list[tuple[str | int, Container]] = []
        """The open containers, outermost first, each with its key or index in its parent."""
        self._merges = MergeKeys(faults)
        self._duplicates: list[tuple[NodeEvent, str, KeyPath]] = []

    def document(self) -> dict[str, Any] | None:
        """Reads the stream, which must contain one mapping."""
        get, faults = self._get, self._faults
        get()  # the start of the stream
        start: NodeEvent = get()
        if isinstance(start, StreamEndEvent):
            self._refuse_root(start)
            return None
        if isinstance(start, DocumentStartEvent) and start.version == (1, 1):
            faults.at("SC003", "the file declares YAML 1.1", start, hint="scene files are YAML 1.2: remove `%YAML 1.1`")
        root: NodeEvent = get()
        if not isinstance(root, MappingStartEvent):
            self._refuse_root(root)
            return None
        data = self._mapping(root, "")
        get()  # the end of the document
        after: NodeEvent = get()
        if isinstance(after, DocumentStartEvent):
            faults.at("SC007", "a second document starts here", after, hint="put each scene in its own file")
        return data

    def report_duplicates(self) -> None:
        """Reports the duplicate keys; parses the text again for the places of the first ones."""
        if not self._duplicates:
            return
        last = self._duplicates[-1][0].start_mark
        firsts = find_duplicate_keys(self._faults.lines.text, (last.line, last.column))
        for event, key, path in self._duplicates:
            mark = event.start_mark
            first = firsts.get((mark.line, mark.column))
            place = () if first is None else (("first written here", self._faults.lines.location(*first)),)
            lines, where = self._faults.lines, self._faults.span(event.start_mark, event.end_mark)
            hint = "rename it, or remove one of the two"
            text = lines.line(mark.line)
            if first is not None and text.strip() == lines.line(first[0]).strip() and ": " in text:
                where, hint = lines.location(mark.line, mark.column), "remove it: the line above is the same"
            self._faults.report(
                "SC004", f"the key `{key}` is written twice", where, path=path, related=place, hint=hint
            )

    def _refuse_root(self, event: NodeEvent) -> None:
        if isinstance(event, StreamEndEvent) or (isinstance(event, ScalarEvent) and event.value in ("", "~", "null")):
            place = self._faults.lines.location(0, 0, 1)
            self._faults.report("SC012", "the document is empty", place, hint="a scene file starts with `scenecc: 1`")
            return
        if isinstance(event, ScalarEvent):
            # `scenecc:1` is a string, and the next line an error, whose message helps more.
            self._get()
            self._get()
        what = "a list" if isinstance(event, SequenceStartEvent) else "a single value"
        hint = "a scene file consists of `key: value` lines, with a space after each colon"
        self._faults.at("SC013", f"the document is {what}, not a mapping", event, hint=hint)

    def _mapping(self, start: NodeEvent, under: str | int) -> dict[str, Any]:
        """Reads a mapping from start to end. `under`: its key or index in its parent.

        This method and `_list` are the hot loops: every node of a valid file passes through them. Other methods handle
        rare cases (tags, anchors, aliases, merges, nulls, errors).
        """
        get, plain, keys, type_of = self._get, self._plain, self._keys, _TYPE_OF
        node: dict[str, Any] = {}
        if start.anchor is not None or start.tag is not None or len(self._open) >= self._depth:
            self._read_odd_start(start, node, under)
        self._open.append((under, node))
        while True:
            key_event = get()
            type_ = type_of(key_event)
            key = None
            if type_ is ScalarEvent:
                if key_event.anchor is None:
                    if key_event.implicit[0]:
                        key = keys[key_event.value]
                    elif key_event.tag is None and RESERVED_CHARACTER not in key_event.value:
                        key = key_event.value
            elif type_ is MappingEndEvent:
                self._open.pop()
                return node
            if key is None or key in node:
                self._read_odd_entry(key_event, node)
                continue
            event = get()
            type_ = type_of(event)
            if type_ is ScalarEvent:
                value = plain[event.value] if event.implicit[0] else event.value if event.tag is None else None
                node[key] = value if value is not None and event.anchor is None else self._scalar(event, key, key_event)
            elif type_ is MappingStartEvent:
                node[key] = self._mapping(event, key)
            elif type_ is SequenceStartEvent:
                node[key] = self._list(event, key)
            else:
                node[key] = self._follow(event, key)

    def _list(self, start: NodeEvent, under: str | int) -> list[Any]:
        """Reads a list from start to end. `under`: its key or index in its parent."""
        get, plain, type_of = self._get, self._plain, _TYPE_OF
        node: list[Any] = []
        if start.anchor is not None or start.tag is not None or len(self._open) >= self._depth:
            self._read_odd_start(start, node, under)
        self._open.append((under, node))
        while True:
            event = get()
            type_ = type_of(event)
            if type_ is ScalarEvent:
                value = plain[event.value] if event.implicit[0] else event.value if event.tag is None else None
                node.append(
                    value if value is not None and event.anchor is None else self._scalar(event, len(node), event)
                )
            elif type_ is SequenceEndEvent:
                self._open.pop()
                return node
            elif type_ is MappingStartEvent:
                node.append(self._mapping(event, len(node)))
            elif type_ is SequenceStartEvent:
                node.append(self._list(event, len(node)))
            else:
                node.append(self._follow(event, len(node)))

    def _value(self, key: str, key_event: NodeEvent) -> Any:
        """Reads the value of an entry."""
        event: NodeEvent = self._get()
        if isinstance(event, ScalarEvent):
            return self._scalar(event, key, key_event)
        if isinstance(event, AliasEvent):
            return self._follow(event, key)
        return self._mapping(event, key) if isinstance(event, MappingStartEvent) else self._list(event, key)

    def _follow(self, event: NodeEvent, under: str | int) -> Any:
        return self._aliases.follow(event, [node for _, node in self._open], self._path(under))

    def _read_odd_start(self, event: NodeEvent, node: Container, under: str | int) -> None:
        """Handles a collection's anchor, tag and depth."""
        path = self._path(under)
        if len(self._open) >= self._depth:
            abort_at_depth(self._faults, self._limits, event, path)
        if event.anchor is not None:
            self._aliases.define(event.anchor, node)
        if event.tag is not None:
            try:
                check_collection_tag(event)
            except NodeError as refused:
                self._faults.at(refused.code, refused.message, event, path=path, hint=refused.hint)

    def _scalar(self, event: NodeEvent, under: str | int, key_event: NodeEvent) -> Any:
        """Returns the value of a scalar that is tagged, anchored, null or out of range."""
        value: Any = None
        try:
            value = scalar_value(event)
        except NodeError as refused:
            self._faults.at(refused.code, refused.message, event, path=self._path(under), hint=refused.hint)
        else:
            if value is None:
                subject = f"the key `{under}`" if isinstance(under, str) else "the list item"
                hint = "give it a value, or remove the key to get its default"
                lines, end = self._faults.lines, key_event.end_mark
                line, below = lines.line(end.line), lines.line(end.line + 1)[:_NEAR]
                if isinstance(under, str) and ":" in under.strip(":"):
                    hint = "a space must follow the colon of a key: write `key: value`"
                elif isinstance(under, str) and (parts := _WITHOUT_COLON.fullmatch(under)):
                    hint = f"write `{parts[1]}: {parts[2]}`, with a colon"
                elif form := _SPREAD_FORM.search(_around(lines, key_event)):
                    hint = f"write its numbers in brackets: `{self._path()[-1]}: {{{form[1]}: [{form[2]}]}}`"
                elif isinstance(under, str) and line[end.column - len(under) - 1 :].startswith(f"{{{under}}}"):
                    owner = self._path()[-1:]
                    hint = f'an expression is written `{"".join(f"{one}: " for one in owner)}"${{{under}}}"`'
                elif colour := _COMMENTED_COLOUR.match(lines.line(end.line)[end.column :]):
                    hint = f'`#` starts a comment, so quote it: `{under}: "{colour[1]}"`'
                elif isinstance(under, str) and _is_key_at(below, key_event.start_mark.column):
                    more = f"indent the lines below `{under}` by two more spaces"
                    is_inside = len(self._path()) >= _NAMES_DEPTH
                    hint = f"give it a value, or {more}" if is_inside else f"{more}, or remove the key"
                elif below.lstrip().startswith("-{"):
                    hint = "write a space after the `-` of each item: `- {…}`"
                self._faults.at("SC006", f"{subject} has no value", key_event, path=self._path(under), hint=hint)
        if event.anchor is not None:
            self._aliases.define(event.anchor, value)
        return value

    def _read_odd_entry(self, event: NodeEvent, node: dict[str, Any]) -> None:
        """Reads an entry whose key is not simply a new string."""
        if isinstance(event, ScalarEvent) and event.value == "<<" and event.implicit[0]:
            self._merges.merge(self._value("<<", event), event, node, self._path("<<"))
            return
        key = self._key(event)
        if key is None:
            self._value(format_scalar(event), event)
            return
        if key in node and not self._merges.brought(key, node):
            self._faults.admit(event)
            self._duplicates.append((event, key, self._path(key)))
            self._value(key, event)
            return
        self._merges.replace(key, node)
        node.setdefault(key, None)  # keeps the position of its first occurrence
        node[key] = self._value(key, event)

    def _key(self, event: NodeEvent) -> str | None:
        """Returns the key of an event; None, reported, if it is not a string."""
        hint = f'quote it: `"{format_scalar(event)}"`'
        line, at = _around(self._faults.lines, event), min(event.start_mark.column, _NEAR)
        if form := _SPREAD_FORM.search(line):
            hint = f"write its numbers in brackets: `{self._path()[-1]}: {{{form[1]}: [{form[2]}]}}`"
        elif spread := next((one for one in _SPREAD_NUMBERS.finditer(line) if one.end() > at), None):
            numbers = ", ".join(spread[2].replace(",", " ").split())
            hint = f"write its numbers in brackets: `{spread[1]}: [{numbers}]`"
        if isinstance(event, AliasEvent):
            key: Any = self._aliases.follow(event, [node for _, node in self._open], self._path())
            if key is None:
                return None
            hint = "write the key itself"
        elif isinstance(event, ScalarEvent):
            try:
                key = scalar_value(event)
            except NodeError as refused:
                self._faults.at(refused.code, refused.message, event, path=self._path(), hint=refused.hint)
                return None
            if event.anchor is not None:
                self._aliases.define(event.anchor, key)
        else:
            key = self._mapping(event, "?") if isinstance(event, MappingStartEvent) else self._list(event, "?")
            hint = "keys must be strings; quote an expression `${…}`"
        if isinstance(key, str):
            if RESERVED_CHARACTER not in key:
                return key
            self._faults.at("SC017", RESERVED_IN_KEY_MESSAGE, event, path=self._path(key))
            return None
        if isinstance(key, int) and not isinstance(key, bool) and has_index_keys(self._path()):
            return str(key)
        self._faults.at("SC005", f"a key is {describe_type(key)}, not a string", event, path=self._path(), hint=hint)
        return None

    def _path(self, under: str | int | None = None) -> KeyPath:
        """Returns the path of a key or index of the innermost open container; its own path for None."""
        path = tuple(key for key, _ in self._open[1:])
        return path if under is None or not self._open else (*path, under)


_DEFAULT_LIMITS = Limits()


def read_file(path: str | PathLike[str], sink: Sink, limits: Limits = _DEFAULT_LIMITS) -> Document | None:
    """Reads a scene file. Returns None, with errors in the sink, if it cannot be read or is invalid."""
    name = fspath(path)
    content = read_bytes(name, sink, limits)
    return None if content is None else read_text(content, name, sink, limits, path=Path(name).absolute())


def read_text(
    text: str | bytes, name: str | None, sink: Sink, limits: Limits = _DEFAULT_LIMITS, path: Path | None = None
) -> Document | None:
    """Reads YAML text; bytes are UTF-8, or UTF-16 with a byte order mark.

    Args:
        text: the whole document.
        name: name for messages.
        sink: collects diagnostics.
        limits: limits of the text's size, depth and aliases.
        path: absolute path of the text's file.
    """
    decoded = decode_text(text, name, sink, limits)
    if decoded is None or not check_value_count(decoded, name, sink, limits):
        return None
    lines = TextLines(name, decoded)
    faults = SourceReporter(lines, sink)
    with collector_paused():
        data = read_yaml(faults, limits)
    if data is None or faults.any:
        return None
    sink.silence(find_yaml_silencings(lines))
    return Document(name, path, data, lines)


def read_value(text: str, sink: Sink) -> Any:
    """Reads a value on one line, as after a key; None, reported, if it is invalid.

    A text that begins with `#` is a string, because a mere comment would be no value.
    """
    text = text.strip()
    if text.startswith("#"):
        return text
    if "\n" in text or "\r" in text:
        sink.report("SC003", "the value has several lines", Location(None), hint="write lists as [a, b]")
        return None
    document = read_text(f"value: {text}", None, sink)
    return None if document is None else document.data["value"]


def read_dict(data: Mapping[str, Any], sink: Sink, limits: Limits = _DEFAULT_LIMITS) -> Document | None:
    """Reads a scene given as Python data, which is copied and never changed.

    Tuples, numpy scalars and arrays, and paths become lists, numbers and strings. Whatever a text could not contain
    (sets, bytes, None, keys that are not strings, other objects) is reported at its path.
    """
    plain = copy_mapping(data, sink, limits)
    return None if plain is None else Document(None, None, plain, None)
