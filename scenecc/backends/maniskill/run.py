"""From a plan to a filled scene of ManiSkill's, readable top to bottom."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.maniskill.actors import build_actor
from scenecc.backends.maniskill.articulations import build_articulation
from scenecc.backends.maniskill.fastened import InManiSkill, Lights, Ties
from scenecc.backends.maniskill.loaded import LoadedScene
from scenecc.backends.maniskill.planes import planes_once
from scenecc.backends.maniskill.sensors import unfit_for_sensors
from scenecc.backends.maniskill.settings import contradictions
from scenecc.backends.sapien.build import prepare, report, unchanged
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.backends.sapien.settings import engine_settings
from scenecc.backends.sapien.turn import ArticulationTurn
from scenecc.diagnostics.collector import collector_paused
from scenecc.plan import Physics

if TYPE_CHECKING:
    from scenecc.backends.sapien.turn import AnyTurn
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan

_OF_AN_AGENT = (
    "call one of them otherwise; if it is the agent's robot, leave this one out,"
    " or derive the task from the class that `register_env` returns"
)


def run(plan: ScenePlan, scene: Any, sink: Sink) -> LoadedScene | None:
    """`scenecc.backends.maniskill.instantiate` once ManiSkill is known to be there."""
    if not _fits(plan, scene, sink):
        return None
    try:
        built = planes_once(plan) if scene.gpu_sim_enabled else plan
    except EngineFailure as failure:
        report(failure, sink, plan.origin)
        return None
    # The environment has no say in these alone.
    with engine_settings(Physics(sdf=plan.physics.sdf)), collector_paused():
        turns = prepare(built, tuple(range(plan.num_scenes)), sink, rendered=scene.can_render())
        loaded = None if turns is None else _filled(plan, turns, scene, sink)
    return loaded if loaded is not None and unchanged(plan, sink) else None


def _filled(plan: ScenePlan, turns: list[AnyTurn], scene: Any, sink: Sink) -> LoadedScene | None:
    actors: dict[str, Any] = {}
    articulations: dict[str, Any] = {}
    place = plan.origin
    try:
        for turn in turns:
            name, place = turn.entity.name, turn.entity.origin
            if isinstance(turn, ArticulationTurn):
                articulations[name] = build_articulation(turn, scene)
            else:
                actors[name] = build_actor(turn, scene)
        place = plan.origin
        standing = InManiSkill(tuple(range(plan.num_scenes)), _scenes(scene), turns)
        ties = Ties(plan, standing, scene)
        lights = Lights(plan, _lit(standing, scene, turns)) if scene.can_render() else None
    except EngineFailure as failure:
        report(failure, sink, place)
        return None
    held = {turn.entity.name: turn.held() for turn in turns}
    return LoadedScene(plan, scene, actors, articulations, held, ties, lights)


def _scenes(scene: Any) -> list[Any]:
    """The scene of each environment; where they are shown together, it is the first for all."""
    if scene.parallel_in_single_scene:
        return [scene.sub_scenes[0]] * len(scene.sub_scenes)
    return list(scene.sub_scenes)


def _lit(standing: InManiSkill, scene: Any, turns: list[AnyTurn]) -> InManiSkill:
    """Where lights are built: once where environments are shown together, as ManiSkill's."""
    return InManiSkill((0,), standing.scenes[:1], turns) if scene.parallel_in_single_scene else standing


def _fits(plan: ScenePlan, scene: Any, sink: Sink) -> bool:
    """Whether the environment can have the plan; everything that it cannot have is reported."""
    contradicted = contradictions(plan.physics, scene, sink)
    failures = list(_taken_names(plan, scene))
    if scene.can_render():
        failures += unfit_for_sensors(plan)
    for failure in failures:
        report(failure, sink, plan.origin)
    return not contradicted and not failures


def _taken_names(plan: ScenePlan, scene: Any) -> list[EngineFailure]:
    """Objects of names that the environment has already; ManiSkill would stop in between."""
    taken = [entity for entity in plan.entities if entity.name in scene.actors or entity.name in scene.articulations]
    return [
        EngineFailure(
            "SC809",
            f"the environment has an object '{entity.name}' already",
            origin=entity.origin,
            hint=_OF_AN_AGENT if entity.name in scene.articulations else "call one of them otherwise",
        )
        for entity in taken
    ]
