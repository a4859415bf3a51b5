"""Tables and trees for terminals."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from scenecc.diagnostics.formats import wants_color
from scenecc.diagnostics.formats.style import visible
from scenecc.diagnostics.messages import index_ranges

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text
    from rich.tree import Tree

    from scenecc import Item
    from scenecc.inspect.entities import SummaryRow


_BOLD: Final = "\x1b[1m{}\x1b[0m"
_BUILT: Final = ("name", "body", "shapes", "mass [kg]", "size [m]", "scenes")
_PLANNED: Final = ("name", "body", "shapes", "size [m]", "scenes", "differing")
_OTHERS: Final = ("name", "in", "type", "on", "scenes")
_FIELDS: Final = ("", "differs", "", "values")
_RIGHT: Final = frozenset({"shapes", "mass [kg]"})
"""Columns of numbers."""

_MOST: Final = 30
"""Maximum number of rows, unless all are requested."""

_NUMBER: Final = re.compile(r"\d+")
_IN_INSTANCE: Final = re.compile(r"(?<=/).*")
_ANY: Final = re.compile(r".+")

_COMMAND: Final = re.compile(r"^(?=\s*::)|(?<=##)(?=\[)")
"""Where GitHub's runner would read a command in the output of a job."""


def escape_text(text: str) -> str:
    """Escapes a scene's text, so that neither a terminal nor a CI runner interprets it."""
    return _COMMAND.sub(r"\\", visible(text))


def built(rows: Sequence[SummaryRow], *, whole: bool = True) -> str:
    """Returns one line per entity in build order, then one line per constraint, light and camera.

    `~` marks what differs between scenes; the first value is shown. `whole`: print all rows; otherwise, beyond 30 rows,
    entities share a line as in `_groups`, and tables end after 30.
    """
    cells = [
        (_names(group), _body(group[0]), _shapes(group), _masses(group), _sizes(group), _scenes(group))
        for group in _groups(rows, whole=whole)
    ]
    return _cut(_BUILT, cells, whole=whole) + _others(rows, whole=whole)


def planned(rows: Sequence[SummaryRow], *, whole: bool = True) -> str:
    """Returns one line per entity in build order, then one line per field that differs between scenes.

    `whole`: as in `built`.
    """
    entities = _groups(rows, whole=whole)
    cells = [
        (_names(group), _body(group[0]), _shapes(group), _sizes(group), _scenes(group), _differing_cell(group))
        for group in entities
    ]
    others = [[replace(row, name=f"{row.section}.{row.name}")] for row in rows if row.section != "entities"]
    fields = [line for group in [*entities, *others] for line in _field_lines(group)]
    if not whole and len(fields) > _MOST:
        named = _groups([row for row in rows if row.section == "entities"], whole=False, most=0)
        fields = [line for group in [*named, *others] for line in _field_lines(group)]
    differing = f"\n{_cut(_FIELDS, fields, whole=whole)}" if fields else ""
    return _cut(_PLANNED, cells, whole=whole) + _others(rows, whole=whole) + differing


def _groups(rows: Sequence[SummaryRow], *, whole: bool, most: int = _MOST) -> list[list[SummaryRow]]:
    """Returns the entities that share a line. Up to `most` have a line each. More share one if they have the same type
    and their names differ only by numbers (`box_0`, `box_1`), or else their instance is the same, or else at all.
    """
    entities = [row for row in rows if row.section == "entities"]
    groups = [[row] for row in entities]
    for pattern in (_NUMBER, _IN_INSTANCE, _ANY):
        if whole or len(groups) <= most:
            break
        found: dict[tuple[str, str], list[SummaryRow]] = {}
        for row in entities:
            found.setdefault((_NUMBER.sub("#", pattern.sub("#", row.name)), _body(row)), []).append(row)
        groups = list(found.values())
    return groups


def _field_lines(group: Sequence[SummaryRow]) -> Iterator[tuple[str, str, str, str]]:
    """Yields one line per field that differs between the scenes of an entity. Of several entities, equal values are
    shown, and otherwise the first with `…`.
    """
    values: dict[tuple[str, bool], list[str]] = {}
    for row in group:
        for field in row.varying:
            values.setdefault((field.field, field.at_reset), []).append(field.values)
    name = _names(group)
    for (field, at_reset), found in values.items():
        shown = found[0] if len(set(found)) == 1 else f"{found[0]}, …"
        yield name, escape_text(field), "at reset" if at_reset else "", escape_text(shown)
        name = ""


def _names(group: Sequence[SummaryRow]) -> str:
    if len(group) == 1:
        return escape_text(group[0].name)
    return f"{escape_text(group[0].name)} … {escape_text(group[-1].name)} ({len(group)})"


def _scenes(group: Sequence[SummaryRow]) -> str:
    return index_ranges(sorted({idx for row in group for idx in row.scene_idxs}))


def _shapes(group: Sequence[SummaryRow]) -> str:
    return _range([row.shape_count for row in group])


def _masses(group: Sequence[SummaryRow]) -> str:
    return _range([mass for row in group if row.masses is not None for mass in row.masses])


def _sizes(group: Sequence[SummaryRow]) -> str:
    """Returns the extents, as ranges if they differ between entities."""
    sizes = [row.size for row in group if row.size is not None]
    if len(sizes) < len(group):
        return "–"
    return "~ " * any(row.size_differs for row in group) + " × ".join(map(_range, zip(*sizes, strict=True)))


