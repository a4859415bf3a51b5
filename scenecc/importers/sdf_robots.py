"""URDFs that an SDF includes, as models whose links and joints the SDF may name."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from scenecc.robots.link_poses import robot_link_poses

if TYPE_CHECKING:
    from scenecc.importers.sdf_files import SourceElement
    from scenecc.robots.description import DescribedRobot


def robot_element(robots: tuple[DescribedRobot, ...], include: SourceElement) -> SourceElement:
    """Returns a <model> with the links and joints of a URDF, placed as if all joints are at 0.

    Its elements have the location of the <include>.
    """

    def element(tag: str, text: str = "", *children: SourceElement, **attributes: str) -> SourceElement:
        return replace(include, tag=tag, attributes=attributes, children=[*children], characters=[text])

    made: list[SourceElement] = []
    for robot in robots:
        for link, pose in zip(robot.links, robot_link_poses(robot, robot.pose, at_start=False), strict=True):
            text = " ".join(map(repr, (*pose[:3], *pose[4:], pose[3])))
            made.append(element("link", "", element("pose", text, rotation_format="quat_xyzw"), name=link.name))
            if link.joint is not None:
                made.append(element("joint", "", element("child", link.name), name=link.joint.name))
    return element("model", "", *made)
