"""Robots from URDF files against SAPIEN's own loader: every property of every link and joint, and 300 steps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from sapien import physx
from sapien.wrapper.urdf_loader import URDFLoader

from scenecc import load_scene
from scenecc.plan.articulation import BRAKE_DAMPING

SCENES = 2
POSE = [-0.615, 0.1, 0.2, 0.9238795, 0, 0, 0.3826834]

ARM = """<robot name="arm">
  <link name="base"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
    <visual><geometry><box size="0.2 0.2 0.1"/></geometry></visual></link>
  <link name="upper">
    <inertial><origin xyz="0.1 0 0.02" rpy="0.1 0.2 0.3"/><mass value="1.5"/>
      <inertia ixx="0.01" ixy="0.001" ixz="0.002" iyy="0.02" iyz="0.0005" izz="0.015"/></inertial>
    <collision><origin xyz="0.15 0 0" rpy="0 1.5707963 0"/>
      <geometry><cylinder radius="0.03" length="0.3"/></geometry></collision>
  </link>
  <link name="lower"><collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="left"><collision><geometry><box size="0.02 0.02 0.08"/></geometry></collision></link>
  <link name="right"><collision><geometry><box size="0.02 0.02 0.08"/></geometry></collision></link>
  <link name="wheel"><collision><geometry><sphere radius="0.04"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.1" rpy="0.3 -0.2 1"/><axis xyz="0 1 0.2"/>
    <limit lower="-1.1" upper="1.2" effort="50" velocity="2"/>
    <dynamics damping="0.4"/></joint>
  <joint name="elbow" type="prismatic"><parent link="upper"/><child link="lower"/><origin xyz="0.3 0 0"/>
    <axis xyz="1 0 0"/><limit lower="-0.05" upper="0.1" effort="10"/></joint>
  <joint name="grip" type="prismatic"><parent link="lower"/><child link="left"/><origin xyz="0.2 0.03 0"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="10"/></joint>
  <joint name="mount" type="fixed"><parent link="lower"/><child link="right"/><origin xyz="0.2 -0.05 0"/></joint>
  <joint name="spin" type="continuous"><parent link="base"/><child link="wheel"/><origin xyz="-0.2 0 0"/>
    <axis xyz="0 0 1"/><dynamics damping="0" friction="0.3"/></joint>
</robot>
"""
QPOS = {"shoulder": 0.2, "elbow": 0.05, "grip": 0.02, "spin": -0.4}


def without_visuals(path: Path) -> str:
    """What a person needs who has nothing that renders: SAPIEN's loader raises for the visuals of a file."""
    from xml.etree import ElementTree as ET

    root = ET.parse(path).getroot()
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    return ET.tostring(root, encoding="unicode")


def by_loader(path: Path, qpos: dict[str, float], tell: Any, bind: Any = None, **options: Any) -> list[Any]:
    """The file by SAPIEN's loader in every scene, and what a person calls: `bind` on links before they are added."""
    srdf = path.with_suffix(".srdf")
    scenes: list[Any] = []
    for _ in range(SCENES):
        scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
        loader: Any = URDFLoader()
        for name, value in options.items():
            setattr(loader, name, value)
        loader.set_scene(scene)
        loader.package_dir, loader.urdf_dir = None, str(path.parent)
        loader.ignore_pairs = loader.parse_srdf(srdf.read_text()) if srdf.is_file() else []
        (builder,), _, _ = loader._parse_urdf(without_visuals(path))
        builder.set_initial_pose(sapien.Pose(POSE[:3], POSE[3:]))
        links = builder.build_entities()
        if bind is not None:
            bind({entity.name: entity.components[0] for entity in links})
        for entity in links:
            scene.add_entity(entity)
        articulation = links[0].components[0].articulation
        articulation.name = "robot"
        tell(articulation)
        articulation.set_qpos([qpos[joint.name] for joint in articulation.active_joints])
        scenes.append(scene)
    return scenes


def of_file(entity: dict[str, Any]) -> list[Any]:
    document = {
        "scenecc": 1,
        "num_scenes": SCENES,
        "entities": {"robot": {"pose": {"p": POSE[:3], "q": POSE[3:]}, **entity}},
    }
    return load_scene(document, render=False).scenes


