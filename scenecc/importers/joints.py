"""Joints of an imported file as joints of link trees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from scenecc.geometry.rotations import compose, invert, rotate, shortest_from_x
from scenecc.importers.numbers import plain_axis, plain_pose, pose_key

if TYPE_CHECKING:
    from scenecc.geometry.rotations import Pose7, Vec3

HOLD: Final = {"stiffness": 1e10, "damping": 1e4, "mode": "acceleration"}
"""The spring with which `weld` holds what PhysX's limits do not."""

_NEAR: Final = 1e-9
"""Frames that are less apart have one origin [m]."""


def along_x(axis: Vec3) -> Pose7:
    """The frame whose x is an axis of any length but 0."""
    length = math.hypot(*axis)
    return (0.0, 0.0, 0.0, *shortest_from_x((axis[0] / length, axis[1] / length, axis[2] / length)))


def joint_frames(in_parent: Pose7, in_child: Pose7, axis: Vec3 | None) -> dict[str, Any]:
    """The frames of a joint as a link tree has them: `origin` and `axis` where it turns about the link's origin.

    Args:
        in_parent: the joint's frame in the parent link.
        in_child: the same frame in the child link, at position 0.
        axis: along or about which it moves, in its frame; None: it is fixed.
    """
    origin = pose_key(compose(in_parent, invert(in_child)), "origin")
    if axis is None:
        return origin
    if max(map(abs, in_child[:3])) < _NEAR:
        plain = plain_axis(rotate(in_child[3:], axis))
        return {**origin, **({} if plain == "x" else {"axis": plain})}
    turn = along_x(axis)
    ends = {"pose_in_parent": compose(in_parent, turn), "pose_in_child": compose(in_child, turn)}
    return {key: plain_pose(pose) for key, pose in ends.items()}
