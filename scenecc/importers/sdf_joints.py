"""SDF joints as joints of a link tree or as constraints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from scenecc.geometry.rotations import IDENTITY, Pose7, Vec3, compose, relative_pose, rotate
from scenecc.importers.numbers import HOLD, along_x, joint_frames, plain_number, plain_numbers, plain_pose
from scenecc.importers.sdf_files import SMALLEST, SourceElement, find_element
from scenecc.plan.articulation import LIGHT_DAMPING

if TYPE_CHECKING:
    from scenecc.importers.sdf_scopes import Scope

Node = dict[str, Any]

_UNLIMITED: Final = 1e15
"""SDF writes "no limit" as 1e16."""

_AXES_OF: Final = {
    "fixed": (),
    "revolute": ("axis",),
    "continuous": ("axis",),
    "prismatic": ("axis",),
    "screw": ("axis",),
    "universal": ("axis", "axis2"),
    "revolute2": ("axis", "axis2"),
    "ball": ("x", "y", "z"),
}
"""Joint type → axes of its hinges."""


@dataclass(frozen=True, slots=True)
class SdfJoint:
    """A joint between two links, or between a link and the world.

    Attributes:
        scope: the scope that contains it.
        element: the <joint>.
        path: from the top model.
        type: a key of `_AXES_OF`.
        parent, child: paths of links from the top model; "" is the world.
        pose: of its frame in the top model's frame.
        turn: pose of the scope's frame in the top model's frame.
    """

    scope: Scope
    element: SourceElement
    path: str
    type: str
    parent: str
    child: str
    pose: Pose7
    turn: Pose7


@dataclass(frozen=True, slots=True)
class Hinge:
    """A degree of freedom.

    Attributes:
        type: joint type in a link tree.
        axis: in the joint's frame, from the parent to the child.
        keys: limits, damping and so on.
        velocity: velocity limit; None: not in the file.
        drive: drive of a spring; None: no spring.
    """

    type: str
    axis: Vec3
    keys: Node
    velocity: float | None = None
    drive: Node | None = None


def joint_type(element: SourceElement) -> str:
    """Returns the type of a <joint>; "" if unsupported."""
    kind = element.attributes.get("type", "")
    return kind if kind in _AXES_OF else ""


def hinges_of(joint: SdfJoint) -> list[Hinge]:
    """Returns the degrees of freedom of a joint, in series."""
    file = joint.scope.file
    if joint.type == "ball":
        file.lose("ball-joints", f"the ball joint `{joint.path}` becomes three hinges", joint.element)
        return [Hinge("continuous", axis, {}) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
    if joint.type == "screw":
        file.lose("screw-joints", f"the screw joint `{joint.path}` turns without moving along its axis", joint.element)
    return [_hinge(joint, tag) for tag in _AXES_OF[joint.type]]


def _hinge(joint: SdfJoint, tag: str) -> Hinge:
    file, axis = joint.scope.file, joint.element.find(tag)
    xyz = file.vector(axis, "xyz", default=(0, 0, 1))
    if math.hypot(*xyz) < SMALLEST:
        file.error(f"the axis of `{joint.path}` has length 0", joint.element)
        xyz = (0.0, 0.0, 1.0)
    kind = "prismatic" if joint.type == "prismatic" else "revolute"
    low = file.number(axis, "limit", "lower", default=-math.inf)
    high = file.number(axis, "limit", "upper", default=math.inf)
    limits = [-math.inf if low < -_UNLIMITED else low, math.inf if high > _UNLIMITED else high]
    keys: Node = {}
    if joint.type == "continuous" or (limits == [-math.inf, math.inf] and kind == "revolute"):
        kind = "continuous"
    elif limits[0] > limits[1]:
        file.error(f"the lower limit of `{joint.path}` is above the upper one", joint.element)
    elif limits != [-math.inf, math.inf]:
        keys["limits"] = plain_numbers(limits)
    keys["friction"] = 0
    damping = max(file.number(axis, "dynamics", "damping", default=0), 0.0)
    friction = min(file.number(axis, "dynamics", "friction", default=0), _UNLIMITED)
    if 0 <= file.number(axis, "limit", "effort", default=-1) < _UNLIMITED:
        file.lose("effort-limits", f"the effort of `{joint.path}`; the joint has no drive", joint.element)
    stiffness = file.number(axis, "dynamics", "spring_stiffness", default=0)
    drive = None
    if stiffness > 0:
        target = file.number(axis, "dynamics", "spring_reference", default=0)
        drive = {"stiffness": plain_number(stiffness), "damping": plain_number(damping), "target": plain_number(target)}
    elif damping > LIGHT_DAMPING * friction:
        keys["damping"] = plain_number(damping)
    elif friction > 0:
        keys["friction_force"] = plain_number(friction)
        if damping:
            file.lose("joint-friction", f"the damping {damping:g} of `{joint.path}`, which has friction", joint.element)
    if friction > 0 and "friction_force" not in keys:
        words = f"the friction {friction:g} of `{joint.path}`, which has a spring or a damping"
        file.lose("joint-friction", words, joint.element)
    velocity = file.number(axis, "limit", "velocity", default=-1)
    if velocity <= 0 or velocity > _UNLIMITED:
        velocity = None
    return Hinge(kind, _axis_in_joint(joint, axis, xyz), keys, velocity, drive)


def _axis_in_joint(joint: SdfJoint, axis: SourceElement | None, xyz: Vec3) -> Vec3:
    element = find_element(axis, "xyz")
    frame = "" if element is None else element.attributes.get("expressed_in", "")
    is_model = joint.scope.file.flag(axis, "use_parent_model_frame", default=False) or joint.scope.file.is_before(1, 5)
    if frame and element is not None:
        around = compose(joint.turn, joint.scope.pose_of(frame, element))
    elif is_model:
        around = joint.turn
    else:
        return xyz
    local = relative_pose(joint.pose, around)
    if max(abs(a - b) for a, b in zip(local[3:], IDENTITY, strict=True)) < 1e-12:
        return xyz
    return rotate(local[3:], xyz)


def mimic_of(joint: SdfJoint, names: dict[str, str]) -> Node | None:
    """Returns the `mimic` of a joint. `names`: path of a joint → its name in the scene."""
    mimic = find_element(joint.element, "axis", "mimic")
    if mimic is None:
        return None
    file, wanted = joint.scope.file, mimic.attributes.get("joint", "")
    prefix = joint.path.rpartition("::")[0]
    source = names.get(f"{prefix}::{wanted}" if prefix else wanted)
    if source is None:
        file.error(f"`{joint.path}` mimics `{wanted[:80]}`, but there is no such joint", mimic)
        return None
    multiplier = file.number(mimic, "multiplier", default=1)
    offset = file.number(mimic, "offset", default=0) - multiplier * file.number(mimic, "reference", default=0)
    found: Node = {"joint": source, "multiplier": plain_number(multiplier)}
    return {**found, "offset": plain_number(offset)} if offset else found


def sdf_tree_joint(name: str, hinge: Hinge | None, poses: tuple[Pose7, Pose7, Pose7], *, is_reversed: bool) -> Node:
    """Returns a joint of a link tree.

    Args:
        name: name in the scene.
        hinge: None: a fixed joint.
        poses: of the parent link, the child link and the joint in one frame.
        is_reversed: whether the tree's parent is the joint's child.
    """
    parent, child, joint = poses
    made: Node = {"name": name, "type": "fixed" if hinge is None else hinge.type}
    in_parent, in_child = relative_pose(parent, joint), relative_pose(child, joint)
    if hinge is None:
        return {**made, **joint_frames(in_parent, in_child, None)}
    axis = hinge.axis if not is_reversed else (-hinge.axis[0], -hinge.axis[1], -hinge.axis[2])
    return {**made, **joint_frames(in_parent, in_child, axis), **hinge.keys}


def make_constraint(joint: SdfJoint, ends: tuple[str, str], poses: tuple[Pose7, Pose7], hinges: list[Hinge]) -> Node:
    """Returns a joint that closes a loop, as a constraint.

    Args:
        joint: the joint.
        ends: parent and child in the scene.
        poses: of both, in the frame of the joint's pose.
        hinges: of the joint.
    """
    frame = compose(joint.pose, along_x(hinges[0].axis)) if len(hinges) == 1 else joint.pose
    in_parent, in_child = (plain_pose(relative_pose(pose, frame)) for pose in poses)
    made: Node = {"parent": ends[0], "child": ends[1], "pose_in_parent": in_parent, "pose_in_child": in_child}
    locked = {"x": [0, 0], "y": [0, 0], "z": [0, 0]}
    if not hinges:
        return {"type": "weld", **made}
    if joint.type == "ball":
        return {"type": "drive", **made, "limits": locked}
    if len(hinges) > 1:
        joint.scope.file.lose("loops", f"the {joint.type} joint `{joint.path}` closes a loop", joint.element)
    if any("friction_force" in hinge.keys for hinge in hinges):
        joint.scope.file.lose("joint-friction", f"the friction of `{joint.path}`, which closes a loop", joint.element)
    span = hinges[0].keys.get("limits", [-math.inf, math.inf])
    if hinges[0].type == "prismatic":
        limits = {"x": span, "y": [0, 0], "z": [0, 0], "twist": [0, 0]}
    else:
        inside = [min(max(each, -math.pi), math.pi) for each in span]
        limits = {**locked, **({} if inside == [-math.pi, math.pi] else {"twist": plain_numbers(inside)})}
    return {"type": "drive", **made, "limits": limits, "drive": {"swing": HOLD}}
