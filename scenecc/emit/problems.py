"""What of a scene's surfaces cannot be written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics import Location

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.meshes import MeshProblem


def tell_problem(problem: MeshProblem, place: Origin | None, sink: Sink) -> None:
    """Reports a problem of the shape at a place."""
    sink.report(problem.code, problem.message, place or Location(None), hint=problem.hint)
