"""Conditions among a few factors, such as an expression that has no value for some of their alternatives."""

from __future__ import annotations

from itertools import product
from math import prod
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.variation.evaluation import Batch, row_array, to_field_rows
from scenecc.variation.nodes import NODES, Chosen, Drawn
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.coverage.factors import Factor
    from scenecc.plan.properties import Bounds
    from scenecc.variation.nodes import Node

_MOST: Final = 20_000
"""Most combinations that are evaluated."""

_WIDEST: Final = 6
"""Most factors of a scope, of which every subset is looked up."""


class Scope:
    """Which combinations of the alternatives of some factors can be built.

    Args:
        factors: numbers of the factors.
        valid: whether each combination can be built, with an axis for each factor.
        by: where the file excludes the others, as FILE:LINE.
    """

    def __init__(self, factors: tuple[int, ...], valid: NDArray[np.bool_], by: str) -> None:
        self.factors = factors
        self.by = by
        self._valid = valid
        self._projections: dict[tuple[int, ...], NDArray[np.bool_]] = {}

    def allowed(self, factor: int, row: Mapping[int, int]) -> NDArray[np.bool_]:
        """Returns which alternatives of a factor can be built with those of a row, whatever the other factors are."""
        kept = tuple(one for one in self.factors if one == factor or row.get(one, -1) >= 0)
        if kept not in self._projections:
            others = tuple(axis for axis, one in enumerate(self.factors) if one not in kept)
            self._projections[kept] = np.asarray(self._valid.any(axis=others))
        return self._projections[kept][tuple(slice(None) if one == factor else row[one] for one in kept)]

    def excludes(self, levels: Mapping[int, int]) -> bool:
        """Returns whether alternatives (factor → alternative) exclude each other."""
        own = {factor: a for factor, a in levels.items() if factor in self.factors}
        first = next(iter(own), None)
        return first is not None and not self.allowed(first, {**own, first: -1})[own[first]]


def scope_of(
    read: Sequence[int],
    node: Node,
    bounds: Bounds | None,
    draws: Mapping[str, Node],
    factors: Sequence[Factor],
    by: str,
) -> Scope | None:
    """Evaluates a value for all combinations of the factors that determine it; None if it cannot be done.

    Args:
        read: numbers of the factors.
        node: the value.
        bounds: its range; None: it only must have a value.
        draws: the shared draws.
        factors: of the file.
        by: where it is written.
    """
    counts = tuple(factors[one].count for one in read)
    if len(read) > _WIDEST or prod(counts) > _MOST:
        return None
    combinations = list(product(*map(range, counts)))
    given: dict[str, Any] = {}
    for column, one in enumerate(read):
        items = _items(factors[one], draws)
        if items is None:
            return None
        given[factors[one].source.name] = row_array([items[row[column]] for row in combinations])
    batch = Batch(np.arange(len(combinations)), 0, len(combinations), draws, given)
    valid = np.zeros(len(combinations), np.bool_)
    _evaluate(batch, node, bounds, np.arange(len(combinations)), valid)
    return Scope(tuple(read), valid.reshape(counts), by)


def _items(factor: Factor, draws: Mapping[str, Node]) -> list[Any] | None:
    """Returns the values of a factor that is a shared draw; None for others."""
    source = factor.source
    node = draws.get(source.name)
    if source.section != "draws" or source.path or source.is_vector or source.word:
        return None
    if isinstance(node, Drawn) and not node.shape:
        return [*source.values]
    if not isinstance(node, Chosen) or any(isinstance(item, NODES) for item in node.items):
        return None
    return [node.items[number] for number in source.items]


def _evaluate(
    batch: Batch, node: Node, bounds: Bounds | None, rows: NDArray[np.intp], valid: NDArray[np.bool_]
) -> None:
    """Notes in which rows a node has a value in its range."""
    try:
        values = to_field_rows(batch.only(rows).evaluate(node))
    except DrawError:
        for half in np.array_split(rows, 2) if len(rows) > 1 else ():
            _evaluate(batch, node, bounds, half, valid)
        return
    inside = np.ones(len(rows), np.bool_)
    if bounds is not None and values.dtype.kind in "if":
        fits = (values >= bounds.low) & (values <= bounds.high) & ((values != 0) | (not bounds.nonzero))
        inside = fits.reshape(len(rows), -1).all(axis=1)
    valid[rows] = inside
