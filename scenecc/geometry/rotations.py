"""Rotations as unit quaternions [w, x, y, z], in float64.

Formulas after J. Diebel, "Representing Attitude: Euler Angles, Unit Quaternions, and Rotation Vectors" (2006). Matrix
to quaternion after S. W. Shepperd, "Quaternion from rotation matrix" (1978), which uses the largest component and so
never divides by a small number.

These functions handle one rotation and do not need NumPy, which scenes without variation never load.
`scenecc.geometry.rotation_arrays` handles many and gives the same bits, see `tests/property/test_rotation_arrays.py`.
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
"""p [m], then q (wxyz) of unit length."""

IDENTITY_POSE: Final[Pose7] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)

AXES: dict[str, Vec3] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

MAX_COORDINATE = 1e6
"""Largest coordinate of a mesh or terrain [m]. At 1e9 m PhysX can no longer compute the mass of a hull."""

EXACT_UNIT_TOLERANCE, UNIT_TOLERANCE = 1e-5, 1e-3
"""Allowed deviation of a quaternion's length from 1: to be kept exactly, and to be accepted
(docs/reference/language.md, Poses).
"""

RIGID_TOLERANCE = 1e-3
"""Allowed deviation of a matrix from a rigid motion (docs/reference/language.md, Poses)."""

MIN_HORIZONTAL = 1e-6
"""Smallest horizontal part of a direction; below it the heading is rounding noise."""


def to_pose(row: Iterable[float]) -> Pose7:
    """Converts seven numbers of any type to a pose."""
    x, y, z, qw, qx, qy, qz = map(float, row)
    return x, y, z, qw, qx, qy, qz


def to_vector(row: Iterable[float]) -> Vec3:
    """Converts three numbers of any type to a vector."""
    x, y, z = map(float, row)
    return x, y, z


def multiply_quaternions(a: Quat, b: Quat) -> Quat:
    """Returns the Hamilton product: first b, then a."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def normalized(q: Sequence[float]) -> Quat:
    """Returns a quaternion scaled to length 1."""
    w, x, y, z = q
    length = math.sqrt(w * w + x * x + y * y + z * z)
    return (w / length, x / length, y / length, z / length)


def rotate(q: Quat, v: Vec3) -> Vec3:
    """Rotates a vector by a unit quaternion."""
    w, *u = q
    t = cross((u[0], u[1], u[2]), v)
    t = (2 * t[0], 2 * t[1], 2 * t[2])
    c = cross((u[0], u[1], u[2]), t)
    return (v[0] + w * t[0] + c[0], v[1] + w * t[1] + c[1], v[2] + w * t[2] + c[2])


def from_rpy(roll: float, pitch: float, yaw: float) -> Quat:
    """Returns a rotation about the fixed axes x, then y, then z [rad]: qz(yaw) · qy(pitch) · qx(roll)."""
    x, y, z = roll / 2, pitch / 2, yaw / 2
    return from_half_angles((math.cos(x), math.cos(y), math.cos(z)), (math.sin(x), math.sin(y), math.sin(z)))


def from_half_angles(cosines: Vec3, sines: Vec3) -> Quat:
    """Like `from_rpy`, from cosines and sines of the half angles."""
    (cr, cp, cy), (sr, sp, sy) = cosines, sines
    return (
        cy * cp * cr + sy * sp * sr,
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
    )


def to_rpy(q: Quat) -> Vec3:
    """Returns the angles of `from_rpy` [rad], with pitch in [-π/2, π/2]; straight up or down without roll."""
    w, x, y, z = q
    sine = 2 * (w * y - x * z)
    roll_x, roll_y = 1 - 2 * (x * x + y * y), 2 * (w * x + y * z)
    if math.hypot(roll_x, roll_y) < _VERTICAL:
        return 0.0, math.copysign(math.pi / 2, sine), -2 * math.copysign(1.0, sine) * math.atan2(x, w)
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return math.atan2(roll_y, roll_x), math.asin(max(-1.0, min(1.0, sine))), yaw


_VERTICAL: Final = 1e-6
"""Cosine of a pitch that single precision cannot tell from ±90°."""


def from_axis_angle(axis: Vec3, angle: float) -> Quat:
    """Returns a rotation about a nonzero axis by an angle [rad]."""
    length = math.hypot(*axis)
    s = math.sin(angle / 2) / length
    return (math.cos(angle / 2), axis[0] * s, axis[1] * s, axis[2] * s)


def shortest_from_x(target: Vec3) -> Quat:
    """Returns the shortest rotation from +x to a nonzero `target`; about z if opposite."""
    length = math.hypot(*target)
    x, y, z = target[0] / length, target[1] / length, target[2] / length
    if y == 0 and z == 0:
        return IDENTITY if x > 0 else (0.0, 0.0, 0.0, 1.0)
    if x == -1:
        # Numerically opposite; the rest of y and z may be too small to square.
        across = math.hypot(y, z)
        return (0.0, 0.0, -z / across, y / across)
    # Half way between +x and the target: q = (1 + cos, x × target), normalized.
    return normalized((1 + x, 0.0, 0.0 - z, y))


def from_matrix(m: Matrix3) -> Quat:
    """Returns the rotation of an orthonormal matrix, with w ≥ 0 if w is the largest component."""
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
    """Returns the rotation with +x along `forward` and +z as far up as possible; None if `forward` is 0 or vertical."""
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
    """Returns the cross product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def compose(outer: Pose7, inner: Pose7) -> Pose7:
    """Returns outer · inner: `inner`, given in the frame of `outer`.

    If one pose has no rotation, the other's rotation is kept exactly.
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
    """Returns a pose moved by a rotation and a step in its own frame.

    If the pose has no rotation, the given rotation is kept exactly, and vice versa.
    """
    if rotation == IDENTITY and not any(step):
        return pose
    if pose[3:] == IDENTITY:
        return (pose[0] + step[0], pose[1] + step[1], pose[2] + step[2], *rotation)
    return compose(pose, (*step, *rotation))


def invert(pose: Pose7) -> Pose7:
    """Returns the inverse of a pose."""
    w, x, y, z = pose[3:]
    back = (w, -x, -y, -z)
    p = rotate(normalized(back), pose[:3])
    return (-p[0], -p[1], -p[2], *back)


def relative_pose(outer: Pose7, inner: Pose7) -> Pose7:
    """Returns outer⁻¹ · inner: `inner` relative to `outer`, both given in the same frame."""
    return compose(invert(outer), inner)


def rigidity(m: Sequence[Sequence[float]]) -> float:
    """Returns a 4×4 matrix's deviation from a rigid motion: the largest of |RᵀR - I|, |det R - 1| and the last row."""
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
