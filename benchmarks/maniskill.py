"""Scene files in ManiSkill, against its own builders, and against the loading of one of its tasks."""

from __future__ import annotations

import importlib.util
import io
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.paired import Row, Side, alternating, best, ratios
from benchmarks.sources import boxes, plain_scene_text

if TYPE_CHECKING:
    from collections.abc import Callable

BODIES = 256
OWN = f"{BODIES} boxes into a ManiSkill scene, less the same by its own builder / the former"

TASK = "TableTopFreeDraw-v1"
FILE = Path(__file__).parents[1] / "scenes" / "maniskill" / f"{TASK}.yaml"
LOADING = f"{TASK}, text to a live scene without rendering / ManiSkill's own loading"
ACTORS = 1013

MOST_LOADINGS = 3
"""ManiSkill's takes 20 seconds."""

CHILD = f"""
import time, gymnasium, mani_skill.envs
from mani_skill.envs.sapien_env import BaseEnv
options = dict(num_envs=1, sim_backend="cpu", render_backend="none")
gymnasium.make("Empty-v1", robot_uids="panda_stick", **options)
reconfigure, seconds = BaseEnv._reconfigure, []
def timed(self, *args, **others):
    started = time.perf_counter()
    reconfigure(self, *args, **others)
    seconds.append(time.perf_counter() - started)
BaseEnv._reconfigure = timed
env = gymnasium.make("{TASK}", **options).unwrapped
print(len(env.scene.actors), *seconds)
"""
"""ManiSkill's side, once the robot's meshes are known to the process, as on the other side.

A process for each: where nothing holds the renderer, every material starts it and ends it again, and after a few
thousand of them a driver may end the process.
"""


def run(repetitions: int) -> list[Row]:
    """What the backend costs beyond ManiSkill's builder, and a task of a thousand actors."""
    if importlib.util.find_spec("mani_skill") is None:
        return [Row("maniskill", what, (), note="mani_skill is not installed") for what in (OWN, LOADING)]
    return [_own_cost(repetitions), _task(min(repetitions, MOST_LOADINGS))]


def _own_cost(repetitions: int) -> Row:
    from scenecc import compile_scene
    from scenecc.backends.maniskill import instantiate
    from scenecc.diagnostics import Sink

    plan = compile_scene(io.StringIO(plain_scene_text(BODIES)))
    numbers = [
        (entity.name, box.half, entity.pose.data[0]) for entity, box in zip(plan.entities, boxes(BODIES), strict=True)
    ]

    def ours(scene: Any) -> None:
        assert instantiate(plan, scene, Sink()) is not None

    def theirs(scene: Any) -> None:
        import sapien

        for name, half_size, pose in numbers:
            builder = scene.create_actor_builder()
            builder.add_box_collision(half_size=half_size)
            builder.initial_pose = sapien.Pose(pose[:3], pose[3:])
            builder.build(name)

    rounds = alternating([_filling(ours), _filling(theirs)], repetitions)
    note = f"{best(rounds, 0)} (a plan), {best(rounds, 1)} (ManiSkill's builder)"
    return Row("maniskill", OWN, tuple((ours - theirs) / ours for ours, theirs in rounds), 0.15, note=note)


def _filling(fill: Callable[[Any], None]) -> Side:
    """Fills an empty `ManiSkillScene`, whose making is off the clock."""
    import sapien
    from mani_skill.envs.scene import ManiSkillScene
    from mani_skill.envs.utils.system.backend import parse_sim_and_render_backend

    backend = parse_sim_and_render_backend("physx_cpu", "none")

    def side() -> float:
        sub_scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
        scene = ManiSkillScene([sub_scene], device=backend.device, backend=backend)
        started = time.perf_counter()
        fill(scene)
        seconds = time.perf_counter() - started
        assert len(scene.actors) == BODIES
        sub_scene.clear()
        return seconds

    return side


def _task(repetitions: int) -> Row:
    """`_reconfigure` is what ManiSkill does to load a task's scene. Its tasks make materials that need a device."""
    from scenecc import load_scene
    from scenecc.backends.sapien.engine import render_problem

    if (problem := render_problem()) is not None:
        return Row("maniskill", LOADING, (), note=f"ManiSkill cannot make its materials: {problem}")

    def ours() -> float:
        started = time.perf_counter()
        batch = load_scene(FILE, render=False)
        seconds = time.perf_counter() - started
        assert len(batch.entities) == ACTORS
        batch.close()
        return seconds

    def theirs() -> float:
        done = subprocess.run([sys.executable, "-c", CHILD], check=True, capture_output=True, text=True)
        actors, seconds = done.stdout.split()[-2:]
        assert int(actors) == ACTORS
        return float(seconds)

    rounds = alternating([ours, theirs], repetitions)
    note = f"{best(rounds, 0)} (scenecc), {best(rounds, 1)} (ManiSkill), render_backend='none' on both sides"
    return Row("maniskill", LOADING, ratios(rounds, 0, 1), 0.02, note=note)
