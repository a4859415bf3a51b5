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


_KINDS = {"f": np.float64, "i": np.int64, "u": np.int64, "b": np.bool_}


def constant(item: float | Sequence[Any] | NDArray[Any]) -> Value:
    """The same in every scene. Numbers become float64, integers int64, flags bool."""
    return _value(np.asarray(item)[None])


def per_scene(rows: Sequence[Any] | NDArray[Any]) -> Value:
    """One row a scene of the entity; one row in all where they are equal to the bit."""
    data = np.asarray(rows)
    if len(data) > 1 and all(row.tobytes() == data[0].tobytes() for row in data[1:]):
        data = data[:1]
    return _value(data)


def _value(data: NDArray[Any]) -> Value:
    out = np.array(data, dtype=_KINDS[data.dtype.kind])
    out.flags.writeable = False
    return Value(out)
