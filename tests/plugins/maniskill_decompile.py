"""Decompiles ManiSkill's tasks without a render device, builds the files, and prints what differs.

    python -m plugins.maniskill_decompile TASK …

A process of its own, for the reasons of `plugins.maniskill_capture`.
"""

from __future__ import annotations

import json
import logging
import os
import sys
import tempfile
from typing import Any

from plugins.maniskill_capture import render_nothing
from plugins.maniskill_tasks import STEPS


def main(tasks: list[str]) -> None:
    """Prints one line of JSON a task: `task`, `lines`, `differences`, `step`."""
    with tempfile.TemporaryDirectory() as assets:
        os.environ["MS_ASSET_DIR"] = assets
        render_nothing()
        import gymnasium
        import mani_skill.envs

        assert mani_skill.envs
        logging.disable()
        for task in tasks:
            print(json.dumps(decompiled(gymnasium, task)), flush=True)


def decompiled(gymnasium: Any, task: str) -> dict[str, Any]:
    """A task's file against the task: what is built, and the steps that follow."""
    import scenecc
    from scenecc.decompiler.trajectory import first_difference, trajectory
    from scenecc.decompiler.verify import untouched_engine

    with scenecc.record() as recording:
        env: Any = gymnasium.make(task, num_envs=1, sim_backend="cpu", render_backend="none").unwrapped
        env.reset(seed=0)
    found = scenecc.decompile(env, recording=recording, name=task)
    with untouched_engine(), scenecc.load_scene(found.document, render=False) as batch:
        first, second = (trajectory(scene, STEPS) for scene in (env.scene.sub_scenes[0], batch.scenes[0]))
    lines = len(found.text.splitlines())
    return {
        "task": task,
        "lines": lines,
        "differences": found.differences,
        "step": first_difference(first, second),
    }


if __name__ == "__main__":
    main(sys.argv[1:])
