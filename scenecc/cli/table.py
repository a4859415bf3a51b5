"""Tables for people."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from typing import TYPE_CHECKING, Final

from scenecc.diagnostics.render.terminal import visible
from scenecc.diagnostics.words import index_ranges

if TYPE_CHECKING:
    from scenecc.api import SummaryRow

_BOLD: Final = "\x1b[1m{}\x1b[0m"
_BUILT: Final = ("name", "body", "shapes", "mass [kg]", "size [m]", "scenes")
_PLANNED: Final = ("name", "body", "shapes", "size [m]", "scenes", "differing")
_OTHERS: Final = ("name", "in", "type", "on", "scenes")
_FIELDS: Final = ("", "differs", "", "values")
_RIGHT: Final = frozenset({"shapes", "mass [kg]"})
"""Columns of numbers."""

_NUMBER: Final = re.compile(r"\d+")

_COMMAND: Final = re.compile(r"^(?=\s*::)|(?<=##)(?=\[)")
"""Where GitHub's runner, which reads what a job prints, sees a command of its own."""


def plain(text: str) -> str:
    """A scene's text as part of one line, which neither a terminal nor a CI runner acts upon."""
    return _COMMAND.sub(r"\\", visible(text))


def built(rows: Sequence[SummaryRow], *, color: bool) -> str:
    """One line an entity, in build order. `~` marks what scenes differ in, of which the first is told. Then a line a
    constraint, light and camera.
    """
    cells = [
        (plain(row.name), _body(row), str(row.shape_count), _mass(row), _size(row), index_ranges(row.scene_idxs))
        for row in rows
        if row.section == "entities"
    ]
    return table(_BUILT, cells, color=color) + _others(rows, color=color)


def planned(rows: Sequence[SummaryRow], *, color: bool) -> str:
    """One line an entity, in build order; then one line a field in which scenes differ. Copies that are the same in
    all that is told share their lines.
    """
    told = _told([row for row in rows if row.section == "entities"])
    others = [(f"{row.section}.{row.name}", row) for row in rows if row.section != "entities"]
    cells = [
        (
            plain(name),
            _body(row),
            str(row.shape_count),
            _size(row),
            index_ranges(row.scene_idxs),
            _differing(row),
        )
        for name, row in told
    ]
    fields = [
        (
            plain(name if first else ""),
            plain(field.field),
            "at reset" if field.at_reset else "",
            plain(field.values),
        )
        for name, row in [*told, *others]
        for first, field in zip((True, *[False] * len(row.varying)), row.varying, strict=False)
    ]
    differing = f"\n{table(_FIELDS, fields, color=color)}" if fields else ""
    return table(_PLANNED, cells, color=color) + _others(rows, color=color) + differing


def _others(rows: Sequence[SummaryRow], *, color: bool) -> str:
    """One line a constraint, light and camera; nothing where there are none."""
    cells = [
        (plain(row.name), row.section, row.body_type, plain(" – ".join(row.mounts)), index_ranges(row.scene_idxs))
        for row in rows
        if row.section != "entities"
    ]
    return f"\n{table(_OTHERS, cells, color=color)}" if cells else ""


def _body(row: SummaryRow) -> str:
    """The type of a body, or how many links an articulation has and how many of its joints move."""
    if not row.link_count:
        return row.body_type
    return f"{row.body_type}, {row.link_count} link{'s' * (row.link_count != 1)}, {row.dof} dof"


def _told(rows: Sequence[SummaryRow]) -> list[tuple[str, SummaryRow]]:
    """The rows with the names that stand for them: copies in a row are one where only their numbers differ."""

    def facts(row: SummaryRow) -> tuple[str, SummaryRow]:
        return _NUMBER.sub("#", row.name), replace(row, name="")

    groups = [list(group) for _, group in groupby(rows, facts)]
    return [
        (group[0].name if len(group) == 1 else f"{group[0].name} … {group[-1].name} ({len(group)})", group[0])
        for group in groups
    ]


def table(head: Sequence[str], rows: Sequence[Sequence[str]], *, color: bool) -> str:
    """Columns under their names. The cells are harmless: see `plain`."""
    cells = [head, *rows]
    widths = [max(len(row[i]) for row in cells) for i in range(len(head))]
    first, *others = ["  ".join(_padded(row, widths, head)).rstrip() for row in cells]
    return "\n".join([_BOLD.format(first) if color else first, *others]) + "\n"


def stage_times(timings: Mapping[str, float]) -> str:
    """The time of each stage and of all, on one line. `timings`: stage → seconds."""
    stages = ", ".join(f"{stage} {_time(seconds)}" for stage, seconds in timings.items())
    return f"{stages}; {_time(sum(timings.values()))} in all"


def _padded(row: Sequence[str], widths: Sequence[int], head: Sequence[str]) -> list[str]:
    return [
        cell.rjust(width) if name in _RIGHT else cell.ljust(width)
        for cell, width, name in zip(row, widths, head, strict=True)
    ]


def _mass(row: SummaryRow) -> str:
    if row.masses is None:
        return "–"
    low, high = (f"{mass:.4g}" for mass in row.masses)
    return low if low == high else f"{low}–{high}"


def _size(row: SummaryRow) -> str:
    if row.size is None:
        return "–"
    return "~ " * row.size_differs + " × ".join(f"{length:.4g}" for length in row.size)


def _differing(row: SummaryRow) -> str:
    return f"{len(row.varying)} of {row.field_count}" if row.varying else "–"


def _time(seconds: float) -> str:
    return f"{seconds:.2f} s" if seconds >= 1 else f"{seconds * 1e3:.1f} ms"
