"""`validate` of a long file against reading its YAML alone."""

from __future__ import annotations

import io

from benchmarks.paired import Row, alternating, best, ratios, timed
from benchmarks.sources import scene_text

ENTITIES = 10_000


def run(repetitions: int) -> list[Row]:
    """The whole of `validate` (reading, models, lowering, checks), the collector off on both sides."""
    import yaml

    from scenecc import validate

    text = scene_text(ENTITIES)
    assert validate(io.StringIO(text)) == []
    sides = [
        timed(lambda: validate(io.StringIO(text))),
        timed(lambda: yaml.load(text, yaml.CSafeLoader)),
    ]
    rounds = alternating(sides, repetitions)
    what = f"validate {ENTITIES} entities ({len(text) / 1e6:.1f} MB) / yaml.load(CSafeLoader)"
    note = f"{best(rounds, 0)} / {best(rounds, 1)}"
    return [Row("validate", what, ratios(rounds, 0, 1), 0.6, 0.5, note)]
