"""The `github` format: workflow commands, which annotate a pull request at the line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Final

from scenecc.diagnostics.formats.style import Style, relative_file, unchecked, unchecked_text, visible

if TYPE_CHECKING:
    from scenecc.diagnostics.codes import Severity
    from scenecc.diagnostics.diagnostic import Diagnostic, Location

_COMMANDS: Final[dict[Severity, str]] = {"error": "error", "warning": "warning", "note": "notice"}


def render(diagnostics: Sequence[Diagnostic], style: Style) -> str:
    """Returns one line `::error file=…,line=…::message` per diagnostic; file names are relative to `style.root`."""
    line = unchecked_text(unchecked(diagnostics, style))
    return "".join(
        [_command(d, style.root) + "\n" for d in diagnostics]
        + ([f"::notice title=scenecc::{_data(line)}\n"] if line else [])
    )


def _command(diagnostic: Diagnostic, root: PurePath | None) -> str:
    properties = {**_place(diagnostic.location, root), "title": diagnostic.code}
    written = ",".join(f"{key}={_property(value)}" for key, value in properties.items())
    return f"::{_COMMANDS[diagnostic.severity]} {written}::{_data(_message(diagnostic))}"


def _place(location: Location, root: PurePath | None) -> dict[str, str]:
    if not location.file:
        return {}
    place = {"file": relative_file(location.file, root)[0]}
    if location.line is not None:
        place["line"] = str(location.line)
        if location.column is not None:
            place["col"] = str(location.column)
            if location.end_column is not None and location.end_column > location.column:
                place["endColumn"] = str(location.end_column)
    return place


def _message(diagnostic: Diagnostic) -> str:
    lines = [diagnostic.message]
    if diagnostic.path:
        lines.append(f"at {diagnostic.path}")
    if diagnostic.hint:
        lines.append(f"hint: {diagnostic.hint}")
    for related in diagnostic.related:
        where = (related.location.file, related.location.line, related.location.column)
        lines.append(":".join(str(part) for part in (*where, f" {related.message}") if part is not None).strip())
    return "\n".join(lines)


def _data(text: str) -> str:
    """Returns the text escaped for GitHub's runner, whose only line breaks are CR and LF."""
    lines = text.replace("%", "%25").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return "%0A".join(visible(line) for line in lines)


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
