"""Rows that meet all pairs, compared with a count by hand."""

from __future__ import annotations

from itertools import combinations, product

import pytest

from scenecc.coverage.factors import Factor
from scenecc.coverage.pairs import PairTable, Row, RowMaker
from scenecc.diagnostics.diagnostic import Origin
from scenecc.variation.chosen import DrawSource


def factor(
    number: int, count: int, *, cycle: bool = False, needs: tuple[tuple[int, frozenset[int]], ...] = ()
) -> Factor:
    units = () if cycle else tuple((j + 0.5) / count for j in range(count))
    source = DrawSource(
        "draws", f"f{number}", "", 0, "choice", tuple(range(count)), units, "choice", 1, (0,), Origin(None)
    )
    return Factor(source, needs)


def rows_of(factors: list[Factor], most: int = 200) -> list[Row]:
    table = PairTable(factors)
    maker, rows = RowMaker(table), list[Row]()
    while table.open.any() and len(rows) < most:
        found = maker.best(len(rows))
        assert found is not None
        rows.append(found[0])
        table.meet(found[0])
    return rows


def met(rows: list[Row]) -> set[tuple[tuple[int, int], tuple[int, int]]]:
    return {pair for row in rows for pair in combinations([(f, a) for f, a in enumerate(row) if a >= 0], 2)}


@pytest.mark.parametrize(
    ("counts", "most"),
    [([4] * 6, 28), ([2] * 10, 10), ([10] * 3, 112), ([3] * 20, 24), ([3, 4, 2, 7, 2], 30), ([5], 5), ([2, 3], 6)],
)
def test_all_pairs_are_met_in_few_rows(counts: list[int], most: int) -> None:
    factors = [factor(number, count) for number, count in enumerate(counts)]
    rows = rows_of(factors)
    assert len(rows) <= most
    for f, g in combinations(range(len(counts)), 2):
        assert {(row[f], row[g]) for row in rows} == set(product(range(counts[f]), range(counts[g])))
    assert all({row[f] for row in rows} == set(range(count)) for f, count in enumerate(counts))
    assert rows == rows_of(factors)


def test_what_is_inside_of_an_alternative_is_drawn_only_with_it() -> None:
    factors = [
        factor(0, 2),
        factor(1, 3),
        factor(2, 2, needs=((0, frozenset((1,))),)),
        factor(3, 2, needs=((2, frozenset((0,))),)),
    ]
    table = PairTable(factors)
    rows = rows_of(factors)
    assert all((row[2] >= 0) == (row[0] == 1) and (row[3] >= 0) == (row[2] == 0) for row in rows)
    possible = {
        row
        for row in product(range(2), range(3), (-1, 0, 1), (-1, 0, 1))
        if (row[2] >= 0) == (row[0] == 1) and (row[3] >= 0) == (row[2] == 0)
    }
    assert met(rows) == met([*possible])
    assert table.total == len(met([*possible]))


def test_cycles_are_selected_by_the_scene() -> None:
    factors = [factor(0, 4, cycle=True), factor(1, 2, cycle=True), factor(2, 3)]
    rows = rows_of(factors)
    assert all(row[:2] == (scene % 4, scene % 2) for scene, row in enumerate(rows))
    assert len(met(rows)) == 4 + 12 + 6
    assert PairTable(factors).total == 4 + 12 + 6


def test_conflicts_are_left_out() -> None:
    factors = [factor(number, 3) for number in range(4)]
    table = PairTable(factors)
    maker = RowMaker(table)
    maker.add_conflict({0: 0, 1: 0}, "scene.yaml:7")
    assert not maker.is_possible(((0, 0), (1, 0)), 0)
    assert maker.reason(((0, 0), (1, 0))) == "scene.yaml:7"
    for scene in range(30):
        found = maker.best(scene)
        assert found is not None
        assert found[0][:2] != (0, 0)
        table.meet(found[0])
    assert table.open_pairs() == [((0, 0), (1, 0))]
