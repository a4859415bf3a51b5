"""Links that never collide, as sets of which all pairs ignore one another: a bit of SAPIEN's third integer for each."""

from __future__ import annotations

from itertools import combinations

MAX_SETS = 32
"""Bits of the third integer."""

Pairs = set[tuple[int, int]]
"""Numbers of two links, the lower first."""


def ordered(first: int, second: int) -> tuple[int, int]:
    """A pair of links as `Pairs` has it."""
    return min(first, second), max(first, second)


def cover_pairs(wanted: Pairs, free: Pairs, count: int) -> list[list[int]]:
    """Sets of links that cover pairs, found greedily.

    Args:
        wanted: pairs that must be in a set.
        free: all pairs that may be, those among them.
        count: how many links there are.
    """
    sets: list[list[int]] = []
    while wanted:
        together: list[int] = [*min(wanted)]
        for number in range(count):
            if number not in together and all(ordered(number, one) in free for one in together):
                together.append(number)
        sets.append(together)
        wanted = wanted - {ordered(*pair) for pair in combinations(together, 2)}
    return sets
