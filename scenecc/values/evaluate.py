"""Nodes evaluated over many scenes at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.values import columns, drawing, placing
from scenecc.values.computing import compute
from scenecc.values.failure import DrawError
from scenecc.values.holding import held
from scenecc.values.nodes import (
    NODES,
    Chosen,
    Composed,
    Computed,
    Const,
    Cycled,
    Drawn,
    FromAxisAngle,
    FromMatrix,
    FromRpy,
    Held,
    Looking,
    Node,
    Normalized,
    Pointing,
    Posed,
    Radians,
    RandomRotated,
    Rows,
    Shared,
    Stacked,
)
from scenecc.values.order import needed

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.values.work import Work


class Batch:
    """Some of the parallel scenes, for which nodes are evaluated.

    What a node gives in a scene follows from the seed, the node and the scene's index, whichever other scenes are in
    the batch. The shared draws are evaluated when they are first read, and kept.

    Args:
        scenes: indices of the scenes (B,), at least one, in any order.
        seed: of every draw, or one for each of the scenes.
        num_scenes: what `num_scenes` gives in an expression.
        draws: the shared draws by name; one may read those before it.
        given: values (N, …) that take the place of draws, row i being scene i's.
        work: counts what is computed; None: nothing does.
    """

    def __init__(
        self,
        scenes: NDArray[np.int64],
        seed: int | tuple[int, ...],
        num_scenes: int,
        draws: Mapping[str, Node],
        given: Mapping[str, NDArray[Any]],
        work: Work | None = None,
    ) -> None:
        self.scenes = np.asarray(scenes, dtype=np.int64)
        self.seed = seed
        self.num_scenes = num_scenes
        self.draws = draws
        self.given = given
        self.work = work
        self._shared: dict[str, NDArray[Any]] = {}
        self._failed: dict[str, DrawError] = {}
        self._whole: tuple[Batch, NDArray[np.intp]] | None = None

    def evaluate(self, node: Node) -> NDArray[Any]:
        """The node's values (B, …): float64, int64 or bool, or objects where they are texts, lists or mixed.

        The array may be read-only.

        Raises:
            DrawError: the node, or what it reads, has no value in one of the scenes.
        """
        return _TABLE[type(node)](self, node)

    def item(self, item: Any) -> NDArray[Any]:
        """As `evaluate`, of a plain value too."""
        if isinstance(item, NODES):
            return self.evaluate(item)
        value = columns.plain(item)
        return np.broadcast_to(value, (len(self.scenes), *value.shape))

    def shared(self, name: str) -> NDArray[Any]:
        """The values of a shared draw (B, …).

        Raises:
            DrawError: it has none in one of the scenes.
        """
        if not self._is_made(name):
            for other in needed(name, self.draws, self._is_made):
                self._make(other)
        if name in self._failed:
            error = self._failed[name]
            raise DrawError(error.message, error.scene, error.node, error.expression)
        return self._shared[name]

    def kept(self, name: str) -> NDArray[Any] | None:
        """The values of a shared draw, if they are there without evaluating anything."""
        found = self._shared.get(name)
        if found is not None:
            return found
        if name in self.given:
            found = columns.tidy(self.given[name][self.scenes])
        elif self._whole is not None:
            whole, rows = self._whole
            values = whole.kept(name)
            found = None if values is None else values[rows]
        if found is not None:
            self._shared[name] = found
        return found

    def _is_made(self, name: str) -> bool:
        return name in self._failed or self.kept(name) is not None

    def _make(self, name: str) -> None:
        try:
            self._shared[name] = self.evaluate(self.draws[name])
        except DrawError as error:
            # What reads it need not do so in that scene.
            self._failed[name] = error

    def only(self, rows: NDArray[np.intp]) -> Batch:
        """Some rows of the batch as one of their own."""
        chosen: list[int] = rows.tolist()
        seed = self.seed if isinstance(self.seed, int) else tuple(self.seed[row] for row in chosen)
        part = Batch(self.scenes[rows], seed, self.num_scenes, self.draws, self.given, self.work)
        part._whole = (self, rows)
        return part

    def selected(self, items: Sequence[Any], index: NDArray[np.int64]) -> NDArray[Any]:
        """Of several items the one with the index (B,) in each scene; the others are not evaluated there."""
        if not any(isinstance(item, NODES) for item in items):
            return columns.table(items)[index]
        parts: list[tuple[NDArray[np.intp], NDArray[Any]]] = []
        for number in np.unique(index).tolist():
            rows = np.flatnonzero(index == number)
            parts.append((rows, self.only(rows).item(items[number])))
        return columns.merged(len(self.scenes), parts)


def _rows(batch: Batch, node: Rows) -> NDArray[Any]:
    known = np.array(node.scene_idxs, dtype=np.int64)
    index = np.minimum(np.searchsorted(known, batch.scenes), max(len(known) - 1, 0))
    missing = np.flatnonzero(known[index] != batch.scenes) if known.size else np.arange(len(batch.scenes))
    if missing.size:
        raise DrawError("nothing is given for this scene", int(batch.scenes[missing[0]]), node)
    return batch.selected(node.items, index)


def _stacked(batch: Batch, node: Stacked) -> NDArray[Any]:
    parts = [batch.item(item) for item in node.items]
    if any(part.dtype == object for part in parts):
        parts = [part.astype(object) for part in parts]
    return np.stack(parts, axis=1)


_TABLE: dict[type[Any], Callable[[Batch, Any], NDArray[Any]]] = {
    Const: lambda batch, node: batch.item(node.data),
    Rows: _rows,
    Cycled: lambda batch, node: batch.selected(node.items, batch.scenes % len(node.items)),
    Chosen: lambda batch, node: batch.selected(node.items, drawing.chosen(batch, node)),
    Drawn: drawing.drawn,
    RandomRotated: drawing.rotated,
    Stacked: _stacked,
    Computed: compute,
    Shared: lambda batch, node: batch.shared(node.name),
    Posed: placing.posed,
    Normalized: placing.normalized,
    FromRpy: placing.from_rpy,
    FromAxisAngle: placing.from_axis_angle,
    FromMatrix: placing.from_matrix,
    Looking: placing.looking,
    Pointing: placing.pointing,
    Radians: placing.radians,
    Held: held,
    Composed: placing.composed,
}
