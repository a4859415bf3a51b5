"""Rotations as unit quaternions [w, x, y, z], in float64.

Formulas after J. Diebel, "Representing Attitude: Euler Angles, Unit Quaternions, and Rotation
Vectors" (2006); the matrix to quaternion step after S. W. Shepperd, "Quaternion from rotation
matrix" (1978), which picks the largest component and so never divides by a small number.

These are for one rotation and need no numpy, which a scene in which nothing varies never loads. Those of
`scenecc.geometry.rotation_arrays` are for many scenes at once and give the same bits, to which
`tests/property/test_rotation_arrays.py` holds the two.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

Vec3 = tuple[float, float, float]

Quat = tuple[float, float, float, float]


Matrix3 = tuple[Vec3, Vec3, Vec3]

IDENTITY: Quat = (1.0, 0.0, 0.0, 0.0)

Pose7 = tuple[float, float, float, float, float, float, float]
"""p [m] then q (wxyz), of unit length."""

IDENTITY_POSE: Final[Pose7] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)

AXES: dict[str, Vec3] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

MAX_COORDINATE = 1e6
"""Largest coordinate of a mesh or of terrain [m]. At 1e9 m PhysX can no longer compute the mass of a hull."""

EXACT_UNIT_TOLERANCE, UNIT_TOLERANCE = 1e-5, 1e-3
"""How far from 1 a quaternion's length may be: to be passed on as it is, and to be used at all
(docs/reference/language.md, Poses)."""

RIGID_TOLERANCE = 1e-3
"""How far a matrix may be from a rigid motion (docs/reference/language.md, Poses)."""

MIN_HORIZONTAL = 1e-6
"""Below this length of what is horizontal of a direction, where it points is rounding noise."""


def to_pose(row: Iterable[float]) -> Pose7:
    """Seven numbers of any type as a pose."""
    x, y, z, qw, qx, qy, qz = map(float, row)
    return x, y, z, qw, qx, qy, qz


def to_vector(row: Iterable[float]) -> Vec3:
    """Three numbers of any type as a vector."""
    x, y, z = map(float, row)
    return x, y, z


def multiply_quaternions(a: Quat, b: Quat) -> Quat:
    """The Hamilton product: first b, then a."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def normalized(q: Sequence[float]) -> Quat:
    """The quaternion of length 1 in the same direction."""
    w, x, y, z = q
    length = math.sqrt(w * w + x * x + y * y + z * z)
    return (w / length, x / length, y / length, z / length)


def rotate(q: Quat, v: Vec3) -> Vec3:
    """A vector turned by a unit quaternion."""
    w, *u = q
    t = cross((u[0], u[1], u[2]), v)
    t = (2 * t[0], 2 * t[1], 2 * t[2])
    c = cross((u[0], u[1], u[2]), t)
    return (v[0] + w * t[0] + c[0], v[1] + w * t[1] + c[1], v[2] + w * t[2] + c[2])


def from_rpy(roll: float, pitch: float, yaw: float) -> Quat:
    """Turns about the fixed axes x, then y, then z [rad]: qz(yaw) · qy(pitch) · qx(roll)."""
    x, y, z = roll / 2, pitch / 2, yaw / 2
    return from_half_angles((math.cos(x), math.cos(y), math.cos(z)), (math.sin(x), math.sin(y), math.sin(z)))


def from_half_angles(cosines: Vec3, sines: Vec3) -> Quat:
    """The same turns, of the cosines and the sines of half their angles."""
    (cr, cp, cy), (sr, sp, sy) = cosines, sines
    return (
        cy * cp * cr + sy * sp * sr,
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
    )


def from_axis_angle(axis: Vec3, angle: float) -> Quat:
    """A turn about an axis of any length but 0 by an angle [rad]."""
    length = math.hypot(*axis)
    s = math.sin(angle / 2) / length
    return (math.cos(angle / 2), axis[0] * s, axis[1] * s, axis[2] * s)


def shortest_from_x(target: Vec3) -> Quat:
    """The shortest rotation that turns +x to `target` (any length but 0); about z where they are opposite."""
    length = math.hypot(*target)
    x, y, z = target[0] / length, target[1] / length, target[2] / length
    if y == 0 and z == 0:
        return IDENTITY if x > 0 else (0.0, 0.0, 0.0, 1.0)
    if x == -1:
        # Opposite as far as the numbers go, and what is left of y and z may be too small to square.
        across = math.hypot(y, z)
        return (0.0, 0.0, -z / across, y / across)
    # Half way between +x and the target: q = (1 + cos, x × target), normalised.
    return normalized((1 + x, 0.0, 0.0 - z, y))


