"""What is reported while a text is read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.source.text import report_character

if TYPE_CHECKING:
    from scenecc.diagnostics import Location, Path, Sink
    from scenecc.source.lines import Lines
    from scenecc.source.parsing import Event, Mark

MAX_FAULTS = 1000
"""A text of nothing but errors (`- ` a million times) must not fill the memory with reports."""


class Stopped(Exception):
    """The rest of the text is not read: a limit was reached, or too much is wrong."""


class Faults:
    """Reports at the marks of a parser.

    Attributes:
        lines: the text that is read.
        any: whether anything was reported.
    """

    def __init__(self, lines: Lines, sink: Sink) -> None:
        self.lines = lines
        self.any = False
        self._count = 0
        self._sink = sink

    def at(
        self,
        code: str,
        message: str,
        event: Event,
        *,
        path: Path = (),
        hint: str | None = None,
        related: tuple[tuple[str, Location], ...] = (),
    ) -> None:
        """Reports an error at what an event names.

        Raises:
            Stopped: too many errors so far.
        """
        self.report(code, message, self.span(event.start_mark, event.end_mark), path=path, hint=hint, related=related)
        self.admit(event)

    def admit(self, event: Event) -> None:
        """Counts an error at an event.

        Raises:
            Stopped: it is one too many.
        """
        self._count += 1
        if self._count >= MAX_FAULTS:
            self.report(
                "SC016",
                f"reading stopped after {MAX_FAULTS} errors",
                self.span(event.start_mark, event.end_mark),
                hint="mend these first; the rest of the file was not looked at",
            )
            raise Stopped

    def report(
        self,
        code: str,
        message: str,
        location: Location,
        *,
        path: Path = (),
        hint: str | None = None,
        related: tuple[tuple[str, Location], ...] = (),
    ) -> None:
        """Reports an error at a place."""
        self.any = True
        self._sink.report(
            code, message, location, path=path, hint=hint, related=[(text, place, "value") for text, place in related]
        )

    def character(self, offset: int) -> None:
        """Reports a character that must not stand in a scene file."""
        self.any = True
        report_character(self.lines, offset, self._sink)

    def span(self, start: Mark, end: Mark) -> Location:
        """The place from one mark to another, as far as it is on the first one's line."""
        return self.lines.location(start.line, start.column, end.column if end.line == start.line else None)
