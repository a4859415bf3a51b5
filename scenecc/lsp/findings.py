"""Findings in an editor, in each open file that they concern."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lsprotocol import types

from scenecc.diagnostics.diagnostic import Location, Related

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic
    from scenecc.lsp.analysis import SceneText
    from scenecc.lsp.positions import Columns
    from scenecc.lsp.workspace import Project, WorkspaceView

_SEVERITIES: Final = {
    "error": types.DiagnosticSeverity.Error,
    "warning": types.DiagnosticSeverity.Warning,
    "note": types.DiagnosticSeverity.Information,
}


def findings_in(view: WorkspaceView, path: Path) -> list[Diagnostic]:
    """Returns the findings of an open file: those of its own check, and of the open scenes that read it.

    A part of an open scene is checked only as a part, not by itself.
    """
    found: list[Diagnostic] = []
    for user in view.judges(path):
        project = view.projects[user]
        here = (_move_to_line(one, path, project) if user == path else one for one in project.diagnostics)
        found += [one for one in here if project.files.get(one.file or "") == path or one.file == str(path)]
    return list(dict.fromkeys(found))


def _move_to_line(found: Diagnostic, path: Path, project: Project) -> Diagnostic:
    """Returns a finding in another file, moved to the line of the scene that leads to it."""
    if found.file is None or found.file == str(path) or project.files.get(found.file) == path:
        return replace(found, location=replace(found.location, file=str(path)))
    led = next((one.location for one in found.related if one.location.file == str(path)), None)
    true_place = Related(found.message, found.location)
    return replace(found, location=led or Location(str(path), 1, 1), related=(true_place, *found.related), fix=None)


def _range_of(text: SceneText, place: Location, columns: Columns) -> types.Range:
    """Returns the range of a finding; without a line, the first line."""
    start = (place.column or 1) - 1
    end = None if place.end_column is None else place.end_column - 1
    return columns.range(text, (place.line or 1) - 1, start, end)


def to_client(view: WorkspaceView, text: SceneText, found: Diagnostic, columns: Columns) -> types.Diagnostic:
    """Converts a finding in a text to the protocol's type."""
    hint = f"\n{found.hint}" if found.hint else ""
    return types.Diagnostic(
        _range_of(text, found.location, columns),
        found.message + hint,
        severity=_SEVERITIES[found.severity],
        code=found.code,
        source="scenecc",
        related_information=list(_list_related(view, found, columns)),
    )


def _list_related(
    view: WorkspaceView, found: Diagnostic, columns: Columns
) -> Iterator[types.DiagnosticRelatedInformation]:
    names: Mapping[str, Path] = {name: path for one in view.projects.values() for name, path in one.files.items()}
    for related in found.related:
        path = names.get(related.location.file or "")
        text = None if path is None else view.text(path)
        if text is not None and related.location.line is not None:
            place = types.Location(text.path.as_uri(), _range_of(text, related.location, columns))
            yield types.DiagnosticRelatedInformation(place, related.message)
