"""Finds which drawn value shows which alternative of a factor, and how far a range is drawn.

A factor may be seen in a value that is computed from it: a rotation in a quaternion, a material in its friction. So
the scenes of a cover are compiled, in which the alternatives are known. A column shows a factor if it has one value
for each alternative, whatever the other factors and ranges are.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, cast

from scenecc.coverage.episodes import Cell, cell_of, flat_columns
from scenecc.drawn_values import DrawnValues, plain_values
from scenecc.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.coverage.cover import Builder
    from scenecc.coverage.pairs import Row
    from scenecc.plan import ScenePlan

    Table = list[dict[str, Cell]]
    """The columns of each scene."""

TENTHS: Final = 10

_SCENES: Final = 48
"""Least number of scenes of a calibration, if the rows can be repeated."""

_BELOW_ONE: Final = 1.0 - 2.0**-53


@dataclass(frozen=True, slots=True)
class FactorReader:
    """Reads the alternative of a factor from drawn values.

    Attributes:
        columns: the columns that show it.
        alternatives: their values → alternative.
        ranged: the alternative that is itself a range, so that it has any other value; None: there is none.
    """

    columns: tuple[str, ...]
    alternatives: Mapping[tuple[Cell, ...], int]
    ranged: int | None = None

    def read(self, values: Mapping[str, Any]) -> int | None:
        """Returns the alternative of an episode, -1 if the value is missing; None if the file cannot draw it."""
        cells = tuple(cell_of(values, column) for column in self.columns)
        if None in cells:
            return -1
        found = self.alternatives.get(cast("tuple[Cell, ...]", cells))
        return self.ranged if found is None else found


@dataclass(frozen=True, slots=True)
class RangeReader:
    """Reads in which tenth of a range a value is.

    Attributes:
        column: the column that shows it.
        edges: its values at 0, 1/10, …, 1 of the probability, ascending or descending.
        is_bounded: whether nothing beyond the ends is drawn.
        needs: the alternatives of factors with which it is drawn.
    """

    column: str
    edges: tuple[float, ...]
    is_bounded: bool
    needs: tuple[tuple[int, frozenset[int]], ...] = ()

    def read(self, values: Mapping[str, Any], row: Row) -> int | None:
        """Returns the tenth of an episode, -1 if the value is missing; None if the file cannot draw it."""
        cell = cell_of(values, self.column)
        if not isinstance(cell, float) or any(row[factor] not in allowed for factor, allowed in self.needs):
            return -1
        edges = self.edges if self.edges[0] < self.edges[-1] else self.edges[::-1]
        margin = 1e-5 * max(abs(edges[0]), abs(edges[-1]))
        if self.is_bounded and not edges[0] - margin <= cell <= edges[-1] + margin:
            return None
        return min(max(bisect_right(edges, cell) - 1, 0), TENTHS - 1)


class Calibration:
    """The readers of a file's factors and ranges; None for one that no drawn value shows.

    Args:
        builder: compiles the file.
        rows: rows of a cover, scene by scene.
        can_move: whether a row may be in any scene.

    Attributes:
        factors, ranges: a reader for each of the builder's.
        columns: all columns.
    """

    def __init__(self, builder: Builder, rows: Sequence[Row], *, can_move: bool) -> None:
        self._builder = builder
        many = [rows[scene % len(rows)] for scene in range(max(_SCENES, len(rows)))] if can_move else [*rows]
        self._rows: Sequence[Row] = many
        known = builder.filled(many, [0] * len(many))
        table = self._compile(many, known)
        if table is None:
            # Other numbers of the ranges than those of the cover cannot be built.
            raise SceneError(self._diagnostics)
        self._table = table
        self.columns = dict.fromkeys(column for row in self._table for column in row)
        self._columns_of = {column: [row.get(column) for row in self._table] for column in self.columns}
        self.factors = [self._factor(number) for number in range(len(builder.factors))]
        self.ranges = self._ranges(known)

    def in_all_scenes(self) -> list[str]:
        """Returns the columns that are read and that every scene has."""
        read = [one.columns[0] for one in self.factors if one is not None]
        read += [one.column for one in self.ranges if one is not None]
        return [column for column in read if None not in self._columns_of[column]]

    def _compile(self, rows: Sequence[Row], known: Sequence[Mapping[int, Sequence[float]]]) -> Table | None:
        """Returns what scenes draw with these alternatives and quantiles; None if one cannot be built."""
        units = {scene: self._builder.row_units(row, known[scene]) for scene, row in enumerate(rows)}
        result, _, sink = self._builder.compile(units, len(rows))
        self._diagnostics = sink.diagnostics()
        return None if result is None else drawn_table(result.plan)

    def _ordered(self, label: str) -> list[str]:
        """Returns the columns, those first whose names are most like a label."""
        plain = label.replace(".pose.p", ".pose").replace("material.physical.", "material.")
        return sorted(self.columns, key=lambda column: (column not in {label, plain}, -_alike(column, plain)))

    def _factor(self, number: int) -> FactorReader | None:
        factor = self._builder.factors[number]
        levels = [row[number] for row in self._rows]
        names = self._ordered(factor.source.label)
        pure = {column: groups for column in names if (groups := self._groups(column, levels)) is not None}
        single = [column for column, groups in pure.items() if all(len(cells) == 1 for cells in groups.values())]
        by_name: dict[str, list[str]] = {}
        for column in single:
            by_name.setdefault(_base(column), []).append(column)
        for columns in (*by_name.values(), single):
            found = {tuple(next(iter(pure[column][a])) for column in columns): a for a in {*levels} - {-1}}
            if columns and len(found) == len({*levels} - {-1}):
                return FactorReader(tuple(columns), found)
        for column, groups in pure.items():
            ranged = [a for a, cells in groups.items() if len(cells) > 1]
            others = {(next(iter(cells)),): a for a, cells in groups.items() if len(cells) == 1}
            is_apart = not ranged or not any((cell,) in others for cell in groups[ranged[0]])
            # An alternative that is a range: only of the column of the factor itself.
            if column == names[0] and len(ranged) == 1 and is_apart and len(others) == len(groups) - 1:
                return FactorReader((column,), others, ranged[0])
        return None

    def _groups(self, column: str, levels: Sequence[int]) -> dict[int, set[Cell]] | None:
        """Returns the values of a column for each alternative; None if one is missing where the factor is drawn."""
        groups: dict[int, set[Cell]] = {}
        for level, cell in zip(levels, self._columns_of[column], strict=True):
            if level >= 0:
                if cell is None:
                    return None
                groups.setdefault(level, set()).add(cell)
        return groups

    def _ranges(self, known: Sequence[Mapping[int, Sequence[float]]]) -> list[RangeReader | None]:
        found: list[RangeReader | None] = []
        columns = [self._range_column(number, known) for number in range(len(self._builder.ranges))]
        hosts = dict.fromkeys(self._host(n, column) for n, column in enumerate(columns) if column is not None)
        rows = [self._rows[host] for host in hosts for _ in range(TENTHS + 1)]
        levels = [min(tenth / TENTHS, _BELOW_ONE) for _ in hosts for tenth in range(TENTHS + 1)]
        ends = [{n: [level] * one.words for n, one in enumerate(self._builder.ranges)} for level in levels]
        table = self._compile(rows, ends) if rows else None
        for number, column in enumerate(columns):
            edges = None
            if column is not None and table is not None:
                first = [*hosts].index(self._host(number, column)) * (TENTHS + 1)
                edges = _edges([row.get(column) for row in table[first : first + TENTHS + 1]])
            is_bounded = self._builder.ranges[number].distribution != "normal"
            needs = self._builder.range_needs[number]
            found.append(None if edges is None else RangeReader(str(column), edges, is_bounded, needs))
        return found

    def _host(self, number: int, column: str) -> int:
        """Returns the first scene in which a range is drawn and a column has a value."""
        cells = enumerate(self._columns_of[column])
        return next(
            scene for scene, cell in cells if cell is not None and self._builder.draws_range(number, self._rows[scene])
        )

    def _range_column(self, number: int, known: Sequence[Mapping[int, Sequence[float]]]) -> str | None:
        """Returns the column that rises, or falls, with the quantile of a range."""
        source = self._builder.ranges[number]
        if source.kind != "range":
            return None
        drawn = [scene for scene in range(len(known)) if self._builder.draws_range(number, self._rows[scene])]
        order = sorted(drawn, key=lambda scene: known[scene][number][0])
        for column in self._ordered(source.label)[:_LIKELY]:
            cells = [cell for scene in order if isinstance(cell := self._columns_of[column][scene], float)]
            if len(cells) > _LEAST and (_rises(cells) or _rises(cells[::-1])):
                return column
        return None


def _edges(cells: Sequence[Cell | None]) -> tuple[float, ...] | None:
    numbers = [cell for cell in cells if isinstance(cell, float)]
    is_whole = len(numbers) == TENTHS + 1 and (_rises(numbers) or _rises(numbers[::-1]))
    return tuple(numbers) if is_whole else None


_LIKELY: Final = 200
"""Most columns that are compared with a range."""

_LEAST: Final = 5
"""Least scenes by which a column is recognized as that of a range."""


def drawn_table(plan: ScenePlan) -> Table:
    """Returns the drawn values of each scene of a plan by column."""
    drawn = {name: plain_values(rows) for name, rows in DrawnValues(plan).read(range(plan.num_scenes)).items()}
    return [flat_columns({name: rows[scene] for name, rows in drawn.items()}) for scene in range(plan.num_scenes)]


def _alike(first: str, second: str) -> int:
    """Returns the length of the common beginning of two names."""
    return next(
        (n for n, (a, b) in enumerate(zip(first, second, strict=False)) if a != b), min(len(first), len(second))
    )


def _base(column: str) -> str:
    while column.endswith("]"):
        column = column.rpartition("[")[0]
    return column


def _rises(numbers: Sequence[float]) -> bool:
    return all(a <= b for a, b in pairwise(numbers)) and len({*numbers}) > len(numbers) // 2
