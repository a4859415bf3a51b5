"""The `junit` format: XML that CI services show as a list of tests, one per file."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape, quoteattr

from scenecc.diagnostics.formats.style import (
    Style,
    checked_file,
    encodable,
    relative_file,
    unchecked,
    unchecked_text,
    visible,
)

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Diagnostic

_NOT_XML = re.compile("[\ufffe\uffff]")


def render(diagnostics: Sequence[Diagnostic], style: Style) -> str:
    """Returns one test case per file that was checked or has a finding; file names are relative to `style.root`.

    A file with errors is a failure that lists them, as is a strict one with warnings; other findings are its output.
    """
    by_file: dict[str, list[Diagnostic]] = {file: [] for file in style.files}
    for diagnostic in diagnostics:
        by_file.setdefault(checked_file(diagnostic, style.files), []).append(diagnostic)
    missing = unchecked(diagnostics, style)
    lines = {file: unchecked_text({file: stages}) for file, stages in missing.items()}
    cases = [
        _case(relative_file(file, style.root)[0], found, lines.get(file), is_strict=file in style.strict)
        for file, found in by_file.items()
    ]
    counts = f'tests="{len(cases)}" failures="{sum("<failure" in case for case in cases)}" errors="0"'
    suite = f'  <testsuite name="scenecc" {counts}>\n{"".join(cases)}  </testsuite>\n'
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<testsuites>\n{suite}</testsuites>\n'


def _case(file: str, found: list[Diagnostic], unchecked: str | None, *, is_strict: bool) -> str:
    failing = ("error", "warning") if is_strict else ("error",)
    faults = [one for one in found if one.severity in failing]
    parts = ""
    if faults:
        kind = "error" if any(one.severity == "error" for one in faults) else "warning"
        count = f"{len(faults)} finding{'' if len(faults) == 1 else 's'}"
        text = _text(map(_line, faults))
        parts += f"      <failure message={_attribute(count)} type={_attribute(kind)}>{text}</failure>\n"
    notes = [_line(one) for one in found if one.severity not in failing]
    if notes := [*notes, *([unchecked] if unchecked else [])]:
        parts += f"      <system-out>{_text(notes)}</system-out>\n"
    head = f'    <testcase classname="scenecc" name={_attribute(file)}'
    return f"{head}>\n{parts}    </testcase>\n" if parts else f"{head}/>\n"


def _text(lines: Iterable[str]) -> str:
    return escape("\n".join(map(_clean, lines)))


def _line(diagnostic: Diagnostic) -> str:
    parts = [str(diagnostic), *([f"hint: {diagnostic.hint}"] if diagnostic.hint else [])]
    for related in diagnostic.related:
        where = (related.location.file, related.location.line, related.location.column)
        parts.append("note: " + ":".join(str(part) for part in (*where, f" {related.message}") if part is not None))
    return "; ".join(parts)


def _attribute(text: str) -> str:
    return quoteattr(_clean(text))


def _clean(text: str) -> str:
    """Returns the text with characters that XML does not allow spelled out."""
    return _NOT_XML.sub("\ufffd", "\n".join(visible(line) for line in encodable(text).split("\n")))
