"""Articulations as link trees of a scene document."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from scenecc.importers.numbers import SINGLE, Names, clean_pose, joint_frames, plain_number, plain_numbers
from scenecc.robots.rules import default_position, with_one_resistance
from scenecc.scene_file.patterns import group_by_pattern

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.robots.description import DescribedDrive, DescribedJoint, DescribedRobot
    from scenecc.scene_file import Node

_X: Final = (1.0, 0.0, 0.0)

_NO_LIMITS: Final = (-math.inf, math.inf)

_TOLERANCE: Final = 1e-6
"""Allowed distance of a position beyond a limit [m, rad]."""

_NUMBERS: Final = {
    "friction": "friction",
    "friction_force": "friction_force",
    "armature": "armature",
    "max_velocity": "velocity",
}
"""Key of a joint → field of `DescribedJoint`."""


def joint_names(robot: DescribedRobot) -> dict[int, str]:
    """Returns the name of each joint in the scene, by index of its link. Moving joints always have one."""
    names = Names()
    found: dict[int, str] = {}
    for number, link in enumerate(robot.links):
        if link.joint is not None and (link.joint.name or link.joint.type != "fixed"):
            found[number] = names.new(link.joint.name or f"{link.name}_joint")
    return found


def tree_of(robot: DescribedRobot, links: list[Node], called: Mapping[int, str]) -> Node:
    """Returns the keys of an articulation for its joints and links: `root`, `joints`, `drives`, `qpos`, `qvel`.

    Args:
        robot: the articulation.
        links: the keys of each link, which get their joint and children.
        called: names of its joints, by index of the link.
    """
    links_of_file = (replace(link, joint=link.joint and with_one_resistance(link.joint)) for link in robot.links)
    robot = replace(robot, links=tuple(links_of_file))
    moving = [n for n, link in enumerate(robot.links) if link.joint is not None and link.joint.type != "fixed"]
    own_names = {joint.name: called[n] for n in moving if (joint := robot.links[n].joint) is not None}
    rows = {n: _joint_numbers(joint) for n in moving if (joint := robot.links[n].joint) is not None}
    common = _common(list(rows.values()))
    for number, (link, keys) in enumerate(zip(robot.links, links, strict=True)):
        if link.joint is not None:
            own = {key: value for key, value in rows.get(number, {}).items() if key not in common}
            keys["joint"] = _joint_node(link.joint, called.get(number), own, own_names)
        if link.parent is not None:
            links[link.parent].setdefault("children", []).append(keys)
    entity: Node = {"joints": {".*": common}} if common else {}
    entity |= _states(robot, moving, called)
    return {**entity, "root": links[0]}


def _common(rows: list[Node]) -> Node:
    """Returns the keys that all of several joints share."""
    if len(rows) < 2:
        return {}
    return {key: value for key, value in rows[0].items() if all(row.get(key) == value for row in rows)}


def _joint_numbers(joint: DescribedJoint) -> Node:
    numbers = {key: getattr(joint, field) for key, field in _NUMBERS.items()}
    return {key: plain_number(number) for key, number in numbers.items() if number is not None}


def _joint_node(joint: DescribedJoint, name: str | None, numbers: Node, names: Mapping[str, str]) -> Node:
    limits = joint.limits or _NO_LIMITS
    kind = "continuous" if joint.type == "revolute" and limits == _NO_LIMITS else joint.type
    node: Node = {"name": name, "type": kind} if name else {"type": kind}
    axis = None if joint.type == "fixed" else _X
    node |= joint_frames(clean_pose(joint.pose_in_parent), clean_pose(joint.pose_in_child), axis)
    if kind in {"fixed", "continuous"}:
        limits = _NO_LIMITS
    if limits != _NO_LIMITS:
        node |= _limits_key(limits, turns=joint.type != "prismatic")
    if joint.damping and joint.drive is None:
        node["damping"] = plain_number(joint.damping)
    node |= numbers
    mimic = joint.mimic
    if mimic is not None:
        node["mimic"] = {"joint": names[mimic.source], "multiplier": plain_number(mimic.multiplier)}
        if mimic.offset:
            node["mimic"]["offset"] = plain_number(mimic.offset)
    return node


def _limits_key(limits: tuple[float, float], *, turns: bool) -> Node:
    """Returns limits, those of a rotation in degrees if these have few digits."""
    degrees = [round(math.degrees(limit), 2) if math.isfinite(limit) else limit for limit in limits]
    is_whole = all(
        a == b or abs(math.radians(a) - b) <= SINGLE * max(abs(b), 1e-3) for a, b in zip(degrees, limits, strict=True)
    )
    return {"limits_deg": plain_numbers(degrees)} if turns and is_whole else {"limits": plain_numbers(limits)}


def drive_keys(drive: DescribedDrive, damping: float = 0.0) -> Node:
    """Returns the keys of a drive except its targets. `damping`: of the joint, added to that of the drive."""
    keys: Node = {}
    for key, number in (("stiffness", drive.stiffness), ("damping", drive.damping + damping)):
        if number:
            keys[key] = plain_number(number)
    if drive.force_limit is not None and math.isfinite(drive.force_limit):
        keys["force_limit"] = plain_number(drive.force_limit)
    return {**keys, "mode": drive.mode} if drive.mode != "force" else keys


def _states(robot: DescribedRobot, moving: list[int], called: Mapping[int, str]) -> Node:
    """Returns `drives`, `qpos`, `qvel` and `beyond_limits`."""
    drives: dict[str, Node] = {}
    found: dict[str, Any] = {"qpos": {}, "qvel": {}}
    beyond = False
    for number in moving:
        joint = robot.links[number].joint
        assert joint is not None
        low, high = joint.limits or _NO_LIMITS
        default = default_position(joint)
        start = default if joint.qpos is None else joint.qpos
        # A joint that cannot start at 0 would be a warning (SC518).
        if abs(start - default) > _TOLERANCE or (default and joint.mimic is None):
            found["qpos"][called[number]] = plain_number(start)
        if joint.qvel:
            found["qvel"][called[number]] = plain_number(joint.qvel)
        positions = [start]
        if joint.drive is not None:
            target = joint.drive.target
            keys = drive_keys(joint.drive, joint.damping)
            if target is not None and abs(target - start) > _TOLERANCE / 10:
                keys["target"] = plain_number(target)
                positions.append(target)
            if joint.drive.velocity_target:
                keys["velocity_target"] = plain_number(joint.drive.velocity_target)
            drives[called[number]] = keys or {"stiffness": 0.0}
        beyond = beyond or any(not low - _TOLERANCE <= each <= high + _TOLERANCE for each in positions)
    if drives:
        found["drives"] = group_by_pattern(drives, [called[number] for number in moving])
    if beyond:
        found["beyond_limits"] = True
    return {key: value for key, value in found.items() if value}
