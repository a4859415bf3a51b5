"""The initial state of every body of a batch, as planned or as drawn by a reset."""

from __future__ import annotations

from functools import cached_property
from itertools import repeat
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.objects import ArticulationObjects, BodyObjects
from scenecc.backends.sapien.preparation import StructureRows, group_by_structure
from scenecc.backends.sapien.properties import rows_in_scenes, select_rows
from scenecc.backends.sapien.state import AnyState, ArticulationState, bodies_at_rest
from scenecc.diagnostics.messages import cut
from scenecc.plan import ArticulationStructure, BodyStructure
from scenecc.plan.articulation import JOINT_STATE_FIELDS, VELOCITY_FIELDS
from scenecc.plan.scene import is_unnamed_draw
from scenecc.plan.starts import StartTable, places_followers
from scenecc.variation.evaluation import Batch, to_field_rows
from scenecc.variation.injected_draws import InjectedDrawError, convert_injected, draw_type
from scenecc.variation.node_bounds import BoundsAnalysis
from scenecc.variation.nodes import Computed, Node, Rows
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from collections.abc import Container, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.plan import Entity, ScenePlan, Value


class _SampledField(NamedTuple):
    """One field that a reset redraws, in the batch's scenes that have it.

    `column` is that of the joint named `joint`. None: the field is a pose or a velocity.
    """

    entity: str
    field: str
    node: Node
    scene_idxs: frozenset[int]
    column: int | None = None
    joint: str = ""

    @property
    def what(self) -> str:
        """The field's name in messages."""
        return self.field if self.column is None else f"{self.field} of joint '{self.joint}'"


