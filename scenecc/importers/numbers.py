"""Formats numbers, poses, names and joints of an imported file for a scene file."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.geometry.rotations import (
    IDENTITY,
    Pose7,
    Quat,
    Vec3,
    compose,
    from_matrix,
    from_rpy,
    invert,
    rotate,
    shortest_from_x,
    to_rpy,
)
from scenecc.names import UniqueNames, valid_name
from scenecc.robots.rules import default_position

if TYPE_CHECKING:
    from scenecc.robots.description import DescribedRobot

_NOISE = 1e-9
"""Smaller numbers in poses and directions are rounding noise [m, or quaternion]."""

SINGLE: Final = 2e-7
"""Rounding error of a quaternion or a direction in single precision."""

_HALF_DIGIT: Final = 6e-8
"""Relative rounding error of a number in single precision."""

LOOK: Final[Pose7] = (0.0, 0.0, 0.0, *from_matrix(((0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0))))
"""SAPIEN's x (forward), y (left), z (up) in a MuJoCo or USD camera frame, which looks along -z with y up."""

_AXES = {(1.0, 0.0, 0.0): "x", (0.0, 1.0, 0.0): "y", (0.0, 0.0, 1.0): "z"}


def plain_number(value: float) -> float:
    """Returns the shortest decimal number with the same float32."""
    return float(str(np.float32(value))) + 0.0


def plain_numbers(values: Iterable[float], noise: float = 0.0) -> list[float]:
    """Returns several plain numbers. `noise`: smaller values become 0."""
    return [0.0 if abs(value) < noise else plain_number(value) for value in values]


def plain_pose(pose: Pose7) -> Any:
    """Returns a pose as a value of `pose:`."""
    p, q = plain_numbers(pose[:3], _NOISE), pose[3:]
    rotation = plain_numbers(q if q[0] >= 0 else [-each for each in q], _NOISE)
    if rotation == list(IDENTITY):
        return p
    turned = _plain_rotation(q, rotation)
    return {"p": p, **turned} if any(p) else turned


def clean_pose(pose: Pose7) -> Pose7:
    """Returns a pose without the rounding errors of single precision: whole degrees where it is that near to them."""
    near = from_rpy(*map(math.radians, _whole_degrees(pose[3:])))
    sign = math.copysign(1.0, sum(a * b for a, b in zip(near, pose[3:], strict=True)))
    near = (near[0] * sign, near[1] * sign, near[2] * sign, near[3] * sign)
    is_near = max(abs(a - b) for a, b in zip(near, pose[3:], strict=True)) < SINGLE
    reach = max(*map(abs, pose[:3]), 1.0) * _HALF_DIGIT
    p = [_shortest(each, reach) for each in pose[:3]]
    q = near if is_near else tuple(0.0 if abs(each) < SINGLE else each for each in pose[3:])
    return (p[0], p[1], p[2], q[0], q[1], q[2], q[3])


def short_number(value: float) -> float:
    """Returns a computed number as the shortest decimal number within the rounding error of single precision."""
    scale = 10.0 ** math.floor(math.log10(abs(value))) if value and math.isfinite(value) else 1.0
    return plain_number(_shortest(value / scale, 2 * abs(value / scale) * _HALF_DIGIT) * scale)


def _shortest(value: float, reach: float) -> float:
    """Returns the number with the fewest decimals within a distance."""
    return next((near for digits in range(9) if abs((near := round(value, digits)) - value) <= reach), value)


def is_identity(pose: Pose7) -> bool:
    """Returns whether a pose, as written, is the identity."""
    return plain_pose(pose) == [0, 0, 0]


def pose_key(pose: Pose7, key: str = "pose") -> dict[str, Any]:
    """Returns a pose under its key; empty for the identity, the default of these keys."""
    return {} if is_identity(pose) else {key: plain_pose(pose)}


