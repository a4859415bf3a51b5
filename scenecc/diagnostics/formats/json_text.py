"""The `json` format, for programs."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, TypedDict

from scenecc.diagnostics.formats.style import Style, encodable, unchecked

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Diagnostic, Related


class RelatedRecord(TypedDict):
    """A related place; None for unknown values."""

    message: str
    file: str | None
    line: int | None
    column: int | None
    end_column: int | None


class DiagnosticRecord(TypedDict):
    """A diagnostic; None for unknown values."""

    code: str
    severity: str
    message: str
    file: str | None
    line: int | None
    column: int | None
    end_column: int | None
    path: str
    hint: str | None
    related: list[RelatedRecord]


def records(diagnostics: Iterable[Diagnostic]) -> list[DiagnosticRecord]:
    """Returns diagnostics as plain data: the value of `diagnostics` in every JSON report."""
    return [_record(d) for d in diagnostics]


def render(diagnostics: Sequence[Diagnostic], style: Style) -> str:
    """Returns `{"diagnostics": [...]}` with a line break at the end, with `corrections` if any were requested, and with
    `simulated` if the command simulates, and with `unchecked` for files of which not everything was checked.

    It is ASCII, so it passes through any pipe, and cannot contain escape sequences of an untrusted file.
    """
    report: dict[str, Any] = {"diagnostics": records(diagnostics)}
    if style.corrections is not None:
        made = ((one, one.fix) for one in style.corrections)
        report["corrections"] = [{**_record(one), "wrote": encodable(fix.text)} for one, fix in made if fix is not None]
    if style.simulated is not None:
        report["simulated"] = {encodable(file): one for file, one in style.simulated.items()}
    if missing := unchecked(diagnostics, style):
        report["unchecked"] = {encodable(file): stages for file, stages in missing.items()}
    return json.dumps(report, indent=2) + "\n"


def _record(diagnostic: Diagnostic) -> DiagnosticRecord:
    location = diagnostic.location
    return {
        "code": encodable(diagnostic.code),
        "severity": diagnostic.severity,
        "message": encodable(diagnostic.message),
        "file": _text(location.file),
        "line": location.line,
        "column": location.column,
        "end_column": location.end_column,
        "path": encodable(diagnostic.path),
        "hint": _text(diagnostic.hint),
        "related": [_related_record(r) for r in diagnostic.related],
    }


def _related_record(related: Related) -> RelatedRecord:
    return {
        "message": encodable(related.message),
        "file": _text(related.location.file),
        "line": related.location.line,
        "column": related.location.column,
        "end_column": related.location.end_column,
    }


def _text(text: str | None) -> str | None:
    return None if text is None else encodable(text)
