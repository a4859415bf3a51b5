"""Rows that meet all pairs of alternatives, one row at a time.

The method is that of AETG (D. Cohen, S. Dalal, M. Fredman, G. Patton, "The AETG system: an approach to testing based on
combinatorial design", 1997): of several random rows, each built factor by factor, the one with most new pairs is taken.
"""

from __future__ import annotations

from math import lcm
from random import Random
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.coverage.factors import closure, cycles_meet, joined

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.coverage.factors import Factor, Level, Needs

Row = tuple[int, ...]
"""The alternative of each factor; -1: it is not drawn in this scene."""

Pair = tuple["Level", "Level"]

_CANDIDATES: Final = 40
"""Rows of which the best is taken."""

_WORK: Final = 20_000
"""Most choices of an alternative for one row, over all candidates."""

_FEW: Final = 2000
"""Open pairs that are all considered as the start of a row. Of more, some are."""

_LONGEST: Final = 256
"""Scenes in which a pair with a `cycle` is looked for."""

_STEPS: Final = 5000
"""Most alternatives that are tried for a row besides one for each factor."""


class PairTable:
    """Which pairs of alternatives are open, met or impossible.

    Args:
        factors: of the file.

    Attributes:
        at: number of each factor's first alternative among all.
        open: (V, V) symmetric: pairs that can occur and are not met yet; on the diagonal single alternatives.
        impossible: pairs that the forms of the file exclude.
    """

    def __init__(self, factors: Sequence[Factor]) -> None:
        self.factors = factors
        self.at = np.concatenate([[0], np.cumsum([one.count for one in factors])]).astype(int).tolist()
        self.levels: list[Level] = [(f, a) for f, one in enumerate(factors) for a in range(one.count)]
        self.open = self._all()
        self.needs = [closure(level, factors) for level in self.levels]
        self.impossible: list[Pair] = []
        self._exclude()
        self.total = self.count

    def _all(self) -> NDArray[np.bool_]:
        owner = np.array([f for f, _ in self.levels], int)
        return (owner[:, None] != owner[None, :]) | np.eye(len(owner), dtype=bool)

    def _exclude(self) -> None:
        """Closes pairs that exclude each other by the forms around them, or by two cycles."""
        bound = [
            needs is None or len(needs) > 1 or self.factors[f].is_cycle
            for needs, (f, _) in zip(self.needs, self.levels, strict=True)
        ]
        for v, is_bound in enumerate(bound):
            if not is_bound:
                continue
            for w in np.flatnonzero(self.open[v]).tolist():
                if (w > v or not bound[w]) and self.together(v, w) is None:
                    self.close(v, w)
                    self.impossible.append(self.pair(v, w))

    def together(self, v: int, w: int) -> Needs | None:
        """Returns what two alternatives need together; None: they exclude each other."""
        first, second = self.needs[v], self.needs[w]
        found = None if first is None or second is None else joined(first, second)
        return found if found is not None and cycles_meet(found, self.factors) else None

    def close(self, v: int, w: int) -> None:
        """Marks a pair as no longer open."""
        self.open[v, w] = self.open[w, v] = False

    def pair(self, v: int, w: int) -> Pair:
        """Returns a pair by its two numbers."""
        return self.levels[min(v, w)], self.levels[max(v, w)]

    def named(self, pair: Pair) -> tuple[tuple[str, Any], tuple[str, Any]]:
        """Returns the name and the value of each alternative of a pair."""
        (f, a), (g, b) = pair
        first, second = self.factors[f].source, self.factors[g].source
        return (first.label, first.values[a]), (second.label, second.values[b])

    def ignore(self, factor: int) -> None:
        """Marks all pairs of a factor as no longer open."""
        own = slice(self.at[factor], self.at[factor + 1])
        self.open[own] = self.open[:, own] = False

    def numbers(self, row: Row) -> list[int]:
        """Returns the numbers of a row's alternatives."""
        return [self.at[f] + a for f, a in enumerate(row) if a >= 0]

    def meet(self, row: Row) -> None:
        """Marks the pairs of a row as met."""
        numbers = self.numbers(row)
        self.open[np.ix_(numbers, numbers)] = False

    def reopen(self, rows: Sequence[Row], closed: Sequence[Pair]) -> None:
        """Recomputes the open pairs: all but those of these rows, and the closed ones."""
        self.open = self._all()
        for (f, a), (g, b) in (*self.impossible, *closed):
            self.close(self.at[f] + a, self.at[g] + b)
        for row in rows:
            self.meet(row)

    @property
    def count(self) -> int:
        """Number of open pairs of two factors."""
        return int(self.open.sum() - self.open.trace()) // 2

    def open_pairs(self, first: int = 1) -> list[Pair]:
        """Returns the open pairs; with `first=0` also those of an alternative with itself."""
        return [self.pair(int(v), int(w)) for v, w in np.argwhere(np.triu(self.open, first))]


