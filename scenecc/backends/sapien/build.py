"""The loop that fills scenes: every scene gets its entities in the order of the plan."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.batch import EntityBatch, SceneBatch
from scenecc.backends.sapien.builder import BatchActorBuilder
from scenecc.backends.sapien.engine import physx, render, sapien
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.backends.sapien.resources import Resources

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.diagnostics import Sink
    from scenecc.plan import Entity, ScenePlan

Make = "Callable[[int], tuple[Any, Any]]"


@dataclass(slots=True)
class Turn:
    """An entity's part in the loop over scenes.

    Attributes:
        make: builds a row; None: it depends on the scene.
        table: for each scene that is built (make, row), or None where the entity is not in it.
        rows: rows of the entity's values that are built, ascending.
        builders: the structures that occur, each with the rows (among `rows`) that have it.
        objs, components: what was built, a row each.
    """

    entity: Entity
    make: Callable[[int], tuple[Any, Any]] | None
    table: list[tuple[Callable[[int], tuple[Any, Any]], int] | None]
    scene_idxs: tuple[int, ...]
    rows: np.ndarray[Any, np.dtype[np.intp]]
    picks: np.ndarray[Any, np.dtype[np.intp]]
    objs: list[Any] = field(default_factory=list)
    components: list[Any] = field(default_factory=list)


def build_scenes(
    plan: ScenePlan,
    scene_idxs: tuple[int, ...],
    sink: Sink,
    *,
    rendered: bool,
    progress: Callable[[int, int], None] | None,
) -> tuple[SceneBatch, list[Turn]] | None:
    """Builds the scenes named; after a failure, which is reported, nothing is left of them."""
    turns = prepare(plan, scene_idxs, sink, rendered=rendered)
    if turns is None:
        return None
    scenes = [new_scene(plan, rendered=rendered) for _ in scene_idxs]
    try:
        fill(scenes, turns, progress)
    except EngineFailure as failure:
        report(failure, sink, plan)
        for scene in scenes:
            scene.clear()
        return None
    entities = {
        turn.entity.name: EntityBatch(turn.entity.name, turn.scene_idxs, turn.objs, turn.components) for turn in turns
    }
    return SceneBatch(plan, scene_idxs, scenes, entities, render=rendered), turns


def new_scene(plan: ScenePlan, *, rendered: bool) -> Any:  # noqa: ANN401 - a sapien.Scene
    """An empty scene with systems of its own."""
    systems: list[Any] = [physx.PhysxCpuSystem()]
    if rendered:
        systems.append(render.RenderSystem())
    scene = sapien.Scene(systems)
    if plan.physics.timestep is not None:
        scene.set_timestep(plan.physics.timestep)
    return scene


def prepare(plan: ScenePlan, scene_idxs: tuple[int, ...], sink: Sink, *, rendered: bool) -> list[Turn] | None:
    """Everything that is done once: argument tables, materials, and every mesh cooked.

    All that fail are reported, not only the first.
    """
    resources = Resources(plan)
    turns: list[Turn] = []
    failed = False
    for entity in plan.entities:
        try:
            turn, failures = _turn(entity, scene_idxs, resources, rendered=rendered)
        except EngineFailure as failure:
            turn, failures = None, [failure]
        for failure in failures:
            report(failure, sink, entity)
        failed = failed or bool(failures)
        if turn is not None:
            turns.append(turn)
    return None if failed else turns


def _turn(
    entity: Entity, scene_idxs: tuple[int, ...], resources: Resources, *, rendered: bool
) -> tuple[Turn | None, list[EngineFailure]]:
    row_of = {index: row for row, index in enumerate(entity.scene_idxs)}
    present = [index for index in scene_idxs if index in row_of]
    if not present:
        return None, []
    rows = np.array([row_of[index] for index in present], dtype=np.intp)
    picks = np.zeros(len(rows), np.intp) if entity.pick is None else np.array(entity.pick, np.intp)[rows]
    failures: list[EngineFailure] = []
    makes: dict[int, Callable[[int], tuple[Any, Any]]] = {}
    number_in_structure = np.empty(len(rows), np.intp)
    for structure in np.unique(picks).tolist():
        chosen = np.flatnonzero(picks == structure)
        number_in_structure[chosen] = np.arange(len(chosen))
        builder = BatchActorBuilder(entity, entity.structures[structure], rows[chosen], resources, rendered=rendered)
        failures += builder.cook()
        makes[structure] = builder.make
    if len(makes) == 1 and len(present) == len(scene_idxs):
        return Turn(entity, next(iter(makes.values())), [], tuple(present), rows, picks), failures
    each = zip(present, picks.tolist(), number_in_structure.tolist(), strict=True)
    table = {index: (makes[pick], number) for index, pick, number in each}
    return Turn(entity, None, [table.get(index) for index in scene_idxs], tuple(present), rows, picks), failures


def fill(scenes: list[Any], turns: list[Turn], progress: Callable[[int, int], None] | None) -> None:
    """Builds scene after scene: faster than entity after entity, since a scene's memory stays warm.

    Raises:
        EngineFailure: with the entity's origin where a shape's is not known.
    """
    plan = [(t.make, t.table, t.objs.append, t.components.append) for t in turns]
    for number, scene in enumerate(scenes):
        add = scene.add_entity
        for make, table, keep, keep_component in plan:
            row = number
            if make is None:
                turn = table[number]
                if turn is None:
                    continue
                make, row = turn
            entity, component = make(row)
            add(entity)
            keep(entity)
            keep_component(component)
        if progress is not None:
            progress(number + 1, len(scenes))


def report(failure: EngineFailure, sink: Sink, place: Any) -> None:  # noqa: ANN401 - whatever has an origin
    """Puts a failure into the sink, at the node that asked or else at `place`."""
    from scenecc.diagnostics import Location

    origin = failure.origin or place.origin
    sink.report(failure.code, failure.message, origin or Location(None), hint=failure.hint)
