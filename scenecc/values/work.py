"""How much may be computed for the scenes of a batch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.values.failure import DrawError
from scenecc.values.operations import SEQUENCES

if TYPE_CHECKING:
    from scenecc.values.nodes import Node

TOO_MUCH = "compute less, in fewer scenes, or raise the limit with --limit computed=N or limits={'computed': N}"

NAME = 100
"""How many operations it takes to look up a file or a material that an expression names."""

_CHARACTERS = 16
"""How many characters of an expression count as one operation."""

_ROWS = 4
"""How many rows of a form numpy makes in the time of one operation."""

_ITEM = 4
"""How many operations an item of a list counts for: it stays in memory."""


class TooMuch(DrawError):
    """A node that would take more operations than there may be."""


@dataclass(slots=True)
class Work:
    """Counts operations before they are done. A few lines can ask for any number: 900 draws in 65 536 scenes.

    Attributes:
        most: how many there may be (limit `computed`).
        done: how many there were.
    """

    most: int
    done: int = 0

    @property
    def exhausted(self) -> bool:
        """Whether more was asked for than there may be."""
        return self.done > self.most

    @property
    def message(self) -> str:
        """What is said then."""
        return f"the values of all scenes take more than {self.most} operations (limit computed)"

    def take(self, operations: int, node: Node) -> None:
        """Counts so many.

        Raises:
            TooMuch: they are too many.
        """
        self.done += operations
        if self.exhausted:
            raise TooMuch(self.message, 0, node)


def of_expression(text: str, rows: int) -> int:
    """About how many operations an expression of this text takes in so many scenes."""
    return rows * (1 + len(text) // _CHARACTERS)


def of_form(rows: int) -> int:
    """The same of a form."""
    return rows // _ROWS


def of_result(value: Any) -> int:
    """The same of what an expression gives: of the characters of a text, and the items of lists within lists."""
    if value.__class__ not in SEQUENCES:
        return 0
    return _ITEM * len(value) + (0 if value.__class__ is str else sum(map(of_result, value)))