class RowMaker:
    """Builds rows, deterministically.

    Args:
        table: the pairs.
        seed: of the random candidates.

    Attributes:
        conflicts: factors → alternatives of them that cannot be built together → where they are excluded.
    """

    def __init__(self, table: PairTable, seed: int = 0) -> None:
        self._table = table
        self._random = Random(seed)  # noqa: S311 - the same rows at every run
        self.conflicts: dict[tuple[int, ...], dict[tuple[int, ...], str]] = {}

    def add_conflict(self, conflict: Mapping[int, int], by: str) -> None:
        """Excludes alternatives (factor → alternative) together. `by`: where they are excluded."""
        self.conflicts.setdefault(tuple(conflict), {}).setdefault(tuple(conflict.values()), by)

    def best(self, scene: int) -> tuple[Row, Pair | None] | None:
        """Returns a row of a scene with many open pairs, and the pair that it was built for; None: no row is possible.

        If no open pair can occur in this scene, the row was built for none.
        """
        table = self._table
        count = max(min(_CANDIDATES, _WORK // max(len(table.factors), 1)), 4)
        starts = self._starts(scene, count)
        found: tuple[int, Row, Pair | None] | None = None
        for start in (*starts, *[None] * count):
            if start is None and found is not None and starts:
                break
            row = self._build(scene, start)
            if row is None:
                continue
            numbers = table.numbers(row)
            gain = int(table.open[np.ix_(numbers, numbers)].sum())
            if found is None or gain > found[0]:
                found = gain, row, None if start is None else table.pair(*start)
        return None if found is None else (found[1], found[2])

    def is_possible(self, pair: Pair, scene: int) -> bool:
        """Returns whether a row with a pair is found in this scene or a later one."""
        (f, a), (g, b) = pair
        start = self._table.at[f] + a, self._table.at[g] + b
        needs = self._table.together(*start)
        period = min(lcm(*(one.count for one in self._table.factors if one.is_cycle)), _LONGEST)
        scenes = [one for one in range(scene, scene + period) if needs is not None and self._is_possible(needs, one)]
        return any(self._build(one, start) is not None for one in scenes)

    def reason(self, pair: Pair) -> str:
        """Returns where a pair is excluded; empty if several places exclude it together."""
        at = dict(pair)
        return next(
            (by for fs, known in self.conflicts.items() if (by := known.get(tuple(at.get(f, -1) for f in fs)))), ""
        )

    def _starts(self, scene: int, count: int) -> list[tuple[int, int]]:
        """Returns open pairs that can occur in a scene."""
        pairs = np.argwhere(np.triu(self._table.open))
        order = self._random.sample(range(len(pairs)), len(pairs) if len(pairs) <= _FEW else 4 * count)
        found: list[tuple[int, int]] = []
        for number in order:
            v, w = map(int, pairs[number])
            needs = self._table.together(v, w)
            if needs is not None and self._is_possible(needs, scene):
                found.append((v, w))
            if len(found) == count:
                break
        return found

    def _is_possible(self, needs: Needs, scene: int) -> bool:
        factors = self._table.factors
        return all(
            factors[f].is_in(scene) and ((at := factors[f].fixed(scene)) is None or at in allowed)
            for f, allowed in needs.items()
        )

    def _build(self, scene: int, start: tuple[int, int] | None) -> Row | None:
        """Returns a row by depth-first search: constrained factors first, the best alternatives first."""
        table, wanted = self._table, (start and self._table.together(*start)) or {}
        order = self._order(wanted)
        row: dict[int, int] = {}
        score = np.zeros(len(table.levels), np.int64)
        left = [self._alternatives(order[0], scene, wanted, row, score)]
        for _ in range(len(order) + _STEPS):
            factor = order[len(left) - 1]
            before = row.pop(factor, -1)
            if before >= 0:
                score -= table.open[table.at[factor] + before]
            if not left[-1]:
                left.pop()
                if not left:
                    return None
                continue
            row[factor] = left[-1].pop()
            if row[factor] >= 0:
                score += table.open[table.at[factor] + row[factor]]
            if len(left) == len(order):
                return tuple(row[f] for f in range(len(order)))
            left.append(self._alternatives(order[len(left)], scene, wanted, row, score))
        return None

    def _order(self, wanted: Needs) -> list[int]:
        """Returns the factors in random order, constrained ones first, and each after those that it needs."""
        factors = self._table.factors
        bound = {f for conflict in self.conflicts for f in conflict}
        names = self._random.sample(range(len(factors)), len(factors))
        todo = sorted(names, key=lambda f: (f not in wanted, not factors[f].is_cycle, f not in bound))[::-1]
        found: dict[int, None] = {}
        while todo:
            above = [f for f, _ in factors[todo[-1]].needs if f not in found]
            if above:
                todo += above
            else:
                found[todo.pop()] = None
        return [*found]

    def _alternatives(
        self, factor: int, scene: int, wanted: Needs, row: dict[int, int], score: NDArray[np.int64]
    ) -> list[int]:
        """Returns what a factor may have in a row, the best one last; -1: it is not drawn."""
        one, at = self._table.factors[factor], self._table.at[factor]
        if not one.is_in(scene) or any(row[above] not in allowed for above, allowed in one.needs):
            return [] if factor in wanted else [-1]
        fixed = one.fixed(scene)
        found = [*wanted.get(factor, range(one.count))] if fixed is None else [fixed]
        for factors, known in self.conflicts.items():
            if factor in factors:
                found = [a for a in found if tuple(a if f == factor else row.get(f, -1) for f in factors) not in known]
        if fixed is not None and fixed not in wanted.get(factor, found):
            return []
        gains = score[at : at + one.count].tolist()
        return sorted(found, key=lambda a: (gains[a], self._random.random()))
