"""The `text` format for terminals: location, message, the source line with the place underlined, and the hint."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from rich.cells import cell_len

from scenecc.diagnostics.formats.style import Style, unchecked, unchecked_text, visible

if TYPE_CHECKING:
    from scenecc.diagnostics.codes import Severity
    from scenecc.diagnostics.diagnostic import Diagnostic, Location

_TAB = 4
_ONE_LINE = 140
"""Maximum characters of a message and its hint on one line."""

_CUT = "…"


@dataclass(frozen=True, slots=True)
class Excerpt:
    """An excerpt of a source line.

    Attributes:
        shown: printable text, at most the requested width in cells.
        indent: cells before the underline.
        length: cells of the underline, at least 1.
    """

    shown: str
    indent: int
    length: int


def excerpt(text: str, column: int | None, end_column: int | None, *, width: int) -> Excerpt:
    """Returns the part of `text` around [column, end_column) that fits into `width` cells.

    Columns count from 1; one past the last character underlines the cell after it.
    """
    start = min(max((column or 1) - 1, 0), len(text))
    end = min(max((end_column or 0) - 1, start + 1), len(text))
    first, last = _window(text, start, width)
    head = _CUT if first > 0 else ""
    tail = _CUT if last < len(text) else ""
    before = _cells(head, text[first:start])
    under = _cells(head, text[first : min(end, last)])
    shown = _printable_line(head, text[first:last]) + tail
    return Excerpt(shown, before, max(under - before, 1))


def _window(text: str, start: int, width: int) -> tuple[int, int]:
    """Returns the range to show: from the line's start if that fits, else a third of the width before the caret."""
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
    return cell_len(_printable_line(head, text))


def _printable_line(head: str, text: str) -> str:
    """Returns printable text: tabs become blanks up to the next stop, other characters are escaped."""
    first, *rest = text.split("\t")
    line = head + visible(first)
    for part in rest:
        line += " " * (_TAB - cell_len(line) % _TAB) + visible(part)
    return line


Tone = Literal["error", "warning", "note", "place", "gutter", "hint"]

_SGR: Final[dict[Tone, str]] = {
    "error": "1;31",
    "warning": "1;33",
    "note": "1;36",
    "place": "1",
    "gutter": "34",
    "hint": "32",
}

_SEVERITIES: Final[tuple[Severity, ...]] = ("error", "warning", "note")


def render(diagnostics: Sequence[Diagnostic], style: Style) -> str:
    """Returns diagnostics separated by blank lines, with a count at the end; "" if there are none. A last line says
    what was not checked because of errors.

    Notes come first and errors last, nearest to the prompt; the order within one severity is kept.
    """
    if not diagnostics:
        return ""
    page = _Page(style)
    last_errors = sorted(diagnostics, key=lambda d: -_SEVERITIES.index(d.severity))
    blocks = ["".join(line + "\n" for line in page.block(d)) for d in last_errors]
    summary = page.summary(diagnostics)
    missing = unchecked_text(unchecked(diagnostics, style))
    return "\n".join([*blocks, f"{summary}\n{missing}\n" if missing else f"{summary}\n"])


class _Page:
    """The options shared by all lines of a report."""

    def __init__(self, style: Style) -> None:
        self._style = style

    def block(self, diagnostic: Diagnostic) -> list[str]:
        """Returns the lines of one diagnostic."""
        severity = diagnostic.severity
        head = self._paint(severity, f"{severity} {visible(diagnostic.code)}")
        indent = " " * _gutter(diagnostic)
        message, hint = visible(diagnostic.message), diagnostic.hint or ""
        if hint and "\n" not in hint and len(message) + len(hint) <= _ONE_LINE:
            message, hint = f"{message}; {self._paint('hint', visible(hint))}", ""
        lines = [f"{self._place(diagnostic.place, diagnostic.location)} {head}: {message}"]
        if diagnostic.node:
            lines.append(f"{indent} {self._paint('gutter', '-->')} {visible(diagnostic.node)}")
        lines += self._source(diagnostic.location, severity, len(indent))
        lines += self._hint(hint, indent)
        for related in diagnostic.related:
            where = self._place(related.location.file or "<dict>", related.location)
            note = self._paint("note", "note")
            lines.append(f"{indent} {self._paint('gutter', '=')} {note}: {where} {visible(related.message)}")
            lines += self._source(related.location, "note", len(indent))
        return lines

    def _hint(self, hint: str, indent: str) -> list[str]:
        """Returns the lines of a hint, which may contain YAML: lines stay separate, without blank ones."""
        shown = [visible(line) for line in hint.splitlines() if line.strip()]
        head = f"{indent} {self._paint('gutter', '=')} {self._paint('hint', 'hint')}: "
        return [(head if i == 0 else f"{indent}         ") + line for i, line in enumerate(shown)]

    def summary(self, diagnostics: Sequence[Diagnostic]) -> str:
        """Returns `2 errors, 1 warning`; errors are always counted."""
        counts = Counter(d.severity for d in diagnostics)
        return ", ".join(
            self._paint(s, f"{counts[s]} {s}" + ("" if counts[s] == 1 else "s"))
            for s in _SEVERITIES
            if counts[s] or s != "note"
        )

    def _place(self, name: str, location: Location) -> str:
        parts = (name, location.line, location.column)
        place = ":".join(visible(str(part)) for part in parts if part is not None)
        return self._paint("place", place + ":")

    def _source(self, location: Location, tone: Tone, gutter: int) -> list[str]:
        if location.line is None or location.text is None:
            return []
        part = excerpt(location.text, location.column, location.end_column, width=self._style.width)
        bar = self._paint("gutter", "|")
        number = self._paint("gutter", f"{location.line:>{gutter}}")
        lines = [f"{number} {bar} {part.shown}".rstrip()]
        if location.column is not None:
            lines.append(f"{' ' * gutter} {bar} {' ' * part.indent}{self._paint(tone, '^' * part.length)}")
        return lines

    def _paint(self, tone: Tone, text: str) -> str:
        return f"\x1b[{_SGR[tone]}m{text}\x1b[0m" if self._style.color else text


def _gutter(diagnostic: Diagnostic) -> int:
    """Returns the width of the line numbers of this diagnostic and its related places."""
    locations = (diagnostic.location, *(related.location for related in diagnostic.related))
    return max((len(str(location.line)) for location in locations if location.line is not None), default=1)
