"""Builds ManiSkill's tasks and writes down what their scenes are.

    python -m plugins.maniskill_capture FOLDER [TASK …]

A process of its own, since it changes what the whole process sees: ManiSkill's assets are looked for in an empty
folder, so that only what the wheel brings is there, and materials of SAPIEN's renderer are replaced by ones that need
no device. ManiSkill is imported once, and every task is built in a fork, as SAPIEN keeps process-wide defaults and
caches.
"""

from __future__ import annotations

import logging
import os
import pickle
import re
import sys
import tempfile
import traceback
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from plugins.maniskill_tasks import STEPS, Camera, Captured, LeftOut, Robot
from plugins.trajectory import trajectory

from scenecc.decompiler.reading import read_scene

JOBS = 2


def main(folder: Path, tasks: list[str]) -> None:
    """Captures tasks, all of the registry if none is named, and writes `FOLDER/TASK.pickle` for each."""
    with tempfile.TemporaryDirectory() as assets:
        os.environ["MS_ASSET_DIR"] = assets
        os.environ.pop("MS_SKIP_ASSET_DOWNLOAD_PROMPT", None)
        render_nothing()
        import mani_skill.envs  # registers the tasks
        from mani_skill.utils.registration import REGISTERED_ENVS

        assert mani_skill.envs

        running: set[int] = set()
        for task in tasks or sorted(REGISTERED_ENVS, key=lambda name: "Draw" not in name):  # the longest first
            if len(running) == JOBS:
                running.remove(os.wait()[0])
            pid = os.fork()
            if pid == 0:
                _child(folder / f"{task}.pickle", task, Path(assets))
            running.add(pid)
        while running:
            running.remove(os.wait()[0])


def _child(target: Path, task: str, assets: Path) -> None:
    try:
        part = target.with_suffix(".part")
        part.write_bytes(pickle.dumps(capture(task, assets)))
        part.rename(target)
    except BaseException:  # noqa: BLE001 - whatever it is, a fork never returns to its parent's code
        traceback.print_exc()
    finally:
        os._exit(0)


class _NoMaterial:
    """Takes what a `RenderMaterial` or a `RenderTexture2D` takes, and is seen by nobody."""

    def __init__(self, *_args: Any, **options: Any) -> None:
        vars(self).update(options)

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("set_"):
            raise AttributeError(name)
        return lambda value: setattr(self, name.removeprefix("set_"), value)


def render_nothing() -> None:
    """Without a render backend ManiSkill attaches no visual, but its tasks make materials, which need a device."""
    import sapien

    modules = [module for name, module in sys.modules.items() if name.startswith(sapien.__name__)]
    for name in ("RenderMaterial", "RenderTexture2D"):
        for module in modules:  # some took the name from the module that defines it
            if hasattr(module, name):
                setattr(module, name, _NoMaterial)


def capture(task: str, assets: Path) -> Captured | LeftOut:
    """A task's scene as `gym.make` and `reset(seed=0)` leave it, or what it lacks."""
    import gymnasium

    said = StringIO()
    sys.stdin = StringIO()  # who asks whether to download gets no answer
    try:
        logging.disable()  # ManiSkill warns of tasks that give no initial pose
        with redirect_stdout(said), redirect_stderr(StringIO()):
            env: Any = _make(gymnasium, task, num_envs=1, sim_backend="cpu", render_backend="none").unwrapped
            env.reset(seed=0)
    except (Exception, SystemExit) as error:  # noqa: BLE001 - told as what the task lacks
        return LeftOut(task, _lacking(error, said.getvalue(), assets))
    (scene,) = env.scene.sub_scenes
    facts = read_scene(scene)
    robots = () if env.agent is None else tuple(_robot(agent) for agent in getattr(env.agent, "agents", [env.agent]))
    hidden = tuple(actor.name for actor in env._hidden_objects)
    return Captured(task, robots, hidden, _cameras(env), facts, trajectory(scene, STEPS))


def _make(gymnasium: Any, task: str, **options: Any) -> Any:
    """A task as it is, or `TASK:ROBOT`: with another robot (`+` between two), which starts without noise."""
    name, _, robot = task.partition(":")
    if robot:
        options |= {"robot_init_qpos_noise": 0, "obs_mode": "none"}
        options["robot_uids"] = tuple(robot.split("+")) if "+" in robot else robot
    return gymnasium.make(name, **options)


def _cameras(env: Any) -> tuple[Camera, ...]:
    """A task makes its cameras where something is rendered; what it makes them of is there in any case."""
    from mani_skill.sensors.camera import parse_camera_configs

    robots = [] if env.agent is None else env.agent._sensor_configs
    found = [env._default_sensor_configs, robots, env._default_human_render_camera_configs]
    return tuple(_camera(config) for configs in found for config in parse_camera_configs(configs).values())


def _camera(config: Any) -> Camera:
    mount = config.mount
    on = mount and (f"{mount.articulation.name}/{mount.name}" if hasattr(mount, "articulation") else mount.name)
    (pose,) = config.pose.raw_pose.tolist()
    fov = float(np.ravel(config.fov)[0])  # one a scene where a task draws it
    sizes = (config.width, config.height, fov, float(config.near), float(config.far))
    return Camera(config.uid, on, tuple(pose), *sizes)


def _robot(agent: Any) -> Robot:
    return Robot(agent.uid, str(agent.urdf_path or agent.mjcf_path), agent.fix_root_link, agent.control_mode)


def _lacking(error: BaseException, said: str, assets: Path) -> str:
    """The file that a task could not find, relative to ManiSkill's folder of assets; else the error that it raised."""
    if path := _named_file(error) or _first(r"(?:not found|not find asset \S+) at (\S+)", said):
        return _inside(path, assets)
    if group := _first(r"assets in group (\w+)", said) or _first(r"download_asset (\w+)", str(error)):
        from mani_skill.utils.assets import DATA_SOURCES, expand_data_group_into_individual_data_source_ids

        sources = [DATA_SOURCES[name] for name in expand_data_group_into_individual_data_source_ids(group)]
        paths = sorted(_inside(str(Path(source.output_dir) / str(source.target_path)), assets) for source in sources)
        return f"{paths[0]} and {len(paths) - 1} more"
    return f"{type(error).__name__}: {error}"


def _named_file(error: BaseException | None) -> str | None:
    while error is not None:
        if isinstance(error, FileNotFoundError) and error.filename:
            return str(error.filename)
        error = error.__cause__ or error.__context__
    return None


def _first(pattern: str, text: str) -> str | None:
    found = re.search(pattern, text)
    return found and found[1]


def _inside(path: str, assets: Path) -> str:
    folder = assets / "data"
    return str(Path(path).relative_to(folder)) if Path(path).is_relative_to(folder) else path


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
