"""Where the plan has every body at the start, and how a reset draws that anew."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.columns import taken
from scenecc.backends.sapien.state import EntityState, resting
from scenecc.backends.sapien.turn import parts_of, present_rows
from scenecc.values.evaluate import Batch
from scenecc.values.failure import DrawError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.plan import BodyStructure, Entity, ScenePlan, Value
    from scenecc.values.nodes import Node

VELOCITIES = ("linear_velocity", "angular_velocity")


def plan_start(plan: ScenePlan, scene_idxs: tuple[int, ...]) -> dict[str, EntityState]:
    """Of every entity that is in one of the scenes, as the plan has it."""
    found = {entity.name: _entity_start(entity, scene_idxs) for entity in plan.entities}
    return {name: state for name, state in found.items() if state is not None}


def _entity_start(entity: Entity, scene_idxs: tuple[int, ...]) -> EntityState | None:
    present, rows = present_rows(entity, scene_idxs)
    if not present:
        return None
    pose = np.broadcast_to(taken(entity.pose, rows), (len(rows), 7))
    start = resting(present, pose, np.zeros(len(rows), np.bool_))
    for part in parts_of(entity, rows):
        if part.structure.body_type == "dynamic":
            start.dynamic[part.numbers] = True
            for name, value in _velocities(part.structure):
                getattr(start, name)[part.numbers] = taken(value, part.rows)
    return start


def _velocities(structure: BodyStructure) -> list[tuple[str, Value]]:
    found = [(name, getattr(structure, name)) for name in VELOCITIES]
    return [(name, value) for name, value in found if value is not None]


class _Recipe(NamedTuple):
    """One field that a reset draws anew.

    Attributes:
        rows: which rows of the entity's start it fills, ascending.
    """

    entity: str
    field: str
    node: Node
    rows: NDArray[np.intp]


class Redraw:
    """Draws the reset-time fields of a batch anew; prepared once."""

    def __init__(self, plan: ScenePlan, scene_idxs: tuple[int, ...]) -> None:
        self._plan = plan
        self._draws: Mapping[str, Node] = dict(plan.draws)
        self._recipes = [recipe for entity in plan.entities for recipe in _recipes(entity, scene_idxs)]

    def __call__(
        self,
        start: Mapping[str, EntityState],
        scene_idxs: Sequence[int],
        seeds: Sequence[int],
        given: Mapping[str, Any],
    ) -> dict[str, EntityState]:
        """The start in some scenes, each by its own seed.

        Args:
            start: of the whole batch; it stays as it is.
            scene_idxs: which scenes.
            seeds: one a scene, in their order.
            given: in place of shared draws, name → one row a scene, in their order.

        Raises:
            ValueError: something has no value, or none that the engine can hold; entity, field and scene are named.
        """
        asked = np.array(scene_idxs, dtype=np.int64)
        found = {
            name: state.rows(np.flatnonzero(np.isin(state.scene_idxs, asked)).tolist()) for name, state in start.items()
        }
        whole = self._spread(given, asked)
        for seed, members in _by_seed(seeds):
            batch = Batch(np.sort(asked[members]), seed, self._plan.num_scenes, self._draws, whole)
            for recipe in self._recipes:
                _draw(recipe, batch, start[recipe.entity], found[recipe.entity])
        return {name: state for name, state in found.items() if state.scene_idxs}

    def _spread(self, given: Mapping[str, Any], asked: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
        """Values for some scenes as values for all, which is how the draws take them."""
        spread: dict[str, NDArray[Any]] = {}
        for name, rows in given.items():
            if name not in self._draws:
                raise ValueError(_cannot_change(name, self._draws))
            values = np.asarray(rows)
            if values.ndim == 0 or len(values) != len(asked):
                raise ValueError(f"draws['{name}'] must have a row for each of the {len(asked)} scenes that are reset")
            spread[name] = np.zeros((self._plan.num_scenes, *values.shape[1:]), values.dtype)
            spread[name][asked] = values
        return spread


def _cannot_change(name: str, draws: Mapping[str, Node]) -> str:
    known = ", ".join(draws) or "none"
    return (
        f"a reset cannot change a shared draw '{name}'; those that it can: {known}. A draw that a size, a material, a "
        "static pose or anything else that is built reads stays as built: build another batch to change it"
    )


def _recipes(entity: Entity, scene_idxs: tuple[int, ...]) -> Iterator[_Recipe]:
    present, rows = present_rows(entity, scene_idxs)
    if not present:
        return
    if entity.pose.recipe is not None:
        yield _Recipe(entity.name, "pose", entity.pose.recipe, np.arange(len(present)))
    for part in parts_of(entity, rows):
        for name, value in _velocities(part.structure):
            if value.recipe is not None:
                yield _Recipe(entity.name, name, value.recipe, part.numbers)


def _by_seed(seeds: Sequence[int]) -> list[tuple[int, NDArray[np.intp]]]:
    groups: dict[int, list[int]] = {}
    for number, seed in enumerate(seeds):
        groups.setdefault(seed, []).append(number)
    return [(seed, np.array(members, dtype=np.intp)) for seed, members in groups.items()]


def _draw(recipe: _Recipe, batch: Batch, start: EntityState, found: EntityState) -> None:
    """Fills the rows of `found` that are in the batch's scenes and have the field."""
    having = np.array(start.scene_idxs, dtype=np.int64)[recipe.rows]
    numbers = np.flatnonzero(np.isin(batch.scenes, having))
    if not numbers.size:
        return
    part = batch if len(numbers) == len(batch.scenes) else batch.only(numbers)
    try:
        drawn = part.evaluate(recipe.node)
    except DrawError as error:
        raise ValueError(f"'{recipe.entity}' in scene {error.scene}: its {recipe.field} {error.message}") from error
    with np.errstate(over="ignore"):
        values = np.asarray(drawn, dtype=np.float64).astype(np.float32)
    wrong = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if wrong.size:
        scene, shown = int(part.scenes[wrong[0]]), np.asarray(drawn)[wrong[0]].tolist()
        raise ValueError(
            f"'{recipe.entity}' in scene {scene}: its {recipe.field} is drawn as {shown}, and the engine takes "
            "finite numbers in the range of float32 alone"
        )
    getattr(found, recipe.field)[np.searchsorted(found.scene_idxs, part.scenes)] = values
