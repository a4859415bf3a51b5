"""Joints of an articulation as statements: what the builder of a link is told, and what is set once they are there."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.emit.python.alike import Among, Unit, write_alike
from scenecc.emit.python.columns import number, numbers, pose
from scenecc.emit.python.knobs import given
from scenecc.emit.python.layout import Node, call, list_of, string
from scenecc.plan import constant
from scenecc.plan.articulation import breadth_first_order

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.emit.python.columns import Columns
    from scenecc.emit.python.layout import Source
    from scenecc.plan import ArticulationStructure, Joint, Link, Value

_DRIVE = ("stiffness", "force_limit", "drive_mode")
"""Of a drive, what the builder of a link is not told: it takes a damping."""

_NO_LIMITS = constant([-np.inf, np.inf])
_TARGETS = ("drive_target", "drive_velocity_target")
FEWEST = 3
"""How many joints make a loop that is worth reading."""

JOINT_KNOBS = ("friction", "armature", "max_velocity")
"""Properties of a joint by the plan's names."""


def write_joint_properties(source: Source, joint: Joint, columns: Columns, builder: str) -> None:
    """What the builder of a link is told of its joint."""
    if joint.name:
        source.statement(call(f"{builder}.set_joint_name", string(joint.name)))
    alone = joint.damping is not None and not given(joint, _DRIVE)
    damping = {"damping": columns.value(joint.damping, "damping")} if alone and joint.damping is not None else {}
    limits: Node = "[]" if joint.type == "fixed" else columns.value(joint.limits or _NO_LIMITS, "limits")
    properties = call(
        f"{builder}.set_joint_properties",
        type=string(joint.type),
        limits=limits,
        pose_in_parent=_pose(joint.pose_in_parent, "pose_in_parent", columns),
        pose_in_child=_pose(joint.pose_in_child, "pose_in_child", columns),
        **damping,
    )
    source.statement(properties)


def write_joint_component(source: Source, joint: Joint, columns: Columns) -> None:
    """The same, of the joint of `body`."""
    source.line("joint = body.joint")
    if joint.name:
        source.statement(string(joint.name), assign="joint.name")
    source.statement(string(joint.type), assign="joint.type")
    for name in ("pose_in_child", "pose_in_parent"):
        # As the builder does, also where nothing is said: shapes have moved the frames by a rounding.
        source.statement(_pose(getattr(joint, name), name, columns), assign=f"joint.{name}")
    if joint.type == "fixed":
        return
    source.statement(columns.value(joint.limits or _NO_LIMITS, "limits"), assign="joint.limit")
    if not given(joint, _DRIVE):
        # As the builder does, which leaves no joint without.
        source.statement(_drive(joint, columns))


def _pose(value: Value | None, name: str, columns: Columns) -> Node:
    return call("sapien.Pose") if value is None else columns.value(value, name, pose)


def write_joints(source: Source, structure: ArticulationStructure, columns: Columns) -> None:
    """What no builder is told of the joints of `articulation`."""
    links = [link for link in structure.links if link.joint is not None and link.joint.type != "fixed"]
    things = [(link, _units(link.joint, columns)) for link in links if link.joint is not None]
    named = all(link.joint is not None and link.joint.name for link, units in things if units)
    among: Among[Link] = Among(
        "joint",
        "articulation.active_joints",
        "articulation.find_joint_by_name" if named else "articulation.find_link_by_name",
        (lambda link: link.joint.name if link.joint is not None else "") if named else (lambda link: link.name),
        len(links),
        "" if named else ".joint",
    )
    write_alike(source, things, among)


def _units(joint: Joint, columns: Columns) -> list[Unit]:
    units: list[Unit] = []
    if given(joint, _DRIVE):
        units.append(lambda source: source.statement(_drive(joint, columns)))
    return units + [partial(_write_knob, joint, name, columns) for name in given(joint, JOINT_KNOBS)]


