"""The context at a position of a text that may be invalid YAML, from the indentation and brackets before it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Path as KeyPath
    from scenecc.diagnostics.diagnostic import PathKey


class Cursor(NamedTuple):
    """The context of a position in a text.

    Attributes:
        path: path of the node that is typed, or of the mapping for a typed key.
        keys: whether it may be a key of the mapping at `path`.
        values: whether it may be the value at `path`.
        typed: its text before the position, without an opening quote.
        start: the column at which that begins.
        seen: path of each surrounding mapping → its keys before the position, with the texts of scalar values.
    """

    path: KeyPath
    keys: bool
    values: bool
    typed: str
    start: int
    seen: Mapping[KeyPath, Mapping[str, str]]


@dataclass(slots=True)
class _Level:
    """A mapping or list around the position.

    Attributes:
        rank: twice the column of a block mapping, plus one for a list; infinite in brackets.
        step: current key or index; None: the next key of a mapping in braces.
        seen: keys of a mapping.
        closer: the bracket that ends it.
    """

    rank: float
    step: PathKey | None
    seen: dict[str, str] = field(default_factory=dict[str, str])
    closer: str = ""


_TOKEN: Final = re.compile(
    r'"(?:\\.|[^"\\])*"?|' + r"'(?:''|[^'])*'?|[\[\]{},]|:(?=[\s,\[\]{}]|$)|(?:(?<=\s)|^)#.*|\s+|[^\s\[\]{},:\"']+|."
)
"""A token in brackets."""

_BLANKS: Final = re.compile(r"[ \t]*")

_PROPERTY: Final = re.compile(r"(?:[&!][^\s\[\]{},]*[ \t]+)*")
"""Anchors and tags before a node."""

_DEEPEST: Final = 200
"""Maximum nesting depth; no real scene is as deep."""

_BLOCK_TEXT: Final = re.compile(r"[|>][-+0-9]{0,2}[ \t]*(?:#.*)?$")


def cursor_at(lines: list[str], line: int, column: int) -> Cursor:
    """Returns the context at a 0-based position."""
    scan = _Scan()
    for text in lines[:line]:
        if text.strip():  # a blank line ends nothing
            scan.read(text)
    scan.read((lines[line] if line < len(lines) else "")[:column])
    return scan.cursor()


class _Scan:
    """Reads lines in order; the last may end anywhere."""

    def __init__(self) -> None:
        self._levels: list[_Level] = []
        self._block_text: int | None = None
        self._keys = self._values = False
        self._typed, self._start = "", 0

    def cursor(self) -> Cursor:
        """Returns the context at the end of the last line."""
        if len(self._levels) > _DEEPEST:
            return Cursor((), keys=False, values=False, typed="", start=0, seen={})
        seen: dict[KeyPath, Mapping[str, str]] = {}
        path: list[PathKey] = []
        for level in self._levels:
            if level.seen or level.step is None:
                seen[tuple(path)] = level.seen
            if level.step is not None:
                path.append(level.step)
        return Cursor(tuple(path), self._keys, self._values, self._typed, self._start, seen)

    def read(self, text: str) -> None:
        """Reads one line."""
        indent = len(text) - len(text.lstrip(" "))
        is_blank = indent == len(text)
        if self._block_text is not None and (is_blank or indent > self._block_text):
            self._expect(keys=False, values=False)
            return
        self._block_text = None
        if self._levels and self._levels[-1].closer:
            self._read_flow(text, 0)
        elif text.startswith("#", indent) or text.startswith(("---", "...", "%")):
            self._expect(keys=False, values=False)
        else:
            self._read_block(text, indent)

    def _expect(self, *, keys: bool, values: bool, typed: str = "", start: int = 0) -> None:
        self._keys, self._values, self._typed, self._start = keys, values, typed, start

    def _read_block(self, text: str, column: int) -> None:
        in_list = False
        while text.startswith("-", column) and text[column + 1 : column + 2] in {"", " ", "\t"}:
            rank = 2 * column + 1
            known = self._leave(rank)
            number = known.step + 1 if known is not None and isinstance(known.step, int) else 0
            self._levels.append(_Level(rank, number))
            column = _skip(_BLANKS, text, column + 1)
            in_list = True
        column = _skip(_PROPERTY, text, column)
        colon = _find_colon(text, column)
        if colon is not None:
            self._read_entry(text, column, colon)
            return
        known = None if in_list else self._leave(2 * column)
        if known is not None:
            self._levels.append(_Level(2 * column, None, known.seen))
        rest = text[column:]
        if rest[:1] in {"[", "{"}:
            self._read_flow(text, column)
        else:
            typed, start = _unquoted(rest, column)
            self._expect(keys=True, values=True, typed=typed, start=start)

    def _read_entry(self, text: str, column: int, colon: int) -> None:
        """Reads a key of a block mapping, and the rest of its line."""
        known = self._leave(2 * column)
        key = _unquoted(text[column:colon].rstrip(), column)[0]
        level = _Level(2 * column, key, {} if known is None else known.seen)
        self._levels.append(level)
        start = _skip(_PROPERTY, text, _skip(_BLANKS, text, colon + 1))
        rest = text[start:]
        level.seen[key] = ""
        if rest[:1] in {"[", "{"}:
            self._read_flow(text, start)
        elif _BLOCK_TEXT.match(rest):
            self._block_text = column
            self._expect(keys=False, values=False)
        elif rest.startswith("#"):
            self._expect(keys=False, values=False)
        else:
            typed, at = _unquoted(rest, start)
            level.seen[key] = typed.partition(" #")[0].strip()
            self._expect(keys=False, values=" #" not in typed, typed=typed, start=at)

    def _leave(self, rank: float) -> _Level | None:
        """Closes the levels that do not contain a node of a rank. Returns the level of this rank, if there was one."""
        left: _Level | None = None
        while self._levels and self._levels[-1].rank >= rank:
            left = self._levels.pop()
        return left if left is not None and left.rank == rank else None

    def _read_flow(self, text: str, column: int) -> None:
        """Reads text in brackets, up to their end or the end of the line."""
        typed, start = "", len(text)
        for match in _TOKEN.finditer(text, column):
            part = match[0]
            level = self._levels[-1] if self._levels and self._levels[-1].closer else None
            if part in {"[", "{"}:
                self._levels.append(_Level(inf, 0, closer="]") if part == "[" else _Level(inf, None, closer="}"))
            elif level is None:
                self._expect(keys=False, values=False)
                return
            elif part in {"]", "}"}:
                self._levels.pop()
            elif part == ",":
                _next_item(level, typed)
            elif part == ":" and level.closer == "}" and level.step is None:
                level.step = _unquoted(typed.rstrip(), 0)[0]
                level.seen[level.step] = ""
            elif not part.startswith("#") or typed:
                start = start if typed else match.end() if part.isspace() else match.start()
                typed = text[start : match.end()]
                continue
            typed, start = "", len(text)
        level = self._levels[-1] if self._levels and self._levels[-1].closer else None
        shown, at = _unquoted(typed, start)
        is_key = level is not None and level.closer == "}" and level.step is None
        self._expect(keys=is_key, values=level is not None and not is_key, typed=shown, start=at)


def _next_item(level: _Level, typed: str) -> None:
    """Moves a level to its next item at a comma."""
    if isinstance(level.step, int):
        level.step += 1
    else:
        if level.step is not None:
            level.seen[level.step] = _unquoted(typed.strip(), 0)[0]
        level.step = None


def _unquoted(text: str, column: int) -> tuple[str, int]:
    """Returns a scalar, or its beginning, without quotes, and the column of its first character."""
    quote = text[:1]
    if quote not in {'"', "'"}:
        return text, column
    body = text[1:]
    end = body.find(quote)
    return (body if end < 0 else body[:end]), column + 1


def _skip(pattern: re.Pattern[str], text: str, column: int) -> int:
    """Returns the column after a pattern's match."""
    found = pattern.match(text, column)
    return found.end() if found else column


def _find_colon(text: str, column: int) -> int | None:
    """Returns the column of the colon that ends a block key."""
    quote = text[column : column + 1]
    if quote in {"[", "{", "#"}:
        return None
    if quote in {'"', "'"}:
        end = text.find(quote, column + 1)
        if end < 0:
            return None
        after = _skip(_BLANKS, text, end + 1)
        return after if text.startswith(":", after) and text[after + 1 : after + 2] in {"", " ", "\t"} else None
    at = text.find(":", column)
    while at >= 0 and text[at + 1 : at + 2] not in {"", " ", "\t"}:
        at = text.find(":", at + 1)
    return at if at > column and " #" not in text[column:at] else None
