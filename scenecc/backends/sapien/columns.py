"""Values of a plan as what the engine's calls take: converted once, never inside the loop over bodies.

A column is a list with one item (the same in every scene) or one item for each row that is built.
Vectors become float32 arrays: SAPIEN reads those faster than lists, and the rounding from float64 is
the one that it would do itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from scenecc.backends.sapien.engine import sapien

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from scenecc.plan import Value

Column = list[Any]
Item = TypeVar("Item")


def at(column: Sequence[Item], row: int) -> Item:
    """The item of a row."""
    return column[row if len(column) != 1 else 0]


def taken(value: Value, rows: NDArray[np.intp]) -> NDArray[Any]:
    """The rows of a value that are built; one row where it is the same in every scene."""
    return value.data if value.data.shape[0] == 1 else value.data[rows]


def plain_row(value: Value, row: int) -> Any:
    """One row as a Python number, or as a tuple or an array of numbers; no array is made where there is none."""
    if value.varies:
        found = value.data[row]
        return found if found.ndim else found.item()
    first, *others = numbers = value.as_drawn()
    return numbers if others else first


def scalars(data: NDArray[Any]) -> Column:
    """Python floats, integers or booleans, or lists of them."""
    return data.tolist()


def vectors(data: NDArray[Any]) -> Column:
    """float32 arrays."""
    return list(data.astype(np.float32))


def poses(data: NDArray[Any]) -> Column:
    """`sapien.Pose` objects. The quaternion is passed on as it is: normalising it again would change bits."""
    return list(map(sapien.Pose, *position_and_rotation(data)))


def position_and_rotation(data: NDArray[Any]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """(B, 3) and (B, 4) of poses (B, 7), each in one piece: SAPIEN reads their rows faster than slices of a row."""
    rows = data.astype(np.float32, copy=False)
    return np.ascontiguousarray(rows[:, :3]), np.ascontiguousarray(rows[:, 3:])


def scalar_column(value: Value, rows: NDArray[np.intp]) -> Column:
    """Python numbers a row; no array is made where there is none."""
    return value.data[rows].tolist() if value.varies else [value.as_drawn()[0]]


def vector_column(value: Value, rows: NDArray[np.intp]) -> Column:
    """Vectors a row: of what is built once, the plan's own tuple, which costs less than an array of it."""
    if value.varies or len(rows) > 1:
        return vectors(taken(value, rows))
    return [value.as_drawn()]


def side_by_side(columns: Sequence[Column]) -> list[tuple[Any, ...]]:
    """The arguments of a call: one tuple in all, or one a row where any column has one item a row."""
    length = max([len(column) for column in columns])
    if length == 1:
        return [tuple([column[0] for column in columns])]
    return list(zip(*[column if len(column) == length else column * length for column in columns], strict=True))


def caller(function: Callable[..., Any], columns: Sequence[Column]) -> Callable[[int], Any]:
    """`function` with its arguments bound, to be called with a row."""
    arguments = side_by_side(columns)
    if len(arguments) == 1:
        only = arguments[0]
        return lambda _: function(*only)
    return lambda row: function(*arguments[row])
