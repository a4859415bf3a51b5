"""Batched rotations and poses: quaternions (B, 4) wxyz, poses (B, 7), vectors (B, 3), all float64.

Each function gives, for every row, the same bits as the function of the same name in `scenecc.geometry.rotations`.
Sums, products, quotients and square roots are rounded exactly everywhere; other functions are those of `math`, called
per element.

The functions for one rotation compile scenes without variation, which never load NumPy.
`tests/property/test_rotation_arrays.py` compares the two modules.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.geometry import rotations

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]
    Flags = NDArray[np.bool_]


_IDENTITY = np.array((1.0, 0.0, 0.0, 0.0))

_IDENTITY_POSE = np.array((0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0))


def map_elements(function: Callable[[float], float], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Applies a function of `math` to every element.

    NumPy's own functions may give different bits for the same number, depending on its position in the array. A scene's
    draw must not depend on the other scenes.
    """
    if values.strides[:1] == (0,) and len(values) > 1:
        # Equal in every scene.
        return np.broadcast_to(map_elements(function, values[:1]), values.shape)
    flat = np.fromiter(map(function, values.ravel().tolist()), dtype=np.float64, count=values.size)
    return flat.reshape(values.shape)


def hypot(values: Floats) -> Floats:
    """Returns the lengths (B,) of vectors (B, n), with the bits of `math.hypot`."""
    return np.fromiter((math.hypot(*row) for row in values.tolist()), dtype=np.float64, count=len(values))


def _by_column(function: Callable[..., tuple[Any, ...]], *rows: Floats) -> Floats:
    """Applies a function of `rotations` to columns; works for functions that only add and multiply."""
    return np.stack(function(*[each.T for each in rows]), axis=1)


def multiply_quaternions(a: Floats, b: Floats) -> Floats:
    """Returns the Hamilton product: first b, then a."""
    return _by_column(rotations.multiply_quaternions, a, b)


def normalized(q: Floats) -> Floats:
    """Returns quaternions scaled to length 1."""
    w, x, y, z = q.T
    return q / np.sqrt(w * w + x * x + y * y + z * z)[:, None]


def rotate(q: Floats, v: Floats) -> Floats:
    """Rotates vectors by unit quaternions."""
    return _by_column(rotations.rotate, q, v)


def cross(a: Floats, b: Floats) -> Floats:
    """Returns the cross products."""
    return _by_column(rotations.cross, a, b)


def from_rpy(angles: Floats) -> Floats:
    """Returns rotations about the fixed axes x, then y, then z, from angles (B, 3) [rad]."""
    cosines, sines = (map_elements(function, angles / 2) for function in (math.cos, math.sin))
    return _by_column(rotations.from_half_angles, cosines, sines)


def from_axis_angle(axis: Floats, angle: Floats) -> Floats:
    """Returns rotations about nonzero axes (B, 3) by angles (B,) [rad]."""
    s = map_elements(math.sin, angle / 2) / hypot(axis)
    return np.concatenate((map_elements(math.cos, angle / 2)[:, None], axis * s[:, None]), axis=1)


def shortest_from_x(target: Floats) -> Floats:
    """Returns the shortest rotations from +x to nonzero targets; about z for opposite ones."""
    x, y, z = (target / hypot(target)[:, None]).T
    aligned, opposite = (y == 0) & (z == 0), x == -1
    zero = np.zeros_like(x)
    across = np.where(opposite & ~aligned, hypot(np.stack((y, z), axis=1)), 1.0)
    reversed_ = np.stack((zero, zero, -z / across, y / across), axis=1)
    ahead = np.where((x > 0)[:, None], _IDENTITY, np.array((0.0, 0.0, 0.0, 1.0)))
    half_way = np.stack((1 + x, zero, 0.0 - z, y), axis=1)
    half_way[aligned | opposite] = _IDENTITY
    turned_ = np.where(opposite[:, None], reversed_, normalized(half_way))
    return np.where(aligned[:, None], ahead, turned_)


