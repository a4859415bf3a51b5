"""What it costs to find the overlaps of a batch, against steps of the same batch at rest."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from benchmarks.paired import Row, alternating, best, ratios

if TYPE_CHECKING:
    from scenecc.backends.sapien import SceneBatch

SCENES, ACROSS = 16, 32
BODIES = ACROSS * ACROSS
RESTING_STEPS = 2


def run(repetitions: int) -> list[Row]:
    """As `check` does it: bounds, a step, the contacts in doubt, and what is deep among them. No box falls asleep."""
    from scenecc import load_scene
    from scenecc.simulation.bounds import scenes_in_doubt
    from scenecc.simulation.expect import overlap_rules
    from scenecc.simulation.start import OVERLAP, overlaps

    with load_scene(_document(), render=False) as batch:
        batch.step(50)
        rules = overlap_rules(batch.plan, set(), OVERLAP)

        def find() -> float:
            started = time.perf_counter()
            doubted = scenes_in_doubt(batch, rules.least)
            batch.step(1)
            found = list(overlaps(batch.contacts(scene_idxs=doubted), batch.plan, rules))
            seconds = time.perf_counter() - started
            assert found == []
            return seconds

        rounds = alternating([find, lambda: _rest(batch)], repetitions)
    what = f"overlaps of {BODIES} resting boxes in {SCENES} scenes / {RESTING_STEPS} steps of them"
    return [Row("overlap", what, ratios(rounds, 0, 1), 1.0, note=f"{best(rounds, 0)} / {best(rounds, 1)}")]


def _document() -> dict[str, Any]:
    grid = {"i": {"count": ACROSS}, "j": {"count": ACROSS}}
    box = {
        "repeat": grid,
        "name": "box_${i}_${j}",
        "pose": ["${0.05 * i}", "${0.05 * j}", 0.02],
        "sleep_threshold": 0,
        "shapes": [{"type": "box", "half_size": [0.02, 0.02, 0.02]}],
    }
    ground = {"body_type": "static", "shapes": [{"type": "plane"}]}
    return {"scenecc": 1, "num_scenes": SCENES, "entities": {"ground": ground, "box": box}}


def _rest(batch: SceneBatch) -> float:
    started = time.perf_counter()
    batch.step(RESTING_STEPS)
    return time.perf_counter() - started