class ResetSampler:
    """Samples the initial state of a batch. Prepared once, at the first reset."""

    def __init__(
        self, plan: ScenePlan, scene_idxs: tuple[int, ...], objects: Mapping[str, BodyObjects | ArticulationObjects]
    ) -> None:
        self._plan = plan
        self._draws: Mapping[str, Node] = dict(plan.draws)
        # Values that are not redrawn are rows of the plan.
        self._drawn_again = [
            name for name, node in plan.draws if not isinstance(node, Rows) and not is_unnamed_draw(name)
        ]
        found = [(entity, *rows_in_scenes(entity, scene_idxs)) for entity in plan.entities]
        present = [each for each in found if each[1]]
        self._states = {
            entity.name: _planned_state(entity, where, rows, objects[entity.name]) for entity, where, rows in present
        }
        self._row_of = {
            name: {index: row for row, index in enumerate(state.scene_idxs)} for name, state in self._states.items()
        }
        self._placed: list[_SampledField] = []
        self._recipes = [recipe for each in present for recipe in _sampled_fields(*each, objects[each[0].name])]
        self._starts = StartTable(plan) if plan.starts else None
        self._objects = objects
        if plan.placements:
            from scenecc.placing.at_reset import placed_members

            placed = placed_members(plan)
            self._placed = [one for one in self._recipes if one.field == "pose" and one.entity in placed]
            self._recipes = [one for one in self._recipes if one not in self._placed]
        self._places = bool(plan.placements) and (self._starts is None or places_followers(plan))

    def batch(self, scene_idxs: Sequence[int], seeds: Sequence[int], given: Mapping[str, Any]) -> Batch:
        """Returns a batch that evaluates recipes in some scenes, by ascending index, each with its own seed.

        Args:
            scene_idxs: the scenes.
            seeds: one for each scene, in their order.
            given: replaces shared draws: name → one row for each scene, in their order.

        Raises:
            ValueError: a given value has the wrong type or shape for its draw, or the scenes begin at starts and values
                are given, or a scene has no start.
        """
        whole = self._expand_given(given, scene_idxs)
        if self._starts is not None:
            if given:
                raise ValueError("draws cannot be given: the scenes begin at starts, which have their own draws")
            seeds = self._starts.seeds(scene_idxs, seeds)
        chosen = sorted(scene_idxs)
        seed_of = dict(zip(scene_idxs, seeds, strict=True))
        one = seeds[0] if len(set(seeds)) == 1 else tuple(seed_of[index] for index in chosen)
        return Batch(np.array(chosen, dtype=np.int64), one, self._plan.num_scenes, self._draws, whole)

    def drawn(self, batch: Batch) -> dict[str, AnyState]:
        """Returns the initial state of every entity in the scenes of a batch.

        Raises:
            ValueError: a value is undefined, or the engine cannot hold it; the message names entity, field and scene.
        """
        chosen: list[int] = batch.scenes.tolist()
        rows_of = {name: [rows[i] for i in chosen if i in rows] for name, rows in self._row_of.items()}
        found = {name: state.rows(rows_of[name]) for name, state in self._states.items() if rows_of[name]}
        for recipe in self._recipes:
            if recipe.entity in found:
                _sample_field(recipe, batch, found[recipe.entity])
        if self._places:
            from scenecc.placing.at_reset import place_anew

            place_anew(self._plan, batch, {name: (state.scene_idxs, state.pose) for name, state in found.items()})
            for recipe in self._placed:
                if recipe.entity in found:
                    _sample_field(recipe, batch, found[recipe.entity])
        if self._starts is not None:
            self._begin_at_starts(self._starts, batch, found)
        return found

    def _begin_at_starts(self, starts: StartTable, batch: Batch, found: Mapping[str, AnyState]) -> None:
        """Sets the poses and joint positions of the starts, at rest."""
        seeds = repeat(batch.seed) if isinstance(batch.seed, int) else batch.seed
        row_of = {name: {index: row for row, index in enumerate(state.scene_idxs)} for name, state in found.items()}
        for scene, seed in zip(batch.scenes.tolist(), seeds, strict=False):
            for (entity, *_), pose, qpos in starts.states(scene, seed):
                state, row = found[entity.name], row_of[entity.name][scene]
                state.pose[row], state.linear_velocity[row], state.angular_velocity[row] = pose, 0, 0
                if isinstance(state, ArticulationState):
                    objects = self._objects[entity.name]
                    assert isinstance(objects, ArticulationObjects)
                    columns = objects.columns[objects.row_of[scene]]
                    state.qpos[row, columns], state.qvel[row, columns] = qpos, 0

    def _expand_given(self, given: Mapping[str, Any], scene_idxs: Sequence[int]) -> dict[str, NDArray[Any]]:
        """Expands values for some scenes to arrays for all scenes, which the draws need."""
        spread: dict[str, NDArray[Any]] = {}
        for name, rows in given.items():
            if name not in self._drawn_again:
                raise ValueError(_fixed_draw_message(name, self._drawn_again))
            wanted = draw_type(self._draws[name], self._supports.shared(name))
            try:
                values = convert_injected(rows, wanted, len(scene_idxs))
            except InjectedDrawError as error:
                rows_of = f": {error.hint} that is reset" if error.hint else ""
                raise ValueError(f"draws['{name}'] {error}{rows_of}") from None
            spread[name] = np.zeros((self._plan.num_scenes, *values.shape[1:]), values.dtype)
            spread[name][list(scene_idxs)] = values
        return spread

    @cached_property
    def _supports(self) -> BoundsAnalysis:
        return BoundsAnalysis(self._draws, self._plan.num_scenes)


def _fixed_draw_message(name: str, names: Sequence[str]) -> str:
    known = ", ".join(names) or "none"
    return (
        f"a reset cannot change the shared draw '{name}', only these: {known}. Draws of sizes, materials, static "
        "poses and other built values stay as built: build another batch to change them"
    )


def _planned_state(
    entity: Entity, scene_idxs: tuple[int, ...], rows: NDArray[np.intp], objects: BodyObjects | ArticulationObjects
) -> AnyState:
    """Returns the planned initial state of an entity."""
    pose = np.broadcast_to(select_rows(entity.pose, rows), (len(rows), 7))
    if isinstance(objects, ArticulationObjects):
        whole = ArticulationState.at_rest(scene_idxs, pose, objects.dof)
        for part in group_by_structure(entity, rows):
            if isinstance(part.structure, ArticulationStructure):
                _fill_articulation_state(whole, part.structure, part, objects)
        return whole
    start = bodies_at_rest(scene_idxs, pose, np.zeros(len(rows), np.bool_))
    for part in group_by_structure(entity, rows):
        if isinstance(part.structure, BodyStructure) and part.structure.body_type == "dynamic":
            start.dynamic[part.numbers] = True
            for name, value in _specified_fields(part.structure, VELOCITY_FIELDS):
                getattr(start, name)[part.numbers] = select_rows(value, part.rows)
    return start


