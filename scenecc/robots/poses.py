"""Poses of robots' files, in the arithmetic of SAPIEN's and ManiSkill's loaders, which decides their last bits."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np

from scenecc.geometry.rotations import IDENTITY, Pose7, Quat, Vec3, multiply, rotate
from scenecc.robots.maniskill_attributes import ORIENTATION_ATTRIBUTES, CompilerSettings, MjcfAttributes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.floating[Any]]

_F = np.float32

_HALF, _ONE, _TWO = _F(0.5), _F(1), _F(2)


Float32Tuple = tuple[np.float32, ...]


def pose_of_matrix(matrix: NDArray[np.float64]) -> Pose7:
    """What `sapien.Pose(matrix)` is.

    Args:
        matrix: (4, 4), a rotation and a translation.
    """
    with np.errstate(all="ignore"):
        m = matrix.astype(_F)
        quaternion = _normalize(_quaternion_of_matrix(m))
    return _numbers((m[0, 3], m[1, 3], m[2, 3], *quaternion))


@lru_cache(maxsize=1024)
def axis_pose(axis: Vec3, p: Vec3 = (0.0, 0.0, 0.0)) -> Pose7:
    """A frame at `p` whose x is an axis of length 1; y and z are those that SAPIEN's and ManiSkill's loaders choose."""
    y: NDArray[np.float64] = np.cross(axis, (0.0, 0.0, 1.0) if abs(axis[0]) > 0.9 else (1.0, 0.0, 0.0))
    y /= np.linalg.norm(y)
    matrix: NDArray[np.float64] = np.eye(4)
    matrix[:3, 3] = p
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = axis, y, np.cross(axis, y)
    return pose_of_matrix(matrix)


def compose_poses(first: Pose7, second: Pose7) -> Pose7:
    """What `first * second` is: `second`, in the frame of `first`."""
    with np.errstate(all="ignore"):
        p, q = _floats(first[:3]), _floats(first[3:])
        turned = _rotate(q, _floats(second[:3]))
        rotation = _multiply(q, _floats(second[3:]))
    return _numbers((turned[0] + p[0], turned[1] + p[1], turned[2] + p[2], *rotation))


def pose_numbers(p: Vec3, q: tuple[float, float, float, float]) -> Pose7:
    """What `sapien.Pose(p, q)` is: single precision, the quaternion as it is given."""
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
    # The order in which Eigen adds four squares that lie in one register as x, y, z, w.
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


Symmetry = Literal["none", "axis", "point"]
"""Which part of a rotation changes a shape: all of it, the direction of its z axis, or nothing."""

_ROTATION_TOLERANCE = 1e-7

_UNIT_TOLERANCE = 1e-5


def read_rotation(attributes: MjcfAttributes, compiler: CompilerSettings, symmetry: Symmetry = "none") -> Quat:
    """The rotation that an element's attributes say, wxyz in double precision.

    Args:
        attributes: of a body or a geom.
        compiler: how angles are written.
        symmetry: of what is turned.
    """
    way = attributes.orientation()
    if way is None:
        return IDENTITY
    count = {"quat": 4, "euler": 3, "axisangle": 4, "xyaxes": 6, "zaxis": 3}[way]
    default = (math.nan,) * count
    values = attributes.numbers(way, default)
    if values is default:
        return IDENTITY
    if way != "euler" and not any(values):
        attributes.wrong(way, "is zero, which is no rotation")
        return IDENTITY
    meant = _mujoco_rotation(way, values, compiler, attributes)
    if meant is None:
        return IDENTITY
    # Of several ways at once ManiSkill's loader takes the first in this order.
    first = next(name for name in ORIENTATION_ATTRIBUTES if name in attributes)
    theirs = _maniskill_rotation(way, values, compiler) if first == way else None
    if theirs is not None and _is_equivalent(theirs, meant, symmetry):
        return theirs
    attributes.report.differs(
        way, f"`{way}` is read as MJCF means it; ManiSkill's loader reads another rotation", attributes.at(way)
    )
    return meant


def shortest_rotation(z: Sequence[float]) -> Quat:
    """The shortest rotation that turns z to a direction, as MuJoCo computes it."""
    direction = np.asarray(z, np.float64) / np.linalg.norm(z)
    axis = np.array([-direction[1], direction[0], 0.0])
    length = float(np.linalg.norm(axis))
    axis = np.array([1.0, 0.0, 0.0]) if length < 1e-10 else axis / length
    return from_axis_angle(axis, math.atan2(length, float(direction[2])))


def from_axis_angle(vector: Array, angle: float) -> Quat:
    """A rotation about a vector of any length but zero."""
    vector = vector / math.sqrt(np.dot(vector, vector))
    half = angle / 2.0
    turned = vector * math.sin(half)
    return (math.cos(half), float(turned[0]), float(turned[1]), float(turned[2]))


def from_rpy(roll: float, pitch: float, yaw: float) -> Quat:
    """Turns about the fixed x, y and z, one after another."""
    (ci, si), (cj, sj), (ck, sk) = ((math.cos(half), math.sin(half)) for half in (roll / 2.0, pitch / 2.0, yaw / 2.0))
    cc, cs, sc, ss = ci * ck, ci * sk, si * ck, si * sk
    return (cj * cc + sj * ss, cj * sc - sj * cs, cj * ss + sj * cc, cj * cs - sj * sc)


def _mujoco_rotation(
    way: str, values: Sequence[float], compiler: CompilerSettings, attributes: MjcfAttributes
) -> Quat | None:
    """The rotation as MJCF means it."""
    if way == "quat":
        return _normalize_mjcf(values)
    if way == "euler":
        return _from_euler([compiler.radians(value) for value in values], compiler.euler_sequence)
    if way == "axisangle":
        if not any(values[:3]):
            attributes.wrong(way, "has an axis of no length")
            return None
        return from_axis_angle(np.asarray(values[:3]), compiler.radians(values[3]))
    return shortest_rotation(values) if way == "zaxis" else _from_xy_axes(values, attributes)


def _from_xy_axes(values: Sequence[float], attributes: MjcfAttributes) -> Quat | None:
    """The rotation to an x axis and a y axis, of which the second need not be upright to the first."""
    x: Array = np.asarray(values[:3], np.float64)
    y: Array = np.asarray(values[3:], np.float64)
    if not x.any() or not np.cross(x, y).any():
        attributes.wrong("xyaxes", "has axes that lie in one line, or that have no length")
        return None
    x = x / np.linalg.norm(x)
    y = y - x * np.dot(x, y)
    y = y / np.linalg.norm(y)
    return _from_axes(x, y, np.cross(x, y))


def _maniskill_rotation(way: str, values: Sequence[float], compiler: CompilerSettings) -> Quat | None:
    """The rotation as ManiSkill's loader computes it; None where nothing comes of it."""
    array: Array = np.asarray(values, np.float64)
    if way == "quat":
        return (values[0], values[1], values[2], values[3])
    if way == "euler":
        if compiler.degrees:
            array = array * (np.pi / 180)
        return from_rpy(float(array[0]), -float(array[1]), float(array[2]))
    if way == "axisangle":
        angle = array[3] * (np.pi / 180) if compiler.degrees else array[3]
        return from_axis_angle(array[:3] / np.linalg.norm(array[:3]), float(angle))
    if way == "xyaxes":
        return None
    z: Array = array / np.linalg.norm(array)
    x: Array = np.cross(np.array([0, 0, 1]), z)
    if not x.any():
        return None
    x = x / np.linalg.norm(x)
    y = np.cross(z, x)
    return _from_axes(x, y / np.linalg.norm(y), z)


