"""Decompiles ManiSkill's tasks without a render device, builds the files, and prints what differs.

    python -m plugins.maniskill_decompile TASK[*COUNT] …

COUNT environments, reset with the seeds 0, 1, …, are one file of parallel scenes.

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
        import scenecc.backends.sapien.live_properties  # which names setters of materials that are taken away below

        assert scenecc.backends.sapien.live_properties
        render_nothing()
        import gymnasium
        import mani_skill.envs

        assert mani_skill.envs
        logging.disable()
        for task in tasks:
            print(json.dumps(decompiled(gymnasium, task)), flush=True)


def decompiled(gymnasium: Any, asked: str) -> dict[str, Any]:
    """A task's file against the task: what is built, and the steps that follow."""
    from plugins.trajectory import first_difference, trajectory

    import scenecc
    from scenecc.decompiler.verify import default_engine_settings

    task, _, count = asked.partition("*")
    envs: list[Any] = []
    with scenecc.record() as recording:
        for seed in range(int(count or 1)):
            envs.append(gymnasium.make(task, num_envs=1, sim_backend="cpu", render_backend="none").unwrapped)
            envs[-1].reset(seed=seed)
    found = scenecc.decompile(envs if count else envs[0], recording=recording, name=task)
    with default_engine_settings(), scenecc.load_scene(found.document, render=False) as batch:
        pairs = zip((env.scene.sub_scenes[0] for env in envs), batch.scenes, strict=True)
        steps = [first_difference(trajectory(live, STEPS), trajectory(built, STEPS)) for live, built in pairs]
    return {
        "task": asked,
        "lines": len(found.text.splitlines()),
        "differences": found.differences,
        "step": next((step for step in steps if step is not None), None),
    }


if __name__ == "__main__":
    main(sys.argv[1:])
