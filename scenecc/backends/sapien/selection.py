"""Checks scene indices and seeds that a user gives. Loads neither NumPy nor the engine."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence


def check_scene_idxs(given: Iterable[Any]) -> tuple[int, ...]:
    """The indices as Python's integers, in the order given.

    Raises:
        TypeError: it is not several integers. A mask of booleans is refused too: as indices it would name scenes 0
            and 1.
        ValueError: one is given twice.
    """
    if isinstance(given, str | bytes) or not hasattr(given, "__iter__"):
        raise TypeError(f"scene_idxs are scene indices, as in [0, 2] or range(4), not {given!r}")
    indices: list[int] = []
    for item in given:
        if _is_bool(item):
            raise TypeError("scene_idxs are scene indices, not a mask: take numpy.flatnonzero(mask)")
        indices.append(_check_integer(item, "a scene index"))
    if len(set(indices)) != len(indices):
        raise ValueError(f"scene_idxs name a scene twice: {indices}")
    return tuple(indices)


def check_seeds(seed: int | Iterable[int] | None, last: Sequence[int]) -> tuple[int, ...]:
    """A seed for each of some scenes: one for all, one for each, or None for those that they had last.

    Raises:
        TypeError: one is no integer.
        ValueError: one is negative, or there are more or fewer than scenes.
    """
    if seed is None:
        return tuple(last)
    if isinstance(seed, Iterable) and not isinstance(seed, str | bytes):
        seeds = tuple(_check_seed(each) for each in seed)
        if len(seeds) != len(last):
            raise ValueError(f"{len(seeds)} seeds for {len(last)} scenes")
        return seeds
    return (_check_seed(seed),) * len(last)


def _check_seed(given: object) -> int:
    seed = _check_integer(given, "a seed")
    if seed < 0:
        raise ValueError(f"a seed is not negative, as {seed} is")
    return seed


def _check_integer(given: Any, what: str) -> int:
    try:
        if not _is_bool(given):
            return operator.index(given)
    except TypeError:
        pass
    raise TypeError(f"{what} is an integer, not {given!r}")


def _is_bool(given: object) -> bool:
    # By its name: numpy 1 and 2 call theirs otherwise.
    return type(given).__name__ in {"bool_", "bool"}
