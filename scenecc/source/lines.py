"""The lines of a text, split only when a place in it is shown."""

from __future__ import annotations

from functools import cached_property

from scenecc.diagnostics import Location


class Lines:
    """A named text whose places can be shown.

    Attributes:
        file: name of the document as shown to people.
        text: what was read, without a byte order mark.
    """

    def __init__(self, file: str | None, text: str) -> None:
        self.file = file
        self.text = text
        self._split: list[str] = []

    @cached_property
    def _unified(self) -> str:
        return _unified(self.text)

    def line(self, line: int) -> str:
        """The text of a 0-based line; "" past the end."""
        if line >= len(self._split):
            # One line more than is asked for, since the last part is the rest of the text; and twice as
            # many, so that questions about each line in turn cost no more than one about the last.
            self._split = self._unified.split("\n", 2 * line + 100)
            if len(self._split) == 2 * line + 101:
                del self._split[-1]
        return self._split[line] if line < len(self._split) else ""

    def is_last(self, line: int) -> bool:
        """Whether nothing but blanks comes after a 0-based line."""
        parts = self._unified.split("\n", line + 1)
        return len(parts) <= line + 1 or not parts[-1].strip()

    def is_past(self, line: int) -> bool:
        """Whether a 0-based line is none of the text's."""
        return line > self._unified.count("\n")

    def location(self, line: int, column: int, end_column: int | None = None) -> Location:
        """The place of 0-based columns `column` to `end_column` (excluded; None: the line's end) of a 0-based line.

        At least one character is underlined, and never one past the end of the line but the first.
        """
        text = self.line(line)
        end = len(text.rstrip()) if end_column is None else min(end_column, len(text))
        return Location(self.file, line + 1, column + 1, max(end, column + 1) + 1, text)

    def position(self, offset: int) -> tuple[int, int]:
        """The 0-based line and column of a 0-based offset into the text."""
        before = self.text[:offset]
        if before.endswith("\r") and self.text.startswith("\n", offset):
            before = before[:-1]
        before = _unified(before)
        return before.count("\n"), len(before) - (before.rfind("\n") + 1)


def _unified(text: str) -> str:
    """The text with every line break a line feed: the parser's line breaks, fewer than `str.splitlines` has."""
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text
