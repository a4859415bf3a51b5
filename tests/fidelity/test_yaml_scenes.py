"""The scenes that ship, against the same scenes written by hand with plain SAPIEN."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.yaml_cases import UP, assert_same, load
from sapien import Pose, physx

from scenecc import load_scene

SCENES = Path(__file__).resolve().parents[2] / "scenes"


def empty() -> Any:
    return sapien.Scene([physx.PhysxCpuSystem()])


def ground(scene: Any, altitude: float = 0) -> None:
    # `add_ground` names the entity and not its component; a builder that is told the name gives it to both.
    scene.add_ground(altitude, render=False).components[0].name = "ground"


def create_table(scene: Any, pose: Any, size: float, height: float, thickness: float = 0.1, name: str = "table") -> Any:
    """The tutorial's own function, without what is seen."""
    builder = scene.create_actor_builder()
    builder.add_box_collision(pose=Pose([0, 0, -thickness / 2]), half_size=[size / 2, size / 2, thickness / 2])
    for i in [-1, 1]:
        for j in [-1, 1]:
            x, y = i * (size - thickness) / 2, j * (size - thickness) / 2
            builder.add_box_collision(
                pose=Pose([x, y, -height / 2]), half_size=[thickness / 2, thickness / 2, height / 2]
            )
    table = builder.build(name=name)
    table.set_pose(pose)
    return table


def tutorial() -> Any:
    scene = empty()
    scene.set_timestep(1 / 100)
    ground(scene)
    create_table(scene, Pose([0, 0, 1]), size=1, height=1)
    for name, at, add in [
        ("box", [0, 0, 1.05], lambda b: b.add_box_collision(half_size=[0.05, 0.05, 0.05])),
        ("sphere", [0, -0.2, 1.05], lambda b: b.add_sphere_collision(radius=0.05)),
        ("capsule", [0, 0.2, 1.05], lambda b: b.add_capsule_collision(radius=0.05, half_length=0.05)),
        (
            "cylinder",
            [0.2, 0, 1.05],
            lambda b: b.add_cylinder_collision(
                Pose(q=[math.sqrt(0.5), 0, -math.sqrt(0.5), 0]), radius=0.05, half_length=0.05
            ),
        ),
        ("mesh", [-0.2, 0, 1.05], lambda b: b.add_convex_collision_from_file(str(SCENES / "assets/bowl.obj"))),
    ]:
        builder = scene.create_actor_builder()
        add(builder)
        builder.build(name=name).set_pose(Pose(at))
    return scene


def tabletop() -> Any:
    scene = empty()
    ground(scene, 0)
    scene.entities[-1].set_pose(Pose([0, 0, -0.92]))
    wood, rubber = physx.PhysxMaterial(0.6, 0.5, 0), physx.PhysxMaterial(1, 1, 0.1)
    table = scene.create_actor_builder()
    table.set_physx_body_type("kinematic")
    table.add_box_collision(Pose([0, 0, -0.02]), half_size=[0.6, 1.2, 0.02], material=wood)
    for x in (0.55, -0.55):
        for y in (1.15, -1.15):
            table.add_box_collision(Pose([x, y, -0.48]), half_size=[0.03, 0.03, 0.44], material=wood)
    table.build(name="table")
    cube = scene.create_actor_builder()
    cube.add_box_collision(half_size=[0.02, 0.02, 0.02], material=rubber, density=1100)
    cube.initial_pose = Pose([-0.1, 0, 0.02], [math.cos(math.pi / 12), 0, 0, math.sin(math.pi / 12)])
    cube.build(name="cube")
    goal = sapien.Entity()
    goal.set_name("goal")
    goal.set_pose(Pose([0.15, 0.1, 0.001]))
    scene.add_entity(goal)
    return scene


