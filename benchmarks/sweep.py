"""What a sweep adds to the builds that it makes: cutting the work, the hand-over to processes, the table."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from benchmarks.paired import Row, Side, alternating, best

UNITS = 200
MOST = 0.010
"""Of a unit, over its build [s]."""


def run(repetitions: int) -> list[Row]:
    """One process builds on both sides, so that no time is hidden by a second one."""
    import yaml

    with tempfile.TemporaryDirectory() as top:
        scene = Path(top, "scene.yaml")
        scene.write_text(yaml.safe_dump(_document()))
        rounds = alternating([_apart(_sweep, scene), _apart(_build, scene)], max(3, repetitions // 3))
    added = tuple((swept - built) / (UNITS * MOST) for swept, built in rounds)
    what = f"what a sweep adds to each of {UNITS} builds / {MOST * 1e3:g} ms"
    return [Row("sweep", what, added, 1.0, note=f"{best(rounds, 0)} − {best(rounds, 1)}, all of them")]


def _apart(work: Callable[[Path], float], scene: Path) -> Side:
    """Its own seconds, in a process in which no engine runs yet."""

    def side() -> float:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
            return process.submit(work, scene).result()

    return side


def _sweep(scene: Path) -> float:
    from scenecc import sweep

    with tempfile.TemporaryDirectory() as output:
        started = time.perf_counter()
        sweep(scene, seeds=range(UNITS), do=["state"], output=output, jobs=1)
        return time.perf_counter() - started


def _build(scene: Path) -> float:
    from scenecc import load_scene

    started = time.perf_counter()
    for seed in range(UNITS):
        with load_scene(scene, seed=seed, render=False) as batch:
            for body in batch.entities.values():
                body.pose.tolist()
    return time.perf_counter() - started


def _document() -> dict[str, Any]:
    thing = {
        "repeat": {"i": {"count": 20}},
        "name": "thing_${i}",
        "pose": {"p": ["${0.1 * i}", {"uniform": [-0.1, 0.1]}, 0.02]},
        "shapes": [{"type": "box", "half_size": [0.02, 0.02, 0.02]}],
    }
    ground = {"body_type": "static", "shapes": [{"type": "plane"}]}
    return {"scenecc": 1, "entities": {"ground": ground, "thing": thing}}
