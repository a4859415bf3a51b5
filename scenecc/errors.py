"""Exceptions of the API."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.codes import CODES

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.diagnostics.diagnostic import Diagnostic


class SceneError(Exception):
    """A scene could not be compiled or built, or its simulation diverged.

    Attributes:
        diagnostics: all diagnostics, warnings included, in file order.
    """

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = list(diagnostics)
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        from scenecc.diagnostics.formats import render  # noqa: PLC0415 - a circular import

        return "\n" + render(self.diagnostics)

    @property
    def at_fault(self) -> Literal["scene", "machine"]:
        """Whether the machine (or engine) or the scene caused the error; the machine if both did."""
        faults = {CODES[found.code].at_fault for found in self.diagnostics if found.severity == "error"}
        return "machine" if "machine" in faults else "scene"
