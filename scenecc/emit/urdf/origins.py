"""Poses as URDF has them: a point, and turns about the fixed axes x, then y, then z."""

from __future__ import annotations

from math import atan2, hypot
from typing import TYPE_CHECKING, Final

from scenecc.emit.xml import frames
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7

if TYPE_CHECKING:
    from scenecc.emit.xml.elements import Element
    from scenecc.plan.snapshot import Vec3

_UPRIGHT: Final = 1e-6
"""How near x may come to ±z for the turns about x and z to be told apart."""


def origin(element: Element, pose: Pose7) -> None:
    """Adds where something is; nothing for the identity."""
    if pose != IDENTITY_POSE:
        element.add("origin", xyz=pose[:3], rpy=rpy(pose))


def rpy(pose: Pose7) -> Vec3:
    """Roll, pitch and yaw [rad]."""
    x, y, z = (frames.turn(pose, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    level = hypot(x[0], x[1])
    pitch = atan2(-x[2], level)
    if level < _UPRIGHT:
        return 0.0, pitch, atan2(-y[0], y[1])
    return atan2(y[2], z[2]), pitch, atan2(x[1], x[0])
