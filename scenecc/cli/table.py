"""What was built, as a table for people."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

from scenecc.diagnostics.render.terminal import visible

if TYPE_CHECKING:
    from scenecc.api import SummaryRow

_BOLD: Final = "\x1b[1m{}\x1b[0m"
_HEAD: Final = ("name", "body", "shapes", "mass [kg]", "size [m]", "scenes")
_RIGHT: Final = frozenset({2, 3})
"""Columns of numbers."""


_COMMAND: Final = re.compile(r"^(?=\s*::)|(?<=##)(?=\[)")
"""Where GitHub's runner, which reads what a job prints, sees a command of its own."""


def plain(text: str) -> str:
    """A scene's text as part of one line, which neither a terminal nor a CI runner acts upon."""
    return _COMMAND.sub(r"\\", visible(text))


def table(rows: Sequence[SummaryRow], *, color: bool) -> str:
    """One line an entity, in build order."""
    cells = [_HEAD, *(_cells(row) for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(_HEAD))]
    head, *body = ["  ".join(_padded(row, widths)).rstrip() for row in cells]
    return "\n".join([_BOLD.format(head) if color else head, *body]) + "\n"


def stage_times(timings: Mapping[str, float]) -> str:
    """The time of each stage and of all, on one line. `timings`: stage → seconds."""
    stages = ", ".join(f"{stage} {_time(seconds)}" for stage, seconds in timings.items())
    return f"{stages}; {_time(sum(timings.values()))} in all"


def index_ranges(idxs: Sequence[int]) -> str:
    """Ascending scene indices in short: `0, 2`, `0–4095`, `0–3, 8`."""
    runs: list[list[int]] = []
    for idx in idxs:
        if runs and idx == runs[-1][1] + 1:
            runs[-1][1] = idx
        else:
            runs.append([idx, idx])
    return ", ".join(_run(first, last) for first, last in runs)


def _run(first: int, last: int) -> str:
    if first == last:
        return str(first)
    return f"{first}, {last}" if last == first + 1 else f"{first}–{last}"


def _padded(row: Sequence[str], widths: Sequence[int]) -> list[str]:
    return [
        cell.rjust(width) if i in _RIGHT else cell.ljust(width)
        for i, (cell, width) in enumerate(zip(row, widths, strict=True))
    ]


def _cells(row: SummaryRow) -> tuple[str, ...]:
    size = "–" if row.size is None else " × ".join(f"{length:.4g}" for length in row.size)
    mass = "–" if row.mass is None else f"{row.mass:.4g}"
    return (plain(row.name), row.body_type, str(row.shape_count), mass, size, index_ranges(row.scene_idxs))


def _time(seconds: float) -> str:
    return f"{seconds:.2f} s" if seconds >= 1 else f"{seconds * 1e3:.1f} ms"
