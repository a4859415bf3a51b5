"""Diagnostics of a command: how they are printed, and the exit status that follows from them."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING

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


_BANDS = {"8": Status.machine, "9": Status.usage}
"""Who is at fault for a code, by its first digit; for all others it is the scene."""


def status(diagnostics: Iterable[Diagnostic], *, strict: bool = False) -> Status:
    """The exit status. `strict`: warnings count as errors do."""
    counted = ("error", "warning") if strict else ("error",)
    return max((_BANDS.get(d.code[2], Status.scene) for d in diagnostics if d.severity in counted), default=Status.fine)


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


def usage_error(code: str, message: str, *, file: str | None = None, hint: str | None = None) -> Diagnostic:
    """A diagnostic about the command line itself."""
    from scenecc.diagnostics import Diagnostic, Location

    return Diagnostic(code, "error", message, Location(file), hint=hint)
