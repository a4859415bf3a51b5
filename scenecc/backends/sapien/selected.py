"""Scene indices and seeds that a user gives, as integers and nothing else."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence


def scene_indices(given: Iterable[int]) -> tuple[int, ...]:
    """The indices as Python's integers, in the order given.

    Raises:
        TypeError: one is no integer. A mask of booleans is refused too: as indices it would name scenes 0 and 1.
        ValueError: one is given twice.
    """
    indices: list[int] = []
    for item in given:
        if isinstance(item, bool) or type(item).__name__ in {"bool_", "bool"}:
            raise TypeError("scene_idxs are scene indices, not a mask: take numpy.flatnonzero(mask)")
        indices.append(operator.index(item))
    if len(set(indices)) != len(indices):
        raise ValueError(f"scene_idxs name a scene twice: {indices}")
    return tuple(indices)


def seeds_of(seed: int | Iterable[int] | None, last: Sequence[int]) -> tuple[int, ...]:
    """A seed for each of some scenes: one for all, one for each, or None for those that they had last.

    Raises:
        TypeError: one is no integer.
        ValueError: one is negative, or there are more or fewer than scenes.
    """
    if seed is None:
        return tuple(last)
    if isinstance(seed, Iterable):
        seeds = tuple(_seed(each) for each in seed)
        if len(seeds) != len(last):
            raise ValueError(f"{len(seeds)} seeds for {len(last)} scenes")
        return seeds
    return (_seed(seed),) * len(last)


def _seed(given: int) -> int:
    if isinstance(given, bool) or type(given).__name__ in {"bool_", "bool"}:
        raise TypeError(f"a seed is an integer, not {given!r}")
    seed = operator.index(given)
    if seed < 0:
        raise ValueError(f"a seed is not negative, as {seed} is")
    return seed