def assert_same(ours: list[Any], theirs: list[Any]) -> None:
    for a, b in zip(ours, theirs, strict=True):
        assert_same_scene(a, b)
    assert_same_trajectory(ours, theirs)


def tell(articulation: Any) -> None:
    """What `ARM` says and the loader drops, and its friction, which the loader takes for a ratio."""
    articulation.find_joint_by_name("shoulder").set_max_velocity(2.0)
    spin = articulation.find_joint_by_name("spin")
    spin.set_friction(0)
    spin.set_drive_properties(0, BRAKE_DAMPING, force_limit=0.3)


@pytest.mark.parametrize("fixed", [True, False])
@pytest.mark.parametrize("scale", [1.0, 0.5])
def test_a_urdf_robot_equals_one_loaded_by_hand(tmp_path: Path, fixed: bool, scale: float) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)

    entity = {"urdf": str(path), "qpos": QPOS, "fix_root_link": fixed, "scale": scale}
    loaded = by_loader(path, QPOS, tell, fix_root_link=fixed, scale=scale)
    document = {
        "scenecc": 1,
        "num_scenes": SCENES,
        "entities": {"robot": {"pose": {"p": POSE[:3], "q": POSE[3:]}, **entity}},
    }
    ours = load_scene(document, render=False, allow_outside_assets=True).scenes
    assert_same(ours, loaded)


PANDA = [0, 0.39, 0, -1.96, 0, 2.36, 0.79, 0.04, 0.04]


@pytest.mark.maniskill
@pytest.mark.parametrize("file", ["panda_v2", "panda_v3"])
def test_the_panda_with_drives_equals_one_loaded_by_hand(file: str) -> None:
    import importlib.util

    found = importlib.util.find_spec("mani_skill")
    assert found is not None
    assert found.origin is not None
    path = Path(found.origin).parent / f"assets/robots/panda/{file}.urdf"
    names = [*(f"panda_joint{i}" for i in range(1, 8)), "panda_finger_joint1", "panda_finger_joint2"]
    qpos = {name: float(np.float32(number)) for name, number in zip(names, PANDA, strict=True)}
    said = drops_of(path)

    def bind(links: dict[str, Any]) -> None:
        """`panda_finger_joint2` mimics its sibling, which SAPIEN would have the other way round."""
        chain = [links[name] for name in ("panda_hand", "panda_leftfinger", "panda_rightfinger")]
        chain[0].articulation.create_fixed_tendon(chain, [0, -1, 1], [0, -1, 1], rest_length=0, stiffness=1e5)

    def tell(articulation: Any) -> None:
        for joint in articulation.active_joints:
            joint.set_drive_properties(1000.0, 100.0, 100.0)
            joint.set_drive_target(qpos[joint.name])
            for name, value in said[joint.name].items():
                getattr(joint, f"set_{name}")(value)
        for link in articulation.links:
            link.set_disable_gravity(True)

    ours = of_file(
        {
            "urdf": f"pkg://mani_skill/assets/robots/panda/{file}.urdf",
            "qpos": PANDA,
            "gravity": False,
            "drives": {"panda_.*": {"stiffness": 1000, "damping": 100, "force_limit": 100}},
        }
    )
    assert_same(ours, by_loader(path, qpos, tell, bind))


def drops_of(path: Path) -> dict[str, dict[str, float]]:
    """What a file says of each joint and the loader drops: the limit of the velocity, and a friction of 0."""
    from xml.etree import ElementTree as ET

    found: dict[str, dict[str, float]] = {}
    for joint in ET.parse(path).getroot().iter("joint"):
        said = found.setdefault(joint.get("name", ""), {})
        limit = joint.find("limit")
        if limit is not None and "velocity" in limit.attrib:
            said["max_velocity"] = float(limit.attrib["velocity"])
        dynamics = joint.find("dynamics")
        if dynamics is not None and float(dynamics.get("friction", "nan")) == 0:  # a drive replaces any other
            said["friction"] = 0.0
    return found
