"""Plans whose scenes differ in everything, and scenes that are built alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.hand import UP, built, counts
from plugins.sample_plans import indices, rubbing
from sapien import physx

from scenecc.plan import (
    AssetFile,
    BodyStructure,
    Box,
    CollisionShape,
    ConvexMesh,
    Entity,
    Physics,
    Plane,
    ScenePlan,
    Sphere,
    constant,
    per_scene,
)

B = 6
HALF = [[0.03 + 0.01 * i, 0.05, 0.04 + 0.005 * i] for i in range(B)]
START = [[0.02 * i, 0.01 * i, 0.3 + 0.1 * i, 0.9238795, 0.3826834, 0, 0] for i in range(B)]
FRICTION = [(0.2, 0.1, 0.0), (0.8, 0.7, 0.5)]
PICK = (0, 1, 1, 0, 2, 2)
OBSTACLE = (0, 2, 5)
RADII = [0.05, 0.06, 0.07]


def varied(meshes: dict[str, Path]) -> ScenePlan:
    """Pose, half size, file, material and structure differ by scene; one entity is in some scenes only."""
    every = tuple(range(B))
    box = CollisionShape(Box(per_scene(HALF)), material=counts([0, 1, 0, 1, 0, 1]))
    ball = CollisionShape(Sphere(constant(0.06)))
    rock = CollisionShape(
        ConvexMesh(counts([0, 1, 0, 1, 0, 1]), constant([1, 1, 1])),
        density=per_scene([500.0 + 100 * i for i in range(B)]),
    )
    return ScenePlan(
        "varied",
        B,
        (
            Entity(
                "ground",
                every,
                constant([0, 0, 0, 1, 0, 0, 0]),
                (BodyStructure("static", (CollisionShape(Plane(), pose=constant([0, 0, 0, *UP])),)),),
            ),
            Entity("box", every, per_scene(START), (BodyStructure("dynamic", (box,)),)),
            Entity(
                "variant",
                every,
                constant([0.1, 0, 0.9, 1, 0, 0, 0]),
                (
                    BodyStructure("dynamic", (ball,)),
                    BodyStructure("dynamic", (rock,), mass=constant(0.7)),
                    BodyStructure("kinematic", (ball, rock)),
                ),
                indices(*PICK),
            ),
            Entity(
                "obstacle",
                OBSTACLE,
                per_scene([[0.3, 0.1 * k, 0.2, 1, 0, 0, 0] for k in range(3)]),
                (BodyStructure("static", (CollisionShape(Sphere(per_scene(RADII))),)),),
            ),
        ),
        Physics(),
        files=tuple(AssetFile(path.name, path) for path in (meshes["rock"], meshes["wedge"])),
        physical_materials=tuple(rubbing(*numbers) for numbers in FRICTION),
    )


def by_hand(i: int, meshes: dict[str, Path]) -> Any:
    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    builder = scene.create_actor_builder()
    builder.add_plane_collision(pose=sapien.Pose([0, 0, 0], UP))
    builder.build_static(name="ground")

    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=HALF[i], material=physx.PhysxMaterial(*FRICTION[i % 2]))
    builder.initial_pose = sapien.Pose(START[i][:3], START[i][3:])
    builder.build(name="box")

    file = str(meshes[("rock", "wedge")[i % 2]])
    builder = scene.create_actor_builder()
    builder.initial_pose = sapien.Pose([0.1, 0, 0.9])
    if PICK[i] != 1:
        builder.add_sphere_collision(radius=0.06)
    if PICK[i] != 0:
        builder.add_convex_collision_from_file(file, density=500.0 + 100 * i)
    if PICK[i] == 2:
        builder.build_kinematic(name="variant")
    else:
        body = builder.build(name="variant").components[0]
        if PICK[i] == 1:
            mass, inertia = body.mass, body.inertia.astype(float)
            body.mass = 0.7
            body.inertia = inertia * (0.7 / mass)

    if i in OBSTACLE:
        k = OBSTACLE.index(i)
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=RADII[k])
        builder.initial_pose = sapien.Pose([0.3, 0.1 * k, 0.2])
        builder.build_static(name="obstacle")
    return scene


def test_scenes_that_differ_in_everything(meshes: dict[str, Path]) -> None:
    batch = built(varied(meshes))
    hand = [by_hand(i, meshes) for i in range(B)]
    for ours, theirs in zip(batch.scenes, hand, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, hand)
    assert list(batch.entities) == ["ground", "box", "variant", "obstacle"]
    assert batch.entities["obstacle"].scene_idxs == OBSTACLE


def test_a_scene_built_alone_is_as_it_is_among_all(meshes: dict[str, Path]) -> None:
    chosen = (1, 2, 4)
    batch = built(varied(meshes), scene_idxs=[4, 1, 2])
    assert batch.scene_idxs == chosen
    hand = [by_hand(i, meshes) for i in chosen]
    for ours, theirs in zip(batch.scenes, hand, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, hand)
    assert batch.entities["obstacle"].scene_idxs == (2,)


def test_an_entity_in_none_of_the_chosen_scenes_is_absent(meshes: dict[str, Path]) -> None:
    batch = built(varied(meshes), scene_idxs=[3])
    assert list(batch.entities) == ["ground", "box", "variant"]
