"""A file that repeats a box against the same file written out without loops."""

from __future__ import annotations

import io
import time
from collections.abc import Callable

from benchmarks.paired import Row, Side, alternating, best, ratios

SMALL, LARGE = 10_000, 100_000
_COLUMNS = 100
_LIMITS = {"text_bytes": 2**30}

_REPEATED = """\
scenecc: 1
entities:
  box:
    repeat: {{i: {{count: {rows}}}, j: {{count: {columns}}}}}
    name: "box_${{i}}_${{j}}"
    pose: ["${{0.5 * i}}", "${{0.5 * j}}", 0.3]
    shapes:
      - {{type: box, half_size: [0.1, 0.1, "${{0.1 + 0.001 * j}}"]}}
"""
_WRITTEN = """\
  box_{i}_{j}:
    pose: [{x}, {y}, 0.3]
    shapes:
      - {{type: box, half_size: [0.1, 0.1, {z}]}}
"""


def run(repetitions: int) -> list[Row]:
    """Text to plan, the collector as users have it, a third of the repetitions; both plans are compared once."""
    from scenecc import compile_scene

    one, other = (compile_scene(io.StringIO(make(_COLUMNS))) for make in (repeated, written))
    assert one.entities == other.entities
    sides = [_compiled(make, count) for count in (LARGE, SMALL) for make in (repeated, written)]
    rounds = alternating(sides, max(3, repetitions // 3), collector=True)
    growth = tuple(ratio * SMALL / LARGE for ratio in ratios(rounds, 0, 2))
    note = f"{best(rounds, 0)} / {best(rounds, 1)}"
    return [
        Row("expand", f"{LARGE} repeated boxes / the same written out", ratios(rounds, 0, 1), 1.5, note=note),
        Row("expand", f"a repeated box of {LARGE} / one of {SMALL}", growth, 1.5),
    ]


def repeated(count: int) -> str:
    """A file of `count` boxes (a multiple of 100) as two loops."""
    return _REPEATED.format(rows=count // _COLUMNS, columns=_COLUMNS)


def written(count: int) -> str:
    """The same without loops: names, numbers and order."""
    entities = (
        _WRITTEN.format(i=i, j=j, x=0.5 * i, y=0.5 * j, z=0.1 + 0.001 * j)
        for i in range(count // _COLUMNS)
        for j in range(_COLUMNS)
    )
    return "scenecc: 1\nentities:\n" + "".join(entities)


def _compiled(make: Callable[[int], str], count: int) -> Side:
    from scenecc import compile_scene

    text = make(count)

    def side() -> float:
        started = time.perf_counter()
        plan = compile_scene(io.StringIO(text), limits=_LIMITS)
        seconds = time.perf_counter() - started
        assert len(plan.entities) == count
        return seconds

    return side
