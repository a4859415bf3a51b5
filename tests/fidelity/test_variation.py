"""Plans whose scenes differ in everything, and scenes that are built alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import sapien
import yaml
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.hand import UP, built, counts
from plugins.sample_plans import indices, rubbing
from plugins.structures import body_of
from sapien import physx

from scenecc import compile_scene
from scenecc.plan import (
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
from scenecc.plan.body import AssetFile

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


WRITTEN = """
scenecc: 1
num_scenes: 6
seed: 4
draws:
  half: {uniform: [0.02, 0.05]}
  paint: {choice: ["#336699", "#993333"]}
materials:
  grippy: {physical: {static_friction: 0.8, dynamic_friction: 0.7, restitution: 0.5}}
  slick: {physical: {static_friction: {uniform: [0.1, 0.3]}, dynamic_friction: 0.1, restitution: 0}}
frames:
  table: {pose: {p: [0, 0, {per_scene: [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]}], rpy_deg: [0, 0, {uniform: [0, 90]}]}}
entities:
  ground:
    body_type: static
    shapes: [{type: plane}]
  cube:
    pose: {p: {uniform: [[-0.1, -0.1, 0.3], [0.1, 0.1, 0.5]]}, q: uniform, relative_to: table}
    linear_velocity: [{normal: [0, 0.1]}, 0, 0]
    mass: {log_uniform: [0.1, 1]}
    gravity: {cycle: [true, false]}
    shapes:
      - type: box
        half_size: ["${half}", "${2 * half}", 0.03]
        material: {cycle: [grippy, slick]}
  bin:
    scene_idxs: [1, 2, 5]
    pose: {cycle: [[0.4, 0, 1], {p: [0.4, 0, 1], axis_angle: {axis: z, angle_deg: {uniform: [0, 45]}}}]}
    pick: {per_scene: {2: 1, default: 0}}
    density: {per_scene: [100, 200, 300]}
    variants:
      - shapes: [{type: capsule, radius: "${half}", half_length: 0.05, axis: z, pose: [0, {uniform: [0, 0.1]}, 0]}]
      - shapes: [{type: sphere, radius: 0.06}]
        body_type: kinematic
"""


def numbers(value: Any, row: int) -> Any:
    return value.row(row).tolist()


def written_by_hand(i: int, plan: ScenePlan) -> Any:
    """What a person would write who had the drawn numbers of one scene."""
    ground, cube, bin_ = plan.entities
    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    builder = scene.create_actor_builder()
    builder.add_plane_collision(pose=sapien.Pose([0, 0, 0], body_of(ground).collisions[0].pose.row(0)[3:]))  # type: ignore[union-attr]
    builder.build_static(name="ground")

    body = body_of(cube)
    box: Any = body.collisions[0].geometry
    half = numbers(box.half_size, i)
    builder = scene.create_actor_builder()
    friction = plan.physical_materials[int(body.collisions[0].material.row(i))].row(i)  # type: ignore[union-attr]
    sliding = (0.8, 0.7, 0.5) if i % 2 == 0 else (friction.static_friction, 0.1, 0)
    builder.add_box_collision(half_size=[half[0], 2 * half[0], 0.03], material=physx.PhysxMaterial(*sliding))
    pose = numbers(cube.pose, i)
    builder.initial_pose = sapien.Pose(pose[:3], pose[3:])
    component = builder.build(name="cube").components[0]
    mass, inertia = component.mass, component.inertia.astype(float)
    component.mass = numbers(body.mass, i)
    component.inertia = inertia * (numbers(body.mass, i) / mass)
    component.set_disable_gravity(i % 2 == 1)
    component.set_linear_velocity(numbers(body.linear_velocity, i))

    if i in bin_.scene_idxs:
        row = bin_.scene_idxs.index(i)
        builder = scene.create_actor_builder()
        pose = numbers(bin_.pose, row)
        builder.initial_pose = sapien.Pose(pose[:3], pose[3:])
        density = 100.0 * (row + 1)
        if i == 2:
            builder.add_sphere_collision(radius=0.06, density=density)
            builder.build_kinematic(name="bin")
        else:
            local = numbers(body_of(bin_).collisions[0].pose, row)
            builder.add_capsule_collision(
                pose=sapien.Pose(local[:3], local[3:]), radius=half[0], half_length=0.05, density=density
            )
            builder.build(name="bin")
    return scene


def test_forms_are_built_as_a_person_would_with_the_drawn_numbers() -> None:
    plan = compile_scene(yaml.safe_load(WRITTEN))
    batch = built(plan)
    hand = [written_by_hand(i, plan) for i in range(B)]
    for ours, theirs in zip(batch.scenes, hand, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, hand)


OF_ALL = "{per_scene: [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]}"
BY_MAP = "{per_scene: {1: 0.2, default: 0.1}}"
"""A height that other numbers of scenes have as well."""


def test_a_scene_is_the_same_among_fewer_and_among_more() -> None:
    def compiled(num_scenes: int) -> ScenePlan:
        text = WRITTEN.replace("num_scenes: 6", f"num_scenes: {num_scenes}").replace(OF_ALL, BY_MAP)
        return compile_scene(yaml.safe_load(text))

    for one, other in zip(compiled(6).entities, compiled(9).entities, strict=True):
        for row in range(len(one.scene_idxs)):
            assert numbers(one.pose, row) == numbers(other.pose, row)
            velocities = (body_of(entity).linear_velocity for entity in (one, other))
            assert len({str(velocity and numbers(velocity, row)) for velocity in velocities}) == 1
