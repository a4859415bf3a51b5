"""The corrections that `validate --fix` makes in files, and `--diff` shows."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.cli.output import usage_error, write
from scenecc.diagnostics.fixing import is_better, with_fix
from scenecc.diagnostics.messages import cut
from scenecc.files import open_regular

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic
    from scenecc.options import Options


@dataclass(frozen=True, slots=True)
class Corrected:
    """A file's text before and after its corrections.

    Attributes:
        corrections: the findings that are gone, in the order of the text.
    """

    file: str
    before: str
    after: str
    corrections: Sequence[Diagnostic]

    def diff(self) -> str:
        """The change as `diff -u` shows it."""
        before, after = (text.splitlines(keepends=True) for text in (self.before, self.after))
        lines = difflib.unified_diff(before, after, self.file, self.file)
        return "".join(line if line.endswith("\n") else line + "\n" for line in lines)

    def write(self) -> Diagnostic | None:
        """Writes the file completely or not at all; the finding where that fails."""
        fault = write(str(Path(self.file)), self.after.encode("utf-8", errors="surrogateescape"))
        return None if fault is None else usage_error(*fault, file=self.file)


Check = Callable[[str], "list[Diagnostic]"]
"""What checks a text as if it were the file's."""


def corrected(file: str, options: Options) -> Corrected | None:
    """The text of a file with its corrections; None where there is none to make.

    A correction that leads to a new error, or does not remove its finding, is not made. A stage whose mistakes are
    corrected lets the next one find its own.
    """
    with open_regular(file) as stream:
        before = text = stream.read().decode("utf-8", errors="surrogateescape")
    made: list[Diagnostic] = []
    then, last = _check_text(file, options, text), ""
    while text != last:
        last = text
        tried = [one for one in then if one.fix is not None and one.file == one.fix.location.file == file]
        for found in sorted(tried, key=_place, reverse=True):
            changed = with_fix(text, found)
            now = then if changed is None else _check_text(file, options, changed)
            if changed is not None and is_better(now, then, found):
                text, then = changed, now
                made.append(found)
    return Corrected(file, before, text, sorted(made, key=_place)) if made else None


def _place(found: Diagnostic) -> tuple[int, int]:
    return found.line or 0, found.column or 0


def _check_text(file: str, options: Options, text: str) -> list[Diagnostic]:
    """Checks a text in the place of a file: what it names is beside the file."""
    from scenecc.diagnostics import Sink
    from scenecc.scene import validate_source
    from scenecc.source import read_text

    sink = Sink()
    document = read_text(text, file, sink, path=Path(file).absolute())
    return sink.diagnostics() if document is None else validate_source(document, options, {}, None)


def summary(corrections: Sequence[Diagnostic]) -> str:
    """A line for each correction, and how many there are; "" for none."""
    from scenecc.diagnostics.formats.style import visible

    if not corrections:
        return ""
    lines = [
        f"{one.file}:{one.line}:{one.column}: corrected {one.code}: {one.message}; wrote `{cut(one.fix.text)}`"
        for one in corrections
        if one.fix is not None
    ]
    lines.append(f"{len(lines)} correction{'s' * (len(lines) != 1)}")
    return "".join(visible(line) + "\n" for line in lines)
