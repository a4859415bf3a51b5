"""Diagnostics of a command: how they are printed, and the exit status that follows from them."""

from __future__ import annotations

import sys
from collections.abc import Container, Iterable, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, NoReturn

import typer

from scenecc.cli.options import Format
from scenecc.cli.output import print_err, print_out

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic


class Status(IntEnum):
    """Exit statuses. Of several that apply, the highest says what has to be put right first."""

    fine = 0
    scene = 1
    usage = 2
    machine = 3


_PARAMS = "params"
"""The file that the API names for a value of `params=`."""

_SET = "--set"
"""And the command line, which is then used wrongly."""


def status(diagnostics: Iterable[Diagnostic], *, strict: bool = False) -> Status:
    """The exit status. `strict`: warnings count as errors do."""
    counted = ("error", "warning") if strict else ("error",)
    return max((_blamed(d) for d in diagnostics if d.severity in counted), default=Status.fine)


def _blamed(diagnostic: Diagnostic) -> Status:
    from scenecc.diagnostics.codes import CODES

    if diagnostic.line is None and (diagnostic.file or "").startswith(_SET):
        return Status.usage
    return Status[CODES[diagnostic.code].at_fault]


def of_settings(diagnostics: Iterable[Diagnostic], settings: Container[str]) -> list[Diagnostic]:
    """The same diagnostics, those about `params=` of the API as ones about `--set`. `settings`: its names."""
    from dataclasses import replace

    from scenecc.diagnostics import Location

    found: list[Diagnostic] = []
    for diagnostic in diagnostics:
        if diagnostic.file == _PARAMS and diagnostic.line is None:
            place = f"{_SET} {diagnostic.path}" if diagnostic.path in settings else _SET
            diagnostic = replace(diagnostic, location=Location(place), path="")  # noqa: PLW2901 - the same, elsewhere
        found.append(diagnostic)
    return found


def print_findings(diagnostics: Sequence[Diagnostic], form: Format) -> None:
    """Prints diagnostics that are what the command was asked for: on standard output."""
    if form is Format.text and not diagnostics:
        return  # nothing to say, and nothing to load for it
    from scenecc.diagnostics.render import render, wants_color

    print_out(render(diagnostics, form.value, color=wants_color(sys.stdout)))


def print_asides(diagnostics: Sequence[Diagnostic], form: Format) -> None:
    """Prints diagnostics beside another result: text on standard error, the formats of programs on standard output."""
    if form is not Format.text:
        print_findings(diagnostics, form)
    elif diagnostics:
        from scenecc.diagnostics.render import render, wants_color

        print_err(render(diagnostics, color=wants_color(sys.stderr)))


def end(diagnostics: Sequence[Diagnostic], form: Format = Format.text, *, least: Status = Status.fine) -> NoReturn:
    """Ends the command: prints diagnostics beside its result, and exits with their status, `least` or above."""
    print_asides(diagnostics, form)
    raise typer.Exit(max(status(diagnostics), least))


def usage_error(code: str, message: str, *, file: str | None = None, hint: str | None = None) -> Diagnostic:
    """A diagnostic about the command line itself."""
    from scenecc.diagnostics import Diagnostic, Location

    return Diagnostic(code, "error", message, Location(file), hint=hint)