def _fill_articulation_state(
    start: ArticulationState, structure: ArticulationStructure, part: StructureRows[Any], objects: ArticulationObjects
) -> None:
    """Fills the rows of a structure."""
    for name, value in _specified_fields(structure, VELOCITY_FIELDS):
        getattr(start, name)[part.numbers] = select_rows(value, part.rows)
    joints = structure.active_joints
    columns = objects.columns[int(part.numbers[0])]
    for field in JOINT_STATE_FIELDS:
        numbers = getattr(start, field)
        for joint, column in zip(joints, columns.tolist(), strict=True):
            for _, value in _specified_fields(joint, (field,)):
                numbers[part.numbers, column] = select_rows(value, part.rows)
    for field in (*JOINT_STATE_FIELDS, "qf"):
        getattr(start, field)[part.numbers, len(joints) :] = np.nan


def _sampled_fields(
    entity: Entity, scene_idxs: tuple[int, ...], rows: NDArray[np.intp], objects: BodyObjects | ArticulationObjects
) -> Iterator[_SampledField]:
    if entity.pose.recipe is not None:
        yield _SampledField(entity.name, "pose", entity.pose.recipe, frozenset(scene_idxs))
    for part in group_by_structure(entity, rows):
        numbers: list[int] = part.numbers.tolist()
        where = frozenset(scene_idxs[number] for number in numbers)
        for name, value in _specified_fields(part.structure, VELOCITY_FIELDS):
            if value.recipe is not None:
                yield _SampledField(entity.name, name, value.recipe, where)
        if isinstance(objects, ArticulationObjects) and isinstance(part.structure, ArticulationStructure):
            columns: list[int] = objects.columns[numbers[0]].tolist()
            for joint, column in zip(part.structure.active_joints, columns, strict=True):
                for name, value in _specified_fields(joint, JOINT_STATE_FIELDS):
                    if value.recipe is not None:
                        yield _SampledField(entity.name, name, value.recipe, where, column, joint.name)


def _specified_fields(holder: object, fields: Sequence[str]) -> list[tuple[str, Value]]:
    """Returns the given fields that the plan sets, with their values."""
    found = [(name, getattr(holder, name)) for name in fields]
    return [(name, value) for name, value in found if value is not None]


def part_in_scenes(batch: Batch, scene_idxs: Container[int]) -> Batch | None:
    """Returns the part of a batch in some scenes, or None if it has none of them."""
    having = [number for number, index in enumerate(batch.scenes.tolist()) if index in scene_idxs]
    if not having:
        return None
    return batch if len(having) == len(batch.scenes) else batch.only(np.array(having, dtype=np.intp))


def sample_value(batch: Batch, node: Node, who: str, what: str, *, cite: bool = False) -> NDArray[np.float64]:
    """Returns what a reset draws, a row for each scene. `who`, `what`: names of owner and value for messages.

    `cite`: name the expression of the file that has no value, which may belong to a shared draw.

    Raises:
        ValueError: the value is undefined.
    """
    try:
        return np.asarray(to_field_rows(batch.evaluate(node)), np.float64)
    except DrawError as error:
        message = f"'{who}' in scene {error.scene}: its {what} has no value: {error.message}"
        if cite and isinstance(error.node, Computed):
            message = f"{message}, in {cut(error.node.template.text)!r}"
        raise ValueError(message) from None


def check_drawn_finite(drawn: NDArray[np.float64], batch: Batch, who: str, what: str) -> None:
    """Raises ValueError for values that do not fit in float32. Arguments are as for `sample_value`."""
    with np.errstate(over="ignore"):
        wrong = np.flatnonzero(~np.isfinite(drawn.astype(np.float32)).reshape(len(drawn), -1).all(axis=1))
    if wrong.size:
        scene, shown = int(batch.scenes[wrong[0]]), drawn[wrong[0]].tolist()
        raise ValueError(
            f"'{who}' in scene {scene}: the drawn {what} is {shown}; values must be finite and fit in float32"
        )


def _sample_field(recipe: _SampledField, batch: Batch, found: AnyState) -> None:
    """Fills the rows of `found` in the batch's scenes that have the field."""
    part = part_in_scenes(batch, recipe.scene_idxs)
    if part is None:
        return
    values = sample_value(part, recipe.node, recipe.entity, recipe.what, cite=True)
    check_drawn_finite(values, part, recipe.entity, recipe.what)
    rows = np.searchsorted(found.scene_idxs, part.scenes)
    numbers = getattr(found, recipe.field)
    if recipe.column is None:
        numbers[rows] = values
    else:
        numbers[rows, recipe.column] = values
