"""A part of a scalar's text, as a place in the line where the scalar is written."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.diagnostics.origin import Location

Span = tuple[int, int]
"""The first character and the one after the last, in the value of a scalar."""

_BEFORE = re.compile(r"(?:[&!]\S*\s+)*")
"""An anchor and a tag, in front of the scalar itself."""

_CHARACTER = {
    '"': re.compile(r"\\x..|\\u.{4}|\\U.{8}|\\.|[^\"\\]"),
    "'": re.compile(r"''|[^']"),
    "": re.compile(r"."),
}
"""What stands for one character: in double quotes, in single quotes, and in plain text."""


def within(location: Location, span: Span) -> Location:
    """The place of a part of a scalar; the scalar's own where the part does not begin on its first line.

    Args:
        location: of the scalar.
        span: the part.
    """
    if location.column is None or location.text is None:
        return location
    start = location.column - 1
    end = len(location.text) if location.end_column is None else location.end_column - 1
    match = _BEFORE.match(location.text, start, end)
    start = match.end() if match else start
    first = location.text[start : start + 1]
    if first in {"|", ">"}:
        return location
    style = first if first in {'"', "'"} else ""
    columns = [found.start() for found in _CHARACTER[style].finditer(location.text, start + len(style), end)]
    if span[0] >= len(columns):
        return location
    last = columns[min(span[1], len(columns)) - 1] + 1 if span[1] > span[0] else columns[span[0]] + 1
    return replace(location, column=columns[span[0]] + 1, end_column=last + 1)
