"""A plan to live scenes, against the loops that people write."""

from __future__ import annotations

import io
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from benchmarks.paired import Row, Side, alternating, best, ratios
from benchmarks.sources import boxes, plain_scene_text

if TYPE_CHECKING:
    from scenecc.plan import ScenePlan

SCENES, BODIES = 256, 20


def run(repetitions: int) -> list[Row]:
    """256 scenes × 20 boxes, physics only. Scenes are made before the clock starts, on every side by one function."""
    from scenecc import compile_scene

    plan = compile_scene(io.StringIO(plain_scene_text(BODIES)), num_scenes=SCENES)
    numbers = _numbers(plan)
    sides: list[Side] = [
        ours(lambda: plan, audit=False),
        ours(lambda: plan, audit=True),
        _by_hand(lambda scenes: _actor_builder(scenes, numbers)),
        _by_hand(lambda scenes: add_components(scenes, numbers)),
    ]
    rounds = alternating(sides, repetitions)
    what = f"instantiate {SCENES} × {BODIES} boxes"
    names = ("audit off", "default audit", "ActorBuilder", "components")
    note = ", ".join(f"{best(rounds, side)} ({name})" for side, name in enumerate(names))
    return [
        Row("instantiate", f"{what}, audit off / ActorBuilder loop", ratios(rounds, 0, 2), 0.75, note=note),
        Row("instantiate", f"{what}, audit off / component loop", ratios(rounds, 0, 3), 1.3, 1.1),
        Row("instantiate", f"{what}, default audit alone / component loop", ratios(rounds, 1, 3, less=0), 0.35),
    ]


def ours(make: Callable[[], ScenePlan], *, audit: bool) -> Side:
    """A plan to live scenes, physics only. The plan and the empty scenes are made before the clock starts."""
    from scenecc.backends.sapien import build, instantiate
    from scenecc.diagnostics import Sink

    def side() -> float:
        plan = make()
        scenes = [build.new_scene(plan, rendered=False) for _ in range(plan.num_scenes)]
        ready, made = iter(scenes), build.new_scene
        build.new_scene = lambda plan, *, rendered: next(ready)  # noqa: ARG005 - the making of scenes is off the clock
        try:
            started = time.perf_counter()
            batch = instantiate(plan, Sink(), render=False, audit=audit)
            seconds = time.perf_counter() - started
        finally:
            build.new_scene = made
        assert batch is not None
        assert len(batch.entities) == len(plan.entities)
        batch.close()
        return seconds

    return side


def _by_hand(loop: Callable[[list[Any]], list[Any]]) -> Side:
    import sapien
    from sapien import physx

    def side() -> float:
        scenes = [sapien.Scene([physx.PhysxCpuSystem()]) for _ in range(SCENES)]
        started = time.perf_counter()
        made = loop(scenes)
        seconds = time.perf_counter() - started
        assert len(made) == SCENES * BODIES
        for scene in scenes:
            scene.clear()
        return seconds

    return side


Numbers = list[tuple[str, list[float], list[float], list[float]]]
"""Name, half size, p and q of each box."""


def _numbers(plan: Any) -> Numbers:
    found: Numbers = []
    for entity, box in zip(plan.entities, boxes(BODIES), strict=True):
        p, q = entity.pose.data[0, :3].tolist(), entity.pose.data[0, 3:].tolist()
        found.append((entity.name, list(box.half), p, q))
    return found


def _actor_builder(scenes: list[Any], numbers: Numbers) -> list[Any]:
    import sapien

    made: list[Any] = []
    for scene in scenes:
        for name, half_size, p, q in numbers:
            builder = scene.create_actor_builder()
            builder.add_box_collision(half_size=half_size)
            builder.initial_pose = sapien.Pose(p, q)
            made.append(builder.build(name=name))
    return made


def add_components(scenes: list[Any], numbers: Numbers) -> list[Any]:
    import sapien
    from sapien import physx

    made: list[Any] = []
    material = physx.get_default_material()
    ready = [(name, half_size, sapien.Pose(p, q)) for name, half_size, p, q in numbers]
    for scene in scenes:
        for name, half_size, pose in ready:
            component = physx.PhysxRigidDynamicComponent()
            shape = physx.PhysxCollisionShapeBox(half_size=half_size, material=material)
            shape.set_collision_groups([1, 1, 0, 0])
            shape.set_density(1000)
            component.attach(shape)
            entity = sapien.Entity()
            entity.add_component(component)
            entity.set_name(name)
            entity.set_pose(pose)
            scene.add_entity(entity)
            made.append(entity)
    return made
