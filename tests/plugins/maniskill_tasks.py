"""ManiSkill's tasks as references: what `gym.make(TASK, …)` and `reset(seed=0)` leave behind, and what follows from it.

    tasks = references(tmp_path_factory)        # taken once a session: all tasks in 20 to 30 seconds on two cores
    reference = tasks["PickCube-v1"]            # `Captured`, or `LeftOut` with the file that the wheel does not bring

The scene is that of `num_envs=1, sim_backend="cpu", render_backend="none"`. ManiSkill builds it as `gym.make` runs,
with its own seed 2022, and `reset(seed=0)` builds it again only for tasks that say so (`reconfiguration_freq`); what a
task draws when it builds is therefore mostly drawn from 2022, and poses and joint positions from 0.

"No action" is `STEPS` times `scene.step()` of SAPIEN from that state. No controller is called, so drives hold what the
reset left them: ManiSkill gives them stiffness and damping and no target, which is 0 for every joint.
"""

from __future__ import annotations

import fcntl
import os
import pickle
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from plugins.trajectory import Trajectory

from scenecc.decompiler.reading import LiveObject, Plain

STEPS = 200
TIMEOUT = 600


@dataclass(frozen=True)
class Robot:
    """A robot of a task.

    Attributes:
        uid: ManiSkill's name of the robot.
        file: its URDF or MJCF, an absolute path.
        fix_root_link: as ManiSkill's loader was told.
        control_mode: the controllers that set its drives.
    """

    uid: str
    file: str
    fix_root_link: bool
    control_mode: str


@dataclass(frozen=True)
class Camera:
    """A camera of a task or of its robots.

    Attributes:
        name: ManiSkill's uid of it.
        mount: the actor that it is mounted on, or ROBOT/LINK; None: it stands in the world.
        pose: position and quaternion (7,), in the world or in the frame of what it is mounted on.
        width, height: [px].
        fov: upright [rad].
        near, far: [m].
    """

    name: str
    mount: str | None
    pose: tuple[float, ...]
    width: int
    height: int
    fov: float
    near: float
    far: float


@dataclass(frozen=True)
class Captured:
    """What a task leaves behind.

    Attributes:
        task: its name in ManiSkill's registry.
        robots: in the order in which they were built.
        hidden: names of objects that are hidden from sensors.
        cameras: the sensors of the task and its robots, then those that people see by.
        scene: all that can be read, before the first step.
        trajectory: the steps that follow.
    """

    task: str
    robots: tuple[Robot, ...]
    hidden: tuple[str, ...]
    cameras: tuple[Camera, ...]
    scene: LiveObject
    trajectory: Trajectory

    def bare(self) -> Captured:
        """The same without what ManiSkill puts before names: the scene's number, the robot's name before its links."""
        robots = [facts.name for facts in self.scene.of_kind("articulation")]
        prefixes = sorted((f"{robot.replace('_', '-', 1)}_" for robot in robots), key=len, reverse=True)

        def bare(name: str) -> str:
            for prefix in prefixes:
                if name.startswith(prefix):
                    return name.removeprefix(prefix)
            return re.sub(r"^scene-\d+_", "", name)

        return replace(self, scene=renamed(self.scene, bare))


@dataclass(frozen=True)
class LeftOut:
    """A task that does not build from the wheel alone.

    Attributes:
        task: its name in ManiSkill's registry.
        lacking: the missing file, relative to ManiSkill's folder of assets; where no file is missing, the error.
    """

    task: str
    lacking: str


def references(
    factory: pytest.TempPathFactory, folder: str = "maniskill-references", tasks: tuple[str, ...] = ()
) -> dict[str, Captured | LeftOut]:
    """Some tasks, or all of ManiSkill's registry, captured once for all processes that run the tests of a session.

    Args:
        factory: of the session.
        folder: a name of its own for each choice of tasks.
        tasks: all if empty.
    """
    base = factory.getbasetemp()
    return capture_tasks((base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / folder, tasks)


def capture_tasks(folder: Path, tasks: tuple[str, ...] = ()) -> dict[str, Captured | LeftOut]:
    """The tasks' references by name, taken once for each folder; processes that ask at once wait for the first.

    Args:
        folder: where the references are kept.
        tasks: all of ManiSkill's registry if empty.

    Raises:
        subprocess.CalledProcessError: the process that captures failed; what it printed is on stderr.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        done = folder / "done"
        wanted = [task for task in tasks if not (folder / f"{task}.pickle").exists()]
        if not done.exists() and (wanted or not tasks):
            command = [sys.executable, "-m", "plugins.maniskill_capture", str(folder), *wanted]
            path = os.pathsep.join([str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
            subprocess.run(command, env=os.environ | {"PYTHONPATH": path}, check=True, timeout=TIMEOUT)
            if not tasks:
                done.touch()
    files = [folder / f"{task}.pickle" for task in tasks] or sorted(folder.glob("*.pickle"))
    return {file.stem: pickle.loads(file.read_bytes()) for file in files}


_OF_OTHERS = frozenset({"links", "joints", "active_joints", "parent", "articulation"})
"""Properties that hold names of other objects."""


def renamed(facts: LiveObject, rename: Callable[[str], str]) -> LiveObject:
    """The same tree with other names, also where one object names another; shapes keep theirs."""

    def called(name: str, value: Plain) -> Plain:
        if name not in _OF_OTHERS or value is None:
            return value
        return rename(value) if isinstance(value, str) else tuple(called(name, item) for item in _items(value))

    return replace(
        facts,
        name=facts.name if facts.kind.startswith("RenderShape") else rename(facts.name),
        values=tuple((name, called(name, value)) for name, value in facts.values),
        parts=tuple(renamed(part, rename) for part in facts.parts),
    )


def _items(value: Plain) -> tuple[Plain, ...]:
    assert isinstance(value, tuple)
    return value
