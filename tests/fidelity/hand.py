"""Scenes written by hand: plain `sapien.ActorBuilder`, as in SAPIEN's tutorial, and plans for the same.

Nothing here uses our builder. A case is a body that falls on a ground, with a box that falls on it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from scenecc.backends.sapien import SceneBatch, instantiate
from scenecc.diagnostics import Sink
from scenecc.plan import (
    BodyStructure,
    Box,
    CollisionShape,
    Entity,
    Physics,
    Plane,
    ScenePlan,
    Value,
    constant,
    per_scene,
)
from scenecc.plan.body import AssetFile, PhysicalMaterial, VisualMaterial

UP = [0.7071068, 0, -0.7071068, 0]
TURNED = [0.9238795, 0.2209424, 0.2209424, 0.2209424]
SCENES = 3

Hand = Callable[[Any, int], object]
"""What a person does to a builder, for the scene of an index."""


def turned(scene: int) -> list[float]:
    """Where the body under test starts in a scene: p, then q."""
    return [0.01 * scene, -0.02 * scene, 0.4 + 0.05 * scene, *TURNED]


@dataclass(frozen=True)
class Case:
    """A body in the plan and by hand.

    Attributes:
        structure: the body in the plan.
        builder: what a person calls on `scene.create_actor_builder()`.
        component: what a person sets on the component once it is built.
        kind: the body's type, as the hand-written code sets it.
    """

    structure: BodyStructure
    builder: Hand
    component: Hand = field(default=lambda component, scene: None)
    kind: str = "dynamic"
    files: tuple[Path, ...] = ()
    physical_materials: tuple[PhysicalMaterial, ...] = ()
    visual_materials: tuple[VisualMaterial, ...] = ()
    physics: Physics = field(default_factory=Physics)


def box_shape(*half_size: float, **knobs: Any) -> CollisionShape:
    """A colliding box."""
    return CollisionShape(Box(constant(half_size)), **knobs)


def plan_of(case: Case, *, scenes: int = SCENES) -> ScenePlan:
    """Ground, the case, and a box above it, in every scene."""
    every = tuple(range(scenes))
    ground = BodyStructure("static", (CollisionShape(Plane(), pose=constant([0, 0, 0, *UP])),))
    cap = BodyStructure("dynamic", (box_shape(0.05, 0.06, 0.07),))
    start = per_scene([turned(i) for i in every])
    return ScenePlan(
        "case",
        scenes,
        (
            Entity("ground", every, constant([0, 0, 0, 1, 0, 0, 0]), (ground,)),
            Entity("body", every, start, (case.structure,)),
            Entity("cap", every, constant([0.02, 0.01, 0.9, 1, 0, 0, 0]), (cap,)),
        ),
        case.physics,
        files=tuple(AssetFile(path.name, path) for path in case.files),
        physical_materials=case.physical_materials,
        visual_materials=case.visual_materials,
    )


def by_hand(case: Case, *, scenes: int = SCENES, rendered: bool = False) -> list[Any]:
    """The same scenes as a person would write them."""
    return [_scene(case, index, rendered=rendered) for index in range(scenes)]


def _scene(case: Case, index: int, *, rendered: bool) -> Any:
    import sapien
    from sapien import physx

    scene: Any = sapien.Scene() if rendered else sapien.Scene([physx.PhysxCpuSystem()])
    ground = scene.create_actor_builder()
    ground.add_plane_collision(pose=sapien.Pose([0, 0, 0], UP))
    ground.build_static(name="ground")

    builder = scene.create_actor_builder()
    builder.set_physx_body_type(case.kind)
    case.builder(builder, index)
    start = turned(index)
    builder.initial_pose = sapien.Pose(start[:3], start[3:])
    body = builder.build(name="body")
    case.component(body.components[-1], index)

    cap: Any = scene.create_actor_builder()
    cap.add_box_collision(half_size=[0.05, 0.06, 0.07])
    cap.initial_pose = sapien.Pose([0.02, 0.01, 0.9])
    cap.build(name="cap")
    return scene


def built(plan: ScenePlan, **options: Any) -> SceneBatch:
    """The plan's scenes; every complaint fails the test."""
    sink = Sink()
    batch = instantiate(plan, sink, **{"render": False, **options})
    assert not sink.diagnostics(), "\n".join(str(d) for d in sink.diagnostics())
    assert batch is not None
    return batch


def component(batch: SceneBatch, name: str, scene: int = 0) -> Any:
    """The first component of an entity in a scene; untyped, as the engine's stubs know only its base."""
    return batch.entities[name].objs[scene].components[0]


def flags(items: list[Any]) -> Value:
    """Booleans, a row a scene."""
    return per_scene(items, np.bool_)


def counts(items: list[Any]) -> Value:
    """Integers, a row a scene."""
    return per_scene(items, np.int64)
