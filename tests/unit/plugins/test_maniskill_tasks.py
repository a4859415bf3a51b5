"""References taken from ManiSkill: all tasks of its registry, each the same whenever it is taken."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from plugins.maniskill_tasks import STEPS, Captured, LeftOut, capture_tasks, references
from plugins.trajectory import first_difference

from scenecc.decompiler.verify import differences

pytestmark = [pytest.mark.maniskill, pytest.mark.timeout(600)]
FOLDERS = ("assets/", "partnet_mobility/", "robots/", "scene_datasets/", "tasks/")


@pytest.fixture(scope="module")
def tasks(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Captured | LeftOut]:
    return references(tmp_path_factory)


def captured(tasks: dict[str, Captured | LeftOut], task: str) -> Captured:
    found = tasks[task]
    assert isinstance(found, Captured)
    return found


def test_every_task_of_the_registry_is_captured_or_lacks_something_by_name(tasks: dict[str, Captured | LeftOut]):
    script = "import mani_skill.envs; from mani_skill.utils.registration import REGISTERED_ENVS as r; print(*r)"
    listed = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True).stdout.split()
    assert sorted(listed) == sorted(tasks)
    lacking = {name: task.lacking for name, task in tasks.items() if isinstance(task, LeftOut)}
    assert (len(tasks) - len(lacking), len(lacking)) == (44, 30)
    files = {name: what for name, what in lacking.items() if what.startswith(FOLDERS)}
    assert lacking.keys() - files.keys() == {"DrawSVG-v1", "PushT-v1"}  # a package, and a device to render with


def test_a_task_is_captured_whole(tasks: dict[str, Captured | LeftOut]):
    pick = captured(tasks, "PickCube-v1").bare()
    assert [robot.uid for robot in pick.robots] == ["panda"]
    assert pick.hidden == ("goal_site",)
    names = [entity.name for entity in pick.scene.of_kind("entity")]
    assert names[0] == "panda_link0"
    assert names[-4:] == ["table-workspace", "ground", "cube", "goal_site"]
    (panda,) = pick.scene.of_kind("articulation")
    assert panda.name == "panda"
    links = panda.value("links")
    assert isinstance(links, tuple)
    assert len(links) == 15
    targets = [joint.value("drive_target") for joint in pick.scene.of_kind("joint") if joint.value("dof")]
    assert all(str(target) == "[0.0]" for target in targets)
    moves = pick.trajectory
    assert len(moves.states) == STEPS + 1
    assert sum(label.startswith("pose of ") for label in moves.labels) == 19 * 7
    qpos = [label.startswith("qpos of ") for label in moves.labels]
    assert np.abs(moves.states[-1, qpos] - moves.states[0, qpos]).max() > 1


def test_prefixes_of_maniskill_are_taken_off_names(tasks: dict[str, Captured | LeftOut]):
    two = captured(tasks, "TwoRobotPickCube-v1").bare()
    robots = [facts.name for facts in two.scene.of_kind("articulation")]
    assert robots == ["panda_wristcam-agent-0", "panda_wristcam-agent-1"]
    links = two.scene.of_kind("PhysxArticulationLinkComponent")
    assert {link.name for link in links} == {entity.name for entity in two.scene.of_kind("entity")[:15]}
    assert links[-1].value("articulation") == "panda_wristcam-agent-1"
    assert not [facts for facts in two.scene.of_kind("entity") if facts.name.startswith("scene-")]


def test_what_a_task_lacks_is_named(tasks: dict[str, Captured | LeftOut]):
    assert tasks["PickSingleYCB-v1"] == LeftOut("PickSingleYCB-v1", "assets/mani_skill2_ycb")
    lacking = tasks["DrawSVG-v1"]
    assert isinstance(lacking, LeftOut)
    assert "svgpathtools" in lacking.lacking


def test_a_task_taken_again_is_the_same_to_the_bit(
    tasks: dict[str, Captured | LeftOut], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    names = ("PickCube-v1", "MS-AntWalk-v1")
    capture_tasks(tmp_path, names)
    monkeypatch.setattr("subprocess.run", None)  # what was taken is read, and not taken again
    again = capture_tasks(tmp_path, names)
    for task in again:
        one, other = captured(tasks, task), captured(again, task)
        assert differences(one.scene, other.scene) == []
        assert first_difference(one.trajectory, other.trajectory) is None
