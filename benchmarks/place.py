"""What placing costs: 12 things of several shapes on a table, against the build of the same batch."""

from __future__ import annotations

import time
from functools import cache
from typing import TYPE_CHECKING, Any

from benchmarks.instantiate import ours
from benchmarks.paired import Row, alternating, best, ratios

if TYPE_CHECKING:
    from scenecc.plan import ScenePlan

SCENES, THINGS = 4096, 12

_SHAPES: list[dict[str, Any]] = [
    {"type": "box", "half_size": [0.03, 0.02, 0.015]},
    {"type": "sphere", "radius": 0.025},
    {"type": "cylinder", "radius": 0.025, "half_length": 0.03, "axis": "z"},
    {"type": "capsule", "radius": 0.018, "half_length": 0.03},
]
_PLACE = {"on": "table", "yaw_deg": {"uniform": [0, 360]}, "apart": 0.01}


def run(repetitions: int) -> list[Row]:
    """Text to plan, nearly all of which is placing, over the build of that plan."""
    rounds = alternating([_placing, ours(_plan, audit=False), ours(_plan, audit=True)], max(3, repetitions // 3))
    what = f"{THINGS} things on a table in {SCENES} scenes, placed / built"
    note = f"{best(rounds, 0)} / {best(rounds, 1)}, with the default audit {best(rounds, 2)}"
    return [
        Row("place", f"{what}, audit off", ratios(rounds, 0, 1), 1.0, note=note),
        Row("place", f"{what}, default audit", ratios(rounds, 0, 2), 1.0),
    ]


def _document() -> dict[str, Any]:
    table = {"body_type": "static", "shapes": [{"type": "box", "half_size": [0.5, 0.35, 0.02]}]}
    things = {f"thing_{i}": {"place": _PLACE, "shapes": [_SHAPES[i % len(_SHAPES)]]} for i in range(THINGS)}
    return {"scenecc": 1, "num_scenes": SCENES, "entities": {"table": table, **things}}


def _placing() -> float:
    from scenecc import compile_scene

    started = time.perf_counter()
    compile_scene(_document())
    return time.perf_counter() - started


@cache
def _plan() -> ScenePlan:
    from scenecc import compile_scene

    return compile_scene(_document())
