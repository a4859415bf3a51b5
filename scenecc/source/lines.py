"""The lines of a text, split only when a place in it is shown."""

from __future__ import annotations

import re
from functools import cached_property

from scenecc.diagnostics import Location

_BREAK = re.compile(r"\r\n|\r|\n")


class Lines:
    """A named text whose places can be shown.

    Attributes:
        file: name of the document as shown to people.
        text: what was read, without a byte order mark.
    """

    def __init__(self, file: str | None, text: str) -> None:
        self.file = file
        self.text = text

    @cached_property
    def _lines(self) -> list[str]:
        # The parser's own idea of a line break; str.splitlines() breaks at more characters.
        return _BREAK.split(self.text)

    def line(self, line: int) -> str:
        """The text of a 0-based line; "" past the end."""
        return self._lines[line] if 0 <= line < len(self._lines) else ""

    def is_last(self, line: int) -> bool:
        """Whether nothing but blanks comes after a 0-based line."""
        return not any(text.strip() for text in self._lines[line + 1 :])

    def location(self, line: int, column: int, end_column: int | None = None) -> Location:
        """The place of 0-based columns `column` to `end_column` (excluded; None: the line's end) of a 0-based line.

        At least one character is underlined, and never one past the end of the line but the first.
        """
        text = self.line(line)
        end = len(text.rstrip()) if end_column is None else min(end_column, len(text))
        return Location(self.file, line + 1, column + 1, max(end, column + 1) + 1, text)

    def position(self, offset: int) -> tuple[int, int]:
        """The 0-based line and column of a 0-based offset into the text."""
        line = start = 0
        for match in _BREAK.finditer(self.text, 0, offset):
            if match.end() > offset:
                break
            line, start = line + 1, match.end()
        return line, offset - start
