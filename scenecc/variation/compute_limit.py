"""How much may be computed for the scenes of a batch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.variation.errors import DrawError
from scenecc.variation.operations import SEQUENCES

if TYPE_CHECKING:
    from scenecc.variation.nodes import Node

COMPUTE_LIMIT_HINT = (
    "compute less, in fewer scenes, or raise the limit with --limit computed=N or limits={'computed': N}"
)

NAME_LOOKUP_COST = 100
"""How many operations it takes to look up a file or a material that an expression names."""

_CHARACTERS_PER_OPERATION = 16
"""How many characters of an expression count as one operation."""

_ROWS_PER_OPERATION = 4
"""How many rows of a form numpy makes in the time of one operation."""

_OPERATIONS_PER_ITEM = 4
"""How many operations an item of a list counts for: it stays in memory."""


class ComputeLimitError(DrawError):
    """A node that would take more operations than there may be."""


@dataclass(slots=True)
class OperationCounter:
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
            raise ComputeLimitError(self.message, 0, node)


def expression_cost(text: str, rows: int) -> int:
    """About how many operations an expression of this text takes in so many scenes."""
    return rows * (1 + len(text) // _CHARACTERS_PER_OPERATION)


def form_cost(rows: int) -> int:
    """The same of a form."""
    return rows // _ROWS_PER_OPERATION


def result_cost(value: Any) -> int:
    """The same of what an expression gives: of the characters of a text, and the items of lists within lists."""
    if value.__class__ not in SEQUENCES:
        return 0
    return _OPERATIONS_PER_ITEM * len(value) + (0 if value.__class__ is str else sum(map(result_cost, value)))
