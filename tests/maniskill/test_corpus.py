"""The scenes of ManiSkill's tasks as files: their cameras, and what they build, against what the tasks leave behind.

`SCENECC_UPDATE_GOLDEN=1 pytest tests/maniskill/test_corpus.py` writes the table of `docs/reference/maniskill-tasks.md`.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from plugins.live.starting import start_from
from plugins.maniskill_corpus import DISTRIBUTIONS, FOLDER, PAGE, TASKS, UNLIKE, page_with, table
from plugins.maniskill_tasks import STEPS, Camera, Captured, LeftOut, references
from plugins.trajectory import first_difference, trajectory

import scenecc
from scenecc import plan
from scenecc.decompiler.reading import read_scene
from scenecc.decompiler.verify import differences

Tasks = dict[str, Captured | LeftOut]

pytestmark = pytest.mark.timeout(600)  # the first to ask waits until all tasks are captured


@pytest.fixture(scope="session")
def tasks(tmp_path_factory: pytest.TempPathFactory) -> Tasks:
    return references(tmp_path_factory)


def first_of(camera: plan.Camera) -> Camera:
    """A camera of a plan as the first scene has it."""
    mount = camera.mount and camera.mount.entity + (f"/{camera.mount.link}" if camera.mount.link else "")
    assert isinstance(camera.lens, plan.Perspective)
    assert camera.lens.fovy is not None
    near, far = float(camera.near.data[0]), float(camera.far.data[0])
    pose = tuple(camera.pose.data[0].tolist())
    return Camera(camera.name, mount, pose, camera.width, camera.height, float(camera.lens.fovy.data[0]), near, far)


def turned_alike(first: Camera, second: Camera) -> float:
    """1 where both are turned alike; a quaternion and its negative are one rotation."""
    return abs(float(np.dot(first.pose[3:], second.pose[3:])))


def assert_warns_of_nothing_that_it_says_itself(scene: scenecc.Scene) -> None:
    """ManiSkill's robots' files say things that are not read; what a scene says has to be right."""
    ours = [d for d in scene.diagnostics if d.severity == "error" or not is_about_maniskills_file(d)]
    assert not ours, "\n".join(map(str, ours))


def is_about_maniskills_file(found: scenecc.Diagnostic) -> bool:
    places = [found.file, *(other.location.file for other in found.related)]
    return any(str(file).startswith("pkg://mani_skill/") for file in places)


def assert_same_cameras(planned: Iterable[plan.Camera], theirs: tuple[Camera, ...]) -> None:
    found = {camera.name: first_of(camera) for camera in planned}
    assert sorted(found) == sorted(camera.name for camera in theirs)
    for camera in theirs:
        ours = found[camera.name]
        assert (ours.mount, ours.width, ours.height) == (camera.mount, camera.width, camera.height), camera.name
        assert (ours.fov, ours.near, ours.far) == pytest.approx((camera.fov, camera.near, camera.far), rel=1e-6)
        assert ours.pose[:3] == pytest.approx(camera.pose[:3], abs=1e-6), camera.name
        assert turned_alike(ours, camera) == pytest.approx(1, abs=1e-6), camera.name


@pytest.mark.parametrize("name", TASKS)
def test_a_file_builds_what_its_task_leaves_behind(name: str, tasks: Tasks) -> None:
    """Names, bodies, shapes, materials, masses, joints, limits, drives and state; then the steps, to the last bit.

    All that is asked of a file is asked here, since compiling it takes longest.
    """
    task = tasks[name]
    assert isinstance(task, Captured), task
    reference = task.bare()
    scene = scenecc.open_scene(FOLDER / f"{name}.yaml", num_scenes=1)
    assert_warns_of_nothing_that_it_says_itself(scene)
    assert_same_cameras(scene.plan.cameras, task.cameras)
    with scene.build(render=False) as batch:
        start_from(batch.scenes[0], reference.scene)
        unlike = differences(reference.scene, read_scene(batch.scenes[0]))
        step = first_difference(reference.trajectory, trajectory(batch.scenes[0], STEPS))
        hidden = {entity.name for entity in batch.plan.entities if entity.hidden}
    if name not in UNLIKE:
        assert not unlike, "\n".join(unlike)
        assert step is None, step
    else:
        known = UNLIKE[name]
        assert unlike, "equal now: take it out of UNLIKE"
        others = [line for line in unlike if not re.search(known.each, line)]
        assert not others, "\n".join(others)
        assert step is not None
        assert re.search(known.first, step), step
    # What stands in for bodies that ManiSkill shows nothing of is hidden as well.
    assert set(reference.hidden) <= hidden


def test_each_task_that_builds_has_a_file_and_the_others_name_what_they_lack(tasks: Tasks) -> None:
    assert [name for name, task in tasks.items() if isinstance(task, Captured)] == TASKS
    left = [task for task in tasks.values() if isinstance(task, LeftOut)]
    assert all(task.lacking for task in left)
    assert len(tasks) == len(TASKS) + len(left)
    assert len(TASKS) - len(UNLIKE) >= 40


def test_the_page_about_maniskill_has_the_table_of_tasks(tasks: Tasks) -> None:
    text = page_with(table(tasks))
    if os.environ.get("SCENECC_UPDATE_GOLDEN"):
        PAGE.write_text(text, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == text


def test_scene_files_of_tasks_are_short() -> None:
    for file in FOLDER.glob("*.yaml"):
        lines = file.read_text(encoding="utf-8").splitlines()
        assert lines[0].startswith("# "), file.name
        assert len(lines) <= (40 if file.stem == "PickCube-v1" else 150), file.name
        assert max(map(len, lines)) <= 120, file.name


@pytest.mark.parametrize("file", DISTRIBUTIONS, ids=lambda file: file.stem)
def test_a_distribution_gives_each_scene_its_own(file: Path) -> None:
    task = file.stem.removesuffix(".distribution")
    assert task in TASKS
    scene = scenecc.open_scene(file, num_scenes=8, seed=1)
    assert_warns_of_nothing_that_it_says_itself(scene)
    with scene.build(render=False) as batch:
        scenes = [read_scene(scene) for scene in batch.scenes]
        assert len(set(scenes)) == 8
        first = batch.scenes[0]
        for _ in range(10):
            first.step()
    with scenecc.load_scene(file, num_scenes=8, seed=1, render=False) as again:
        assert [read_scene(scene) for scene in again.scenes] == scenes


def test_there_is_a_distribution_of_each_task_that_draws_what_it_builds() -> None:
    drawing = {file.stem for file in FOLDER.glob("*-v1.yaml") if "what ManiSkill draws" in file.read_text("utf-8")}
    assert drawing <= {file.stem.removesuffix(".distribution") for file in DISTRIBUTIONS}
    assert {"PegInsertionSide-v1", "RotateValveLevel2-v1", "SO100GraspCube-v1"} <= drawing
