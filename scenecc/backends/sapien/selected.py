"""Scene indices that a user gives, as integers and nothing else."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable


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
