"""Robots of several files against one `ArticulationBuilder` of SAPIEN: every property, and 300 steps to the bit."""

from __future__ import annotations

import importlib.util
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.test_articulations_urdf import PANDA, drops_of, without_visuals
from plugins.mujoco_judge import assert_same_machine
from sapien import Pose, physx
from sapien.wrapper.urdf_loader import URDFLoader

from scenecc import compile_scene, load_scene

mujoco: Any = pytest.importorskip("mujoco")

SCENES = Path(__file__).resolve().parents[2] / "scenes"
HALF = math.sqrt(0.5)


def links_of(path: Path, *, package_dir: Path | None = None) -> list[Any]:
    """The builders of a URDF's links, by SAPIEN's own loader."""
    loader: Any = URDFLoader()
    loader.set_scene(sapien.Scene([physx.PhysxCpuSystem()]))
    srdf = path.with_suffix(".srdf")
    loader.package_dir, loader.urdf_dir = None, str(path.parent)
    loader.ignore_pairs = loader.parse_srdf(srdf.read_text()) if srdf.is_file() else []
    # The loader takes a folder of packages, and does not look there for these.
    text = without_visuals(path).replace("package://", f"{package_dir}/")
    (builder,), _, _ = loader._parse_urdf(text)
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
    with load_scene(path, render=False) as batch:
        assert batch.articulations["arm"].active_joint_names == (
            "shoulder",
            "elbow",
            "gripper/left_slide",
            "gripper/right_slide",
        )
        for ours, theirs in zip(batch.scenes, hand, strict=True):
            assert_same_scene(ours, theirs)
        assert_same_trajectory(batch.scenes, hand)


@pytest.mark.maniskill
def test_the_panda_with_a_second_gripper() -> None:
    found = importlib.util.find_spec("mani_skill")
    assert found is not None
    assert found.origin is not None
    folder = Path(found.origin).parent / "assets/robots/panda"
    arm, hand = folder / "panda_v2.urdf", folder / "panda_v2_gripper.urdf"
    names = [*(f"panda_joint{i}" for i in range(1, 8)), "panda_finger_joint1", "panda_finger_joint2"]
    qpos = dict(zip(names, PANDA, strict=True)) | {"second/root_x_axis_joint": 0.02, "second/panda_finger_joint1": 0.03}
    qpos["second/panda_finger_joint2"] = 0.03

    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    builder = scene.create_articulation_builder()
    builder.link_builders = links_of(arm)
    attach(builder, links_of(hand), "second/", "panda_link8", Pose([0.2, 0, 0.1], [HALF, 0, 0, HALF]))
    links = builder.build_entities(fix_root_link=True)
    bodies = {entity.name: entity.components[0] for entity in links}
    for prefix in ("", "second/"):
        # SAPIEN's loader would have the second finger lead.
        chain = [bodies[prefix + name] for name in ("panda_hand", "panda_leftfinger", "panda_rightfinger")]
        chain[0].articulation.create_fixed_tendon(chain, [0, -1, 1], [0, -1, 1], rest_length=0, stiffness=1e5)
    for entity in links:
        scene.add_entity(entity)
    articulation = links[0].components[0].articulation
    articulation.name = "arm"
    articulation.qpos = [qpos.get(joint.name, 0) for joint in articulation.active_joints]
    said = drops_of(arm) | {f"second/{name}": values for name, values in drops_of(hand).items()}
    for joint in articulation.active_joints:
        joint.set_drive_properties(*((500, 50, 20) if joint.name.startswith("second/") else (1000, 100, 100)))
        joint.set_drive_target(qpos.get(joint.name, 0))
        for name, value in said[joint.name].items():
            getattr(joint, f"set_{name}")(value)

    part = {
        "urdf": "pkg://mani_skill/assets/robots/panda/panda_v2_gripper.urdf",
        "to": "panda_link8",
        "pose": {"p": [0.2, 0, 0.1], "q": [HALF, 0, 0, HALF]},
        "qpos": {"root_x_axis_joint": 0.02, "panda_finger_joint1": 0.03},
        "drives": {".*": {"stiffness": 500, "damping": 50, "force_limit": 20}},
    }
    entity = {
        "urdf": "pkg://mani_skill/assets/robots/panda/panda_v2.urdf",
        "qpos": dict(zip(names, PANDA, strict=True)),
        "drives": {"panda_.*": {"stiffness": 1000, "damping": 100, "force_limit": 100}},
        "attach": {"second": part},
    }
    with load_scene({"scenecc": 1, "entities": {"arm": entity}}, render=False) as batch:
        assert_same_scene(batch.scenes[0], scene)
        assert_same_trajectory(batch.scenes, [scene])


PANDA_START = {"panda_joint2": 0.39, "panda_joint4": -1.96, "panda_joint6": 2.36, "panda_joint7": 0.79}


