"""A number, vector, flag or table index that may differ from scene to scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Value:
    """One quantity over the scenes of an entity.

    Attributes:
        data: float64, int64 or bool, read-only. The leading axis is 1 (the same in every scene) or
            the number of scenes that the entity is in, by ascending scene index. What follows is
            the quantity's own shape: () for a scalar, (3,) for a vector, (7,) for a pose (p then q,
            wxyz).

    Two values are equal if every bit of their data is.
    """

    data: NDArray[Any]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Value):
            return NotImplemented
        a, b = self.data, other.data
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()

    def __hash__(self) -> int:
        return hash((self.data.dtype.str, self.data.shape, self.data.tobytes()))

    @property
    def varies(self) -> bool:
        """Whether the scenes do not all have the same."""
        return self.data.shape[0] != 1

    def row(self, index: int) -> Any:  # noqa: ANN401 - a scalar or an array, by the quantity's shape
        """What the entity's scene number `index` (a row, not a scene index) has."""
        return self.data[index if self.data.shape[0] != 1 else 0]


def constant(item: float | Sequence[Any] | NDArray[Any], dtype: type[np.generic] = np.float64) -> Value:
    """The same in every scene. `dtype`: float64, `numpy.int64` (table indices, counts) or `numpy.bool_`."""
    return _value(np.array(item, dtype=dtype)[None])


def per_scene(rows: Sequence[Any] | NDArray[Any], dtype: type[np.generic] = np.float64) -> Value:
    """One row a scene of the entity; one row in all where they are equal to the bit."""
    data = np.array(rows, dtype=dtype)
    if len(data) > 1 and all(row.tobytes() == data[0].tobytes() for row in data[1:]):
        data = data[:1]
    return _value(data)


def _value(data: NDArray[Any]) -> Value:
    data.flags.writeable = False
    return Value(data)
