"""Robots as one body (`body_type`), against the same body built with SAPIEN by hand."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from sapien import Pose, physx

from scenecc import load_scene

CABINET = """\
<robot name="cabinet">
  <link name="case">
    <collision><geometry><box size="1 0.5 1"/></geometry></collision>
    <visual><geometry><box size="1 0.5 1"/></geometry></visual>
  </link>
  <link name="drawer">
    <inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0.25 0"/><geometry><box size="0.5 0.5 0.25"/></geometry></collision>
  </link>
  <link name="knob">
    <collision><geometry><sphere radius="0.0625"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic">
    <parent link="case"/><child link="drawer"/><origin xyz="0 0 0.75"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.5" effort="1" velocity="1"/>
  </joint>
  <joint name="stem" type="fixed"><parent link="drawer"/><child link="knob"/><origin xyz="0 0.5 0"/></joint>
</robot>
"""
TREE = """\
root:
      name: case
      collisions: [{type: box, half_size: [0.5, 0.25, 0.5]}]
      children:
        - name: drawer
          joint: {name: slide, type: prismatic, origin: [0, 0, 0.75], axis: x, limits: [0, 0.5], friction: 0.3}
          mass: 2
          collisions: [{type: box, half_size: [0.25, 0.25, 0.125], pose: [0, 0.25, 0]}]
          children:
            - name: knob
              joint: {type: fixed, origin: [0, 0.5, 0]}
              collisions: [{type: sphere, radius: 0.0625}]
"""
MJCF = """\
<mujoco>
  <worldbody>
    <body name="case">
      <geom type="box" size="0.5 0.25 0.5"/>
      <body name="drawer" pos="0 0 0.75">
        <joint name="slide" type="slide" axis="1 0 0" range="0 0.5" limited="true"/>
        <geom type="box" size="0.25 0.25 0.125" pos="0 0.25 0"/>
        <geom type="sphere" size="0.0625" pos="0 0.5 0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
OPENED = [0.0, 0.25, 0.5]


def by_hand(opened: float, body_type: str, *, mjcf: bool) -> sapien.Scene:
    """The cabinet as one actor, and a ball that falls on its drawer."""
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    cabinet: Any = scene.create_actor_builder()
    cabinet.set_physx_body_type(body_type)
    given: dict[str, Any] = {}
    if mjcf:
        # MuJoCo's default friction and bits of geoms. What does not move has no mass.
        given = {"material": physx.PhysxMaterial(1, 1, 0), "density": 0}
        cabinet.collision_groups = [3, 2, 0, 0]
    cabinet.add_box_collision(half_size=[0.5, 0.25, 0.5], **given)
    cabinet.add_box_collision(Pose([opened, 0.25, 0.75]), half_size=[0.25, 0.25, 0.125], **given)
    cabinet.add_sphere_collision(Pose([opened, 0.5, 0.75]), radius=0.0625, **given)
    cabinet.initial_pose = Pose([0, 0, 0.5])
    cabinet.build(name="cabinet")
    ball: Any = scene.create_actor_builder()
    ball.add_sphere_collision(radius=0.1)
    ball.initial_pose = Pose([0.4, 0.4, 1.7])
    ball.build(name="ball")
    return scene


@pytest.mark.parametrize("body_type", ["static", "kinematic"])
@pytest.mark.parametrize("kind", ["urdf", "root", "mjcf"])
def test_a_robot_of_one_body_is_an_actor_with_all_shapes(kind: str, body_type: str, tmp_path: Path) -> None:
    (tmp_path / "cabinet.urdf").write_text(CABINET)
    (tmp_path / "cabinet.xml").write_text(MJCF)
    made = {"urdf": "urdf: cabinet.urdf", "root": TREE, "mjcf": "mjcf: cabinet.xml"}[kind]
    file = tmp_path / "scene.yaml"
    file.write_text(
        f"""\
scenecc: 1
num_scenes: 3
entities:
  cabinet:
    {made}
    body_type: {body_type}
    pose: [0, 0, 0.5]
    qpos: {{slide: {{per_scene: {OPENED}}}}}
  ball: {{pose: [0.4, 0.4, 1.7], collisions: [{{type: sphere, radius: 0.1}}]}}
"""
    )
    with load_scene(file, render=False) as batch:
        scenes = [by_hand(opened, body_type, mjcf=kind == "mjcf") for opened in OPENED]
        for ours, theirs in zip(batch.scenes, scenes, strict=True):
            assert_same_scene(ours, theirs)
        assert_same_trajectory(batch.scenes, scenes)
        assert not batch.articulations


def test_drawn_positions_are_those_of_the_build_after_a_reset() -> None:
    text = f"scenecc: 1\nnum_scenes: 4\nentities:\n  cabinet:\n    body_type: static\n    {TREE}"
    with load_scene(io.StringIO(f"{text}    qpos: {{slide: {{uniform: [0, 0.5]}}}}\n"), render=False) as batch:

        def drawers() -> list[float]:
            components: list[Any] = [scene.entities[0].components[0] for scene in batch.scenes]
            return [float(one.collision_shapes[1].local_pose.p[0]) for one in components]

        before = drawers()
        assert len(set(before)) == 4
        batch.reset(seed=1)
        assert drawers() == before