@pytest.mark.maniskill
def test_the_shipped_panda_with_a_claw_and_a_camera() -> None:
    path = SCENES / "maniskill/panda_dclaw.yaml"
    found = importlib.util.find_spec("mani_skill")
    assert found is not None
    assert found.origin is not None
    robots = Path(found.origin).parent / "assets/robots"
    arm, claw = SCENES / "maniskill/parts/panda_arm.urdf", robots / "dclaw/dclaw_gripper_glb.urdf"
    said = drops_of(arm) | {f"claw/{name}": values for name, values in drops_of(claw).items()}
    plan: Any = compile_scene(path).entities[1].structures[0]
    (first,) = (link.joint.qpos for link in plan.links if link.joint and link.joint.name == "panda_joint1")

    def by_hand(start: float) -> Any:
        scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
        scene.add_ground(0, render=False).components[0].name = "ground"
        builder = scene.create_articulation_builder()
        builder.link_builders = links_of(arm, package_dir=robots / "panda")
        attach(builder, links_of(claw), "claw/", "panda_link8", Pose([0, 0, 0.012]))
        camera = links_of(arm.with_name("wrist_camera.urdf"))
        attach(builder, camera, "camera/", "claw/base_link", Pose([0, 0, -0.06], [HALF, 0, HALF, 0]))
        articulation = builder.build(fix_root_link=True)
        articulation.name = "panda"
        qpos = {**PANDA_START, "panda_joint1": start}
        articulation.qpos = [qpos.get(joint.name, 0) for joint in articulation.active_joints]
        for joint in articulation.active_joints:
            joint.set_drive_properties(*((100, 10, 10) if joint.name.startswith("claw/") else (1000, 100, 100)))
            joint.set_drive_target(qpos.get(joint.name, 0))
            for name, value in said[joint.name].items():
                getattr(joint, f"set_{name}")(value)
        return scene

    hand = [by_hand(start) for start in first.data.tolist()]
    with load_scene(path, render=False) as batch:
        for ours, theirs in zip(batch.scenes, hand, strict=True):
            assert_same_scene(ours, theirs)
        assert_same_trajectory(batch.scenes, hand)


WHEELS = Path(os.environ.get("SCENECC_WHEELS", "nowhere"))
GRIPPERS = sorted((WHEELS / "robosuite/models/assets/grippers").glob("*.xml"))


@pytest.mark.skipif(not GRIPPERS, reason="SCENECC_WHEELS names no folder with robosuite")
@pytest.mark.filterwarnings("ignore:Attach conflict")
@pytest.mark.parametrize("file", GRIPPERS, ids=lambda file: file.stem)
def test_robosuites_grippers_on_its_panda_are_mujocos(file: Path, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    try:
        child = mujoco.MjSpec.from_file(str(file))
        child.compile()
    except ValueError:
        pytest.skip("MuJoCo does not compile it")
    if len(child.worldbody.bodies) != 1 or not any(body.joints for body in child.bodies):
        pytest.skip("a gripper without joints is no articulation")
    arm = file.parents[1] / "robots/panda/robot.xml"
    assert_attached_as_mujoco_does(arm, file, "right_hand", roots=[WHEELS])


def assert_attached_as_mujoco_does(arm: Path, hand: Path, to: str, *, roots: list[Path]) -> None:
    """Compares an MJCF that has another one attached with what MuJoCo's own `attach` makes of both."""
    whole, child = (mujoco.MjSpec.from_file(str(file)) for file in (arm, hand))
    root = child.worldbody.bodies[0]
    pose = {"p": root.pos.tolist(), "q": root.quat.tolist()}
    whole.body(to).add_frame().attach_body(root, "gripper/", "")
    model = whole.compile()
    entity = {"mjcf": str(arm), "attach": {"gripper": {"mjcf": str(hand), "to": to, "pose": pose}}}
    with load_scene({"scenecc": 1, "entities": {"arm": entity}}, render=False, asset_roots=roots) as batch:
        held = batch.articulations["arm"]
        assert len(held.active_joint_names) == model.njnt
        driven = sum(joint.stiffness > 0 for joint in held.objs[0].active_joints)
        assert driven == sum(model.actuator_biastype == mujoco.mjtBias.mjBIAS_AFFINE)
        for seed in range(3):
            assert_same_machine(mujoco, model, batch, seed)
        for _ in range(100):
            batch.step()
        assert np.isfinite(held.qpos).all()


MJCF_ARM = """<mujoco><worldbody><body name="base" pos="0 0 0.3"><geom type="box" size="0.1 0.1 0.1"/>
<body name="upper" pos="0 0 0.2" euler="0 20 0"><joint name="turn" axis="0 1 0" range="-90 90"/>
<geom type="capsule" size="0.03" fromto="0 0 0 0 0 0.4"/><body name="wrist" pos="0 0 0.5">
<joint name="turn2" axis="0 0 1"/><inertial pos="0 0 0.01" mass="0.3" diaginertia="0.01 0.01 0.02"/>
</body></body></body></worldbody><actuator><position joint="turn" kp="50"/></actuator></mujoco>"""
MJCF_HAND = """<mujoco><compiler angle="radian"/><worldbody><body name="palm" pos="0.02 0 0.1" quat="0.6 0 0 0.8">
<geom type="box" size="0.05 0.1 0.02"/><body name="left" pos="0 0.05 0.05"><joint name="l" type="slide" axis="0 1 0"
range="0 0.05"/><geom type="box" size="0.01 0.01 0.05"/></body><body name="right" pos="0 -0.05 0.05"><joint name="turn"
type="slide" axis="0 -1 0" range="0 0.05"/><geom type="box" size="0.01 0.01 0.05"/></body></body></worldbody>
<actuator><position joint="l" kp="20" kv="1"/><position joint="turn" kp="20"/></actuator></mujoco>"""


def test_an_mjcf_on_another_is_what_mujoco_attaches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    for name, text in (("arm", MJCF_ARM), ("hand", MJCF_HAND)):
        (tmp_path / f"{name}.xml").write_text(text)
    assert_attached_as_mujoco_does(tmp_path / "arm.xml", tmp_path / "hand.xml", "wrist", roots=[tmp_path])
