"""Sets of links that never collide with one another. Each set takes one bit of SAPIEN's third collision integer."""

from __future__ import annotations

from itertools import combinations

MAX_SETS = 32
"""Number of bits in the third collision integer."""

Pairs = set[tuple[int, int]]
"""Pairs of link indices, the lower first."""


def order_pair(first: int, second: int) -> tuple[int, int]:
    """Returns a pair of links in the order of `Pairs`."""
    return min(first, second), max(first, second)


def cover_pairs(wanted: Pairs, free: Pairs, count: int) -> list[list[int]]:
    """Covers pairs with sets of links, greedily.

    Args:
        wanted: pairs that must share a set.
        free: all pairs that may share a set, including `wanted`.
        count: number of links.
    """
    sets: list[list[int]] = []
    while wanted:
        together: list[int] = [*min(wanted)]
        for number in range(count):
            if number not in together and all(order_pair(number, one) in free for one in together):
                together.append(number)
        sets.append(together)
        wanted = wanted - {order_pair(*pair) for pair in combinations(together, 2)}
    return sets
