"""A fast line-based reader for the plain YAML subset that long scene files use.

PyYAML's parser creates four objects per scalar and bracket, which takes six times as long as the parsing itself. This
reader supports one notation for each thing: comments, indented mappings and lists, `key: value`, `- value`, `- key:
value`, and values on one line. It declines all other text, which goes to the parser. For accepted text, the parser
would give the same data without an error. The parser reports all errors.
"""

from __future__ import annotations

import re
from typing import Any

from scenecc.source.events import PlainKeys, PlainValues

_KEY = r"[A-Za-z_][A-Za-z0-9_./-]{0,99}"

_FIRST = r"(?:[A-Za-z0-9_./+]|-(?=[A-Za-z0-9_./+-]))"

_WITHIN = r"[A-Za-z0-9_./+%*()=$@^~-]|:(?=[A-Za-z0-9_/])"

_WORD = rf"{_FIRST}(?:{_WITHIN})*"
"""A plain scalar without blanks, valid both inside and outside brackets."""

_TEXT = rf"{_FIRST}(?:{_WITHIN}|[,;']| (?=[A-Za-z0-9_./+%*()=$@^~,;'-]))*"
"""A plain scalar outside brackets: words separated by single blanks."""

_NOT_PRINTED = r"\x00-\x1f\x7f-\x9f"

_DOUBLE = rf'"([^"\\{_NOT_PRINTED}]*)"'

_SINGLE = rf"'([^'{_NOT_PRINTED}]*)'"

_TAIL = rf" *(?:(?<![^ ])#[^{_NOT_PRINTED}]*)?"

_UNUSUAL_CHARACTER = "[\u2028\u2029\ud800-\udfff\ufeff-\uffff]"
"""Unprintable characters, and characters that end a line only for the parser. Searched in the whole text, and only if
it is not ASCII: inside the patterns, they would take milliseconds to compile."""

_LINE = re.compile(
    rf"( *)(- +)?(?:({_KEY}):(?: +|$))?(?:(?:({_TEXT})|{_DOUBLE}|{_SINGLE})?{_TAIL}|([\[{{][^{_NOT_PRINTED}]*))"
).fullmatch

_DECIMAL = r"-?[0-9]{1,20}\.[0-9]{1,20}"

_DECIMALS = re.compile(rf"\[ *({_DECIMAL}(?: *, *{_DECIMAL})*) *\]{_TAIL}").fullmatch

_WORDS = re.compile(rf"\[ *({_WORD}(?: *, *{_WORD})*) *\]{_TAIL}").fullmatch

_TOKEN = re.compile(rf" *(?:([\[\]{{}},])|({_KEY}): +|({_WORD})|{_DOUBLE}|{_SINGLE})").match

_REST = re.compile(_TAIL).fullmatch

_KEY_TOKEN, _WORD_TOKEN = 2, 3

_Line = tuple[int, int, "str | None", Any]
"""Column of the dash or else of the key, column of the key, the key, the value: None if the line has none."""

_MAX_LINE = 1000

_MAX_LINES = 1_000_000
"""Text with longer or more lines, which nobody writes by hand, costs the parser less."""

_KEPT_LINES = 10_000
"""Cached lines. Repeated lines such as `shapes:` and `- type: box` come early; others would only use memory.
"""

_FLOW_DEPTH = 8
"""Maximum nesting of brackets. Deeper text is for the parser, as are the last levels below the depth limit."""


class _UnsupportedSyntax(Exception):
    """The text is for the parser."""


def read_fast(text: str, depth: int) -> dict[str, Any] | None:
    """Returns the mapping of a text; None if this reader does not support it, which does not mean that it is invalid.

    Args:
        text: the text, without a byte order mark.
        depth: maximum nesting of mappings and lists.
    """
    try:
        return _read(text, depth - _FLOW_DEPTH)
    except _UnsupportedSyntax:
        return None


def _read(text: str, depth: int) -> dict[str, Any]:
    if text.count("\n") > _MAX_LINES or (not text.isascii() and re.search(_UNUSUAL_CHARACTER, text)):
        raise _UnsupportedSyntax
    parse = _LineParser()
    top: Any = {}
    # The open containers with the columns of their entries. A list may begin in the column of the surrounding mapping;
    # all other content begins further right.
    open_: list[Any] = [top]
    columns = [0]
    waiting: str | None = None  # the key whose value begins on the next line
    for line in text.split("\n"):
        parsed = parse[line]
        if parsed is None:
            continue
        column, inner, key, value = parsed
        kind: Any = dict if inner == column else list
        if waiting is not None:
            if column < columns[-1] + (kind is dict):
                raise _UnsupportedSyntax
            new = kind()
            top[waiting] = new
            top, waiting = new, None
            open_.append(top)
            columns.append(column)
        elif columns[-1] != column or type(top) is not kind:
            top = _close_containers(open_, columns, column, kind)
        if kind is list:
            if key is None:
                top.append(value)
                continue
            new = {}
            top.append(new)
            top = new
            open_.append(top)
            columns.append(inner)
        if key in top or len(open_) > depth:
            raise _UnsupportedSyntax
        if value is None:
            waiting = key
        else:
            top[key] = value
    if waiting is not None or not open_[0]:
        raise _UnsupportedSyntax
    return open_[0]


