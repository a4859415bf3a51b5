"""Scenes of ManiSkill's tasks from their files, against ManiSkill's own loading of the same tasks."""

from __future__ import annotations

import ctypes
import importlib.util
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.paired import Row, alternating_order
from benchmarks.process import environment

TASKS = (
    "PickCube-v1",
    "StackCube-v1",
    "PegInsertionSide-v1",
    "TwoRobotPickCube-v1",
    "MS-AntWalk-v1",
    "UnitreeG1Stand-v1",
    "TriFingerRotateCubeLevel0-v1",
    "RotateSingleObjectInHandLevel0-v1",
)
SCENES = Path(__file__).parents[1] / "scenes" / "maniskill"

MOST_ROUNDS = 3
"""A round starts sixteen processes."""

OURS = """
import sys, time
from pathlib import Path
from scenecc import load_scene
held = load_scene(Path(sys.argv[1]).with_name("MS-CartpoleBalance-v1.yaml"), render=True)
for _ in range(2):
    started = time.process_time()
    batch = load_scene(sys.argv[1], render=True)
    print(time.process_time() - started)
    batch.close()
"""
"""Both sides load a light task first: scenecc imports modules when they are needed, ManiSkill when it is imported."""

THEIRS = """
import sys, time
import gymnasium, mani_skill.envs
from mani_skill.envs.sapien_env import BaseEnv
options = dict(num_envs=1, sim_backend="cpu", render_backend="cpu")
held = gymnasium.make("MS-CartpoleBalance-v1", **options)
reconfigure = BaseEnv._reconfigure
def timed(self, *args, **others):
    started = time.process_time()
    reconfigure(self, *args, **others)
    print(time.process_time() - started)
BaseEnv._reconfigure = timed
environment = gymnasium.make(sys.argv[1], **options)
environment.reset(options={"reconfigure": True})
"""

FIRST = "eight tasks, file to live scene with visuals, first in a process / ManiSkill's `_reconfigure`"
AGAIN = "the same, the second time in the process"
COLD = "process: scenecc validate PickCube-v1.yaml / its imports"
KNOWN = "the same, its files known to the cache"


def run(repetitions: int) -> list[Row]:
    """CPU seconds of each side, one task a process, and of the command."""
    if importlib.util.find_spec("mani_skill") is None:
        return [Row("real", what, (), note="mani_skill is not installed") for what in (FIRST, AGAIN, COLD, KNOWN)]
    from scenecc.backends.sapien.engine import render_problem

    found = _validation(repetitions)
    if (problem := render_problem()) is not None:
        return [*(Row("real", what, (), note=f"no visuals: {problem}") for what in (FIRST, AGAIN)), *found]
    return [*_loading(min(repetitions, MOST_ROUNDS)), *found]


def _loading(rounds: int) -> list[Row]:
    """The least CPU of a few rounds, for each task and side; the ratio of a task is one of the row's."""
    least: dict[tuple[str, int], list[float]] = {}
    for number in range(rounds):
        for task in TASKS:
            sides = [(OURS, str(SCENES / f"{task}.yaml")), (THEIRS, task)]
            for side in alternating_order(number, len(sides)):
                seconds = _seconds(*sides[side])
                least[task, side] = [*map(min, seconds, least.get((task, side), seconds))]
    rows: list[Row] = []
    for which, what in enumerate((FIRST, AGAIN)):
        pairs = {task: (least[task, 0][which], least[task, 1][which]) for task in TASKS}
        note = ", ".join(f"{task} {ours:.2f}/{theirs:.2f} s" for task, (ours, theirs) in pairs.items())
        rows.append(Row("real", what, tuple(ours / theirs for ours, theirs in pairs.values()), 1.0, note=note))
    return rows


def _seconds(code: str, argument: str) -> list[float]:
    command = [sys.executable, "-W", "ignore", "-c", code, argument]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{argument}: {done.stderr}")
    return [float(line) for line in done.stdout.split()[-2:]]


IMPORTS = "import typer, yaml, numpy; from pydantic import BaseModel"
"""What `scenecc validate` needs of others for a scene with a robot and meshes."""


def _validation(repetitions: int) -> list[Row]:
    """CPU of whole processes."""
    command = ["-m", "scenecc", "validate", str(SCENES / "PickCube-v1.yaml")]
    rounds: list[tuple[float, float, float]] = []
    with tempfile.TemporaryDirectory() as bytecode:
        for _ in range(repetitions + 1):
            with tempfile.TemporaryDirectory() as cache:
                variables = environment(bytecode) | {"XDG_CACHE_HOME": cache}
                cold, known = (_process(command, variables) for _ in range(2))
            rounds.append((cold, known, _process(["-c", IMPORTS], variables)))
    rounds = rounds[1:]
    return [
        Row(
            "real",
            what,
            tuple(each[side] / each[2] for each in rounds),
            1.5,
            note=" / ".join(f"{statistics.median(each[i] for each in rounds):.2f} s" for i in (side, 2)),
        )
        for side, what in enumerate((COLD, KNOWN))
    ]


_PR_SET_CHILD_SUBREAPER = 36
"""See prctl(2)."""


def _process(arguments: Sequence[str], variables: Mapping[str, str]) -> float:
    """CPU seconds of a process and of all that it starts, which may outlive it."""
    ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1)
    quiet = subprocess.DEVNULL
    process = subprocess.Popen([sys.executable, *arguments], env=variables, stdout=quiet, stderr=quiet)
    seconds = 0.0
    while True:
        try:
            child, status, usage = os.wait4(-1, 0)
        except ChildProcessError:
            return seconds
        seconds += usage.ru_utime + usage.ru_stime
        if child == process.pid:
            process.returncode = os.waitstatus_to_exitcode(status)
            if process.returncode:
                raise subprocess.CalledProcessError(process.returncode, arguments)
