"""A plan whose numbers were drawn, as its recipes draw them, and whose materials differ from scene to scene."""

from __future__ import annotations

import numpy as np
from plugins.plan_parts import entity, files, ground, indices, look, pose, rubbing, solid

from scenecc.plan import (
    BodyStructure,
    Box,
    CollisionShape,
    Cylinder,
    Entity,
    Physics,
    ScenePlan,
    Sphere,
    Value,
    VisualShape,
    constant,
    literal,
    per_scene,
    varying,
)
from scenecc.plan.body import PhysicalMaterial, Texture
from scenecc.variation.evaluation import Batch
from scenecc.variation.forms import Template
from scenecc.variation.nodes import Composed, Computed, Const, Drawn, Key, Node, Posed, RandomRotated, Shared, Stacked

SEED = 11
SCENES = (0, 1, 2)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)

DRAWS: tuple[tuple[str, Node], ...] = (
    ("u", Drawn("uniform", (0.0, 1.0), (), Key("draws", "u", ""))),
    ("radius", Computed(Template("${0.3 * sqrt(u)}"), ())),
    ("spot", Stacked((Shared("radius"), Drawn("normal", (0.0, 0.1, -0.2, 0.2), (), Key("draws", "spot", ""), 1), 0.4))),
)


def recipe(node: Node, scenes: tuple[int, ...] = SCENES) -> Value:
    """A value that was drawn by its recipe."""
    batch = Batch(np.array(scenes), SEED, len(SCENES), dict(DRAWS), {})
    return varying(lambda: batch.evaluate(node), lambda: batch.evaluate(node), scenes, recipe=node)


def drawn() -> ScenePlan:
    """Recipes of poses and velocities, and materials, colours and textures by scene."""
    rubber = PhysicalMaterial(per_scene([0.9, 0.5, 0.1]), literal(0.05), per_scene([0.1, 0.2, 0.3]))
    painted = look(base_color=per_scene([[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 0.5]]), roughness=0.25)
    papered = look(
        metallic=per_scene([0, 0.5, 1]),
        base_color_texture=Texture(indices(0, 1, 0), filter_mode="nearest"),
    )
    size = per_scene([[0.05, 0.05, 0.05], [0.06, 0.05, 0.04], [0.1 / 3, 0.02, 0.02]])
    crate = BodyStructure(
        "dynamic",
        (CollisionShape(Box(size), material=indices(0)),),
        (VisualShape(Box(size), material=indices(0)),),
        angular_velocity=recipe(Drawn("uniform", (-2.0, (2.0, 3.0, 4.0)), (3,), Key("entities", "crate", "w"))),
    )
    drum = BodyStructure(
        "dynamic",
        (
            CollisionShape(Cylinder(constant(0.05), constant(0.04)), material=indices(1, 0, 1)),
            CollisionShape(Sphere(constant(0.05)), pose(0, 0, 0.1), material=indices(1)),
        ),
        (VisualShape(Cylinder(constant(0.05), constant(0.04)), material=indices(2, 1, 0)),),
    )
    rock = solid(Sphere(constant(0.03)))
    slow = solid(Sphere(constant(0.02)), linear_damping=constant(2))
    spot = Posed(Shared("spot"), RandomRotated(Key("entities", "crate", "pose.q")))
    beside = Composed(spot, Const((0.0, 0.2, 0.1, *UPRIGHT)))
    high = Drawn("uniform", ((0.5, 0.5, 0.3), (0.6, 0.6, 0.5)), (3,), Key("entities", "rock", "pose.p"))
    alone = Posed(high, UPRIGHT)
    entities = (
        ground(3),
        entity("crate", recipe(spot), crate, SCENES),
        entity("drum", recipe(beside), drum, SCENES),
        entity("rock", recipe(alone, (0, 2)), rock, (0, 2)),
        Entity("pebble", (1,), recipe(alone, (1,)), (rock, slow), pick=indices(1)),
    )
    return ScenePlan(
        "drawn",
        3,
        entities,
        Physics(),
        files=files("checker.png", "bumps.png"),
        physical_materials=(rubber, rubbing(0.4, 0.3, 0.5)),
        visual_materials=(painted, papered, look(ior=1.5)),
        seed=SEED,
        draws=DRAWS,
    )
