"""Bodies of a batch that can move, and where they are: for those who show a simulation as it goes on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.plan import ArticulationStructure

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.backends.sapien.batch import SceneBatch


class Moving:
    """The dynamic and kinematic bodies of a batch, and its links.

    Attributes:
        keys: of each: index of its scene, name of its entity, and its own number among the entity's bodies.
    """

    def __init__(self, batch: SceneBatch) -> None:
        """Raises RuntimeError if the batch is closed."""
        found: list[tuple[tuple[int, str, int], Any]] = []
        for entity in batch.plan.entities:
            for row, index in enumerate(entity.scene_idxs):
                if index in batch.scene_idxs:
                    found += _of(batch, entity.name, entity.structure(row), index)
        self.keys = tuple(key for key, _ in found)
        self._objs = [obj for _, obj in found]

    def poses(self) -> NDArray[np.float32]:
        """(N, 7) p [m] then q (wxyz) of each, in the world of its scene."""
        # All seven in one call: `p` and `q` each make an array, and this is asked for thirty times a second.
        rows = [obj.get_pose().__getstate__() for obj in self._objs]
        return np.array(rows, np.float32).reshape(len(rows), 7)


def _of(batch: SceneBatch, name: str, structure: Any, index: int) -> list[tuple[tuple[int, str, int], Any]]:
    if isinstance(structure, ArticulationStructure):
        articulation = batch.articulations[name]
        row = articulation.scene_idxs.index(index)
        links = [articulation.links[link.name][row].get_entity() for link in structure.links]
        return [((index, name, number), link) for number, link in enumerate(links)]
    if structure.body_type not in {"dynamic", "kinematic"}:
        return []
    entity = batch.entities[name]
    return [((index, name, 0), entity.objs[entity.scene_idxs.index(index)])]
