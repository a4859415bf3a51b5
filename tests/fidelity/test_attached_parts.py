"""Robots of several files against one `ArticulationBuilder` of SAPIEN: every property, and 300 steps to the bit."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.test_articulations_urdf import without_visuals
from sapien import Pose, physx
from sapien.wrapper.urdf_loader import URDFLoader

from scenecc import compile_scene, load_scene

SCENES = Path(__file__).resolve().parents[2] / "scenes"
HALF = math.sqrt(0.5)


def links_of(path: Path) -> list[Any]:
    """The builders of a URDF's links, by SAPIEN's own loader."""
    loader: Any = URDFLoader()
    loader.set_scene(sapien.Scene([physx.PhysxCpuSystem()]))
    loader.package_dir, loader.urdf_dir, loader.ignore_pairs = None, str(path.parent), []
    (builder,), _, _ = loader._parse_urdf(without_visuals(path))
    return builder.link_builders


def attach(builder: Any, links: list[Any], prefix: str, to: str, pose: Any) -> None:
    """Adds the links of another builder below a link."""
    root = links[0]
    root.parent = next(link for link in builder.link_builders if link.name == to)
    root.set_joint_properties("fixed", [], pose, Pose())
    for link in links:
        link.index = len(builder.link_builders)
        link.set_name(prefix + link.name)
        link.set_joint_name(link.joint_record.name and prefix + link.joint_record.name)
        builder.link_builders.append(link)


BITS = {"lower": 3, "gripper/palm": 3, "gripper/left": 1, "gripper/right": 2}
"""What of `lower` and the gripper never collides: `lower`, the palm and one finger, twice."""


def arm_with_gripper(qpos: dict[str, float]) -> Any:
    """The shipped scene, by hand."""
    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    scene.add_ground(0, render=False).components[0].name = "ground"
    builder = scene.create_articulation_builder()
    builder.link_builders = links_of(SCENES / "robots/arm.urdf")
    attach(builder, links_of(SCENES / "robots/gripper.urdf"), "gripper/", "tip", Pose(q=[HALF, 0, 0, HALF]))
    palm = next(link for link in builder.link_builders if link.name == "gripper/palm")
    camera = builder.create_link_builder(palm)
    camera.set_name("camera/body")
    camera.set_joint_properties("fixed", [], Pose([0.05, 0, 0.02], [HALF, 0, -HALF, 0]), Pose())
    camera.add_box_collision(half_size=[0.015, 0.03, 0.01])
    rubber = physx.PhysxMaterial(1, 0.9, 0)
    for link in builder.link_builders:
        link.collision_groups = [1, 1, BITS.get(link.name, 0), 0]
        if link.name in {"gripper/left", "gripper/right"}:
            for record in link.collision_records:
                record.material = rubber
    builder.initial_pose = Pose([0, 0, 0.05])
    articulation = builder.build(fix_root_link=True)
    articulation.name = "arm"
    found = articulation.find_link_by_name("camera/body")
    factor = 0.05 / found.mass
    found.mass, found.inertia = 0.05, found.inertia * factor
    for name, velocity in (("shoulder", 2), ("elbow", 3), ("gripper/left_slide", 0.2), ("gripper/right_slide", 0.2)):
        articulation.find_joint_by_name(name).set_max_velocity(velocity)
    articulation.find_joint_by_name("shoulder").set_friction(0.1)
    articulation.qpos = [qpos[joint.name] for joint in articulation.active_joints]
    for name, effort in (("shoulder", 50), ("elbow", 20)):
        joint = articulation.find_joint_by_name(name)
        joint.set_drive_properties(200, 20, effort)
        joint.set_drive_target(qpos[name])
    for name in ("gripper/left_slide", "gripper/right_slide"):
        joint = articulation.find_joint_by_name(name)
        joint.set_drive_properties(500, 20, 15)
        joint.set_drive_target(0.01)
    return scene


def test_an_arm_with_a_gripper_and_a_camera() -> None:
    path = SCENES / "robot_gripper.yaml"
    arm: Any = compile_scene(path).entities[1].structures[0]
    starts = arm.links[1].joint.qpos.data.tolist()
    qpos = {"elbow": 0.8, "gripper/left_slide": 0.02, "gripper/right_slide": 0.03}
    hand = [arm_with_gripper({**qpos, "shoulder": start}) for start in starts]
    with load_scene(path, render=False, audit="full") as batch:
        assert batch.articulations["arm"].active_joint_names == (
            "shoulder",
            "elbow",
            "gripper/left_slide",
            "gripper/right_slide",
        )
        for ours, theirs in zip(batch.scenes, hand, strict=True):
            assert_same_scene(ours, theirs)
        assert_same_trajectory(batch.scenes, hand)
