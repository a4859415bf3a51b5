"""Loading scenes at their starts, against loading them where they are placed."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.paired import Row, Side, alternating, best, ratios, timed

SCENES = 64
SEEDS = 4
SCENE = Path(__file__).parents[1] / "scenes" / "clutter.yaml"
WHAT = f"text to {SCENES} live scenes of {SCENE.stem}, {SEEDS} starts a scene / the same without starts"


def run(repetitions: int) -> list[Row]:
    """Scenes that do not rest have no start, so both sides build the others."""
    import scenecc

    with TemporaryDirectory() as folder:
        starts = Path(folder) / "starts.json"
        made = scenecc.settle_scene(SCENE, seeds=range(SEEDS), num_scenes=SCENES)
        made.write(starts)
        chosen = [row.scene for row in made.content.rows if row.seed == 0]

        def loading(**options: Any) -> Side:
            load = partial(scenecc.load_scene, SCENE, num_scenes=SCENES, seed=0, scene_idxs=chosen, render=False)
            return timed(partial(load, **options))

        rounds = alternating([loading(starts=starts), loading()], repetitions)
    return [Row("starts", WHAT, ratios(rounds, 0, 1), 1.1, None, f"{best(rounds, 0)} / {best(rounds, 1)}")]