def from_matrix(m: Matrix3) -> Quat:
    """The rotation of an orthonormal matrix, with w ≥ 0 where w is the largest component."""
    (a, b, c), (d, e, f), (g, h, i) = m
    candidates = (a + e + i, a - e - i, e - a - i, i - a - e)
    largest = max(range(4), key=candidates.__getitem__)
    s = 2 * math.sqrt(max(0.0, 1 + candidates[largest]))
    match largest:
        case 0:
            q = (s / 4, (h - f) / s, (c - g) / s, (d - b) / s)
        case 1:
            q = ((h - f) / s, s / 4, (b + d) / s, (c + g) / s)
        case 2:
            q = ((c - g) / s, (b + d) / s, s / 4, (f + h) / s)
        case _:
            q = ((d - b) / s, (c + g) / s, (f + h) / s, s / 4)
    return normalized(q)


def looking(forward: Vec3) -> Quat | None:
    """+x along `forward`, +z as far up as it goes; None where `forward` is 0 or points straight up or down."""
    length = math.hypot(*forward)
    if length == 0:
        return None
    x = (forward[0] / length, forward[1] / length, forward[2] / length)
    y = cross((0.0, 0.0, 1.0), x)
    across = math.hypot(*y)
    if across < MIN_HORIZONTAL:
        return None
    y = (y[0] / across, y[1] / across, y[2] / across)
    z = cross(x, y)
    return from_matrix(((x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])))


def cross(a: Vec3, b: Vec3) -> Vec3:
    """The cross product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def compose(outer: Pose7, inner: Pose7) -> Pose7:
    """`inner`, given in the frame of `outer`, in the frame that `outer` is given in.

    A pose that does not turn passes the other's rotation on untouched.
    """
    if outer == IDENTITY_POSE:
        return inner
    p, q = outer[:3], normalized(outer[3:])
    moved = rotate(q, inner[:3])
    if inner[3:] == IDENTITY:
        turned = outer[3:]
    elif outer[3:] == IDENTITY:
        turned = inner[3:]
    else:
        turned = normalized(multiply_quaternions(q, inner[3:]))
    return (p[0] + moved[0], p[1] + moved[1], p[2] + moved[2], *turned)


def turned(pose: Pose7, rotation: Quat, step: Vec3 = (0.0, 0.0, 0.0)) -> Pose7:
    """A pose with a rotation and a step, both in its own frame, put before it.

    A pose that does not turn passes the rotation on untouched, and the other way round.
    """
    if rotation == IDENTITY and not any(step):
        return pose
    if pose[3:] == IDENTITY:
        return (pose[0] + step[0], pose[1] + step[1], pose[2] + step[2], *rotation)
    return compose(pose, (*step, *rotation))


def invert(pose: Pose7) -> Pose7:
    """The pose that undoes one."""
    w, x, y, z = pose[3:]
    back = (w, -x, -y, -z)
    p = rotate(normalized(back), pose[:3])
    return (-p[0], -p[1], -p[2], *back)


def relative_pose(outer: Pose7, inner: Pose7) -> Pose7:
    """outer⁻¹ · inner: `inner` relative to `outer`, both given in the same frame."""
    return compose(invert(outer), inner)


def rigidity(m: Sequence[Sequence[float]]) -> float:
    """How far a 4×4 matrix is from a rigid motion: the largest entry of |RᵀR - I|, |det R - 1| and the last row."""
    r = [row[:3] for row in m[:3]]
    columns = list(zip(*r, strict=True))
    gram = max(
        abs(sum(p * q for p, q in zip(columns[i], columns[j], strict=True)) - (i == j))
        for i in range(3)
        for j in range(3)
    )
    det = sum(p * q for p, q in zip(columns[0], cross(tuple(columns[1]), tuple(columns[2])), strict=True))
    last = max(abs(p - q) for p, q in zip(m[3], (0, 0, 0, 1), strict=True))
    return max(gram, abs(det - 1), last)