def _drive(joint: Joint, columns: Columns) -> Node:
    arguments: dict[str, Node] = {
        name: "0" if value is None else columns.value(value, name)
        for name, value in (("stiffness", joint.stiffness), ("damping", joint.damping))
    }
    if joint.force_limit is not None:
        arguments["force_limit"] = columns.value(joint.force_limit, "force_limit")
    if joint.drive_mode is not None:
        arguments["mode"] = string(joint.drive_mode)
    return call("joint.set_drive_properties", **arguments)


def _write_knob(joint: Joint, name: str, columns: Columns, source: Source) -> None:
    value: Value = getattr(joint, name)
    if name == "armature":
        # One number a degree of freedom.
        node = columns.value(value, name, lambda row: list_of([number(float(row))]))
    else:
        node = columns.value(value, name)
    source.statement(node, assign=f"joint.{name}")


def engine_order(structure: ArticulationStructure) -> list[Link]:
    """The links whose joints move, in the order of `active_joints`: the engine goes level after level."""
    links = [structure.links[number] for number in breadth_first_order(link.parent for link in structure.links)]
    return [link for link in links if link.joint is not None and link.joint.type != "fixed"]


def write_positions(source: Source, structure: ArticulationStructure, columns: Columns) -> None:
    """Where the joints are at the start, how they move, and what their drives pull them to."""
    joints = [link.joint for link in engine_order(structure) if link.joint is not None]
    if not joints:
        # Until they are told to, SAPIEN leaves the entities of all links but the root at the origin.
        source.line("articulation.root_pose = articulation.root_pose")
        return
    qpos = _together(joints, "qpos", columns)
    targets = {name: _together(joints, name, columns) for name in _TARGETS if _all(joints, name)}
    node = columns.of_block(qpos, "qpos", numbers)
    same = [name for name, rows in targets.items() if rows.tobytes() == qpos.tobytes()]
    if same and not isinstance(node, str):
        source.statement(node, assign="qpos")
        node = "qpos"
    source.statement(node, assign="articulation.qpos")
    if any(joint.qvel is not None for joint in joints):
        source.statement(
            columns.of_block(_together(joints, "qvel", columns), "qvel", numbers), assign="articulation.qvel"
        )
    for name in _TARGETS:
        if name in same:
            _write_targets(source, name, node)
        elif name in targets:
            _write_targets(source, name, columns.of_block(targets[name], name, numbers))
        else:
            _write_some_targets(source, structure, name, columns)


def _write_targets(source: Source, name: str, values: Node) -> None:
    """Targets of all joints, in the engine's order."""
    source.statement(call("zip", "articulation.active_joints", values), assign="targets")
    with source.block("for joint, target in targets:"):
        source.line(f"joint.set_{name}(target)")


def _write_some_targets(source: Source, structure: ArticulationStructure, name: str, columns: Columns) -> None:
    """Targets of the joints that have one, where not all have."""
    links = [link for link in structure.links if link.joint is not None and getattr(link.joint, name) is not None]
    joints = [link.joint for link in links if link.joint is not None]
    named = all(joint.name for joint in joints)
    find = "articulation.find_joint_by_name" if named else "articulation.find_link_by_name"
    names = [string(joint.name if named else link.name) for link, joint in zip(links, joints, strict=True)]
    what = "" if named else ".joint"
    if len(joints) < FEWEST:
        for joint, its in zip(joints, names, strict=True):
            source.line(f"joint = {find}({its}){what}")
            source.statement(call(f"joint.set_{name}", columns.value(getattr(joint, name), name)))
        return
    source.statement(list_of(names), assign="joint_names")
    values = columns.of_block(_together(joints, name, columns), name, numbers)
    source.statement(call("zip", "joint_names", values), assign="targets")
    with source.block("for joint_name, target in targets:"):
        source.line(f"{find}(joint_name){what}.set_{name}(target)")


def _all(joints: list[Joint], name: str) -> bool:
    return all(getattr(joint, name) is not None for joint in joints)


def _together(joints: list[Joint], name: str, columns: Columns) -> NDArray[Any]:
    """(B, dof) of a number of all joints, 0 where nothing is said."""
    values = [getattr(joint, name) for joint in joints]
    nothing = np.zeros(len(columns.rows))
    return np.stack([nothing if value is None else columns.of_rows(value) for value in values], axis=1)
