"""The cameras of the scene files of ManiSkill's tasks against those of the tasks and of their robots."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from plugins.expectations import ROOT
from plugins.maniskill_tasks import Camera, Captured, LeftOut, references

import scenecc
from scenecc import plan

FOLDER = ROOT / "scenes" / "maniskill"
TASKS = sorted(file.stem for file in FOLDER.glob("*-v1.yaml"))

pytestmark = pytest.mark.timeout(600)  # the first to ask waits until all tasks are captured


@pytest.fixture(scope="session")
def tasks(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Captured | LeftOut]:
    return references(tmp_path_factory)


def first_of(camera: plan.Camera) -> Camera:
    """A camera of a plan as the first scene has it."""
    mount = camera.mount and camera.mount.entity + (f"/{camera.mount.link}" if camera.mount.link else "")
    assert isinstance(camera.lens, plan.Perspective)
    assert camera.lens.fovy is not None
    near, far = float(camera.near.data[0]), float(camera.far.data[0])
    pose = tuple(camera.pose.data[0].tolist())
    return Camera(camera.name, mount, pose, camera.width, camera.height, float(camera.lens.fovy.data[0]), near, far)


def cameras_of(file: Path) -> dict[str, Camera]:
    return {camera.name: first_of(camera) for camera in scenecc.compile_scene(file, num_scenes=1).cameras}


def turned_alike(first: Camera, second: Camera) -> float:
    """1 where both are turned alike; a quaternion and its negative are one rotation."""
    return abs(float(np.dot(first.pose[3:], second.pose[3:])))


@pytest.mark.parametrize("name", TASKS)
def test_a_file_has_the_cameras_of_its_task(name: str, tasks: dict[str, Captured | LeftOut]) -> None:
    task = tasks[name]
    assert isinstance(task, Captured)
    found = cameras_of(FOLDER / f"{name}.yaml")
    assert sorted(found) == sorted(camera.name for camera in task.cameras)
    for theirs in task.cameras:
        ours = found[theirs.name]
        assert (ours.mount, ours.width, ours.height) == (theirs.mount, theirs.width, theirs.height), theirs.name
        assert (ours.fov, ours.near, ours.far) == pytest.approx((theirs.fov, theirs.near, theirs.far), rel=1e-6)
        assert ours.pose[:3] == pytest.approx(theirs.pose[:3], abs=1e-6), theirs.name
        assert turned_alike(ours, theirs) == pytest.approx(1, abs=1e-6), theirs.name
