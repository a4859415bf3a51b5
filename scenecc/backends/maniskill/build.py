"""Builds a plan in a `ManiSkillScene`, and checks the plan's settings against those of the environment."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.maniskill.builders import build_actor, build_articulation, deduplicate_planes, unsupported_cameras
from scenecc.backends.maniskill.compat import UNSUPPORTED_CODE, SimConfig
from scenecc.backends.maniskill.loaded_scene import LoadedScene, ManiSkillEntityLookup
from scenecc.backends.sapien.assets import report_changed_files
from scenecc.backends.sapien.audit.scenes import BuiltScenes, audit_scenes
from scenecc.backends.sapien.constraints import ConstraintSet
from scenecc.backends.sapien.engine import EngineFailure, engine_settings, physx
from scenecc.backends.sapien.objects import DrawnObjects
from scenecc.backends.sapien.preparation import PreparedArticulation, PreparedEntity, prepare_entities
from scenecc.backends.sapien.rendering import LightSet
from scenecc.diagnostics.collector import collector_paused
from scenecc.diagnostics.diagnostic import Location, Origin
from scenecc.plan.scene import GpuMemory, Physics, process_wide_settings

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.backends.sapien.preparation import EntityLookup
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan
    from scenecc.plan.body import Friction

CONFLICT_CODE = "SC810"

_CONFLICT_HINT = (
    "make the environment with `sim_config=scenecc.maniskill.sim_config(…)` of this file, or leave the key out"
)

_DEFAULT_CONTROL_FREQ = 20
"""ManiSkill's default [Hz]."""

_SIM_FREQ_LIMIT = 1_000_000
"""[Hz] Highest simulation frequency that is accepted."""


def report_conflicts(physics: Physics, scene: Any, sink: Sink) -> bool:
    """Reports every key that conflicts with the environment's setting. Returns whether there are any."""
    found = False
    for path, said, present in _pair_settings(physics, scene):
        if not np.array_equal(np.asarray(said, np.float32), np.asarray(present, np.float32)):
            message = f"`{'.'.join(path)}` is {_format_value(said)}, but the environment has {_format_value(present)}"
            sink.report(CONFLICT_CODE, message, _key_origin(physics.origin, *path), hint=_CONFLICT_HINT)
            found = True
    return found


def physics_sim_config(physics: Physics, sink: Sink, control_freq: int | None = None) -> Any:
    """Returns ManiSkill's `SimConfig` with the settings of a plan and ManiSkill's defaults, or None after an error.

    Args:
        physics: of the plan. `sdf` is not part of ManiSkill's configuration: it is set while a scene is loaded.
        sink: receives the error about a time step that ManiSkill does not support.
        control_freq: actions per second. None: ManiSkill's 20, or the next lower divisor of the steps per second.

    Raises:
        ValueError: `control_freq` is not positive, or does not divide the steps per second.
    """
    config = SimConfig()
    if physics.timestep is not None:
        steps = round(1 / physics.timestep)
        if not 1 <= steps <= _SIM_FREQ_LIMIT or np.float32(1 / steps) != np.float32(physics.timestep):
            count = f"{1 / physics.timestep:.6g}"
            message = f"ManiSkill needs a whole number of steps per second, but {physics.timestep} s gives {count}"
            sink.report(CONFLICT_CODE, message, _key_origin(physics.origin, "timestep"), hint="use for example 0.005 s")
            return None
        config.sim_freq = steps
    config.control_freq = _control_freq(config.sim_freq, control_freq)
    given = process_wide_settings(physics)
    for name, value in {**given["scene"], **given["shape"], **given["body"]}.items():
        setattr(config.scene_config, name, value)
    if physics.gravity is not None:
        config.scene_config.gravity = list(physics.gravity)
    if physics.cpu_workers is not None:
        config.scene_config.cpu_workers = physics.cpu_workers
    if physics.scene_spacing is not None:
        config.spacing = physics.scene_spacing
    for name, value in _specified_fields(physics.default_material):
        setattr(config.default_materials_config, name, value)
    for name, value in _specified_fields(physics.gpu_memory):
        setattr(config.gpu_memory_config, name, value)
    return config


