"""Entities of a described world that a reader places: their links' poses, moved, fixed, posed and attached."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose
from scenecc.importers.numbers import plain_number
from scenecc.robots.description import IN_WORLD, DescribedRobot, LinkName
from scenecc.robots.link_poses import robot_link_poses
from scenecc.robots.world import DescribedEntity, FilePart, RobotFile

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Location


class PlacedEntities:
    """Entities, with the joints at their start positions.

    Args:
        entities: the list that this changes.
    """

    def __init__(self, entities: list[DescribedEntity]) -> None:
        self._entities = entities
        self._attached: dict[str, FilePart] = {}

    def _index(self, name: str) -> int:
        return next(index for index, entity in enumerate(self._entities) if entity.name == name)

    def _change(self, name: str, content: Any) -> None:
        index = self._index(name)
        self._entities[index] = replace(self._entities[index], content=content)

    def _content(self, name: str) -> DescribedRobot | RobotFile:
        return self._entities[self._index(name)].content

    def set_position(self, name: str, joint: str, start: float) -> None:
        """Sets the start position of a joint of an entity [m, rad]."""
        content = self._content(name)

        def posed(robot: DescribedRobot) -> DescribedRobot:
            links = (
                replace(link, joint=replace(link.joint, qpos=start))
                if link.joint and link.joint.name == joint
                else link
                for link in robot.links
            )
            return replace(robot, links=tuple(links))

        if isinstance(content, DescribedRobot):
            self._change(name, posed(content))
            return
        keys = dict(content.keys)
        keys["qpos"] = {**keys.get("qpos", {}), joint: plain_number(start)}
        robots = tuple(map(posed, content.robots))
        self._change(name, replace(content, keys=tuple(keys.items()), robots=robots))

    def pose_of(self, link: LinkName) -> Pose7:
        """Returns the pose of a link in the world, with the joints at their start positions."""
        if link == IN_WORLD:
            return IDENTITY_POSE
        content = self._content(link[0])
        base = content.pose if isinstance(content, RobotFile) else IDENTITY_POSE
        robot, index = self._found(link)
        return robot_link_poses(robot, compose(base, robot.pose), at_start=True)[index]

    def _found(self, link: LinkName) -> tuple[DescribedRobot, int]:
        rows = ((robot, index) for robot in robots_of(self._content(link[0])) for index in range(len(robot.links)))
        return next((robot, index) for robot, index in rows if robot.links[index].name == link[1])

    def is_root(self, link: LinkName) -> bool:
        """Returns whether a link is the root of the only robot of its entity."""
        robots = robots_of(self._content(link[0]))
        return len(robots) == 1 and robots[0].links[0].name == link[1]

    def is_still(self, link: LinkName) -> bool:
        """Returns whether a link cannot move."""
        if link == IN_WORLD:
            return True
        entity = self._entities[self._index(link[0])]
        robot, index = self._found(link)
        here = robot.links[index]
        while here.joint is not None and here.parent is not None:
            if here.joint.type != "fixed":
                return False
            here = robot.links[here.parent]
        return still_links(entity)

    def move(self, link: LinkName, motion: Pose7) -> None:
        """Moves the entity of a link by a motion in the world frame."""
        content = self._content(link[0])
        self._change(link[0], replace(content, pose=compose(motion, content.pose)))

    def fix(self, link: LinkName) -> None:
        """Fixes the root of an entity in the world; a single body becomes static."""
        content = self._content(link[0])
        if isinstance(content, DescribedRobot):
            is_body = content.body_type is not None
            self._change(link[0], replace(content, body_type="static") if is_body else replace(content, fixed=True))
            return
        keys = {key: value for key, value in content.keys if key != "fix_root_link"}
        keys |= {"body_type": "static"} if len(content.robots[0].links) == 1 else {"fix_root_link": True}
        if content.format == "urdf" and "body_type" not in keys:
            del keys["fix_root_link"]
        self._change(link[0], replace(content, keys=tuple(keys.items())))

    def attach(self, to: LinkName, root: LinkName, pose: Pose7, place: Location) -> bool:
        """Attaches the URDF of a root to a link of another robot's file, if a scene can; returns whether it can."""
        if to == IN_WORLD:
            return False
        whole, part = self._content(to[0]), self._content(root[0])
        if not isinstance(whole, RobotFile) or not isinstance(part, RobotFile) or part.format != "urdf":
            return False
        is_robot = len(whole.robots) == 1 and len(whole.robots[0].links) > 1
        if not is_robot or not self.is_root(root) or part.robots[0].pose != IDENTITY_POSE:
            return False
        keys = tuple(row for row in part.keys if row[0] != "fix_root_link")
        self._attached[root[0]] = FilePart(root[0], to, pose, replace(part, keys=keys), place)
        return True

    def entities(self) -> tuple[DescribedEntity, ...]:
        """Returns the entities, each with what is attached to it."""
        found = {entity.name: entity for entity in self._entities if entity.name not in self._attached}
        for part in self._attached.values():
            whole = part.to[0]
            while whole in self._attached:
                whole = self._attached[whole].to[0]
            top = found[whole].content
            assert isinstance(top, RobotFile)
            found[whole] = replace(found[whole], content=replace(top, parts=(*top.parts, part)))
        return tuple(found.values())


def robots_of(content: DescribedRobot | RobotFile) -> tuple[DescribedRobot, ...]:
    """Returns the robots of an entity."""
    return content.robots if isinstance(content, RobotFile) else (content,)


def still_links(entity: DescribedEntity) -> bool:
    """Returns whether the roots of an entity are fixed in the world."""
    content = entity.content
    if isinstance(content, DescribedRobot):
        return bool(content.fixed) or content.body_type in {"static", "kinematic"}
    keys = dict(content.keys)
    if content.format == "mjcf":
        return (
            "body_type" in keys
            or keys.get("fix_root_link", False)
            or all(robot.fixed or robot.body_type == "static" for robot in content.robots)
        )
    return keys.get("fix_root_link", True)
