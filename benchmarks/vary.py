"""A batch whose scenes all differ against the same batch without variation."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from benchmarks.instantiate import ours
from benchmarks.paired import Row, alternating, best, ratios
from benchmarks.sources import boxes

if TYPE_CHECKING:
    from scenecc.plan import ScenePlan

SCENES, BODIES = 4096, 20

_PLAIN = "{{type: box, half_size: [{0:.4f}, {1:.4f}, {2:.4f}], color: [0.6, 0.4, 0.3]}}"
_DRAWN = (
    "{{type: box, half_size: {{uniform: [[0.02, 0.02, 0.02], [{0:.4f}, {1:.4f}, {2:.4f}]]}}, "
    "color: {{uniform: [[0, 0, 0], [1, 1, 1]]}}}}"
)


def run(repetitions: int) -> list[Row]:
    """4096 scenes × 20 boxes, physics only, with poses, sizes and colours that are drawn, and with none.

    Compiling and the making of empty scenes are off the clock on both sides; drawing is on it. A third of the
    repetitions: one takes half a minute.
    """
    sides = [ours(make, audit=audit) for audit in (False, True) for make in (varied, _plain)]
    rounds = alternating(sides, max(3, repetitions // 3))
    what = f"{SCENES} × {BODIES} boxes, drawn poses, sizes and colours / none"
    note = f"{best(rounds, 0)} / {best(rounds, 1)}, with the default audit {best(rounds, 2)} / {best(rounds, 3)}"
    return [
        Row("vary", f"{what}, audit off", ratios(rounds, 0, 1), 1.3, note=note),
        Row("vary", f"{what}, default audit", ratios(rounds, 2, 3), 1.3),
        Row(
            "vary",
            f"{SCENES} × {BODIES} varied boxes, default audit alone / the rest",
            ratios(rounds, 2, 0, less=0),
            0.35,
        ),
    ]


def _plain() -> ScenePlan:
    return _plan("{{p: [{0:.4f}, {1:.4f}, {2:.4f}], rpy_deg: [0, 0, {3:.2f}]}}", _PLAIN)


def varied(num_scenes: int = SCENES) -> ScenePlan:
    return _plan("{{p: {{uniform: [[-1, -1, 0.3], [{0:.4f}, {1:.4f}, {2:.4f}]]}}, q: uniform}}", _DRAWN, num_scenes)


def _plan(pose: str, shape: str, num_scenes: int = SCENES) -> ScenePlan:
    from scenecc import compile_scene

    lines = [
        f"  box_{box.number}: {{pose: {pose.format(*box.p, box.yaw)}, shapes: [{shape.format(*box.half)}]}}\n"
        for box in boxes(BODIES)
    ]
    return compile_scene(io.StringIO("scenecc: 1\nentities:\n" + "".join(lines)), num_scenes=num_scenes)