def _from_euler(angles: Sequence[float], sequence: str) -> Quat:
    """Turns about the axes of a sequence: small letters turn along, capital ones stay."""
    whole = IDENTITY
    for angle, letter in zip(angles, sequence, strict=True):
        one = from_axis_angle(np.eye(3)["xyz".index(letter.lower())], angle)
        whole = multiply(whole, one) if letter.islower() else multiply(one, whole)
    return whole


def _from_axes(x: Array, y: Array, z: Array) -> Quat:
    """The rotation to some axes, by the largest eigenvector of a symmetric matrix (Bar-Itzhack 2000)."""
    (xx, yx, zx), (xy, yy, zy), (xz, yz, zz) = np.array([x, y, z]).T.tolist()
    symmetric = np.array(
        [
            [xx - yy - zz, 0, 0, 0],
            [yx + xy, yy - xx - zz, 0, 0],
            [zx + xz, zy + yz, zz - xx - yy, 0],
            [yz - zy, zx - xz, xy - yx, xx + yy + zz],
        ]
    )
    values, vectors = np.linalg.eigh(symmetric / 3.0)
    q = vectors[[3, 0, 1, 2], np.argmax(values)]
    q = -q if q[0] < 0 else q
    return (float(q[0]), float(q[1]), float(q[2]), float(q[3]))


def _is_equivalent(one: Quat, other: Quat, symmetry: Symmetry) -> bool:
    """Whether two rotations do the same to a shape, the first of which may not be one."""
    length = math.hypot(*one)
    if not abs(length - 1) <= _UNIT_TOLERANCE:
        return False
    if symmetry == "point":
        return True
    if symmetry == "axis":
        return math.dist(*(rotate(_normalize_mjcf(q), (0.0, 0.0, 1.0)) for q in (one, other))) < _ROTATION_TOLERANCE
    difference = multiply(_normalize_mjcf((one[0], -one[1], -one[2], -one[3])), other)
    return math.hypot(*difference[1:]) < _ROTATION_TOLERANCE


def _normalize_mjcf(q: Sequence[float]) -> Quat:
    length = math.hypot(*q)
    return (q[0] / length, q[1] / length, q[2] / length, q[3] / length)
