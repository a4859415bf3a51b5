"""A plan as text: one module a target, loaded when it is asked for."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan

EMITTERS: dict[str, str] = {
    "json": "scenecc.emit.plan_json",
    "python": "scenecc.emit.python.script",
}
"""Target to the module whose `write(plan, sink, base)` makes its text."""


def emit(plan: ScenePlan, target: str, sink: Sink, *, base: Path | None = None) -> str | None:
    """The plan as text; None if it cannot be written so, which `sink` then tells.

    Args:
        plan: what to write.
        target: a key of `EMITTERS`.
        sink: takes diagnostics.
        base: folder that the text will lie in; relative uris are rewritten against it. None: they stay as they are.

    Raises:
        KeyError: if there is no such target.
    """
    text: str | None = import_module(EMITTERS[target]).write(plan, sink, base)
    return text


__all__ = ["EMITTERS", "emit"]