def _plain_rotation(q: Quat, rotation: list[float]) -> dict[str, Any]:
    """Returns roll, pitch and yaw if they are whole degrees; else the quaternion `rotation`."""
    whole = _whole_degrees(q)
    near = from_rpy(*map(math.radians, whole))
    off = min(max(abs(a - sign * b) for a, b in zip(near, q, strict=True)) for sign in (1, -1))
    return {"rpy_deg": whole} if off < _SAME else {"q": rotation}


def _whole_degrees(q: Quat) -> list[int]:
    """Returns roll, pitch and yaw of a rotation, rounded to whole degrees."""
    roll, pitch, yaw = map(math.degrees, to_rpy(q))
    if abs(roll) > 90 and abs(yaw) > 90:
        # The same rotation: [0, 135, 0] instead of [180, 45, 180].
        roll, yaw = (angle - math.copysign(180, angle) for angle in (roll, yaw))
        pitch = math.copysign(180, pitch) - pitch
    return [_within_half_turn(round(angle)) for angle in (roll, pitch, yaw)]


def _within_half_turn(angle: int) -> int:
    """Returns the same angle from -179 to 180 [degrees]."""
    return 180 - (180 - angle) % 360


_SAME: Final = 1e-11
"""Rounding error of a quaternion in double precision."""


def plain_axis(axis: Vec3) -> Any:
    """Returns a direction: a letter for an axis, else a unit vector."""
    length = math.sqrt(sum(each * each for each in axis))
    unit = plain_numbers([each / length for each in axis], SINGLE)
    unit = [round(each) + 0.0 if abs(each - round(each)) < SINGLE else each for each in unit]
    return _AXES.get((unit[0], unit[1], unit[2]), unit)


def light_place(kind: str, position: Iterable[float], direction: Iterable[float]) -> dict[str, Any]:
    """Returns position [m] and direction of a light, as far as its kind has them."""
    keys: dict[str, Any] = {}
    if kind != "directional":
        keys["position"] = plain_numbers(position, _NOISE)
    if kind != "point":
        keys["direction"] = plain_numbers(direction, _NOISE)
    return keys


def plain_name(wish: str) -> str:
    """Returns the nearest valid name. Names of nested models are joined by dots."""
    return valid_name(wish.replace("::", "."))


class Names(UniqueNames):
    """Assigns valid, unique names."""

    def new(self, wish: str) -> str:
        """Returns the nearest free name."""
        return super().new(plain_name(wish))


_NEAR: Final = 1e-9
"""Origins closer than this coincide [m]."""


def along_x(axis: Vec3) -> Pose7:
    """Returns a frame whose x is along a nonzero axis."""
    length = math.hypot(*axis)
    return (0.0, 0.0, 0.0, *shortest_from_x((axis[0] / length, axis[1] / length, axis[2] / length)))


def joint_frames(in_parent: Pose7, in_child: Pose7, axis: Vec3 | None) -> dict[str, Any]:
    """Returns the frames of a joint in a link tree: `origin` and `axis` if the joint is at the link's origin.

    Args:
        in_parent: the joint's frame in the parent link.
        in_child: the same frame in the child link, at position 0.
        axis: axis of motion in the joint's frame; None: fixed.
    """
    origin = pose_key(clean_pose(compose(in_parent, invert(in_child))), "origin")
    if axis is None:
        return origin
    if max(map(abs, in_child[:3])) < _NEAR:
        plain = plain_axis(rotate(in_child[3:], axis))
        return {**origin, **({} if plain == "x" else {"axis": plain})}
    turn = along_x(axis)
    ends = {"pose_in_parent": compose(in_parent, turn), "pose_in_child": compose(in_child, turn)}
    return {key: plain_pose(pose) for key, pose in ends.items()}


def starts_at_limits(robots: Iterable[DescribedRobot]) -> dict[str, dict[str, float]]:
    """Returns the key `qpos` with the joints that cannot start at 0, at their nearest limit; {} if there are none."""
    found: dict[str, float] = {}
    for joint in (link.joint for robot in robots for link in robot.links):
        if joint is None or not joint.name or joint.mimic is not None or joint.qpos is not None:
            continue
        if start := default_position(joint):
            found[joint.name] = plain_number(start)
    return {"qpos": found} if found else {}
