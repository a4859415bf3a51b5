"""`anchor` of poses: where a body stands, against numbers computed by hand and what SAPIEN has of its shapes."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.yaml_cases import load
from sapien import Pose, physx

from scenecc import compile_scene, load_scene, validate

SCENES = Path(__file__).resolve().parents[2] / "scenes"


def corners(shape: Any) -> Any:
    """Points that bound a colliding shape, in the frame of its body, (n, 3)."""
    match shape:
        case physx.PhysxCollisionShapeBox():
            points = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T * shape.half_size
        case physx.PhysxCollisionShapeConvexMesh():
            points = shape.vertices * shape.scale
        case _:
            raise TypeError(shape)
    frame = shape.local_pose.to_transformation_matrix()
    return points @ frame[:3, :3].T + frame[:3, 3]


def body_of(batch: Any, name: str, scene: int) -> Any:
    return batch.entities[name].objs[scene].components[0]


@pytest.mark.parametrize("anchor", ["bottom", "center", "top"])
def test_the_point_of_the_shapes_is_where_the_pose_says(anchor: str) -> None:
    text = f"""
scenecc: 1
num_scenes: 3
entities:
  body:
    pose: {{p: [1, 2, 3], rpy_deg: [20, {{uniform: [-90, 90]}}, 40], anchor: {anchor}}}
    shapes:
      - {{type: box, half_size: [0.1, 0.2, {{uniform: [0.1, 0.5]}}], pose: {{p: [0.1, 0, 0.3], rpy_deg: [0, 30, 10]}}}}
      - {{type: convex_mesh, file: {SCENES}/assets/mug.obj, scale: [1, 2, 1.5], pose: [0.3, 0, 0]}}
    visuals: [{{type: box, half_size: [5, 5, 5]}}]
"""
    batch = load_scene(io.StringIO(text), render=False, asset_roots=[SCENES])
    for seed in (0, 4):
        batch.reset(seed=seed)
        for number, obj in enumerate(batch.entities["body"].objs):
            points = np.concatenate([corners(shape) for shape in body_of(batch, "body", number).collision_shapes])
            low, high = points.min(axis=0), points.max(axis=0)
            point = (low + high) / 2
            point[2] = {"bottom": low, "center": point, "top": high}[anchor][2]
            assert np.allclose((obj.pose * Pose(point)).p, [1, 2, 3], atol=2e-5)


def test_an_articulation_stands_by_what_it_is_at_its_qpos() -> None:
    text = """
scenecc: 1
num_scenes: 2
entities:
  lever:
    pose: {p: [0, 0, 2], anchor: top}
    fix_root_link: true
    qpos: {turn: {per_scene: [0, 1.5707963267948966]}}
    root:
      name: base
      children:
        - name: arm
          joint: {name: turn, type: revolute, axis: y, limits: [-2, 2], origin: [0, 0, 0.5]}
          shapes: [{type: box, half_size: [0.4, 0.01, 0.1]}]
  ball: {pose: {relative_to: lever, p: [0, 1, 0]}, shapes: [{type: sphere, radius: 0.1}]}
"""
    batch = load(text)
    # The top is a half height above the joint, or a half length.
    assert np.allclose(batch.articulations["lever"].pose[:, 2], [2 - 0.6, 2 - 0.9], atol=1e-6)
    # What is relative to it means its origin all the same.
    assert np.allclose(batch.entities["ball"].pose[:, :3], [[0, 1, 1.4], [0, 1, 1.1]], atol=1e-6)


def test_what_is_seen_counts_where_nothing_collides_and_a_variant_has_its_own_bounds() -> None:
    text = """
scenecc: 1
num_scenes: 4
entities:
  goal: {body_type: kinematic, pose: {p: [0, 0, 1], anchor: bottom}, visuals: [{type: sphere, radius: 0.25}]}
  thing:
    pose: {p: [{uniform: [0, 1]}, 0, 0], anchor: bottom}
    variants:
      - {shapes: [{type: sphere, radius: 0.5}]}
      - {shapes: [{type: cylinder, radius: 0.1, half_length: 1, axis: z}]}
    pick: {cycle: [0, 1]}
"""
    plan = compile_scene(io.StringIO(text))
    goal, thing = plan.entities
    assert goal.pose.row(0)[2] == 1.25
    assert thing.pose.data[:, 2] == pytest.approx([0.5, 1, 0.5, 1])
    assert thing.pose.recipe is not None
    with (
        load_scene(io.StringIO(text), render=False) as batch,
        load_scene(io.StringIO(text), seed=7, render=False) as new,
    ):
        batch.reset(seed=7, exact=True)
        for one, other in zip(batch.scenes, new.scenes, strict=True):
            assert_same_scene(one, other)


def test_the_stack_that_ships_is_what_hand_written_code_builds() -> None:
    file = SCENES / "stack.yaml"
    plan = compile_scene(file)
    batch = load_scene(file, render=False)
    hand: list[Any] = []
    for number in range(plan.num_scenes):
        scene = sapien.Scene([physx.PhysxCpuSystem()])
        scene.add_ground(0, render=False)
        table = scene.create_actor_builder()
        table.set_physx_body_type("static")
        table.add_box_collision(Pose([0, 0, 0.4]), (0.6, 0.4, 0.02))
        for x in (-0.55, 0.55):
            for y in (-0.35, 0.35):
                table.add_box_collision(Pose([x, y, 0.18]), (0.03, 0.03, 0.2))
        table.initial_pose = Pose([0, 0, 0.02])
        table.build(name="table")
        (drawn,) = body_of(batch, "crate", number).collision_shapes
        half = float(drawn.half_size[2])
        crate = scene.create_actor_builder()
        crate.add_box_collision(half_size=drawn.half_size)
        turn: Any = batch.entities["crate"].pose[number, 3:]
        crate.initial_pose = Pose([-0.3, 0, 0.44 + half], turn)
        crate.build(name="crate")
        bowl = scene.create_actor_builder()
        bowl.add_convex_collision_from_file(str(SCENES / "assets/bowl.obj"))
        lowest = min(
            float(line.split()[3]) for line in (SCENES / "assets/bowl.obj").read_text().splitlines() if line[:2] == "v "
        )
        bowl.initial_pose = Pose([-0.3, 0, batch.entities["bowl"].pose[number, 2]])
        assert batch.entities["bowl"].pose[number, 2] == pytest.approx(0.44 + 2 * half - lowest, abs=1e-6)
        bowl.build(name="bowl")
        for i in range(6):
            board = scene.create_actor_builder()
            board.add_box_collision(half_size=(0.15, 0.05, 0.01))
            angle = np.deg2rad(15 * i) / 2
            board.initial_pose = Pose([0.2, 0, 0.44 + i * 0.02 + 0.01], [np.cos(angle), 0, 0, np.sin(angle)])
            board.build(name=f"board_{i}")
        hand.append(scene)
    assert validate(file) == []
    assert_same_trajectory(batch.scenes, hand)
