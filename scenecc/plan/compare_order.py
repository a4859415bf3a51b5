"""Which of some things stand in another order."""

from __future__ import annotations

from bisect import bisect_left
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence


def moved(places: Sequence[int]) -> set[int]:
    """The fewest that must move for the rest to ascend."""
    ends: list[int] = []
    before: list[int | None] = []
    tails: list[int] = []
    for number, place in enumerate(places):
        at = bisect_left(ends, place)
        before.append(tails[at - 1] if at else None)
        ends[at : at + 1] = [place]
        tails[at : at + 1] = [number]
    stay: set[int] = set()
    number = tails[-1] if tails else None
    while number is not None:
        stay.add(places[number])
        number = before[number]
    return set(places) - stay
