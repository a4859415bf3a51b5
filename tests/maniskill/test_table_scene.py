"""`scenecc:table_scene` against ManiSkill's `TableSceneBuilder`, with every robot that it knows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plugins.maniskill_tasks import Captured, LeftOut, references

from scenecc import SceneError, load_scene
from scenecc.decompiler.reading import LiveObject, read_scene
from scenecc.decompiler.verify import differences

PHYSICS = {
    "contact_offset": 0.02,
    "solver_position_iterations": 15,
    "default_material": {"static_friction": 0.3, "dynamic_friction": 0.3, "restitution": 0},
}
PLACED = {
    "panda": "PickCube-v1:panda",
    "panda_wristcam": "PickCube-v1:panda_wristcam",
    "so100": "PickCube-v1:so100",
    "fetch": "PickCube-v1:fetch",
    "panda_wristcam+panda_wristcam": "TwoRobotPickCube-v1:panda_wristcam+panda_wristcam",
}
"""Robots and the tasks in which ManiSkill's builder places them; `panda_stick` stands in the tasks of drawing."""

HANDS = ("panda_stick", "dclaw", "allegro_hand_right", "allegro_hand_left", "allegro_hand_right_touch", "trifingerpro")
DOWNLOADED = {
    "xarm6_robotiq": "xarm6",
    "xarm6_nogripper": "xarm6",
    "widowxai": "widowxai",
    "widowxai_wristcam": "widowxai",
}

NOISY = {
    "panda": [True] * 7 + [False] * 2,
    "panda_wristcam": [True] * 7 + [False] * 2,
    "panda_stick": [True] * 7,
    "so100": [True] * 6,
    "dclaw": [True] * 9,
}
"""The joints to which noise is added."""


def scene(robot: str, **given: Any) -> dict[str, Any]:
    use = {"use": "scenecc:table_scene", "prefix": "", "with": {"robot": robot, **given}}
    return {"scenecc": 1, "physics": PHYSICS, "entities": {"table": use}}


@pytest.fixture(scope="session")
def tasks(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Captured | LeftOut]:
    return references(tmp_path_factory, "table-scenes", tuple(PLACED.values()))


def without_objects(facts: LiveObject) -> LiveObject:
    """A scene without what a task adds to the table."""
    return replace(facts, parts=tuple(part for part in facts.parts if part.name not in {"cube", "goal_site"}))


@pytest.mark.parametrize("robot", PLACED)
def test_a_robot_is_at_the_table_as_in_maniskill(robot: str, tasks: dict[str, Captured | LeftOut]) -> None:
    task = tasks[PLACED[robot]]
    assert isinstance(task, Captured), task
    with load_scene(scene(robot, robot_init_qpos_noise=0, hold=False), render=False) as batch:
        unlike = differences(without_objects(task.bare().scene), read_scene(batch.scenes[0]))
    # A driven joint without limits rests at any target only with this type, which ManiSkill does not use.
    unlike = [one for one in unlike if not one.endswith(".type: 'revolute' against 'revolute_unwrapped'")]
    assert not unlike, "\n".join(unlike)


@pytest.mark.parametrize("robot", HANDS)
def test_other_robots_at_the_table_are_built_and_stay_in_place(robot: str) -> None:
    with load_scene(scene(robot, robot_init_qpos_noise=0), render=False) as batch:
        (arm,) = batch.articulations.values()
        start = arm.qpos.copy()
        assert np.array_equal(arm.drive_target, start)
        for _ in range(50):
            batch.scenes[0].step()
        # A thumb of an Allegro hand starts at 0, beyond its limit of 0.263, which pushes it there.
        assert np.abs(arm.qpos - start).max() < (0.3 if "allegro" in robot else 0.05)


