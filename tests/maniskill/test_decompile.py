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
    "MS-AntRun-v1": 40,  # an MJCF
}
"""Tasks, and how many lines their files may have."""


@pytest.mark.timeout(300)
def test_a_tasks_file_is_the_task() -> None:
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