def _control_freq(sim_freq: int, requested: int | None) -> int:
    if requested is None:
        return next(each for each in range(min(_DEFAULT_CONTROL_FREQ, sim_freq), 0, -1) if sim_freq % each == 0)
    if requested < 1 or sim_freq % requested:
        raise ValueError(f"control_freq must divide the {sim_freq} steps per second, and {requested} does not")
    return requested


def _pair_settings(physics: Physics, scene: Any) -> Iterator[tuple[tuple[str, ...], Any, Any]]:
    """Yields each key that the plan sets, with its value and the environment's."""
    if physics.timestep is not None:
        yield ("timestep",), physics.timestep, scene.px.timestep
    given = process_wide_settings(physics)
    configs = {"scene": scene.px.config, "shape": physx.get_shape_config(), "body": physx.get_body_config()}
    for kind, present in configs.items():
        for name, value in given[kind].items():
            yield (name,), value, getattr(present, name)
    config = scene.sim_config
    if physics.cpu_workers is not None:
        yield ("cpu_workers",), physics.cpu_workers, config.scene_config.cpu_workers
    material = physx.get_default_material()
    for name, value in _specified_fields(physics.default_material):
        yield ("default_material", name), value, getattr(material, name)
    if physics.scene_spacing is not None:
        yield ("scene_spacing",), physics.scene_spacing, config.spacing
    for name, value in _specified_fields(physics.gpu_memory):
        yield ("gpu_memory", name), value, getattr(config.gpu_memory_config, name)


def _specified_fields(group: Friction | GpuMemory | None) -> Iterator[tuple[str, Any]]:
    if group is None:
        return
    for each in fields(group):
        if (value := getattr(group, each.name)) is not None:
            yield each.name, value


def _key_origin(origin: Origin | None, *path: str) -> Origin | Location:
    return Location(None) if origin is None else origin.child(*path)


def _format_value(value: Any) -> str:
    """Formats a value with as many digits as the engine keeps."""
    if isinstance(value, bool | int):
        return str(value).lower()
    numbers = [float(str(np.float32(number))) for number in np.ravel(value)]
    return str(numbers if np.ndim(value) else numbers[0])


_AGENT_HINT = (
    "rename one of them; if it is the agent's robot, leave this one out,"
    " or derive the task from the class that `register_env` returns"
)


def build_plan(plan: ScenePlan, scene: Any, sink: Sink, *, audit: bool) -> LoadedScene | None:
    """Implements `scenecc.backends.maniskill.instantiate`. ManiSkill must be installed."""
    if not _check_environment(plan, scene, sink):
        return None
    try:
        built = deduplicate_planes(plan) if scene.gpu_sim_enabled else plan
    except EngineFailure as failure:
        failure.report(sink, plan.origin)
        return None
    # These settings are not part of the environment.
    with engine_settings(Physics(sdf=plan.physics.sdf)), collector_paused():
        drawn, every_scene = DrawnObjects(), tuple(range(plan.num_scenes))
        # Tendons depend on the time step, which is the environment's.
        built = replace(built, physics=replace(built.physics, timestep=scene.timestep))
        prepared_entities = prepare_entities(built, every_scene, sink, drawn, rendered=scene.can_render())
        if prepared_entities is None:
            return None
        loaded = _fill_scene(plan, prepared_entities, drawn, scene, sink, audit=audit)
    return loaded if loaded is not None and report_changed_files(plan, sink) else None


