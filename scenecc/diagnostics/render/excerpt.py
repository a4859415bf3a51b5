"""The part of a source line that is shown, and where in it the underline stands.

Columns count characters, a terminal counts cells: CJK and emoji take two, combining marks none, tabs
whatever is left to the next stop.
"""

from __future__ import annotations

from dataclasses import dataclass

from rich.cells import cell_len  # noqa: TID253 - this file is loaded with the text format alone

from scenecc.diagnostics.render.terminal import visible

_TAB = 4
_CUT = "…"


@dataclass(frozen=True, slots=True)
class Excerpt:
    """A source line as shown.

    Attributes:
        shown: printable text, at most the asked width in cells.
        indent: cells before the underline.
        length: cells of the underline, at least 1.
    """

    shown: str
    indent: int
    length: int


def excerpt(text: str, column: int | None, end_column: int | None, *, width: int) -> Excerpt:
    """The part of `text` around [column, end_column) that fits into `width` cells.

    Columns count from 1; one behind the last character underlines the cell after it.
    """
    start = min(max((column or 1) - 1, 0), len(text))
    end = min(max((end_column or 0) - 1, start + 1), len(text))
    first, last = _window(text, start, width)
    head = _CUT if first > 0 else ""
    tail = _CUT if last < len(text) else ""
    before = _cells(head, text[first:start])
    under = _cells(head, text[first : min(end, last)])
    shown = _shown(head, text[first:last]) + tail
    return Excerpt(shown, before, max(under - before, 1))


def _window(text: str, start: int, width: int) -> tuple[int, int]:
    """Indices of what is shown: from the line's start where that fits, else a third ahead of the caret."""
    whole = len(text) <= width and _cells("", text) <= width
    if whole:
        return 0, len(text)
    room = max(width - 2, 1)
    first = 0 if start < room // 2 else start - room // 3
    while first < start and _cells("", text[first:start]) > room // 2:
        first += 1
    last = min(len(text), first + room)
    while last > start + 1 and _cells("", text[first:last]) > room:
        last -= 1
    return first, last


def _cells(head: str, text: str) -> int:
    return cell_len(_shown(head, text))


def _shown(head: str, text: str) -> str:
    """Printable text: tabs as blanks up to the next stop, everything else harmless."""
    first, *rest = text.split("\t")
    line = head + visible(first)
    for part in rest:
        line += " " * (_TAB - cell_len(line) % _TAB) + visible(part)
    return line
