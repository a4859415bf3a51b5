"""ManiSkill's tasks as scene files: builds, resets and decompiles a task."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Any

from scenecc.backends.maniskill.compat import REGISTERED_ENVS, gym, torch
from scenecc.backends.sapien.engine import release_renderer, render_problem
from scenecc.decompiler.decompile import Decompiled, decompile
from scenecc.decompiler.record import record
from scenecc.diagnostics.messages import suggest
from scenecc.extras import DRIVER_HINT
from scenecc.scene_file.parallel import UnlikeScenes


class TaskFailure(Exception):
    """A task cannot be built here. The message says why, and its further lines what helps."""


def decompile_task(task: str, *, base: Path, seed: int = 0, num_envs: int = 1, check: bool = True) -> Decompiled:
    """Returns the scene of a ManiSkill task after `gym.make(task)` and `reset(seed=seed)`.

    ManiSkill's CPU simulation has one scene in an environment. Parallel scenes are therefore separate environments,
    each reset with the next seed.

    Args:
        task: its name in ManiSkill's registry; the module that registers it is imported.
        base: folder of the scene file.
        seed: of the reset of the first environment.
        num_envs: number of parallel scenes in the file.
        check: build the file and compare.

    Raises:
        TaskFailure: there is no such task, it does not build here, or its scenes are too different for one file.
    """
    if task not in REGISTERED_ENVS:
        hint = suggest(task, sorted(REGISTERED_ENVS))
        raise TaskFailure(f"ManiSkill has no task `{task}`; {hint}")
    problem = render_problem()
    if problem is not None:
        raise TaskFailure(f"ManiSkill's tasks need a render device: {problem}\n{DRIVER_HINT}")
    release_renderer()
    where = "gpu" if torch.cuda.is_available() else "cpu"
    envs: list[Any] = []
    with ExitStack() as opened:
        try:
            with record() as recording:
                for number in range(num_envs):
                    envs.append(gym.make(task, num_envs=1, sim_backend="cpu", render_backend=where))
                    opened.callback(envs[-1].close)
                    envs[-1].reset(seed=seed + number)
        except (Exception, SystemExit) as error:
            words = f"{type(error).__name__}: {error}".partition("\n")[0]
            raise TaskFailure(f"the task `{task}` cannot be built: {words}") from error
        try:
            return decompile(envs, recording=recording, base=base, name=task, check=check)
        except UnlikeScenes as error:
            raise TaskFailure(f"the scenes of `{task}` do not fit into one file: {error}") from error
