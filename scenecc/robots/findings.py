"""What is wrong with a robot's file, told at the file's own lines and led back to the scene that names it."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import islice
from typing import TYPE_CHECKING

from scenecc.diagnostics import Location, Origin, Sink
from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.messages import nearest
from scenecc.files import open_regular

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from scenecc.diagnostics.diagnostic import RelatedPlace

_GUESSES, _NAMES = 20, 1000
"""After how many errors no name is guessed any more, and among how many names."""


MOST_READ = 2**30
"""About what all robots' files of a scene may take in memory while they are read [bytes]."""

_TEXT_BYTES, _ELEMENT_BYTES, _READ_BYTES = 3, 1024, 4096
"""About what a byte of a file's text, one of its elements, and a file takes."""


@dataclass(slots=True)
class ReadBudget:
    """How much is still read of the robots' files of one scene, each counted as often as it is read. A small scene may
    ask for one large file at any number of scales, and for any number of small files that include it.

    Attributes:
        left: about what they may still take in memory [bytes].
    """

    left: int = MOST_READ

    def take(self, data: bytes) -> bool:
        """Counts a text that was read; whether there was as much left."""
        self.left -= _READ_BYTES + _TEXT_BYTES * len(data) + _ELEMENT_BYTES * data.count(b"<")
        return self.left >= 0


@dataclass(slots=True)
class Findings:
    """Reports of one robot's file.

    Attributes:
        sink: where they go.
        origin: the node of the scene that names the file; None: nothing does.
        told: kinds of what is told once only.
        errors: how many there were.
        budget: of all files that are read; None: the file is read alone.
    """

    sink: Sink
    origin: Origin | None = None
    told: set[tuple[str, str]] = field(default_factory=set[tuple[str, str]])
    errors: int = 0
    budget: ReadBudget | None = None

    def place(self, location: Location, *path: str | int) -> Origin | Location:
        """A place in the file, led back to the scene. `path`: what stands there."""
        return location if self.origin is None else self.origin.into(location, *path)

    def top(self, file: str) -> Location:
        """The place of a file as a whole."""
        return Location(file)

    def report(
        self,
        code: str,
        message: str,
        location: Location,
        *path: str | int,
        hint: str | None = None,
        related: Iterable[RelatedPlace] = (),
    ) -> None:
        """Adds a finding. `path`: what it is about (`"links", "base"`)."""
        self.errors += CODES[code].severity == "error"
        self.sink.report(code, message, self.place(location, *path), hint=hint, related=related)

    def near(self, word: str, names: Iterable[str]) -> str | None:
        """A hint with the name that was probably meant. None after many faults: comparing letters takes its time."""
        found = nearest(word, tuple(islice(names, _NAMES))) if self.errors < _GUESSES else None
        return None if found is None else f"did you mean `{found}`?"

    def guess(self, code: str, kind: str, word: str, names: Iterable[str]) -> str | None:
        """The name that was probably meant, where a finding of this kind is still to be told and few kinds were."""
        is_wanted = (code, kind) not in self.told and len(self.told) < _GUESSES
        return nearest(word, tuple(islice(names, _NAMES))) if is_wanted else None

    def report_once(self, code: str, kind: str, message: str, location: Location, hint: str | None = None) -> None:
        """Adds a finding of a kind, the first of that kind only."""
        if (code, kind) not in self.told:
            self.told.add((code, kind))
            self.report(code, message, location, hint=hint)


def read_robot_bytes(path: Path, file: str, findings: Findings, limit: int) -> bytes | None:
    """The content of a file that was found; None, reported (SC450, SC452), where it cannot be read or is too large.

    Args:
        path: of the file.
        file: its name as shown to people.
        findings: where it is reported.
        limit: its largest size [bytes].
    """
    try:
        with open_regular(path) as stream:
            data = stream.read(limit + 1)
    except OSError as error:
        findings.report("SC450", f"the file cannot be read: {error.strerror or error}", findings.top(file))
        return None
    if len(data) > limit:
        findings.report("SC452", f"the file is too large: it has more than {limit} bytes", findings.top(file))
        return None
    if findings.budget is not None and not findings.budget.take(data):
        findings.report(
            "SC452",
            f"the robots' files of the scene take more than {MOST_READ} bytes of memory",
            findings.top(file),
            hint="use fewer files, or each at fewer scales, for it is read anew for each",
        )
        return None
    return data
