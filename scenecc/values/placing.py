"""Nodes that place: rotations and poses of what they are made of."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.values import columns, rotations
from scenecc.values.failure import DrawError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.values.evaluate import Batch
    from scenecc.values.nodes import (
        Composed,
        FromAxisAngle,
        FromMatrix,
        FromRpy,
        Looking,
        Node,
        Normalized,
        Pointing,
        Posed,
        Radians,
    )

    Floats = NDArray[np.float64]

UNTOUCHED, NORMALISED = 1e-5, 1e-3
"""How far from 1 a quaternion's length may be: to be passed on as it is, and to be used at all."""

RIGID = 1e-3
"""How far a matrix may be from a rigid motion."""


def posed(batch: Batch, node: Posed) -> Floats:
    """Poses (B, 7)."""
    return np.concatenate((_numbers(batch, node, node.p, 3), _numbers(batch, node, node.q, 4)), axis=1)


def normalized(batch: Batch, node: Normalized) -> Floats:
    """Quaternions (B, 4)."""
    q = _numbers(batch, node, node.q, 4)
    length = rotations.hypot(q)
    off = np.abs(length - 1)
    wrong = ~(off <= NORMALISED)
    if wrong.any():
        row = int(np.flatnonzero(wrong)[0])
        raise DrawError(f"the quaternion's length is {length[row]:.6g}, not 1", int(batch.scenes[row]), node)
    return np.where((off <= UNTOUCHED)[:, None], q, rotations.normalized(q))


def from_rpy(batch: Batch, node: FromRpy) -> Floats:
    """Quaternions (B, 4)."""
    return rotations.from_rpy(_numbers(batch, node, node.angles, 3))


def from_axis_angle(batch: Batch, node: FromAxisAngle) -> Floats:
    """Quaternions (B, 4)."""
    axis, angle = _numbers(batch, node, node.axis, 3), _numbers(batch, node, node.angle)
    _refuse(batch, node, (axis == 0).all(axis=1), "an axis of length 0 has no direction")
    return rotations.from_axis_angle(axis, angle)


def from_matrix(batch: Batch, node: FromMatrix) -> Floats:
    """Poses (B, 7)."""
    matrix = _numbers(batch, node, node.matrix, 4, 4)
    off = rotations.rigidity(matrix)
    wrong = ~(off <= RIGID)
    if wrong.any():
        row = int(np.flatnonzero(wrong)[0])
        raise DrawError(f"the matrix is no rigid motion: it is off by {off[row]:.3g}", int(batch.scenes[row]), node)
    return np.concatenate((matrix[:, :3, 3], rotations.from_matrix(matrix[:, :3, :3])), axis=1)


def looking(batch: Batch, node: Looking) -> Floats:
    """Quaternions (B, 4)."""
    forward = _numbers(batch, node, node.target, 3) - _numbers(batch, node, node.p, 3)
    q, known = rotations.looking(forward)
    _refuse(batch, node, ~known, "`look_at` is where the pose itself is, or straight above or below it")
    return q


def pointing(batch: Batch, node: Pointing) -> Floats:
    """Quaternions (B, 4)."""
    direction = _numbers(batch, node, node.direction, 3)
    _refuse(batch, node, (direction == 0).all(axis=1), "a direction of length 0 points nowhere")
    return rotations.shortest_from_x(direction)


def radians(batch: Batch, node: Radians) -> Floats:
    """Angles, of the item's shape; as `math.radians` has them."""
    degrees = columns.joined(batch.item(node.degrees))
    return _checked(batch, node, degrees, degrees.shape[1:]) * (math.pi / 180.0)


def composed(batch: Batch, node: Composed) -> Floats:
    """Poses (B, 7)."""
    return rotations.compose(_numbers(batch, node, node.outer, 7), _numbers(batch, node, node.inner, 7))


def _numbers(batch: Batch, node: Node, item: Any, *shape: int) -> Floats:
    """An item's values (B, *shape) as float64."""
    return _checked(batch, node, columns.joined(batch.item(item)), shape)


def _checked(batch: Batch, node: Node, values: NDArray[Any], shape: tuple[int, ...]) -> Floats:
    if values.dtype.kind not in "if" or values.shape[1:] != shape:
        wanted = " by ".join(str(size) for size in shape) + " numbers" if shape else "a number"
        raise DrawError(f"this is not {wanted}", int(batch.scenes[0]), node)
    return values.astype(np.float64, copy=False)


def _refuse(batch: Batch, node: Node, wrong: NDArray[np.bool_], message: str) -> None:
    if wrong.any():
        raise DrawError(message, int(batch.scenes[np.flatnonzero(wrong)[0]]), node)
