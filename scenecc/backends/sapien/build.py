"""Builds live scenes from a plan: machine, settings, loop over scenes, audit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.assets import report_changed_files
from scenecc.backends.sapien.audit.scenes import BuiltScenes, audit_scenes
from scenecc.backends.sapien.batch import SceneBatch
from scenecc.backends.sapien.constraints import ConstraintSet
from scenecc.backends.sapien.engine import (
    EngineFailure,
    engine_settings,
    new_render_system,
    physx,
    render_problem,
    sapien,
)
from scenecc.backends.sapien.objects import DrawnObjects
from scenecc.backends.sapien.preparation import EntityLookup, PreparedEntity, prepare_entities
from scenecc.backends.sapien.rendering import LightsAndCameras
from scenecc.diagnostics.collector import collector_paused
from scenecc.extras import DRIVER_HINT
from scenecc.interrupt import interrupts_wait

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from scenecc.backends.sapien.objects import ComponentBatch
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan
    from scenecc.plan.rendering import Camera, Light


def build_scenes(
    plan: ScenePlan,
    scene_idxs: tuple[int, ...],
    sink: Sink,
    *,
    rendered: bool,
    progress: Callable[[int, int], None] | None,
) -> tuple[SceneBatch, list[PreparedEntity]] | None:
    """Builds these scenes. On a failure, reports it and clears every scene."""
    drawn = DrawnObjects()
    prepared_entities = prepare_entities(plan, scene_idxs, sink, drawn, rendered=rendered)
    if prepared_entities is None:
        return None
    scenes: list[Any] = []
    try:
        scenes.extend(new_scene(plan, rendered=rendered) for _ in scene_idxs)
        fill_scenes(scenes, prepared_entities, progress)
        bodies = [prepared.objects() for prepared in prepared_entities]
        return (
            SceneBatch(plan, scene_idxs, scenes, bodies, drawn, render=rendered, sink=sink.another()),
            prepared_entities,
        )
    except BaseException as error:
        for scene in scenes:
            scene.clear()
        if not isinstance(error, EngineFailure):
            raise
        error.report(sink, plan.origin)
        return None


def new_scene(plan: ScenePlan, *, rendered: bool) -> Any:
    """Returns an empty scene with its own systems."""
    systems: list[Any] = [physx.PhysxCpuSystem()]
    if rendered:
        systems.append(new_render_system())
    with interrupts_wait():
        scene: Any = sapien.Scene(systems)
    if plan.physics.timestep is not None:
        scene.set_timestep(plan.physics.timestep)
    return scene


def fill_scenes(
    scenes: Sequence[Any], prepared_entities: Sequence[PreparedEntity], progress: Callable[[int, int], None] | None
) -> None:
    """Builds one scene after another, which is faster than one entity after another: a scene's memory stays cached.

    Raises:
        EngineFailure: the engine cannot make a shape.
    """
    order = [prepared.placer() for prepared in prepared_entities]
    for number, scene in enumerate(scenes):
        add = scene.add_entity
        for place in order:
            place(add, number)
        if progress is not None:
            progress(number + 1, len(scenes))


def build_sapien_batch(
    plan: ScenePlan,
    sink: Sink,
    scene_idxs: tuple[int, ...],
    *,
    render: bool | None,
    audit: bool,
    progress: Callable[[int, int], None] | None,
) -> SceneBatch | None:
    """Implements `scenecc.backends.sapien.instantiate`. SAPIEN must be installed."""
    try:
        rendered = _should_render(render=render)
    except EngineFailure as failure:
        failure.report(sink, plan.origin)
        return None
    # SAPIEN starts and stops its renderer for every material unless a system keeps it alive.
    renderer = new_render_system() if rendered else None
    with engine_settings(plan.physics), collector_paused():
        built = build_scenes(plan, scene_idxs, sink, rendered=rendered, progress=progress)
        if built is None:
            return None
        del renderer
        batch, prepared_entities = built
        good = False
        try:
            good = _add_constraints_and_cameras(batch, prepared_entities, sink, audit=audit) and report_changed_files(
                plan, sink
            )
        finally:
            # Also after scenecc's own errors and after Ctrl-C.
            if not good:
                batch.close()
        return batch if good else None


def _add_constraints_and_cameras(
    batch: SceneBatch, prepared_entities: list[PreparedEntity], sink: Sink, *, audit: bool
) -> bool:
    """Builds constraints, lights and cameras and, if `audit`, runs the audit. Returns False after an error."""
    plan, lookup = batch.plan, EntityLookup(batch.scene_idxs, batch.scenes, prepared_entities)
    try:
        if plan.constraints:
            batch.attach_constraints(ConstraintSet(plan, lookup))
        rendering = LightsAndCameras(plan, lookup, rendered=batch.render)
    except EngineFailure as failure:
        failure.report(sink, plan.origin)
        return False
    batch.attach_rendering(rendering)
    if not audit:
        return True
    constraints = [(one, batch.constraints[one.name]) for one in plan.constraints if one.name in batch.constraints]
    visuals: list[tuple[Light | Camera, ComponentBatch]] = []
    if batch.render:
        visuals += [(light, rendering.lights[light.name]) for light in plan.lights]
        visuals += [(camera, rendering.cameras[camera.name]) for camera in plan.cameras]
    return audit_scenes(BuiltScenes(plan, prepared_entities, lookup, constraints, visuals, rendered=batch.render), sink)


def _should_render(*, render: bool | None) -> bool:
    if render is False:
        return False
    problem = render_problem()
    if render is None or problem is None:
        return problem is None
    raise EngineFailure(
        "SC803",
        f"visuals were requested, but there is no render device: {problem}",
        hint=DRIVER_HINT,
    )
