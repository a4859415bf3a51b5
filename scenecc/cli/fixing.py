"""`--fix` and `--diff`: the safe corrections of findings, written into the file at their places."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.cli.output import write
from scenecc.files import open_regular

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic

Check = Callable[[str], "list[Diagnostic]"]
"""What checks a text as if it were the file's."""


def corrected(file: str, diagnostics: list[Diagnostic], check: Check) -> tuple[str, str] | None:
    """The text of a file before and after its corrections; None where there is none to make.

    A correction that leads to a new error, or does not remove its finding, is not made.
    """
    with open_regular(file) as stream:
        before = text = stream.read().decode("utf-8", errors="surrogateescape")
    tried = [one for one in diagnostics if one.fix is not None and one.file == one.fix.location.file == file]
    for found in sorted(tried, key=lambda one: (one.line or 0, one.column or 0), reverse=True):
        changed = _replaced(text, found)
        if changed is not None and _is_better(check(changed), check(text), found):
            text = changed
    return None if text == before else (before, text)


def _replaced(text: str, found: Diagnostic) -> str | None:
    """The text with one correction; None where its place is not a whole key or list on one line."""
    if found.fix is None or (place := found.fix.location).line is None or place.column is None or not place.end_column:
        return None
    lines = text.split("\n")
    line = lines[place.line - 1] if place.line <= len(lines) else ""
    old, rest = line[place.column - 1 : place.end_column - 1], line[place.end_column - 1 :]
    is_list = found.fix.text.startswith("[")
    if line.rstrip("\r") != place.text or not (old[:1] == "[" and old[-1:] == "]" if is_list else old.isidentifier()):
        return None
    lines[place.line - 1] = line[: place.column - 1] + found.fix.text + rest
    return "\n".join(lines)


def _is_better(now: list[Diagnostic], then: list[Diagnostic], found: Diagnostic) -> bool:
    """Whether a finding is gone, and nothing on its line is wrong that was not."""

    def of_line(every: list[Diagnostic]) -> list[str]:
        return [one.code for one in every if one.line == found.line]

    left = of_line(then)
    left.remove(found.code)
    return sorted(of_line(now)) == sorted(left)


def unified_diff(file: str, before: str, after: str) -> str:
    """The change as `diff -u` shows it."""
    lines = difflib.unified_diff(before.splitlines(keepends=True), after.splitlines(keepends=True), file, file)
    return "".join(line if line.endswith("\n") else line + "\n" for line in lines)


def write_corrected(file: str, text: str) -> Diagnostic | None:
    """Writes a file whole or not at all; the finding where that fails."""
    from scenecc.cli.output import usage_error

    fault = write(str(Path(file)), text.encode("utf-8", errors="surrogateescape"))
    return None if fault is None else usage_error(*fault, file=file)
