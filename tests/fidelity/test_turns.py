"""A joint rests at its target beyond a full turn, where SAPIEN's `revolute` would spin for ever."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import sapien
from sapien import physx
from sapien.wrapper.urdf_loader import URDFLoader

import scenecc

URDF = """<robot name="r">
  <link name="base"/>
  <link name="arm"><inertial>
    <mass value="1"/><inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/>
  </inertial></link>
  <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
</robot>"""

MJCF = """<mujoco>
  <compiler angle="radian"/><option gravity="0 0 0"/>
  <worldbody><body name="base"><geom size="0.1"/>
    <body name="arm"><joint name="j" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="0.02 0.02 0.02"/></body>
  </body></worldbody>
  <actuator><position joint="j" kp="20" kv="2"/></actuator>
  <keyframe><key name="far" ctrl="7"/></keyframe>
</mujoco>"""

LINK = "inertial: {mass: 1, inertia: [0.02, 0.02, 0.02]}"


def tree(joint: str) -> str:
    arm = f"{{name: arm, {LINK}, joint: {{name: j, axis: z, {joint}}}}}"
    return f"root: {{name: base, inertial: {{mass: 1, inertia: [1, 1, 1]}}, children: [{arm}]}}"


def scene(keys: str, head: str = "") -> str:
    return f"scenecc: 1\n{head}physics: {{gravity: [0, 0, 0]}}\nentities:\n  m: {{fix_root_link: true, {keys}}}\n"


def robot(batch: Any, number: int = 0) -> Any:
    (found,) = {link.articulation for link in batch.scenes[number].physx_system.articulation_link_components}
    return found


def rest(text: str, folder: Path, target: float | None = None) -> tuple[str, list[float]]:
    """Type of the joint, and its position after 3 s in each scene. `target`: set while running."""
    (folder / "wheel.urdf").write_text(URDF)
    (folder / "wheel.xml").write_text(MJCF)
    (folder / "scene.yaml").write_text(text)
    with scenecc.load_scene(folder / "scene.yaml", render=False) as batch:
        robots = [robot(batch, number) for number in range(len(batch.scenes))]
        for one in robots if target is not None else ():
            one.active_joints[0].set_drive_target(target)
        for _ in range(300):
            batch.step()
        return str(robots[0].active_joints[0].type), [float(one.qpos[0]) for one in robots]


DRIVE = "drives: {j: {stiffness: 20, damping: 2%s}}"

CASES = {
    "start": ("urdf: wheel.urdf, qpos: {j: 7}, " + DRIVE % "", 7.0),
    "negative target": ("urdf: wheel.urdf, " + DRIVE % ", target: -8.5", -8.5),
    "damping of the joint only": ("urdf: wheel.urdf, qpos: {j: 1}, drives: {j: {stiffness: 20}}", None),
    "keyframe": ("mjcf: wheel.xml, keyframe: far", 7.0),
    "tree": (tree("type: revolute") + ", " + DRIVE % ", target: 7", 7.0),
    "limits of turns": (tree("type: revolute, limits: [-10, 10]") + ", " + DRIVE % ", target: 7", 7.0),
    "continuous tree": (tree("type: continuous") + ", qpos: {j: 20}, " + DRIVE % "", 20.0),
}


@pytest.mark.parametrize("case", CASES)
def test_a_joint_rests_beyond_a_turn(case: str, tmp_path: Path) -> None:
    keys, expected = CASES[case]
    kind, found = rest(scene(keys), tmp_path)
    assert kind == "revolute_unwrapped"
    assert expected is None or found == [pytest.approx(expected, abs=1e-3)]


def test_a_target_set_later_and_drawn_ones(tmp_path: Path) -> None:
    keys = "urdf: wheel.urdf, " + DRIVE % ""
    assert rest(scene(keys), tmp_path, target=7.0)[1] == [pytest.approx(7, abs=1e-3)]
    drawn = "urdf: wheel.urdf, drives: {j: {stiffness: {uniform: [15, 20]}, damping: 2, target: {choice: [7.5, -9]}}}"
    found = rest(scene(drawn, "num_scenes: 8\n"), tmp_path)[1]
    assert sorted({round(at, 2) for at in found}) == [-9, 7.5]


def test_a_mimic_follows_beyond_a_turn(tmp_path: Path) -> None:
    wheel = f"{{name: w, {LINK}, joint: {{name: k, type: continuous, axis: z, mimic: {{joint: j, multiplier: 0.5}}}}}}"
    keys = tree("type: continuous").replace("children: [", f"children: [{wheel}, ") + ", " + DRIVE % ", target: 16"
    (tmp_path / "scene.yaml").write_text(scene(keys))
    with scenecc.load_scene(tmp_path / "scene.yaml", render=False) as batch:
        made = robot(batch)
        for _ in range(400):
            batch.step()
        found = {joint.name: float(at) for joint, at in zip(made.active_joints, made.qpos, strict=True)}
    assert found == {"j": pytest.approx(16, abs=0.01), "k": pytest.approx(8, abs=0.01)}


@pytest.mark.parametrize("stiffness", [0.0, 20.0])
def test_below_a_turn_it_equals_the_loader_to_the_bit(stiffness: float, tmp_path: Path) -> None:
    """A wheel, driven by speed, stays the loader's `revolute`."""
    (tmp_path / "wheel.urdf").write_text(URDF)
    keys = f"urdf: wheel.urdf, drives: {{j: {{stiffness: {stiffness}, damping: 2, target: 3, velocity_target: 4}}}}"
    (tmp_path / "scene.yaml").write_text(f"scenecc: 1\nentities: {{m: {{{keys}}}}}\n")
    with scenecc.load_scene(tmp_path / "scene.yaml", render=False) as batch:
        made = robot(batch)
        assert made.active_joints[0].type == ("revolute_unwrapped" if stiffness else "revolute")
        found: list[tuple[float, float]] = []
        for _ in range(100):
            batch.step()
            found.append((float(made.qpos[0]), float(made.qvel[0])))
    hand: Any = sapien.Scene([physx.PhysxCpuSystem()])
    hand.set_timestep(0.01)
    loader: Any = URDFLoader()
    loader.set_scene(hand)
    other = loader.load(str(tmp_path / "wheel.urdf"))
    joint = other.active_joints[0]
    joint.set_drive_properties(stiffness, 2)
    joint.set_drive_target(3)
    joint.set_drive_velocity_target(4)
    for step in range(100):
        hand.step()
        assert (float(other.qpos[0]), float(other.qvel[0])) == found[step]


