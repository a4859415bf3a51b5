"""What ends a build: an engine that refuses, led back to the node that asked."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin


REFUSED = "SC808"
"""The code of what the engine does not take of a body."""


class EngineFailure(Exception):
    """The engine or the machine cannot do what the plan asks.

    Attributes:
        code: a row of band 8.
        message: one sentence, without its place.
        origin: the node that asked; None: whoever catches it knows better.
        hint: what to do.
    """

    def __init__(self, code: str, message: str, *, origin: Origin | None = None, hint: str | None = None) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.origin = origin
        self.hint = hint
