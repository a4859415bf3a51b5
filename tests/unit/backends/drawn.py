"""Plans that draw, as lowering makes them: values that hold a recipe, and data drawn by it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from scenecc.plan import (
    BodyStructure,
    Box,
    Capsule,
    CollisionShape,
    Entity,
    Physics,
    Plane,
    ScenePlan,
    Sphere,
    Value,
    constant,
    varying,
)
from scenecc.variation.evaluation import Batch
from scenecc.variation.nodes import Chosen, Const, Drawn, Key, Node, Posed, RandomRotated, Shared, Stacked

UP = [0.7071068, 0, -0.7071068, 0]
DRAWS: dict[str, Node] = {"push": Drawn("uniform", (-1.0, 1.0), (), Key("draws", "push", ""))}
BODIES = 9


def value(node: Node, scene_idxs: tuple[int, ...], num_scenes: int, seed: int, *, again: bool = True) -> Value:
    """A value that the node draws; `again`: at every reset."""
    draws: Mapping[str, Node] = DRAWS

    def draw() -> Any:
        return np.array(Batch(np.array(scene_idxs), seed, num_scenes, draws, {}).evaluate(node))

    return varying(draw, draw, scene_idxs, recipe=node if again else None)


def anywhere(name: str, height: float) -> Node:
    """A position near a height, and any rotation."""
    key = Key("entities", name, "pose.p")
    p = Drawn("uniform", ((-0.12, -0.12, height), (0.12, 0.12, height + 0.02)), (3,), key)
    return Posed(p, RandomRotated(Key("entities", name, "pose.q")))


def heap(num_scenes: int = 4, seed: int = 0, physics: Physics | None = None) -> ScenePlan:
    """A heap of bodies, a pusher, a marker, and one body in half of the scenes only.

    Sizes are drawn by seed 0, so that heaps differ by what a reset draws anew and by nothing else.
    """
    every = tuple(range(num_scenes))
    entities = [_body("ground", every, constant([0, 0, 0, *UP]), "static", Plane())]
    for number in range(BODIES):
        name = f"body_{number}"
        where = every if number != 4 else every[::2]
        size = Drawn("uniform", (0.03, 0.08), (), Key("entities", name, "shapes[0].size"))
        drawn = value(Stacked((size, size, 0.05)), where, num_scenes, 0, again=False)
        one = value(size, where, num_scenes, 0, again=False)
        geometry = (Box(drawn), Sphere(one), Capsule(one, constant(0.05)))[number % 3]
        pose = value(anywhere(name, 0.1 + 0.08 * number), where, num_scenes, seed)
        push = value(Stacked((Shared("push"), 0.0, 0.5)), where, num_scenes, seed)
        knobs = {"linear_velocity": push, "angular_velocity": constant([0, 1, 0])} if number < 3 else {}
        entities.append(_body(name, where, pose, "dynamic", geometry, **knobs))
    side = Chosen((-0.2, 0.2), None, Key("entities", "pusher", "pose.p"))
    at = value(Posed(Stacked((side, 0.0, 0.1)), Const((1.0, 0.0, 0.0, 0.0))), every, num_scenes, seed)
    entities.append(_body("pusher", every, at, "kinematic", Box(constant([0.05, 0.05, 0.1]))))
    entities.append(Entity("marker", every, constant([0, 0, 2, 1, 0, 0, 0]), (BodyStructure("none"),)))
    return ScenePlan("heap", num_scenes, tuple(entities), physics or Physics(), seed=seed, draws=tuple(DRAWS.items()))


def _body(name: str, where: tuple[int, ...], pose: Value, kind: Any, geometry: Any, **knobs: Any) -> Entity:
    # Off its centre: a pose of the body is another one than that of its centre of mass.
    local = constant([0.01, 0.005, 0, 1, 0, 0, 0]) if kind == "dynamic" else None
    return Entity(name, where, pose, (BodyStructure(kind, (CollisionShape(geometry, pose=local),), **knobs),))
