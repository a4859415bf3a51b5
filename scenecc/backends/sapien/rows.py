"""What users hand to a batch, checked and spread over rows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.engine import sapien

if TYPE_CHECKING:
    from numpy.typing import NDArray

UNIT_TOLERANCE = 1e-3
"""How far a quaternion's length may be from 1: as in the scene language."""


def pose_rows(pose: Any, count: int) -> list[sapien.Pose]:
    """`count` poses from (7,), (count, 7), a `sapien.Pose` or a sequence of them. Raises ValueError."""
    if isinstance(pose, sapien.Pose):
        return [pose] * count
    if isinstance(pose, (list, tuple)):
        items: list[Any] = [*pose]  # pyright: ignore[reportUnknownArgumentType]
        if items and all(isinstance(item, sapien.Pose) for item in items):
            if len(items) != count:
                raise ValueError(f"{len(items)} poses for {count} scenes")
            return items
    rows = _rows(pose, 7, count, "a pose")
    lengths = np.linalg.norm(rows[:, 3:].astype(np.float64), axis=1)
    if (np.abs(lengths - 1) > UNIT_TOLERANCE).any():
        raise ValueError("a pose's quaternion (its last four numbers, wxyz) must be of unit length")
    return [sapien.Pose(row[:3], row[3:]) for row in rows]


def vector_rows(vector: Any, count: int) -> NDArray[np.float32]:
    """(count, 3) float32 from (3,) or (count, 3). Raises ValueError."""
    return _rows(vector, 3, count, "a velocity")


def joint_number_rows(numbers: Any, dofs: list[int], width: int, what: str) -> list[NDArray[np.float32]]:
    """One row for each of some articulations, as long as it has joints that move, from (width,) or (B, width).

    `dofs`: how many each has, `width` at most; what is given beyond is not looked at. Raises ValueError.
    """
    rows = np.asarray(numbers, dtype=np.float32)
    if rows.shape not in ((width,), (1, width), (len(dofs), width)):
        raise ValueError(f"{what} is ({width},) or ({len(dofs)}, {width}) here, not {rows.shape}")
    rows = np.broadcast_to(rows, (len(dofs), width))
    found = [row[:dof].copy() for row, dof in zip(rows, dofs, strict=True)]
    if not all(np.isfinite(row).all() for row in found):
        raise ValueError(f"{what} must be finite")
    return found


def padded(rows: list[Any], width: int) -> NDArray[np.float32]:
    """(B, width, …) of rows (dof, …), filled with NaN."""
    shape = np.shape(rows[0])[1:] if rows else ()
    found = np.full((len(rows), width, *shape), np.nan, np.float32)
    for row, numbers in zip(found, rows, strict=True):
        row[: len(numbers)] = numbers
    return found


def _rows(given: Any, width: int, count: int, what: str) -> NDArray[np.float32]:
    rows = np.asarray(given, dtype=np.float32)
    if rows.shape not in ((width,), (1, width), (count, width)):
        raise ValueError(f"{what} is ({width},) or ({count}, {width}) here, not {rows.shape}")
    if not np.isfinite(rows).all():
        raise ValueError(f"{what} must be finite")
    return np.broadcast_to(rows, (count, width)).copy()
