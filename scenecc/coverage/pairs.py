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
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.coverage.factors import Factor, Level, Needs
    from scenecc.coverage.scopes import Scope

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

_EXCLUDED: Final = np.int64(-(2**40))


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

    def open_pairs(self) -> list[Pair]:
        """Returns the open pairs."""
        return [self.pair(int(v), int(w)) for v, w in np.argwhere(np.triu(self.open, 1))]


class RowMaker:
    """Builds rows, deterministically.

    Args:
        table: the pairs.
        seed: of the random candidates.

    Attributes:
        conflicts: alternatives that cannot be built together, and where they are excluded.
        scopes: conditions of which all combinations are known.
    """

    def __init__(self, table: PairTable, seed: int = 0) -> None:
        self._table = table
        self._random = Random(seed)  # noqa: S311 - the same rows at every run
        self.conflicts: list[tuple[dict[int, int], str]] = []
        self._conflicts_of: dict[int, list[dict[int, int]]] = {}
        self.scopes: list[Scope] = []

    def add_conflict(self, conflict: dict[int, int], by: str) -> None:
        """Excludes alternatives (factor → alternative) together. `by`: where they are excluded."""
        if any(conflict == known for known, _ in self.conflicts):
            return
        self.conflicts.append((conflict, by))
        for factor in conflict:
            self._conflicts_of.setdefault(factor, []).append(conflict)

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

    def is_possible(self, pair: Pair, scene: int, tries: int) -> bool:
        """Returns whether a row with a pair is found in this scene or a later one."""
        (f, a), (g, b) = pair
        if any(one.excludes({f: a, g: b}) for one in self.scopes):
            return False
        start = self._table.at[f] + a, self._table.at[g] + b
        needs = self._table.together(*start)
        period = min(lcm(*(one.count for one in self._table.factors if one.is_cycle)), _LONGEST)
        scenes = [one for one in range(scene, scene + period) if needs is not None and self._is_possible(needs, one)]
        return any(self._build(one, start) is not None for one in scenes for _ in range(tries))

    def reason(self, pair: Pair) -> str:
        """Returns where a pair is excluded; empty if several places exclude it together."""
        at = dict(pair)
        scope = next((one.by for one in self.scopes if one.excludes(at)), None)
        return (
            scope
            if scope is not None
            else next((by for conflict, by in self.conflicts if conflict.items() <= at.items()), "")
        )

    def _starts(self, scene: int, count: int) -> list[tuple[int, int]]:
        """Returns open pairs that can occur in a scene."""
        pairs = np.argwhere(np.triu(self._table.open))
        order = self._random.sample(range(len(pairs)), len(pairs) if len(pairs) <= _FEW else 4 * count)
        found: list[tuple[int, int]] = []
        for number in order:
            v, w = map(int, pairs[number])
            needs = self._table.together(v, w)
            pair = dict(self._table.pair(v, w))
            is_excluded = any(one.excludes(pair) for one in self.scopes)
            if needs is not None and not is_excluded and self._is_possible(needs, scene):
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
        table, factors = self._table, self._table.factors
        wanted: Needs = (start and table.together(*start)) or {}
        order = [f for f in range(len(factors)) if f not in wanted]
        self._random.shuffle(order)
        row: dict[int, int] = {}
        score = np.zeros(len(table.levels), np.int64)
        firsts = sorted(wanted) + [f for f in order if factors[f].is_cycle]
        for factor in (*firsts, *order):
            if not self._assign(factor, scene, wanted, row, score):
                return None
        return tuple(row[f] for f in range(len(factors)))

    def _assign(self, factor: int, scene: int, wanted: Needs, row: dict[int, int], score: NDArray[np.int64]) -> bool:
        """Chooses a factor's alternative, after those that it needs. Returns whether one is possible."""
        if factor in row:
            return True
        one, table = self._table.factors[factor], self._table
        for above, _ in one.needs:
            if not self._assign(above, scene, wanted, row, score):
                return False
        if not one.is_in(scene) or any(row[above] not in allowed for above, allowed in one.needs):
            row[factor] = -1
            return factor not in wanted
        at = table.at[factor]
        gains = score[at : at + one.count].copy()
        allowed = wanted.get(factor)
        fixed = one.fixed(scene)
        for scope in self.scopes:
            if factor in scope.factors:
                gains[~scope.allowed(factor, row)] = _EXCLUDED
        for a in range(one.count):
            excluded = (allowed is not None and a not in allowed) or (fixed is not None and a != fixed)
            if excluded or self._conflicts(factor, a, row):
                gains[a] = _EXCLUDED
        most = gains.max()
        if most == _EXCLUDED:
            return False
        best = np.flatnonzero(gains == most).tolist()
        row[factor] = best[0] if len(best) == 1 else best[int(self._random.random() * len(best))]
        score += table.open[at + row[factor]]
        return True

    def _conflicts(self, factor: int, alternative: int, row: dict[int, int]) -> bool:
        return any(
            all(a == (alternative if f == factor else row.get(f)) for f, a in conflict.items())
            for conflict in self._conflicts_of.get(factor, ())
        )


def without_redundant(rows: Sequence[Row], table: PairTable) -> list[Row]:
    """Returns the rows without those all of whose pairs other rows meet too."""
    met = np.zeros(table.open.shape, np.int32)
    for row in rows:
        numbers = table.numbers(row)
        met[np.ix_(numbers, numbers)] += 1
    kept: list[Row] = []
    for row in rows:
        numbers = table.numbers(row)
        if (met[np.ix_(numbers, numbers)] > 1).all():
            met[np.ix_(numbers, numbers)] -= 1
        else:
            kept.append(row)
    return kept