def _close_containers(open_: list[Any], columns: list[int], column: int, kind: type) -> Any:
    """Closes the containers that end above a line, and returns the one that continues."""
    while columns and (columns[-1] > column or (columns[-1] == column and type(open_[-1]) is not kind)):
        columns.pop()
        open_.pop()
    if not columns or columns[-1] != column:
        raise _UnsupportedSyntax
    return open_[-1]


class _LineParser(dict[str, "_Line | None"]):
    """A line → its content; None for a blank line or comment."""

    def __init__(self) -> None:
        self._keys = PlainKeys()
        self._plain = PlainValues()

    def __missing__(self, line: str) -> _Line | None:
        """Reads a line.

        Raises:
            _UnsupportedSyntax: the line is not plain.
        """
        match = _LINE(line) if len(line) <= _MAX_LINE else None
        if match is None:
            raise _UnsupportedSyntax
        blanks, dash, key, text, double, single, brackets = match.groups()
        value = self._plain[text] if text is not None else double if double is not None else single
        if brackets is not None:
            value = self._read_brackets(brackets)
        if key is None and value is None:
            if dash or text is not None:
                raise _UnsupportedSyntax
            self[line] = None
            return None
        if (key is None and not dash) or (key is not None and self._keys[key] is None) or (text and value is None):
            raise _UnsupportedSyntax
        column = len(blanks)
        said = (column, column + len(dash or ""), key, value)
        if brackets is None and len(self) < _KEPT_LINES:  # lines with brackets would share one list
            self[line] = said
        return said

    def _read_brackets(self, text: str) -> Any:
        decimals = _DECIMALS(text)
        if decimals is not None:
            return list(map(float, decimals[1].split(",")))
        words = _WORDS(text)
        if words is None:
            value, end = self._value(text, 0, _FLOW_DEPTH)
            if _REST(text, end) is None:
                raise _UnsupportedSyntax
            return value
        plain = self._plain
        value = [plain[word] for word in words[1].replace(" ", "").split(",")]
        if None in value:
            raise _UnsupportedSyntax
        return value

    def _value(self, text: str, start: int, depth: int) -> tuple[Any, int]:
        """Returns the value at an offset, and the offset of its end."""
        token = _TOKEN(text, start)
        if token is None:
            raise _UnsupportedSyntax
        kind, end = token.lastindex, token.end()
        if kind == _WORD_TOKEN:
            value = self._plain[token[kind]]
            if value is None:
                raise _UnsupportedSyntax
            return value, end
        if kind == _KEY_TOKEN or kind is None:
            raise _UnsupportedSyntax
        if token[1] is None:
            return token[kind], end
        if not depth:
            raise _UnsupportedSyntax
        if token[1] == "[":
            return self._list(text, end, depth - 1)
        if token[1] == "{":
            return self._mapping(text, end, depth - 1)
        raise _UnsupportedSyntax

    def _list(self, text: str, start: int, depth: int) -> tuple[list[Any], int]:
        node: list[Any] = []
        mark, end = _match_closing(text, start, "]") or (",", start)
        while mark == ",":
            value, end = self._value(text, end, depth)
            node.append(value)
            mark, end = _find_mark(text, end)
        if mark != "]":
            raise _UnsupportedSyntax
        return node, end

    def _mapping(self, text: str, start: int, depth: int) -> tuple[dict[str, Any], int]:
        node: dict[str, Any] = {}
        mark, end = _match_closing(text, start, "}") or (",", start)
        while mark == ",":
            token = _TOKEN(text, end)
            key = token and token[_KEY_TOKEN]
            if not token or not key or key in node or self._keys[key] is None:
                raise _UnsupportedSyntax
            node[key], end = self._value(text, token.end(), depth)
            mark, end = _find_mark(text, end)
        if mark != "}":
            raise _UnsupportedSyntax
        return node, end


def _match_closing(text: str, start: int, bracket: str) -> tuple[str, int] | None:
    """Returns the bracket that closes an empty pair, and the offset after it; None if the pair is not empty."""
    token = _TOKEN(text, start)
    return (bracket, token.end()) if token is not None and token[1] == bracket else None


def _find_mark(text: str, start: int) -> tuple[str | None, int]:
    """Returns the next comma or bracket, and the offset after it."""
    token = _TOKEN(text, start)
    if token is None:
        raise _UnsupportedSyntax
    return token[1], token.end()
