"""Comments that silence warnings and notes: `# scenecc: ignore SC484 -- reason`."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from scenecc.diagnostics.diagnostic import Diagnostic, Location, Sink

MARKER: Final = "scenecc: ignore"
"""What every such comment holds; a text without it is not searched."""

_BODY = re.compile(r"\s+(?P<codes>[A-Z]+[0-9]+(?:\s*,\s*[A-Z]+[0-9]+)*)\s*(?:\s--?\s.*)?")


@frozen
class Silencing:
    """One comment.

    Attributes:
        codes: that it silences; none where it cannot be read.
        line: whose findings it silences, from 1.
        location: of the comment.
    """

    codes: tuple[str, ...]
    line: int
    location: Location


Silencings = dict[Silencing, set[str]]
"""Comments, and the codes that each has silenced so far."""


def silencings_of(comments: Iterable[tuple[Location, str, bool]]) -> list[Silencing]:
    """The silencings of a file's comments.

    Args:
        comments: in the order of the file: the place, the text after the marker, and whether the comment is alone on
            its line. Such a comment is about the next line, or where that is one too, about the line after it.
    """
    found: list[Silencing] = []
    line_below, next_line = 0, 0
    for location, text, is_alone in reversed([*comments]):
        line = location.line or 0
        if is_alone:
            next_line, line_below = (next_line if line_below == line + 1 else line + 1), line
        match = _BODY.fullmatch(text.rstrip())
        codes = re.split(r"\s*,\s*", match["codes"]) if match else []
        found.append(Silencing(tuple(dict.fromkeys(codes)), next_line if is_alone else line, location))
    return found[::-1]


def without_silenced(diagnostics: list[Diagnostic], silencings: Silencings) -> list[Diagnostic]:
    """The diagnostics that no comment silences; of the others it is noted. Errors are never silenced."""
    by_place: dict[tuple[str | None, int, str], Silencing] = {
        (one.location.file, one.line, code): one for one in silencings for code in one.codes
    }
    kept: list[Diagnostic] = []
    for found in diagnostics:
        silencing = by_place.get((found.file, found.line or 0, found.code)) if found.severity != "error" else None
        if silencing is None:
            kept.append(found)
        else:
            silencings[silencing].add(found.code)
    return kept


def report_invalid(silencings: Mapping[Silencing, object], file: str | None, sink: Sink) -> None:
    """Reports comments of a file that can never silence anything."""
    for one in silencings:
        if one.location.file != file:
            continue
        if not one.codes:
            hint = "write the codes, then the reason: `scenecc: ignore SC484, SC526 -- reason`"
            sink.report("SC018", "this comment names no code to ignore", one.location, hint=hint)
        for code in one.codes:
            row = CODES.get(code)
            if row is None and code.startswith("SC"):
                hint = "`scenecc explain` lists all codes"
                sink.report("SC018", f"there is no code {code}", one.location, hint=hint)
            elif row is not None and row.severity == "error":
                sink.report("SC018", f"{code} is an error, and errors cannot be ignored", one.location)


def report_unused(sink: Sink, file: str | None, is_judged: Callable[[str], bool]) -> None:
    """Reports comments of a file that silence nothing of what was reported so far.

    Args:
        sink: has the reports, and takes the warnings.
        file: that is checked.
        is_judged: whether a code, if it applied, would have been reported by now.
    """
    sink.diagnostics()
    for one, used in sink.silencings.items():
        for code in one.codes if one.location.file == file else ():
            row = CODES.get(code)
            if code not in used and (row is None or row.severity != "error") and is_judged(code):
                message = f"line {one.line} has no {code}, so this comment silences nothing"
                sink.report("SC018", message, one.location, hint=f"remove {code}")
