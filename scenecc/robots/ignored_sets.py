"""Sets of links that never collide with one another. Each set takes one bit of SAPIEN's third collision integer."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    import numpy as np
    from numpy.typing import NDArray

MAX_SETS = 32
"""Number of bits in the third collision integer."""

Pairs = set[tuple[int, int]]
"""Pairs of link indices, the lower first."""


def order_pair(first: int, second: int) -> tuple[int, int]:
    """Returns a pair of links in the order of `Pairs`."""
    return min(first, second), max(first, second)


def symmetric(pairs: Iterable[tuple[int, int]], count: int) -> NDArray[np.bool_]:
    """Returns pairs of `count` links as a symmetric matrix (count, count)."""
    import numpy as np  # noqa: PLC0415 - loaded where links ignore one another

    found = np.zeros((count, count), np.bool_)
    for first, second in pairs:
        found[first, second] = found[second, first] = True
    return found


def cover_pairs(wanted: Pairs, free: NDArray[np.bool_]) -> list[list[int]]:
    """Covers pairs with sets of links, greedily.

    Args:
        wanted: pairs that must share a set.
        free: (n, n), symmetric: whether two of n links may share a set; they may for each pair of `wanted`.
    """
    sets: list[list[int]] = []
    while wanted:
        together = [*min(wanted)]
        fits = free[together[0]] & free[together[1]]
        fits[together] = False
        while (number := int(fits.argmax())) or fits[0]:
            together.append(number)
            fits &= free[number]
            fits[number] = False
        sets.append(together)
        members = {*together}
        wanted = {pair for pair in wanted if not members.issuperset(pair)}
    return sets
