"""ManiSkill's tasks as files: each is built and equals its task, now and over the steps that follow."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

TASKS = {
    "PickCube-v1*2": 60,  # parallel scenes
    "PickCube-v1": 40,  # a robot by its URDF, a prefab for table and ground
    "RotateValveLevel2-v1": 75,  # a tree of links
    "MS-HumanoidRun-v1": 400,  # a robot by its MJCF, which is a tree of links, with quaternions not quite of length 1
}
"""Tasks, and how many lines their files may have."""


@pytest.mark.timeout(300)
def test_a_decompiled_task_equals_the_task() -> None:
    tests = Path(__file__).parents[1]
    path = os.pathsep.join([str(tests), str(tests.parent), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", "plugins.maniskill_decompile", *TASKS]
    done = subprocess.run(
        command, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True, check=True, timeout=290
    )
    found = [json.loads(line) for line in done.stdout.splitlines() if line.startswith('{"task"')]
    assert [task["task"] for task in found] == list(TASKS)
    for task in found:
        assert task["differences"] == [], task
        assert task["step"] is None, task
        assert task["lines"] <= TASKS[task["task"]], task


@pytest.mark.render
@pytest.mark.timeout(300)
def test_a_task_is_built_after_scenecc_asked_for_a_render_device() -> None:
    command = [sys.executable, "-m", "scenecc", "decompile", "PickCube-v1", "--no-check"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=290)
    assert done.returncode == 0, done.stderr
    assert "name: PickCube-v1" in done.stdout


@pytest.mark.parametrize("task", ["PickCube", "pickcube-v1"])
def test_an_unknown_task_is_an_error_with_the_nearest_name(task: str, tmp_path: Path) -> None:
    from scenecc.maniskill import tasks

    with pytest.raises(tasks.TaskFailure, match=f"no task `{task}`; did you mean `PickCube-v1`"):
        tasks.decompile_task(task, base=tmp_path)


def test_without_a_device_that_renders_the_error_says_how_to_get_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from scenecc.maniskill import tasks

    monkeypatch.setattr(tasks, "render_problem", lambda: "none")
    with pytest.raises(tasks.TaskFailure, match=r"need a render device: none\n(.|\n)*mesa-vulkan-drivers"):
        tasks.decompile_task("PickCube-v1", base=tmp_path)


def test_environments_are_closed_if_a_later_one_fails(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from scenecc.maniskill import tasks

    class Environment:
        def __init__(self, number: int) -> None:
            self.number = number

        def reset(self, seed: int) -> None:
            if self.number == 2:
                raise RuntimeError("no place left")

        def close(self) -> None:
            closed.append(self.number)

    closed: list[int] = []
    numbers = iter(range(5))
    monkeypatch.setattr(tasks, "render_problem", lambda: None)
    monkeypatch.setattr(tasks.gym, "make", lambda *_, **__: Environment(next(numbers)))
    with pytest.raises(tasks.TaskFailure, match="cannot be built: RuntimeError: no place left"):
        tasks.decompile_task("PickCube-v1", base=tmp_path, num_envs=4)
    assert sorted(closed) == [0, 1, 2]