@pytest.mark.parametrize(
    ("target", "again"), [("mjcf", "mjcf: out.xml, keyframe: start"), ("urdf", "urdf: out.urdf, ")]
)
def test_an_exported_joint_counts_turns_again(target: str, again: str, tmp_path: Path) -> None:
    (tmp_path / "wheel.urdf").write_text(URDF)
    keys = "urdf: wheel.urdf, " + DRIVE % ", target: 7"
    (tmp_path / "scene.yaml").write_text(scene(keys))
    made = scenecc.open_scene(tmp_path / "scene.yaml").emit(target, name="out")
    for name, content in made.files.items():
        (tmp_path / name).write_bytes(content)
    keys = again + (DRIVE % ", target: 7" if target == "urdf" else "")
    assert rest(scene(keys), tmp_path) == ("revolute_unwrapped", [pytest.approx(7, abs=1e-3)])


def test_a_live_joint_that_wraps_is_decompiled(tmp_path: Path) -> None:
    hand: Any = sapien.Scene([physx.PhysxCpuSystem()])
    (tmp_path / "wheel.urdf").write_text(URDF)
    loader: Any = URDFLoader()
    loader.set_scene(hand)
    (joint,) = loader.load(str(tmp_path / "wheel.urdf")).active_joints
    joint.set_drive_properties(20, 2)
    joint.set_drive_target(3)
    found = scenecc.decompile(hand)
    assert found.is_equal, (found.problems, found.differences)