@pytest.mark.parametrize("robot", NOISY)
def test_noise_is_on_the_joints_of_maniskill_and_drawn_again_at_a_reset(robot: str) -> None:
    noisy = np.array(NOISY[robot])
    with load_scene(scene(robot), num_scenes=150, seed=3, render=False) as batch:
        (arm,) = batch.articulations.values()
        first = arm.qpos.copy()
        deviation = first.std(axis=0)
        assert np.all(np.abs(deviation[noisy] - 0.02) < 0.005)
        assert np.all(np.ptp(first, axis=0)[~noisy] == 0)
        batch.reset(seed=4)
        assert np.all((arm.qpos != first).any(axis=0) == noisy)
        batch.reset(seed=3)
        assert np.array_equal(arm.qpos, first)


def test_no_noise_is_the_rest_position_in_every_scene() -> None:
    with load_scene(scene("panda", robot_init_qpos_noise=0), num_scenes=3, render=False) as batch:
        rest = [0, np.pi / 8, 0, -np.pi * 5 / 8, 0, np.pi * 3 / 4, np.pi / 4, 0.04, 0.04]
        assert np.array_equal(batch.articulations["panda"].qpos, np.array([rest] * 3, np.float32))


@pytest.mark.parametrize("robot", DOWNLOADED)
def test_a_robot_with_missing_files_says_how_to_get_them(robot: str) -> None:
    with pytest.raises(SceneError, match=f"download_asset {DOWNLOADED[robot]}"):
        load_scene(scene(robot), render=False)


@pytest.mark.parametrize("robot", DOWNLOADED)
def test_keys_of_a_robot_with_missing_files_fit_its_links_and_joints(robot: str, tmp_path: Path) -> None:
    """A stand-in with the names that ManiSkill's code has of the robot."""
    arm = [f"joint{i}" for i in range(1, 7)]
    fingers = [f"{side}_{part}_joint" for part in ("outer_knuckle", "inner_knuckle", "inner_finger") for side in SIDES]
    wide = ([f"joint_{i}" for i in range(6)] + ["left_carriage_joint", "right_carriage_joint"], "wxai_base")
    joints, name = {
        "xarm6_robotiq": (arm + fingers, "xarm6_robotiq"),
        "xarm6_nogripper": (arm, "xarm6_nogripper"),
        "widowxai": wide,
        "widowxai_wristcam": (wide[0], "wxai_follower"),
    }[robot]
    folder = tmp_path / "robots" / robot.split("_", maxsplit=1)[0]
    folder.mkdir(parents=True)
    (folder / f"{name}.urdf").write_text(stand_in(joints))
    with load_scene(scene(robot, robot_init_qpos_noise=0), asset_roots=[tmp_path], render=False) as batch:
        assert batch.articulations[robot].qpos.shape == (1, len(joints))


SIDES = ("left", "right")


def stand_in(joints: list[str]) -> str:
    """A URDF with these joints, one below the other but for those of fingers."""
    box = '<collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision>'
    mass = '<inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>'
    parts = ['<robot name="stand_in">', f'<link name="base">{mass}{box}</link>']
    parent = "base"
    for joint in joints:
        child = link_of(joint)
        parts.append(f'<link name="{child}">{mass}{box}</link>')
        hangs_on = parent if "finger" not in joint else joint.split("_")[0] + "_outer_knuckle"
        parts.append(
            f'<joint name="{joint}" type="revolute"><parent link="{hangs_on}"/><child link="{child}"/>'
            '<origin xyz="0 0 0.1"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        )
        parent = child if joint.startswith("joint") else parent
    fixed = ["left_inner_finger_pad", "right_inner_finger_pad", "left_outer_finger", "right_outer_finger"]
    for name in [*fixed, "robotiq_arg2f_base_link"] if len(joints) == 12 else []:
        parts.append(f'<link name="{name}">{mass}{box}</link>')
        parts.append(f'<joint name="to_{name}" type="fixed"><parent link="{parent}"/><child link="{name}"/></joint>')
    return "\n".join([*parts, "</robot>"])


def link_of(joint: str) -> str:
    if joint.startswith("joint"):
        return joint.replace("joint", "link")
    return {"left_carriage_joint": "gripper_left", "right_carriage_joint": "gripper_right"}.get(
        joint, joint.removesuffix("_joint")
    )
