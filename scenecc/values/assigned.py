"""A batch whose rows are combinations of what the draws could give, in place of scenes in which they are drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.values.evaluate import Batch
from scenecc.values.nodes import Chosen, Drawn, Key, Node

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from scenecc.values.work import Work


class Assigned(Batch):
    """As `Batch`, but nothing is drawn.

    Args:
        scenes: the scene's index of each row (B,).
        num_scenes: what `num_scenes` gives in an expression.
        draws: the shared draws by name.
        given: values (N, …) that take the place of draws.
        assigned: for every draw, by its key and word, the number (B,) of what it gives: of an item, or from the
            lowest integer on.
        work: counts what is computed; None: nothing does.
    """

    def __init__(
        self,
        scenes: NDArray[np.int64],
        num_scenes: int,
        draws: Mapping[str, Node],
        given: Mapping[str, NDArray[Any]],
        assigned: Mapping[tuple[Key, int], NDArray[np.int64]],
        work: Work | None = None,
    ) -> None:
        super().__init__(scenes, 0, num_scenes, draws, given, work)
        self.assigned = assigned

    def evaluate(self, node: Node) -> NDArray[Any]:
        """As of a batch."""
        match node:
            case Chosen():
                return self.selected(node.items, self.assigned[node.key, node.word])
            case Drawn():
                return node.low + self.assigned[node.key, node.word]
            case _:
                return super().evaluate(node)

    def only(self, rows: NDArray[np.intp]) -> Assigned:
        """As of a batch."""
        assigned = {draw: numbers[rows] for draw, numbers in self.assigned.items()}
        part = Assigned(self.scenes[rows], self.num_scenes, self.draws, self.given, assigned, self.work)
        part._whole = (self, rows)
        return part

    def row(self, number: int) -> Assigned:
        """One row as a batch of its own."""
        return self.only(np.array([number]))
