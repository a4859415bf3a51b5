"""Who is in the scenes of a batch: everything that was built, and what of it is removed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.articulation_batch import ArticulationBatch
from scenecc.backends.sapien.bodies import Articulations, Bodies, entities_of
from scenecc.backends.sapien.entity_batch import EntityBatch
from scenecc.backends.sapien.parked import Parked, state_of
from scenecc.backends.sapien.place import placement_of
from scenecc.backends.sapien.place_articulation import read_articulations
from scenecc.backends.sapien.state import SceneState

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from scenecc.backends.sapien.place import Placement
    from scenecc.backends.sapien.place_articulation import ArticulationPlacement
    from scenecc.backends.sapien.state import AnyState


class Members:
    """The bodies and articulations of a batch.

    Attributes:
        held: all that were built, by name.
        entities, articulations: those that are in the scenes now, by name, in build order.
    """

    def __init__(self, held: Sequence[Bodies | Articulations]) -> None:
        self.held = {each.name: each for each in held}
        self.entities = {each.name: EntityBatch(each) for each in held if isinstance(each, Bodies)}
        self.articulations = {each.name: ArticulationBatch(each) for each in held if isinstance(each, Articulations)}
        self._order = list(self.held)
        self._removed: dict[str, EntityBatch | ArticulationBatch] = {}
        self._parked: dict[str, Parked] = {}

    def remove(self, name: str, scene_at: Callable[[int], Any]) -> None:
        """Takes one out of every scene. `scene_at`: from the plan's index to the scene.

        Raises:
            KeyError: there is none of this name.
            ValueError: it is removed already.
        """
        if name in self._removed:
            raise ValueError(f"'{name}' is removed already")
        self._removed[name] = self._present(name)
        held = self.held[name]
        if isinstance(held, Articulations):
            self._parked[name] = Parked(read_articulations(held, held.scene_idxs))
        for index, entity in entities_of(held):
            scene_at(index).remove_entity(entity)
        self.entities.pop(name, None)
        self.articulations.pop(name, None)
        self._order.remove(name)

    def add(self, name: str, scene_at: Callable[[int], Any]) -> None:
        """Puts a removed one back, as the last in build order. `scene_at`: as for `remove`.

        Raises:
            KeyError: there is none of this name.
            ValueError: it is there.
        """
        if name not in self._removed:
            self._present(name)
            raise ValueError(f"'{name}' is there; only what was removed can be added")
        held, batch = self.held[name], self._removed.pop(name)
        for index, entity in entities_of(held):
            scene_at(index).add_entity(entity)
        self._order.append(name)
        if isinstance(batch, EntityBatch):
            self.entities[name] = batch
        else:
            self.articulations[name] = batch
        if isinstance(held, Articulations):
            self._parked.pop(name).put_back(held)

    def present(self) -> Iterator[Bodies | Articulations]:
        """Those that are in the scenes now."""
        return (self.held[name] for name in self._order)

    def state(self, scene_idxs: tuple[int, ...]) -> SceneState:
        """The state of all in these scenes, and of those that are removed from them."""
        found = {name: state_of(held, self._parked.get(name), scene_idxs) for name, held in self.held.items()}
        return SceneState.of(scene_idxs, found)

    def placements(self, states: Mapping[str, AnyState]) -> list[Placement | ArticulationPlacement]:
        """What puts each where its state says, in build order; removed articulations have theirs when they are added.

        Args:
            states: by name, of some or all.
        """
        for name in self._parked.keys() & states.keys():
            self._parked[name].change(states[name])
        names = [name for name in (*self._order, *self._removed) if name in states]
        return [placement_of(self.held[name], states[name]) for name in names]

    def close(self) -> None:
        """Lets go of everything, and has what a user holds of it say so."""
        for each in (*self.entities.values(), *self.articulations.values(), *self._removed.values()):
            each._close()  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]
        self.held, self.entities, self.articulations = {}, {}, {}
        self._order, self._removed, self._parked = [], {}, {}

    def _present(self, name: str) -> EntityBatch | ArticulationBatch:
        present = {**self.entities, **self.articulations}
        if name not in present:
            raise KeyError(f"no entity '{name}'; there are {', '.join(sorted(present)) or 'none'}")
        return present[name]
