"""Forward kinematics of a described robot; `scenecc.plan.link_poses` is that of a plan."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.geometry.rotations import IDENTITY, Pose7, compose, from_axis_angle, invert
from scenecc.robots.rules import default_position

if TYPE_CHECKING:
    from scenecc.robots.description import DescribedJoint, DescribedRobot


def robot_link_poses(robot: DescribedRobot, root: Pose7, *, at_start: bool) -> list[Pose7]:
    """Returns the poses of all links. `root`: pose of the root; `at_start`: joints are at their starts, else at 0."""
    found: list[Pose7] = []
    for link in robot.links:
        if link.joint is None or link.parent is None:
            found.append(root)
            continue
        joint = link.joint
        start = default_position(joint) if joint.qpos is None else joint.qpos
        found.append(compose(found[link.parent], pose_across(joint, start if at_start else 0.0)))
    return found


def pose_across(joint: DescribedJoint, position: float = 0.0) -> Pose7:
    """Returns the pose of a joint's child in its parent link. `position`: along or about x of its frame [m, rad]."""
    pose = joint.pose_in_parent
    if position and joint.type == "prismatic":
        pose = compose(pose, (position, 0.0, 0.0, *IDENTITY))
    elif position and joint.type != "fixed":
        pose = compose(pose, (0.0, 0.0, 0.0, *from_axis_angle((1.0, 0.0, 0.0), position)))
    return compose(pose, invert(joint.pose_in_child))
