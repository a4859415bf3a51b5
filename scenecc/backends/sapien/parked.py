"""Articulations that are removed from their scenes: the engine knows nothing of their joints meanwhile."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.bodies import Bodies
from scenecc.backends.sapien.place import read
from scenecc.backends.sapien.place_articulation import ArticulationPlacement, read_articulations
from scenecc.backends.sapien.state import OF_ARTICULATIONS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.backends.sapien.bodies import Articulations
    from scenecc.backends.sapien.state import AnyState, ArticulationState


def state_of(held: Bodies | Articulations, parked: Parked | None, scene_idxs: Iterable[int]) -> AnyState:
    """The state of what is in these scenes, or was when it was removed."""
    if isinstance(held, Bodies):
        return read(held, scene_idxs)
    if parked is not None:
        return parked.state.rows(held.rows_in(scene_idxs))
    return read_articulations(held, scene_idxs)


class Parked:
    """The state of a removed articulation, which it had when it was removed or was given since.

    Attributes:
        state: of all its scenes.
    """

    def __init__(self, state: ArticulationState) -> None:
        self.state = state
        self._changed: set[int] = set()

    def change(self, state: AnyState) -> None:
        """Another state, of an articulation, in some of its scenes, which it gets when it is added again."""
        rows = np.searchsorted(self.state.scene_idxs, state.scene_idxs)
        for name in OF_ARTICULATIONS:
            numbers: Any = getattr(self.state, name)
            numbers[rows] = getattr(state, name)
        self._changed.update(state.scene_idxs)

    def put_back(self, held: Articulations) -> None:
        """To be called once its entities are in their scenes again, where the engine gives it what it had there."""
        if self._changed:
            placement = ArticulationPlacement(held, self.state)
            for index in self._changed:
                placement.settle(index)
