"""The loop that fills scenes: every scene gets its entities in the order of the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.assets_on_disk import check_unchanged, refresh
from scenecc.backends.sapien.batch import SceneBatch
from scenecc.backends.sapien.engine import physx, render, sapien
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.backends.sapien.resources import Resources
from scenecc.backends.sapien.turn import take_turn
from scenecc.diagnostics import Location
from scenecc.interrupt import interrupts_wait

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from scenecc.backends.sapien.turn import AnyTurn
    from scenecc.diagnostics import Origin, Sink
    from scenecc.plan import ScenePlan


def build_scenes(
    plan: ScenePlan,
    scene_idxs: tuple[int, ...],
    sink: Sink,
    *,
    rendered: bool,
    progress: Callable[[int, int], None] | None,
) -> tuple[SceneBatch, list[AnyTurn]] | None:
    """Builds the scenes named; after a failure, which is reported, nothing is left of them."""
    turns = prepare(plan, scene_idxs, sink, rendered=rendered)
    if turns is None:
        return None
    scenes: list[Any] = []
    try:
        scenes.extend(new_scene(plan, rendered=rendered) for _ in scene_idxs)
        fill(scenes, turns, progress)
        bodies = [turn.held() for turn in turns]
        return SceneBatch(plan, scene_idxs, scenes, bodies, render=rendered, sink=sink.another()), turns
    except BaseException as error:
        for scene in scenes:
            scene.clear()
        if not isinstance(error, EngineFailure):
            raise
        report(error, sink, plan.origin)
        return None


def new_scene(plan: ScenePlan, *, rendered: bool) -> Any:
    """An empty scene with systems of its own."""
    systems: list[Any] = [physx.PhysxCpuSystem()]
    if rendered:
        systems.append(render.RenderSystem())
    with interrupts_wait():
        scene: Any = sapien.Scene(systems)
    if plan.physics.timestep is not None:
        scene.set_timestep(plan.physics.timestep)
    return scene


def prepare(plan: ScenePlan, scene_idxs: tuple[int, ...], sink: Sink, *, rendered: bool) -> list[AnyTurn] | None:
    """Everything that is done once: argument tables, materials, and every mesh cooked.

    All that fail are reported, not only the first.
    """
    refresh(plan, rendered=rendered)
    resources = Resources(plan)
    turns: list[AnyTurn] = []
    failed, crowded = False, None
    for entity in plan.entities:
        try:
            turn, failures = take_turn(entity, scene_idxs, resources, rendered=rendered)
        except EngineFailure as failure:
            turn, failures = None, [failure]
        for failure in failures:
            report(failure, sink, entity.origin)
        failed = failed or bool(failures)
        if turn is not None:
            turns.append(turn)
        if crowded is None and resources.crowded():
            crowded = entity
    if crowded is not None and (failure := resources.crowded()):
        report(failure, sink, crowded.origin)
        failed = True
    return None if failed else turns


def fill(scenes: Sequence[Any], turns: Sequence[AnyTurn], progress: Callable[[int, int], None] | None) -> None:
    """Builds scene after scene: faster than entity after entity, since a scene's memory stays warm.

    Raises:
        EngineFailure: the engine cannot make a shape.
    """
    order = [turn.placer() for turn in turns]
    for number, scene in enumerate(scenes):
        add = scene.add_entity
        for place in order:
            place(add, number)
        if progress is not None:
            progress(number + 1, len(scenes))


def unchanged(plan: ScenePlan, sink: Sink) -> bool:
    """Whether the files that the engine has opened are those that were checked; reported where they are not."""
    try:
        check_unchanged(plan.files)
    except EngineFailure as failure:
        report(failure, sink, plan.origin)
        return False
    return True


def report(failure: EngineFailure, sink: Sink, place: Origin | None) -> None:
    """Puts a failure into the sink, at the node that asked or else at `place`."""
    sink.report(failure.code, failure.message, failure.origin or place or Location(None), hint=failure.hint)