def _range(values: Sequence[float]) -> str:
    """Returns the smallest and the largest of some numbers; a dash if there are none."""
    if not values:
        return "–"
    low, high = (f"{value:.4g}" for value in (min(values), max(values)))
    return low if low == high else f"{low}–{high}"


def _others(rows: Sequence[SummaryRow], *, whole: bool) -> str:
    """Returns one line per constraint, light and camera; "" if there are none."""
    cells = [
        (
            escape_text(row.name),
            row.section,
            row.body_type,
            escape_text(" – ".join(row.mounts)),
            index_ranges(row.scene_idxs),
        )
        for row in rows
        if row.section != "entities"
    ]
    return f"\n{_cut(_OTHERS, cells, whole=whole)}" if cells else ""


def _body(row: SummaryRow) -> str:
    """Returns the type of a body, or the numbers of links and degrees of freedom of an articulation."""
    if not row.link_count:
        return row.body_type
    return f"{row.body_type}, {row.link_count} link{'s' * (row.link_count != 1)}, {row.dof} dof"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Returns aligned columns under their names, bold on a terminal. Cells must be escaped by `escape_text`."""
    cells = [head, *rows]
    widths = [max(len(row[i]) for row in cells) for i in range(len(head))]
    first, *others = ["  ".join(_padded(row, widths, head)).rstrip() for row in cells]
    return "\n".join([_BOLD.format(first) if wants_color(sys.stdout) else first, *others]) + "\n"


def _cut(head: Sequence[str], rows: Sequence[Sequence[str]], *, whole: bool) -> str:
    """Returns a table, or its first rows and the number of the others."""
    if whole or len(rows) <= _MOST:
        return table(head, rows)
    return f"{table(head, rows[:_MOST])}… {len(rows) - _MOST} more rows, which --all shows\n"


def stage_times(timings: Mapping[str, float]) -> str:
    """Returns the time of each stage and the total, on one line. `timings`: stage → seconds."""
    stages = ", ".join(f"{stage} {_time(seconds)}" for stage, seconds in timings.items())
    return f"{stages}; {_time(sum(timings.values()))} in all"


def _padded(row: Sequence[str], widths: Sequence[int], head: Sequence[str]) -> list[str]:
    return [
        cell.rjust(width) if name in _RIGHT else cell.ljust(width)
        for cell, width, name in zip(row, widths, head, strict=True)
    ]


def _differing_cell(group: Sequence[SummaryRow]) -> str:
    count = max(len(row.varying) for row in group)
    return f"{count} of {max(row.field_count for row in group)}" if count else "–"


def _time(seconds: float) -> str:
    return f"{seconds:.2f} s" if seconds >= 1 else f"{seconds * 1e3:.1f} ms"


_ENDLESS: Final = 10**6
"""Line length for output that is not a terminal: programs expect one item per line."""

_INLINE: Final = frozenset({"shapes", "links", "variants", "joint"})
"""Groups whose items are listed directly below their owner, without a heading."""


def tree_text(item: Item) -> str:
    """Returns a tree for standard output, with colours and the width of the terminal if it is one."""
    console = terminal()
    with console.capture() as captured:
        console.print(tree(item))
    lines = captured.get().splitlines()
    return "".join(f"{line.rstrip()}\n" for line in lines)


def terminal() -> Console:
    """Returns a console for standard output without markup, emoji or number highlighting."""
    from rich.console import Console

    color = wants_color(sys.stdout)
    return Console(
        force_terminal=color,
        color_system="standard" if color else None,
        no_color=not color,
        highlight=False,
        markup=False,
        emoji=False,
        width=None if sys.stdout.isatty() else _ENDLESS,
    )


def tree(item: Item) -> Tree:
    """Returns an item with everything below it."""
    from rich.tree import Tree

    made = Tree(_line(item), guide_style="dim")
    _grow(made, item)
    return made


def _grow(branch: Tree, item: Item) -> None:
    for name, group in item.groups:
        if not isinstance(group, tuple):
            _grow(branch.add(_line(group, "" if group.name else name)), group)
            continue
        below = branch if name in _INLINE else branch.add(_head(name, len(group)))
        grown: list[Tree] = []
        for one in group:
            above = below if one.under is None else grown[one.under]
            grown.append(above.add(_line(one)))
            _grow(grown[-1], one)


def _head(name: str, count: int) -> Text:
    from rich.text import Text

    return Text.assemble((name, "bold"), (f" ({count})", "dim"))


def _line(item: Item, name: str = "") -> Text:
    """Returns a line with name, type and facts. `name`: used if the item has none."""
    from rich.text import Text

    line = Text(overflow="fold")
    parts = [(escape_text(item.name or name), "bold"), (escape_text(item.type), "cyan")]
    for text, style in parts:
        if text:
            line.append(f"{'  ' * bool(line)}{text}", style)
    told = [fact for fact in item.facts if fact.words]
    for number, fact in enumerate(told):
        line.append("  " if number == 0 else " · ", "dim")
        line.append(f"{escape_text(fact.label)} " if fact.label else "", "dim")
        line.append(escape_text(fact.words))
    if item.hidden:
        line.append(f"  … {item.hidden} more below", "dim")
    return line
