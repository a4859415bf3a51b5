"""Positions in the protocol: columns in the units of an encoding, UTF-16 unless negotiated otherwise."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final
from urllib.parse import unquote, urlsplit

from lsprotocol import types

if TYPE_CHECKING:
    from scenecc.lsp.analysis import SceneText

_LAST: Final = 2**31 - 1
"""The largest number that the protocol allows."""


class Columns:
    """Converts columns between characters and the client's units.

    Args:
        encoding: `utf-8`, `utf-16` or `utf-32`.
    """

    def __init__(self, encoding: str = "utf-16") -> None:
        self._encoding = f"{encoding}-le" if encoding != "utf-8" else encoding
        self._size = {"utf-8": 1, "utf-16": 2, "utf-32": 4}[encoding]

    def to_client(self, line: str, column: int) -> int:
        """Returns the number of units before a column [characters] of a line."""
        before = line[:column]
        return len(before) if before.isascii() else len(before.encode(self._encoding, "surrogatepass")) // self._size

    def from_client(self, line: str, units: int) -> int:
        """Returns the column [characters] after `units` units, or the end of a shorter line."""
        if line.isascii():
            return min(max(units, 0), len(line))
        passed = 0
        for column, character in enumerate(line):
            if passed >= units:
                return column
            passed += self.to_client(character, 1)
        return len(line)

    def range(self, text: SceneText, line: int, start: int, end: int | None) -> types.Range:
        """Returns the range of a part of a 0-based line. `end`: None: to the end of the line."""
        shown = text.line(line)
        stop = len(shown) if end is None else end
        return types.Range(
            types.Position(line, self.to_client(shown, start)), types.Position(line, self.to_client(shown, stop))
        )

    def place(self, text: SceneText, position: types.Position) -> tuple[int, int]:
        """Returns the 0-based line and column [characters] of a client's position."""
        line = min(position.line, _LAST)
        return line, self.from_client(text.line(line), position.character)


def path_of(uri: str) -> str | None:
    """Returns the path of a `file:` URI; None for anything else."""
    try:
        parts = urlsplit(uri)
    except ValueError:
        return None
    return unquote(parts.path) if parts.scheme == "file" and parts.path else None
