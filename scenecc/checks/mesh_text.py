"""Text meshes, thousands of lines at once where they are plain, word by word where they are not."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from scenecc.checks.mesh_data import AssetError, Total, check_plain

if TYPE_CHECKING:
    from numpy.typing import NDArray

EXPONENT = rb"(?:[eE](?:-[0-9]{1,3}|\+?0{0,2}[12]?[0-9]))?"
NUMBER = rb"[-+]?[0-9]{1,18}(?:\.[0-9]*)?" + EXPONENT
"""A coordinate as nearly all files write it. No text matches it in two ways, so a failed match costs nothing."""

INDEX = rb"[0-9]{1,9}"
_BLANKS = rb"[ \t]+"
_END = rb"[ \t]*\r?\n"
LONGEST_RUN = 4096
"""Lines in a run: the matcher keeps a state for each."""


def run_of(*words: bytes, lines: bytes = b"") -> re.Pattern[bytes]:
    """Matches a run of lines that each have these words, patterns themselves; or of `lines`, a pattern of several."""
    return re.compile(rb"(?:" + (lines or line_of(*words)) + rb"){1,%d}" % LONGEST_RUN)


def line_of(*words: bytes) -> bytes:
    """The pattern of a line that has these words."""
    return _BLANKS.join(words) + _END


def floats(run: bytes) -> NDArray[np.float64]:
    """The numbers of a text of nothing but numbers and blanks."""
    with np.errstate(over="ignore"):
        return np.fromstring(run, dtype=np.float64, sep=" ")


def integers(run: bytes) -> NDArray[np.int64]:
    """Likewise, of integers."""
    return np.fromstring(run, dtype=np.int64, sep=" ")


def words(line: str) -> list[str]:
    """The words of a line. What Python takes for a blank besides these two, the engine's readers do not."""
    return [word for word in line.replace("\t", " ").split(" ") if word]


class Lines:
    """A text read from its start to its end.

    Attributes:
        row: how many lines were read.
    """

    def __init__(self, data: bytes, budget: Budget, start: int = 0) -> None:
        """Starts at an offset. The budget pays for each run, and for each line that is read alone: they take time.

        Raises:
            ValueError: the data holds characters that no text has.
        """
        check_plain(data)
        self.row = 0
        self._data = data
        self._budget = budget
        self._at = start

    def letter(self) -> bytes:
        """The first byte of the next line; empty at the end."""
        return self._data[self._at : self._at + 1]

    def run(self, pattern: re.Pattern[bytes]) -> bytes:
        """The lines that match here, which are then read; empty where none do."""
        match = pattern.match(self._data, self._at)
        if match is None:
            return b""
        self._budget.spend(ROW_BYTES)
        self._at = match.end()
        run = match[0]
        self.row += run.count(b"\n")
        return run

    def line(self) -> str | None:
        """The next line without blanks around it; None at the end."""
        line = self.raw()
        return None if line is None else line.strip(" \t")

    def raw(self) -> str | None:
        """The next line with the blanks around it; None at the end."""
        if self._at >= len(self._data):
            return None
        end = self._data.find(b"\n", self._at)
        end = len(self._data) if end < 0 else end
        self._budget.spend(ROW_BYTES + _LETTER_BYTES * (end - self._at))
        line = self._data[self._at : end]
        self._at = end + 1
        self.row += 1
        return line.decode("utf-8", "replace").rstrip("\r")

    def filled(self) -> str | None:
        """The next line that is not empty, without blanks around it; None at the end."""
        line = self.line()
        while line == "":
            line = self.line()
        return line


ROW_BYTES, _LETTER_BYTES = 512, 16
"""What a row that is read alone counts for, and each letter of a line, beside what it holds: its words take time."""

_TIMES = 3
"""Arrays take up to three times the file of which they are all: `f 1 2 3` is eight bytes, and 24 as integers."""


class Budget:
    """Counts what a mesh takes in memory, before it is made: a file may ask for far more than its own size."""

    def __init__(self, max_bytes: int, total: Total) -> None:
        self._max_bytes = _TIMES * max_bytes
        self._total = total
        self._used = 0

    def spend(self, size: int) -> None:
        """Counts what takes time, or memory for a moment, for all meshes of the scene together.

        Raises:
            AssetError: it is too much.
        """
        self._total.take(size)

    def take(self, size: int) -> None:
        """Counts so many bytes.

        Raises:
            AssetError: they are too many.
        """
        self.spend(size)
        self._used += size
        if self._used > self._max_bytes:
            raise AssetError(
                "SC607",
                f"the mesh takes more than {self._max_bytes} bytes in memory",
                "simplify it, or raise the limit with --limit asset_bytes=N",
            )
