"""Constraints, lights and cameras made by hand, free and fastened to bodies and links."""

from __future__ import annotations

from typing import Any

import numpy as np
from plugins.plan_parts import entity, files, ground, indices, look, pose, poses, rubbing, solid
from plugins.robot_plans import arm, crawler

from scenecc.plan import (
    AxisDrive,
    AxisLimit,
    Box,
    Camera,
    Connection,
    Constraint,
    DirectionalLight,
    Distance,
    Drive,
    Entity,
    Environment,
    Intrinsic,
    Light,
    Mount,
    Orthographic,
    Perspective,
    Physics,
    PointLight,
    ScenePlan,
    Shadow,
    Sphere,
    SpotLight,
    TexturedLight,
    Weld,
    constant,
    literal,
    per_scene,
)
from scenecc.plan.body import Texture

BOTH = (0, 1)


def constraints() -> tuple[Constraint, ...]:
    """Between bodies, links and the world, some by scene."""
    drive = Drive(
        limits=(AxisLimit("x", constant([-0.1, 0.1])), AxisLimit("y", per_scene([[0, 0], [-0.1, 0.2]]))),
        drives=(
            AxisDrive("z", literal(50), per_scene([5, 10]), literal(20)),
            AxisDrive("slerp", literal(1), literal(0.1), mode="acceleration"),
        ),
        target=pose(0, 0, 0.1),
        linear_velocity_target=constant([0, 0, 0.1]),
        angular_velocity_target=constant([0, 0, 0.2]),
    )
    above, distance = pose(0, 0, 0.1), Distance(constant([0.1, 0.3]), literal(20), literal(1))
    nails = poses((1, 0, 0.5), (1, 0, 0.6))
    return (
        Constraint("held", BOTH, Weld(), Mount("block_0"), Mount("arm_0", "hand"), pose(0.05, 0, 0)),
        Constraint("hung", BOTH, Connection(), Mount("block_1"), None, nails, above),
        Constraint("tied", (1,), distance, Mount("ball"), Mount("block_2")),
        Constraint("pulled", BOTH, drive, Mount("crawler", "trunk"), Mount("ball")),
    )


def lights() -> tuple[Light, ...]:
    """Of every type that needs no ray tracing."""
    shade = Shadow(literal(True, "bool"), literal(0.5), literal(20), map_size=literal(1024, "int64"))
    sun = DirectionalLight()
    cone: dict[str, Any] = {"inner_fov": literal(0.5), "outer_fov": literal(1)}
    picture = TexturedLight(**cone, texture=Texture(indices(2)))
    down = (0.7071068, 0, 0.7071068, 0)
    return (
        Light("sun", BOTH, sun, pose(0, 0, 0, down), per_scene([[1, 1, 1], [1, 0.5, 0.5]])),
        Light("lamp", (1,), PointLight(), pose(0, 0, 2), constant([1, 1, 1]), shadow=shade),
        Light("torch", BOTH, SpotLight(**cone), pose(0, 0, 0.1), constant([2, 2, 2]), Mount("arm_0", "hand"), shade),
        Light("projector", BOTH, picture, pose(0, 0, 3, down), constant([1, 1, 1])),
    )


def cameras() -> tuple[Camera, ...]:
    """Of every lens."""
    wide, near, far = Perspective(fovy=per_scene([1, 1.2])), literal(0.01), literal(10)
    matrix = Intrinsic(literal(60), literal(60), literal(32), literal(24), literal(0))
    top = (0.7071068, 0, 0.7071068, 0)
    return (
        Camera("front", BOTH, poses((-1, 0, 0.5), (-1, 0, 0.6)), 64, 48, wide, near, far),
        Camera("wrist", BOTH, pose(0, 0, 0.05), 64, 48, matrix, near, far, Mount("arm_0", "hand")),
        Camera("top", (0,), pose(0, 0, 3, top), 64, 48, Orthographic(literal(1)), near, far, shader="minimal"),
    )


def fastened() -> ScenePlan:
    """What holds on to entities, some of which are copies in a loop."""
    block = solid(Box(constant([0.05, 0.05, 0.05])))
    arms = [
        Entity(f"arm_{k}", BOTH, pose(0, k, 0.05), (arm(ids=constant([1, 1, 0, 0], np.int64), start=literal(0.3)),))
        for k in range(2)
    ]
    return ScenePlan(
        "fastened",
        2,
        (
            ground(2),
            *arms,
            *(entity(f"block_{k}", pose(k * 0.5, 0.5, 0.3), block) for k in range(3)),
            Entity("crawler", BOTH, pose(2, 0, 0.3), (crawler(),)),
            entity("ball", pose(2, 0.3, 0.3), solid(Sphere(constant(0.05)))),
        ),
        Physics(),
        files=files("mug.obj", "bowl.obj", "checker.png"),
        physical_materials=(rubbing(0.9, 0.8, 0.05),),
        visual_materials=(look(base_color=(0.8, 0.1, 0.1, 1)),),
        constraints=constraints(),
        environment=Environment(ambient_light=per_scene([[0.1, 0.1, 0.1], [0.2, 0.2, 0.3]])),
        lights=lights(),
        cameras=cameras(),
    )