def from_matrix(m: Floats) -> Floats:
    """Returns the rotations of orthonormal matrices (B, 3, 3), with w ≥ 0 if w is the largest component."""
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(m, 0, -1)
    candidates = np.stack((a + e + i, a - e - i, e - a - i, i - a - e), axis=1)
    largest = np.argmax(candidates, axis=1)
    s = 2 * np.sqrt(np.maximum(0.0, 1 + np.take_along_axis(candidates, largest[:, None], axis=1)[:, 0]))
    x, y, z = (h - f) / s, (c - g) / s, (d - b) / s
    xy, xz, yz, main = (b + d) / s, (c + g) / s, (f + h) / s, s / 4
    table = np.stack([np.stack(row, axis=1) for row in (
        (main, x, y, z), (x, main, xy, xz), (y, xy, main, yz), (z, xz, yz, main),
    )])  # fmt: skip
    return normalized(table[largest, np.arange(len(m))])


def looking(forward: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Returns rotations with +x along `forward` and +z as far up as possible, and whether each exists.

    None exists if `forward` is 0 or vertical; the row is then the identity.
    """
    length = hypot(forward)
    known = length != 0
    x = forward / np.where(known, length, 1.0)[:, None]
    up = np.broadcast_to(np.array((0.0, 0.0, 1.0)), x.shape)
    y = cross(up, x)
    across = hypot(y)
    known &= across >= rotations.MIN_HORIZONTAL
    x, y = np.where(known[:, None], x, (1.0, 0.0, 0.0)), np.where(known[:, None], y, (0.0, 1.0, 0.0))
    y = y / np.where(known, across, 1.0)[:, None]
    return from_matrix(np.stack((x, y, cross(x, y)), axis=2)), known


def rigidity(m: Floats) -> Floats:
    """Returns the deviation of matrices (B, 4, 4) from rigid motions: the largest of |RᵀR - I|, |det R - 1| and the
    last row.

    Equal to the scalar function only up to rounding, since Python's `sum` depends on its version.
    """
    r = m[:, :3, :3]
    x, y, z = r[:, :, 0], r[:, :, 1], r[:, :, 2]
    worst = np.abs(_dot(x, cross(y, z)) - 1)
    for i, p in enumerate((x, y, z)):
        for j, q in enumerate((x, y, z)):
            worst = np.maximum(worst, np.abs(_dot(p, q) - (i == j)))
    return np.maximum(worst, np.abs(m[:, 3] - np.array((0.0, 0.0, 0.0, 1.0))).max(axis=1))


def compose(outer: Floats, inner: Floats) -> Floats:
    """Returns outer · inner: `inner`, given in the frame of `outer`; poses (B, 7).

    If one pose has no rotation, the other's rotation is kept exactly.
    """
    q = normalized(outer[:, 3:])
    p = outer[:, :3] + rotate(q, inner[:, :3])
    turned = np.where(_has_no_rotation(outer), inner[:, 3:], normalized(multiply_quaternions(q, inner[:, 3:])))
    composed = np.concatenate((p, np.where(_has_no_rotation(inner), outer[:, 3:], turned)), axis=1)
    still = (outer == _IDENTITY_POSE).all(axis=1)
    return np.where(still[:, None], inner, composed)


def invert(poses: Floats) -> Floats:
    """Returns the inverses of poses."""
    back = poses[:, 3:] * (1, -1, -1, -1)
    return np.concatenate((-rotate(normalized(back), poses[:, :3]), back), axis=1)


def turned(pose: Floats, rotation: Floats, step: Floats) -> Floats:
    """Returns poses moved by rotations (B, 4) and steps (B, 3) in their own frames.

    If the pose has no rotation, the given rotation is kept exactly, and vice versa.
    """
    moved = compose(pose, np.concatenate((step, rotation), axis=1))
    unturned = (pose[:, 3:] == _IDENTITY).all(axis=1)
    shifted = np.concatenate((pose[:, :3] + step, rotation), axis=1)
    untouched = (rotation == _IDENTITY).all(axis=1) & (step == 0).all(axis=1)
    return np.where(untouched[:, None], pose, np.where(unturned[:, None], shifted, moved))


def _has_no_rotation(pose: Floats) -> NDArray[np.bool_]:
    return (pose[:, 3:] == _IDENTITY).all(axis=1)[:, None]


def _dot(a: Floats, b: Floats) -> Floats:
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]


def rotation_matrix(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns the rotation matrix (3, 3) of a unit quaternion [w, x, y, z]; (3, 3, B) for four arrays (B,)."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def pose_matrix(pose: Sequence[float]) -> NDArray[np.float64]:
    """Returns a pose, p then a unit quaternion wxyz, as a (4, 4) matrix."""
    made = np.eye(4)
    made[:3, :3] = rotation_matrix(np.array(pose[3:]))
    made[:3, 3] = pose[:3]
    return made