def _fill_scene(
    plan: ScenePlan,
    prepared_entities: list[PreparedEntity],
    drawn: DrawnObjects,
    scene: Any,
    sink: Sink,
    *,
    audit: bool,
) -> LoadedScene | None:
    actors: dict[str, Any] = {}
    articulations: dict[str, Any] = {}
    place = plan.origin
    try:
        for prepared in prepared_entities:
            name, place = prepared.entity.name, prepared.entity.origin
            if isinstance(prepared, PreparedArticulation):
                articulations[name] = build_articulation(prepared, scene)
            else:
                actors[name] = build_actor(prepared, scene)
        place = plan.origin
        lookup = ManiSkillEntityLookup(tuple(range(plan.num_scenes)), _environment_scenes(scene), prepared_entities)
        _refuse_world_constraints(plan, scene)
        constraints = ConstraintSet(plan, lookup)
        # Lights are built once if environments are shown together, like ManiSkill's.
        once = scene.parallel_in_single_scene
        lit = ManiSkillEntityLookup((0,), lookup.scenes[:1], prepared_entities) if once else lookup
        lights = LightSet(plan, lit, rendered=True) if scene.can_render() else None
    except EngineFailure as failure:
        failure.report(sink, place)
        return None
    if audit and not audit_scenes(_built_scenes(plan, prepared_entities, lookup, constraints, lights, scene), sink):
        return None
    objects = {prepared.entity.name: prepared.objects() for prepared in prepared_entities}
    return LoadedScene(plan, scene, actors, articulations, objects, drawn, constraints, lights)


def _built_scenes(
    plan: ScenePlan,
    prepared_entities: list[PreparedEntity],
    lookup: EntityLookup,
    constraints: ConstraintSet,
    lights: LightSet | None,
    scene: Any,
) -> BuiltScenes:
    """Returns the input of the audit, before the environment sets up its simulation."""
    return BuiltScenes(
        plan,
        prepared_entities,
        lookup,
        [(one, constraints.batches[one.name]) for one in plan.constraints],
        [] if lights is None else [(light, lights.lights[light.name]) for light in plan.lights],
        rendered=lights is not None,
        shared=True,
        # ManiSkill offsets environments that are shown together.
        poses=not scene.parallel_in_single_scene,
        # On a GPU the buffers for joint positions do not exist yet, so links are not at their poses.
        link_poses=not scene.gpu_sim_enabled,
    )


def _refuse_world_constraints(plan: ScenePlan, scene: Any) -> None:
    """Raises EngineFailure for a constraint to the world if environments share one simulation."""
    for constraint in plan.constraints if scene.gpu_sim_enabled and plan.num_scenes > 1 else ():
        if constraint.parent is None:
            message = f"'{constraint.name}' is attached to the world, which environments share on the GPU"
            hint = "attach it to a static or kinematic body instead"
            raise EngineFailure(UNSUPPORTED_CODE, message, origin=constraint.origin, hint=hint)


def _environment_scenes(scene: Any) -> list[Any]:
    """Returns the scene of each environment; if they are shown together, the first for all."""
    if scene.parallel_in_single_scene:
        return [scene.sub_scenes[0]] * len(scene.sub_scenes)
    return list(scene.sub_scenes)


def _check_environment(plan: ScenePlan, scene: Any, sink: Sink) -> bool:
    """Returns whether the environment supports the plan; reports everything that it does not support."""
    contradicted = report_conflicts(plan.physics, scene, sink)
    failures = list(_name_conflicts(plan, scene))
    if scene.can_render():
        failures += unsupported_cameras(plan, on_gpu=scene.gpu_sim_enabled)
    for failure in failures:
        failure.report(sink, plan.origin)
    return not contradicted and not failures


def _name_conflicts(plan: ScenePlan, scene: Any) -> list[EngineFailure]:
    """Returns a failure for each entity whose name is taken. ManiSkill would stop in the middle of the build."""
    taken = [entity for entity in plan.entities if entity.name in scene.actors or entity.name in scene.articulations]
    return [
        EngineFailure(
            "SC809",
            f"the environment already has an object '{entity.name}'",
            origin=entity.origin,
            hint=_AGENT_HINT if entity.name in scene.articulations else "rename one of them",
        )
        for entity in taken
    ]
