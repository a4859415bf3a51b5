"""Poses with the arithmetic of SAPIEN's loader, equal to the last bit."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, cast

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Pose7, Vec3

_F = np.float32

_HALF, _ONE, _TWO = _F(0.5), _F(1), _F(2)


Float32Tuple = tuple[np.float32, ...]


def pose_of_matrix(matrix: NDArray[np.float64]) -> Pose7:
    """Returns `sapien.Pose(matrix)`.

    Args:
        matrix: (4, 4), a rotation and a translation.
    """
    with np.errstate(all="ignore"):
        m = matrix.astype(_F)
        quaternion = _normalize(_quaternion_of_matrix(m))
    return _numbers((m[0, 3], m[1, 3], m[2, 3], *quaternion))


@lru_cache(maxsize=1024)
def axis_pose(axis: Vec3, p: Vec3 = (0.0, 0.0, 0.0)) -> Pose7:
    """Returns a frame at `p` whose x is a unit axis; y and z are chosen as in SAPIEN's loader."""
    y: NDArray[np.float64] = np.cross(axis, (0.0, 0.0, 1.0) if abs(axis[0]) > 0.9 else (1.0, 0.0, 0.0))
    y /= np.linalg.norm(y)
    matrix: NDArray[np.float64] = np.eye(4)
    matrix[:3, 3] = p
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = axis, y, np.cross(axis, y)
    return pose_of_matrix(matrix)


def compose_poses(first: Pose7, second: Pose7) -> Pose7:
    """Returns `first * second`: `second` in the frame of `first`."""
    with np.errstate(all="ignore"):
        p, q = _floats(first[:3]), _floats(first[3:])
        turned = _rotate(q, _floats(second[:3]))
        rotation = _multiply(q, _floats(second[3:]))
    return _numbers((turned[0] + p[0], turned[1] + p[1], turned[2] + p[2], *rotation))


def pose_numbers(p: Vec3, q: tuple[float, float, float, float]) -> Pose7:
    """Returns `sapien.Pose(p, q)`: single precision, without normalization."""
    return _numbers(_floats((*p, *q)))


def _floats(values: tuple[float, ...]) -> Float32Tuple:
    return tuple(_F(value) for value in values)


def _numbers(values: Float32Tuple) -> Pose7:
    return cast("Pose7", tuple(float(value) for value in values))


def _quaternion_of_matrix(m: Any) -> Float32Tuple:
    trace = m[0, 0] + (m[1, 1] + m[2, 2])
    if trace > 0:
        root = np.sqrt(trace + _ONE)
        scale = _HALF / root
        return (
            _HALF * root,
            (m[2, 1] - m[1, 2]) * scale,
            (m[0, 2] - m[2, 0]) * scale,
            (m[1, 0] - m[0, 1]) * scale,
        )
    i = 1 if m[1, 1] > m[0, 0] else 0
    if m[2, 2] > m[i, i]:
        i = 2
    j, k = (i + 1) % 3, (i + 2) % 3
    root = np.sqrt(m[i, i] - m[j, j] - m[k, k] + _ONE)
    scale = _HALF / root
    vector = [_ONE, _ONE, _ONE]
    vector[i] = _HALF * root
    vector[j] = (m[j, i] + m[i, j]) * scale
    vector[k] = (m[k, i] + m[i, k]) * scale
    return ((m[k, j] - m[j, k]) * scale, *vector)


def _normalize(q: Float32Tuple) -> Float32Tuple:
    w, x, y, z = q
    # Eigen's order for adding four squares in a register that holds x, y, z, w.
    squared = (x * x + z * z) + (y * y + w * w)
    if not squared > 0:
        return q
    norm = np.sqrt(squared)
    return (w / norm, x / norm, y / norm, z / norm)


def _rotate(q: Float32Tuple, v: Float32Tuple) -> Float32Tuple:
    w, x, y, z = q
    a, b, c = v
    along = _TWO * (x * a + y * b + z * c)
    kept = w * w - (x * x + y * y + z * z)
    across = _TWO * w
    return (
        along * x + kept * a + across * (y * c - z * b),
        along * y + kept * b + across * (z * a - x * c),
        along * z + kept * c + across * (x * b - y * a),
    )


def _multiply(first: Float32Tuple, second: Float32Tuple) -> Float32Tuple:
    w, x, y, z = first
    a, b, c, d = second
    return (
        w * a - x * b - y * c - z * d,
        w * b + a * x + y * d - c * z,
        w * c + a * y + z * b - d * x,
        w * d + a * z + x * c - b * y,
    )