def obstacle(index: int) -> Any:
    scene = empty()
    ground(scene)
    half = math.radians(20) / 2
    tilt = [math.cos(half), 0, math.sin(half), 0]
    ramp = scene.create_actor_builder()
    ramp.add_box_collision(half_size=[0.4, 0.15, 0.01])
    ramp.initial_pose = Pose([0, 0, 0.15], tilt)
    ramp.build_static(name="ramp")
    ball = scene.create_actor_builder()
    ball.add_sphere_collision(radius=0.04)
    ball.initial_pose = Pose([-0.3, 0, 0.32])
    ball.build(name="ball")
    if index in (0, 2):
        wall = scene.create_actor_builder()
        wall.add_box_collision(half_size=[0.02, 0.15, 0.1])
        wall.initial_pose = Pose([0.6, 0, 0.1])
        wall.build_static(name="obstacle")
    else:
        cushion = scene.create_actor_builder()
        cushion.add_box_collision(half_size=[0.02, 0.15, 0.05])
        cushion.set_physx_body_type("kinematic")
        # (0.42, 0, 0.055) of the ramp, in the world.
        angle = math.radians(20)
        x = 0.42 * math.cos(angle) + 0.055 * math.sin(angle)
        z = 0.15 - 0.42 * math.sin(angle) + 0.055 * math.cos(angle)
        cushion.initial_pose = Pose([x, 0, z], tilt)
        cushion.build(name="cushion")
    return scene


def test_tutorial() -> None:
    with load_scene(SCENES / "tutorial.yaml", num_scenes=2, render=False) as batch:
        assert_same(batch, [tutorial(), tutorial()])


def test_tabletop() -> None:
    with load_scene(SCENES / "tabletop.yaml", num_scenes=4, render=False) as batch:
        assert_same(batch, [tabletop() for _ in range(4)])


def test_obstacle() -> None:
    with load_scene(SCENES / "obstacle.yaml", render=False) as batch:
        assert batch.entities["obstacle"].scene_idxs == (0, 2)
        assert_same(batch, [obstacle(i) for i in range(4)])


@pytest.mark.parametrize("altitude", [0, -0.5, 1.25])
def test_a_plane_is_what_add_ground_builds(altitude: float) -> None:
    by_pose = f"{{type: plane, pose: [0, 0, {altitude}]}}"
    by_offset = f"{{type: plane, offset: {altitude}}}"
    for shape in (by_pose, by_offset):
        text = (
            f"scenecc: 1\nentities:\n  ground: {{body_type: static, shapes: [{shape}]}}\n"
            "  ball: {pose: [0, 0, 2], shapes: [{type: sphere, radius: 0.1}]}\n"
        )
        scene = empty()
        ground(scene, altitude)
        ball = scene.create_actor_builder()
        ball.add_sphere_collision(radius=0.1)
        ball.initial_pose = Pose([0, 0, 2])
        ball.build(name="ball")
        with load(text) as batch:
            assert_same_scene(batch.scenes[0], scene)
            assert_same_trajectory(batch.scenes, [scene])
            ground_body = batch.entities["ground"].objs[0].components[0]
            assert isinstance(ground_body, physx.PhysxRigidBaseComponent)
            shapes = ground_body.collision_shapes
            assert list(shapes[0].local_pose.q) == pytest.approx(UP, abs=1e-7)


def test_the_order_of_the_file_is_the_order_of_the_engine() -> None:
    """PhysX gives other trajectories in another order, so the order is part of what is written."""
    boxes = {
        f"box_{i}": f"{{pose: [0.0{i}, 0, {0.3 * (i + 1)}], shapes: [{{type: box, half_size: [0.1, 0.1, 0.1]}}]}}"
        for i in range(4)
    }
    for names in (list(boxes), list(reversed(boxes))):
        text = "scenecc: 1\nentities:\n  ground: {body_type: static, shapes: [{type: plane}]}\n"
        text += "".join(f"  {name}: {boxes[name]}\n" for name in names)
        scene = empty()
        ground(scene)
        for name in names:
            builder = scene.create_actor_builder()
            builder.add_box_collision(half_size=[0.1, 0.1, 0.1])
            i = int(name[-1])
            builder.initial_pose = Pose([0.01 * i, 0, 0.3 * (i + 1)])
            builder.build(name=name)
        with load(text) as batch:
            assert_same_trajectory(batch.scenes, [scene])
