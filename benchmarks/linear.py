"""Whether cost grows as the scene does: time and peak memory an item, the largest size over a middle one."""

from __future__ import annotations

import io
import json
import resource
import subprocess
import sys
import time
from typing import Any

from benchmarks.paired import Row, collector_off
from benchmarks.sources import plain_scene_text, scene_text

ENTITIES = (1_000, 10_000, 100_000)
SCENES = (16, 256, 4_096)
BODIES = 20
BOUND = 1.5
BY_HAND = "scenes by hand"
_LIMITS = {"text_bytes": 2**30, "objects": 10**7}


def run(repetitions: int) -> list[Row]:
    """Each size, and each side, in a process of its own: one's memory, used or given back, is not another's."""
    rounds = min(3, max(1, repetitions // 2))
    rows: list[Row] = []
    for unit, sizes in (("entities", ENTITIES), ("scenes", SCENES), (BY_HAND, SCENES)):
        found = [[_measured(unit, size) for size in sizes] for _ in range(rounds)]
        for kind in found[0][0]:
            ratios = tuple(row[2][kind] / max(row[1][kind], 1e-12) for row in found)
            each = ", ".join(f"{size}: {min(row[i][kind] for row in found):.3g}" for i, size in enumerate(sizes))
            what = f"{kind} an item, {sizes[2]} / {sizes[1]} {unit}"
            rows.append(Row("linear", what, ratios, None if unit == BY_HAND else BOUND, note=each))
    return rows


def _measured(unit: str, size: int) -> dict[str, float]:
    command = [sys.executable, "-m", "benchmarks.linear", unit, str(size)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _entities(size: int) -> dict[str, float]:
    """Microseconds and kB of peak memory an entity: the compilation, then the instantiation in one scene."""
    from scenecc import compile_scene, load_scene

    text = scene_text(size)
    load_scene(io.StringIO(scene_text(10)), render=False).close()
    start = _peak()
    with collector_off():
        began = time.perf_counter()
        plan = compile_scene(io.StringIO(text), limits=_LIMITS)
        compiled, memory = time.perf_counter() - began, _peak()
        began = time.perf_counter()
        batch = load_scene(plan, render=False)
        built, more = time.perf_counter() - began, _peak()
    del batch
    return {
        "compile [µs]": compiled / size * 1e6,
        "compile peak memory [kB]": (memory - start) / size,
        "instantiate [µs]": built / size * 1e6,
        "instantiate peak memory [kB]": (more - memory) / size,
    }


def _scenes(size: int) -> dict[str, float]:
    """Microseconds and kB of peak memory a scene of 20 boxes whose poses differ by scene."""
    from scenecc import compile_scene, load_scene

    text = plain_scene_text(BODIES)
    load_scene(io.StringIO(text), render=False).close()
    start = _peak()
    with collector_off():
        began = time.perf_counter()
        plan = compile_scene(io.StringIO(text), num_scenes=size)
        compiled = time.perf_counter() - began
        began = time.perf_counter()
        plan = _varied(plan)
        varied = time.perf_counter() - began
        memory = _peak()
        began = time.perf_counter()
        batch = load_scene(plan, render=False)
        built, more = time.perf_counter() - began, _peak()
    del batch
    return {
        "compile [µs]": compiled / size * 1e6,
        "values that differ by scene [µs]": varied / size * 1e6,
        "instantiate [µs]": built / size * 1e6,
        "peak memory [kB]": (max(memory, more) - start) / size,
    }


def _varied(plan: Any) -> Any:
    """The plan with a pose of its own for each scene of each entity."""
    from dataclasses import replace

    import numpy as np

    from scenecc.plan import per_scene

    def moved(entity: Any) -> Any:
        poses = np.repeat(entity.pose.data, plan.num_scenes, axis=0)
        poses[:, 2] += 0.001 * np.arange(plan.num_scenes)
        return replace(entity, pose=per_scene(poses))

    return replace(plan, entities=tuple(map(moved, plan.entities)))


def _by_hand(size: int) -> dict[str, float]:
    """Microseconds a scene of 20 boxes of a loop over bare components, for comparison: the engine's own growth."""
    import sapien
    from sapien import physx

    from benchmarks.instantiate import add_components

    numbers = [(f"box_{i:05d}", [0.1, 0.1, 0.1], [0.5 * i, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0]) for i in range(BODIES)]
    with collector_off():
        began = time.perf_counter()
        scenes = [sapien.Scene([physx.PhysxCpuSystem()]) for _ in range(size)]
        made = add_components(scenes, numbers)
        seconds = time.perf_counter() - began
    assert len(made) == size * BODIES
    return {"instantiate [µs]": seconds / size * 1e6}


if __name__ == "__main__":
    measure = {"entities": _entities, "scenes": _scenes, BY_HAND: _by_hand}[sys.argv[1]]
    print(json.dumps(measure(int(sys.argv[2]))))
