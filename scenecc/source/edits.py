"""Edits of a YAML text at the positions of its nodes. All other characters, including comments, are kept."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, Literal

from yaml.events import AliasEvent, MappingEndEvent, MappingStartEvent, ScalarEvent, SequenceEndEvent

from scenecc.source.events import NextEvent, NodeEvent, next_event

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Path

Style = Literal["any", "block", "flow", "json"]
"""How a value is to be written: as it fits, on lines of its own, in brackets, or as JSON."""

Write = Callable[[int, Style], "str | Sequence[str]"]
"""Returns a value as one text, or as lines indented to a column. Called with the column and the style."""

_BLANK: Final = re.compile(r"(?:[ \t\r\n]|(?<![^ \t\r\n,\[{])#[^\r\n]*)*")
"""Blanks, line breaks and comments between two tokens."""

_PROPERTIES: Final = re.compile(r"(?:[&!]\S*(?:[ \t\r\n]+|$))*")
"""An anchor and a tag before a value."""

_COMMENT_LINE: Final = re.compile(r"[ \t]*#[^\r\n]*(?:\r\n|\r|\n|$)")

_BREAK: Final = re.compile(r"\r\n|\r|\n")


class EditError(Exception):
    """A place in a text cannot be edited; the message gives the reason."""


class _Node:
    """A node of a text.

    Attributes:
        start, end: offsets of its first character and after its last one, without what follows a block.
        line, column: 0-based place of its start.
        text: the value of a scalar; None for others.
        entries: keys and values of a mapping, or None and the items of a list; None for others.
        is_list, is_flow, is_alias: its kind. A block scalar is neither flow nor a collection.
    """

    __slots__ = ("column", "end", "entries", "is_alias", "is_flow", "is_list", "line", "start", "text")

    def __init__(self, event: NodeEvent) -> None:
        self.start, self.end = event.start_mark.index, event.end_mark.index
        self.line, self.column = event.start_mark.line, event.start_mark.column
        self.is_alias = isinstance(event, AliasEvent)
        self.is_list = not isinstance(event, MappingStartEvent)
        self.text = event.value if isinstance(event, ScalarEvent) else None
        style = getattr(event, "style", None)
        self.is_flow = style not in {"|", ">"} if self.is_scalar else bool(event.flow_style)
        self.entries: list[tuple[_Node | None, _Node]] = []

    @property
    def is_scalar(self) -> bool:
        """Whether it is a scalar or an alias."""
        return self.is_alias or self.text is not None

    @property
    def is_block(self) -> bool:
        """Whether it is a list or mapping without brackets."""
        return not self.is_flow and not self.is_scalar


def _read_node(event: NodeEvent, get: NextEvent) -> _Node:
    """Returns the node that starts with an event, and all below it."""
    node = _Node(event)
    if node.is_scalar:
        return node
    while not isinstance(event := get(), (MappingEndEvent, SequenceEndEvent)):
        first = _read_node(event, get)
        node.entries.append((None, first) if node.is_list else (first, _read_node(get(), get)))
    # The end mark of a block is after the comments below it.
    node.end = node.entries[-1][1].end if node.is_block and node.entries else event.end_mark.index
    return node


class TextEdits:
    """Edits of one text, which are applied together.

    Attributes:
        step: number of blanks by which the text indents.
    """

    def __init__(self, text: str) -> None:
        """`text`: valid YAML."""
        self._text = text
        get = next_event(text)
        get()  # the start of the stream
        get()  # the start of the document
        self._root = _read_node(get(), get)
        self._splices: list[tuple[int, int, str]] = []
        found = _BREAK.search(text)
        self._break = found[0] if found else "\n"
        inner = [one for _, one in self._root.entries if one.is_block and not one.is_list]
        columns = [one.entries[0][0].column for one in inner if one.entries[0][0]]
        self.step: int = columns[0] if columns and not self._root.is_flow else 2

    def rename(self, path: Path, key: str) -> None:
        """Replaces a key by another, as YAML text. Raises EditError if it is not written there."""
        place, _ = self._entry(self._find(path[:-1]), path[-1])
        assert place is not None, "only mappings have keys"
        self._splice(place.start, place.end, key)

    def insert(self, path: Path, step: str | int, key: str, write: Write) -> None:
        """Inserts an entry at the end of a mapping, or an item of a list before the one with this index.

        Args:
            path: the mapping or list.
            step: the key; or an index, from 0 to the number of items.
            key: the key as YAML text.
            write: returns the value.

        Raises:
            EditError: it is written in another place.
        """
        node = self._find(path)
        if node.is_scalar:
            raise EditError(f"`{path[-1]}` is written elsewhere, at an anchor")
        if not node.entries:
            self._fill(path, node, key, write)
        elif node.is_flow:
            self._insert_in_brackets(node, step, key, write)
        elif node.is_list and step == 0:
            dash = self._dash(node, 0)
            column = self._column(dash)
            self._splice(dash, dash, self._item(column, write) + self._break + " " * column)
        else:
            count = len(node.entries)
            before = step - 1 if isinstance(step, int) and node.is_list else count - 1
            place = self._after(node.entries[before][1])
            if node.is_list:
                column = self._column(self._dash(node, 0))
                text = " " * column + self._item(column, write)
            else:
                column = (node.entries[0][0] or node).column
                text = " " * column + self._value(key + ":", column, self._style(node), write)
            while before == count - 1 and (comment := _COMMENT_LINE.match(self._text, place)):
                if len(comment[0]) - len(comment[0].lstrip()) < column or not comment[0].strip():
                    break
                place = comment.end()
            self._splice_lines(place, self._break * self._is_spaced(node) + text)

    def replace(self, path: Path, write: Write) -> None:
        """Replaces a value; comments beside and around it stay.

        Raises:
            EditError: it is not written there.
        """
        if not path:
            raise EditError("the whole document cannot be replaced")
        above = self._find(path[:-1])
        key, node = self._entry(above, path[-1])
        if above.is_flow:
            self._splice(node.start, node.end, _one(write(0, self._style(above, flow=True))))
            return
        if key is None:
            place = self._dash(above, int(path[-1])) + 1
            column = self._column(place - 1) + 2
        else:
            place = self._skip(_BLANK, key.end) + 1
            column = key.column + self.step
        own = node.is_block and not self._is_inline(node, place)
        # Lists may be at the column of their key, other blocks not.
        column = node.column if own and (key is None or node.column > key.column) else column
        new = write(column, "block" if node.is_block else "any")
        if isinstance(new, str):
            self._replace_inline(node, place, new, own=own)
        elif own:
            self._splice(self._line_start(node.start), self._after(node), self._joined(new, self._after(node)))
        elif key is None:
            end = self._break * self._ends_line(node)
            self._splice(node.start, node.end, self._break.join(new).lstrip(" ") + end)
        elif not node.is_flow:
            self._splice(place, self._after(node), self._break + self._joined(new, self._after(node)))
        else:
            self._splice(place, node.end, "")
            self._splice_lines(self._after(node), self._break.join(new))

    def remove(self, path: Path) -> None:
        """Removes an entry or item with the rest of its lines. Comments above and below it stay.

        Raises:
            EditError: it is not written there.
        """
        above = self._find(path[:-1])
        key, node = self._entry(above, path[-1])
        number = next(index for index, (_, one) in enumerate(above.entries) if one is node)
        if len(above.entries) == 1:
            empty = "[]" if above.is_list else "{}"
            if above.is_flow:
                self._splice(above.start, above.end, empty)
            else:
                self.replace(path[:-1], as_is(empty))
        elif above.is_flow:
            self._remove_in_brackets(above, number)
        else:
            start = self._dash(above, number) if key is None else key.start
            if not self._text[self._line_start(start) : start].strip(" "):
                self._splice(self._line_start(start), self._after(node), "")
                return
            # It shares its line with a dash; the next entry takes its place.
            following = above.entries[number + 1]
            then = self._dash(above, number + 1) if key is None else (following[0] or key).start
            between = self._text[self._after(node) : then]
            self._splice(start, self._after(node) - len(self._break) if between.strip() else then, "")

    def result(self) -> str:
        """Returns the text with all edits."""
        text = self._text
        for start, end, new in sorted(self._splices, reverse=True):
            text = text[:start] + new + text[end:]
        return text

    def has(self, path: Path) -> bool:
        """Returns whether a key or an item is written there; not if it comes from a merge key."""
        node = self._find(path[:-1])
        return node.is_list or any(key is not None and key.text == path[-1] for key, _ in node.entries)

    def source(self, path: Path) -> Write | None:
        """Returns a function that writes a value as it is written at a path; None if it is an alias."""
        node = self._find(path)
        if node.is_alias or self._skip(_PROPERTIES, node.start) > node.start:
            return None
        if not node.is_block:
            inline = self._text[node.start : node.end]
            return None if _BREAK.search(inline) else as_is(inline)
        key = self._entry(self._find(path[:-1]), path[-1])[0] if path else None
        if key is None or self._is_inline(node, key.end):
            lines = _BREAK.split(" " * node.column + self._text[node.start : node.end])
        else:  # with the comments above the first entry
            lines = _BREAK.split(self._text[self._next_line(key.end) : node.end])

        def write(column: int, style: Style) -> Sequence[str]:
            if style in {"flow", "json"}:
                raise EditError("a block cannot be written in brackets")
            shifts = (min(len(line) - len(line.lstrip(" ")), node.column) for line in lines)
            moved = (line[shift:] for line, shift in zip(lines, shifts, strict=True))
            return [" " * column + line if line.strip() else "" for line in moved]

        return write

    def _fill(self, path: Path, node: _Node, key: str, write: Write) -> None:
        """Writes the first entry of an empty mapping or list."""
        above = self._find(path[:-1]) if path else node

        def written(column: int, style: Style) -> str | Sequence[str]:
            value = write(column + (2 if node.is_list else self.step), style)
            if isinstance(value, str):
                one = value if node.is_list else f"{key}: {value}"
                return f"[{one}]" if node.is_list else f"{{{one}}}"
            head = f"{' ' * column}- " if node.is_list else f"{' ' * column}{key}:"
            return [head + value[0].lstrip(), *value[1:]] if node.is_list else [head, *value]

        if above.is_flow or not path:
            style = self._style(above, flow=True) if path else "flow"
            self._splice(node.start, node.end, _one(written(0, style)))
        else:
            self.replace(path, written)

    def _insert_in_brackets(self, node: _Node, step: str | int, key: str, write: Write) -> None:
        style = self._style(node, flow=True)
        value = _one(write(0, style))
        text = value if node.is_list else f"{json.dumps(step) if style == 'json' else key}: {value}"
        if node.is_list and isinstance(step, int) and step < len(node.entries):
            start = node.entries[step][1].start
            self._splice(start, start, f"{text}, ")
        else:
            last = node.entries[-1][1].end
            self._splice(last, last, f", {text}")

    def _remove_in_brackets(self, above: _Node, number: int) -> None:
        key, node = above.entries[number]
        start = (key or node).start
        comma = self._comma(node.end)
        if comma is not None:
            end = comma + 1
            line = self._line_start(start)
            rest = self._text[end : self._line_end(end)]
            if not self._text[line:start].strip() and (not rest.strip() or rest.lstrip().startswith("#")):
                self._splice(line, self._next_line(end), "")
                return
            while self._text[end : end + 1] == " ":
                end += 1
            self._splice(start, end, " " if self._text[end : end + 1] == "#" else "")
            return
        before = self._comma(above.entries[number - 1][1].end)
        assert before is not None, "a comma is between two items"
        if self._text[before + 1 : start].strip():  # a comment is between them
            self._splice(before, before + 1, "")
            self._splice(start, node.end, "")
        else:
            self._splice(before, node.end, "")

    def _comma(self, place: int) -> int | None:
        """Returns the offset of the comma after an item; None if the bracket closes."""
        end = self._skip(_BLANK, place)
        return end if self._text[end : end + 1] == "," else None

    def _replace_inline(self, node: _Node, place: int, new: str, *, own: bool) -> None:
        if not own:
            blank = " " * (self._text[place : node.start] == "")
            end = self._break * (self._ends_line(node) and node.end > node.start)
            self._splice(node.start, node.end, blank + new + end)
        else:
            self._splice(place, place, f" {new}")
            self._splice(self._line_start(node.start), self._after(node), "")

    def _is_inline(self, node: _Node, place: int) -> bool:
        """Returns whether a value begins on the line of its key or dash."""
        return not _BREAK.search(self._text, place, node.start)

    def _item(self, column: int, write: Write) -> str:
        value = write(column + 2, "any")
        return f"- {value}" if isinstance(value, str) else "- " + self._break.join(value).lstrip(" ")

    def _value(self, head: str, column: int, style: Style, write: Write) -> str:
        value = write(column + self.step, style)
        return f"{head} {value}" if isinstance(value, str) else self._break.join([head, *value])

    def _style(self, node: _Node, *, flow: bool = False) -> Style:
        """Returns the style for a new value in a mapping or list: that of its neighbours."""
        if flow:
            keys = [key for key, _ in node.entries if key is not None] or [one for _, one in node.entries]
            return "json" if keys and all(self._text[one.start] == '"' for one in keys) and not node.is_list else "flow"
        return "block" if any(one.is_block and not one.is_list for _, one in node.entries) else "any"

    def _is_spaced(self, node: _Node) -> bool:
        """Returns whether a blank line is before the last entry of a mapping."""
        if node.is_list or len(node.entries) < 2 or (key := node.entries[-1][0]) is None:
            return False
        between = self._text[self._after(node.entries[-2][1]) : key.start]
        return any(not line.strip() for line in _BREAK.split(between)[:-1])

    def _dash(self, node: _Node, number: int) -> int:
        """Returns the offset of the dash of an item."""
        before = node.entries[number - 1][1].end if number else self._skip(_PROPERTIES, node.start)
        return self._skip(_BLANK, before)

    def _skip(self, pattern: re.Pattern[str], place: int) -> int:
        """Returns the offset after what a pattern matches."""
        found = pattern.match(self._text, place)
        return found.end() if found else place

    def _after(self, node: _Node) -> int:
        """Returns the offset of the line after a node."""
        return node.end if self._ends_line(node) else self._next_line(node.end)

    def _ends_line(self, node: _Node) -> bool:
        """Returns whether a node, such as a block scalar, contains the break of its last line."""
        return self._text[node.end - 1 : node.end] in {"\n", "\r"}

    def _line_start(self, place: int) -> int:
        return max(self._text.rfind("\n", 0, place), self._text.rfind("\r", 0, place)) + 1

    def _line_end(self, place: int) -> int:
        found = _BREAK.search(self._text, place)
        return found.start() if found else len(self._text)

    def _next_line(self, place: int) -> int:
        found = _BREAK.search(self._text, place)
        return found.end() if found else len(self._text)

    def _column(self, place: int) -> int:
        return place - self._line_start(place)

    def _joined(self, lines: Sequence[str], place: int) -> str:
        """Returns lines that replace those before a place, whose last may have no break."""
        is_last = self._text[place - 1 : place] not in {"\n", "\r"}
        return self._break.join(lines) + self._break * (not is_last)

    def _splice_lines(self, place: int, text: str) -> None:
        """Inserts lines at the start of a line, or after a last line without a break."""
        if place and self._text[place - 1] not in "\r\n":
            self._splice(place, place, self._break + text)
        else:
            self._splice(place, place, text + self._break)

    def _splice(self, start: int, end: int, new: str) -> None:
        self._splices.append((start, end, new))

    def _find(self, path: Path) -> _Node:
        node = self._root
        for step in path:
            if node.is_alias:
                raise EditError(f"`{step}` is written elsewhere, at an anchor")
            _, node = self._entry(node, step)
        return node

    def _entry(self, node: _Node, step: str | int) -> tuple[_Node | None, _Node]:
        """Returns the key and the value of an entry, or None and an item."""
        if node.is_alias:
            raise EditError(f"`{step}` is written elsewhere, at an anchor")
        if node.is_list and isinstance(step, int) and step < len(node.entries):
            return node.entries[step]
        found = [entry for entry in node.entries if entry[0] is not None and entry[0].text == step]
        if not found:
            raise EditError(f"`{step}` is not written there: it comes from a merge key or a prefab")
        return found[0]


def text_diff(before: str, after: str, name: str) -> str:
    """Returns the change of a text in the format of `diff -u`; "" if there is none."""
    old, new = (re.findall(r"[^\n]*\n|[^\n]+", text) for text in (before, after))
    diff = difflib.unified_diff(old, new, name, name)
    return "".join(line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in diff)


def as_is(text: str) -> Write:
    """Returns a function that writes a text, whatever the place."""

    def write(column: int, style: Style) -> str:
        del column, style
        return text

    return write


def _one(value: str | Sequence[str]) -> str:
    """Returns a value in brackets. Raises EditError if it has lines."""
    if not isinstance(value, str):
        raise EditError("a block cannot be written in brackets")
    return value
