"""ManiSkill's tasks as scene files: a task is built, reset, and decompiled."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.backends.maniskill.compat import REGISTERED_ENVS, gym, torch
from scenecc.backends.sapien.engine import render_problem
from scenecc.decompiler.decompile import decompile
from scenecc.decompiler.record import record

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.decompiler.decompile import Decompiled


class TaskFailure(Exception):
    """A task that cannot be built here; the message says why in one sentence."""


def decompile_task(task: str, *, base: Path, seed: int = 0, check: bool = True) -> Decompiled:
    """The first scene of a task of ManiSkill, as `gym.make(task)` and `reset(seed=seed)` leave it.

    Args:
        task: its name in ManiSkill's registry; the module that registers it is imported.
        base: folder of the scene file.
        seed: of the reset.
        check: whether to build the file and to compare.

    Raises:
        TaskFailure: there is no such task, or it does not build here.
    """
    if task not in REGISTERED_ENVS:
        raise TaskFailure(f"ManiSkill has no task `{task}`")
    problem = render_problem()
    if problem is not None:
        raise TaskFailure(f"ManiSkill's tasks need a device that renders: {problem}")
    where = "gpu" if torch.cuda.is_available() else "cpu"
    try:
        with record() as recording:
            env = gym.make(task, num_envs=1, sim_backend="cpu", render_backend=where)
            env.reset(seed=seed)
    except (Exception, SystemExit) as error:
        words = f"{type(error).__name__}: {error}".partition("\n")[0]
        raise TaskFailure(f"the task `{task}` does not build: {words}") from error
    try:
        return decompile(env, recording=recording, base=base, name=task, check=check)
    finally:
        env.close()
