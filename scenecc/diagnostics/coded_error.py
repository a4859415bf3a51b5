"""An exception that becomes a diagnostic."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.diagnostic import Location

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Origin, Sink


class CodedError(Exception):
    """What is wrong, raised where no sink is at hand. The caller reports it.

    Attributes:
        code: of the diagnostic.
        message: one sentence, without its place.
        hint: what to do.
        origin: the node at fault; None: the caller knows it.
    """

    def __init__(self, code: str, message: str, hint: str | None = None, *, origin: Origin | None = None) -> None:
        super().__init__(message)
        self.code, self.message, self.hint, self.origin = code, message, hint, origin

    def report(self, sink: Sink, place: Origin | Location | None = None) -> None:
        """Reports it at its origin, else at `place`."""
        sink.report(self.code, self.message, self.origin or place or Location(None), hint=self.hint)
