"""Poses one by one: p [m] then q (wxyz)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.geometry import rotation_arrays
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7

if TYPE_CHECKING:
    from scenecc.plan import Value
    from scenecc.plan.snapshot import Vec3

Z_TO_X: Final[Pose7] = (0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5)
"""Turns z to x, x to y and y to z: from a frame in which things lie along z to one in which they lie along x."""


def compose(outer: Pose7, inner: Pose7) -> Pose7:
    """`inner`, given in the frame of `outer`, in the frame that `outer` is given in."""
    return plain(rotation_arrays.compose(np.array([outer]), np.array([inner]))[0])


def inverse(pose: Pose7) -> Pose7:
    """The pose that undoes it."""
    w, x, y, z = pose[3:]
    back = (w, -x, -y, -z)
    a, b, c = rotate(back, (pose[0], pose[1], pose[2]))
    return (-a, -b, -c, *back)


def between(outer: Pose7, inner: Pose7) -> Pose7:
    """`inner` in the frame of `outer`, both in one frame."""
    return compose(inverse(outer), inner)


def rotate(q: tuple[float, float, float, float], vector: Vec3) -> Vec3:
    """A vector turned by a quaternion of unit length."""
    x, y, z = map(float, rotation_arrays.rotate(rotation_arrays.normalized(np.array([q])), np.array([vector]))[0])
    return x, y, z


def turn(pose: Pose7, vector: Vec3) -> Vec3:
    """A vector of a pose's frame in the frame that the pose is given in."""
    return rotate(pose[3:], vector)


def of(value: Value | None, row: int) -> Pose7:
    """A pose of the plan in a row; the identity where it says none."""
    return IDENTITY_POSE if value is None else plain(value.row(row))


def plain(row: Any) -> Pose7:
    """Seven numbers as a pose."""
    x, y, z, qw, qx, qy, qz = map(float, row)
    return x, y, z, qw, qx, qy, qz
