"""Text to a live scene against what other simulators take for the same boxes."""

from __future__ import annotations

import io
import statistics
from importlib import import_module
from typing import Any

from benchmarks.paired import Row, alternating, best, ratios, timed
from benchmarks.sources import mjcf_text, plain_scene_text

BOXES = 2_000


def run(repetitions: int) -> list[Row]:
    """2000 boxes, one scene, default audit, the collector as users have it."""
    try:
        mujoco: Any = import_module("mujoco")
    except ImportError:
        return [Row("live", _what("MuJoCo"), (), 0.3, 0.2, "mujoco is not installed")]
    from scenecc import load_scene

    text, mjcf = plain_scene_text(BOXES), mjcf_text(BOXES)
    sides = [
        timed(lambda: load_scene(io.StringIO(text), render=False)),
        timed(lambda: mujoco.MjModel.from_xml_string(mjcf)),
    ]
    rounds = alternating(sides, repetitions, collector=True)
    note = f"{best(rounds, 0)} / {best(rounds, 1)}"
    return [Row("live", f"{_what('MuJoCo')} MjModel.from_xml_string", ratios(rounds, 0, 1), 0.3, 0.2, note)]


def _what(other: str) -> str:
    return f"{BOXES} boxes, text to live scene / {other}"


def seconds(repetitions: int) -> float:
    """Median seconds from text to a live scene, for comparison with another process."""
    from scenecc import load_scene

    text = plain_scene_text(BOXES)
    rounds = alternating([timed(lambda: load_scene(io.StringIO(text), render=False))], repetitions, collector=True)
    return statistics.median(r[0] for r in rounds)
