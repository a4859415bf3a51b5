"""The scenes and seeds of the samples that check a file, independent of the seed of a build."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.variation.evaluation import SELECTIONS, Batch
from scenecc.variation.nodes import NODE_FIELDS, Computed, Shared
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.variation.nodes import Node
    from scenecc.variation.operations import OperationCounter

SAMPLE_COUNT = 256
"""Samples per value. An error that occurs less often is found by the build or the reset."""


def sample_positions(count: int) -> NDArray[np.intp]:
    """The position (256,) of each sample's scene among `count` scenes: all in turn, or evenly spaced ones."""
    numbers = np.arange(SAMPLE_COUNT)
    return numbers % count if count <= SAMPLE_COUNT else numbers * count // SAMPLE_COUNT


def as_samples(rows: NDArray[Any]) -> NDArray[Any]:
    """Converts rows that do not depend on the seed, one for all scenes or one per scene, to samples."""
    return rows if len(rows) == 1 else rows[sample_positions(len(rows))]


def sample_of(number: int, scenes: Sequence[int]) -> tuple[int, int]:
    """The scene and the seed of a sample of an object in some scenes."""
    count = len(scenes)
    return scenes[int(sample_positions(count)[number])], number // count


def name_sample(scene: int, seed: int | None) -> str:
    """The words for a scene with a seed at the start of a message. `seed`: None for that of the file."""
    return f"in scene {scene}" if seed is None else f"in scene {scene} with seed {seed}"


def sample_hint(seed: int | None, advice: str = "") -> str:
    """The hint of a warning about a sample: how to see it, and what to do."""
    shown = f"a build with `--seed {seed}` shows it"
    return f"{shown}; {advice}" if advice else shown


class SampleBatch(Batch):
    """The samples of an object.

    Args:
        scenes: indices of the object's scenes.
        num_scenes: of the document.
        draws: the shared draws by name.
        work: counts the operations.
    """

    def __init__(
        self,
        scenes: tuple[int, ...],
        num_scenes: int,
        draws: Mapping[str, Node],
        work: OperationCounter | None,
    ) -> None:
        count = len(scenes)
        # The first sample of each scene has seed 0, the second one seed 1, and so on.
        seeds = 0 if count >= SAMPLE_COUNT else tuple(number // count for number in range(SAMPLE_COUNT))
        super().__init__(np.array(scenes)[sample_positions(count)], seeds, num_scenes, draws, {}, work)
        self._computed: dict[tuple[Any, ...], tuple[Node, NDArray[Any]]] = {}

    def evaluate(self, node: Node) -> NDArray[Any]:
        """The node's values. Values of expressions are cached, since many fields share one."""
        if not isinstance(node, Computed):
            return super().evaluate(node)
        # Keeping the node keeps the id of its template unique.
        key = (id(node.template), node.shape, node.reads)
        if key not in self._computed:
            self._computed[key] = node, super().evaluate(node)
        return self._computed[key][1]


def nodes_read(item: Any, batch: Batch) -> Iterator[tuple[Node, Batch]]:
    """The nodes in an item, each with the rows of a batch in which the item reads it."""
    # A chain of poses may be longer than Python's stack is deep.
    todo: list[tuple[Any, Batch]] = [(item, batch)]
    while todo:
        item, batch = todo.pop()
        kind = item.__class__
        if kind is tuple:
            todo += [(part, batch) for part in reversed(item)]
        elif kind is Shared:
            todo.append((batch.draws[item.name], batch))
        elif kind in SELECTIONS:
            todo += reversed([*_split_by_selection(item, batch)])
        elif kind in NODE_FIELDS:
            yield item, batch
            todo += [(getattr(item, name), batch) for name in reversed(NODE_FIELDS[kind])]


def _split_by_selection(node: Any, batch: Batch) -> Iterator[tuple[Any, Batch]]:
    """The items of a node that selects one for each scene, each with its rows; nothing where the selection fails."""
    try:
        index = SELECTIONS[node.__class__](batch, node)
    except DrawError:
        return
    # Several scenes may share an item.
    numbers: dict[int, list[int]] = {}
    for number in np.unique(index).tolist():
        numbers.setdefault(id(node.items[number]), []).append(number)
    for same in numbers.values():
        yield node.items[same[0]], batch.only(np.flatnonzero(np.isin(index, same)))
