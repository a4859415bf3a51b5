"""One entity as a robot: its links and its joints."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from scenecc.emit.urdf.origins import origin
from scenecc.emit.urdf.shapes import write_collisions, write_visuals
from scenecc.emit.xml import frames
from scenecc.emit.xml.names import Names
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7
from scenecc.plan import ArticulationStructure

if TYPE_CHECKING:
    from scenecc.emit.xml.elements import Element
    from scenecc.emit.xml.lost import Lost
    from scenecc.emit.xml.meshes import Beside
    from scenecc.meshes import Drawer, Look
    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredJoint

FAR: Final = 1e10
"""Where a limit is written that the joint has not, of a kind that URDF has two of, or asks for."""

_STRONG: Final = 1e38
"""A limit of force or of velocity above which there is none."""

_OF_A_BODY: Final = (
    "disable_gravity",
    "locked_motion_axes",
    "linear_velocity",
    "angular_velocity",
    "linear_damping",
    "angular_damping",
    "max_linear_velocity",
    "max_angular_velocity",
    "max_depenetration_velocity",
    "max_contact_impulse",
    "sleep_threshold",
    "solver_position_iterations",
    "solver_velocity_iterations",
    "collision_groups",
    "shading_mode",
)
_OF_AN_ARTICULATION: Final = (
    "solver_position_iterations",
    "solver_velocity_iterations",
    "sleep_threshold",
    "linear_velocity",
    "angular_velocity",
)


@dataclass(slots=True)
class Robot:
    """A robot on its way into a file.

    Attributes:
        moved: how the frame of each link in the file is moved from the link's own, in that.
        joints: the name of each link's joint.
        looks: names of materials.
    """

    measured: MeasuredEntity
    root: Element
    drawer: Drawer
    beside: Beside
    lost: Lost
    moved: list[Pose7] = field(default_factory=list["Pose7"])
    looks: dict[Look, str] = field(default_factory=dict["Look", str])
    joints: dict[int, str] = field(default_factory=dict[int, str])

    @property
    def name(self) -> str:
        """The entity's."""
        return self.measured.entity.name


def write_robot(robot: Robot) -> None:
    """All links, then all joints. Raises MeshProblem."""
    measured = robot.measured
    if measured.entity.hidden:
        robot.lost.leave_out(robot.name, "that only people see it", measured.entity.origin)
    robot.moved = [_moved(robot, body) for body in measured.bodies]
    robot.joints = _joint_names(measured)
    for number, body in enumerate(measured.bodies):
        _write_link(robot, number, body)
    if isinstance(measured.structure, ArticulationStructure):
        robot.lost.fields(robot.name, measured.structure, _OF_AN_ARTICULATION, measured.structure.origin)
        for number, body in enumerate(measured.bodies):
            if body.joint is not None:
                _write_joint(robot, number, body.joint)


def _joint_names(measured: MeasuredEntity) -> dict[int, str]:
    """The name of each link's joint by the link's number: its own, or one that no joint has."""
    joints = {number: body.joint.name for number, body in enumerate(measured.bodies) if body.joint is not None}
    names = Names(*joints.values())
    return {number: name or names.new(f"{measured.bodies[number].name}_joint") for number, name in joints.items()}


def _moved(robot: Robot, body: MeasuredBody) -> Pose7:
    """A link that turns has its frame on its joint's axis in a URDF."""
    joint = body.joint
    if joint is None or joint.type in {"fixed", "prismatic"} or joint.pose_in_child[:3] == IDENTITY_POSE[:3]:
        return IDENTITY_POSE
    robot.lost.change(robot.name, f"the frame of the link `{body.name}` is at its joint", joint.joint.origin)
    return (*joint.pose_in_child[:3], *IDENTITY_POSE[3:])


def _write_link(robot: Robot, number: int, body: MeasuredBody) -> None:
    link = robot.root.add("link", name=body.name)
    back = frames.inverse(robot.moved[number])
    if body.mass is not None:
        inertial = link.add("inertial")
        origin(inertial, frames.compose(back, body.mass.com))
        inertial.add("mass", value=body.mass.mass)
        x, y, z = body.mass.inertia
        inertial.add("inertia", ixx=x, ixy=0, ixz=0, iyy=y, iyz=0, izz=z)
    write_visuals(robot, body, back, link)
    write_collisions(robot, body, back, link)
    robot.lost.fields(robot.name, body.body, _OF_A_BODY, body.body.origin)


def _write_joint(robot: Robot, number: int, joint: MeasuredJoint) -> None:
    body = robot.measured.bodies[number]
    assert body.parent is not None  # of every link with a joint
    element = robot.root.add("joint", name=robot.joints[number], type=_type(joint))
    parent_back = frames.inverse(robot.moved[body.parent])
    at = frames.compose(parent_back, frames.compose(joint.pose_in_parent, frames.inverse(joint.pose_in_child)))
    origin(element, frames.compose(at, robot.moved[number]))
    element.add("parent", link=robot.measured.bodies[body.parent].name)
    element.add("child", link=body.name)
    if joint.type == "fixed":
        return
    element.add("axis", xyz=frames.turn(joint.pose_in_child, (1.0, 0.0, 0.0)))
    _write_limit(robot, element, joint)
    damping = joint.damping if _is_damped(joint) else 0.0
    friction = 0.0 if joint.joint.friction is None else joint.friction
    if damping or friction:
        element.add("dynamics", damping=damping, friction=friction)
    _write_mimic(robot, element, joint)
    _tell(robot, joint)


def _type(joint: MeasuredJoint) -> str:
    if joint.type in {"fixed", "prismatic"}:
        return joint.type
    return "continuous" if all(map(math.isinf, joint.limits)) else "revolute"


def _write_limit(robot: Robot, element: Element, joint: MeasuredJoint) -> None:
    low, high = joint.limits
    endless = element.attributes["type"] == "continuous"
    if not endless and (math.isinf(low) or math.isinf(high)):
        words = f"a side on which a joint has no limit has {FAR:g}"
        robot.lost.change(robot.name, words, joint.joint.origin)
    element.add(
        "limit",
        lower=None if endless else max(low, -FAR),
        upper=None if endless else min(high, FAR),
        effort=FAR if joint.force_limit >= _STRONG else joint.force_limit,
        velocity=FAR if joint.max_velocity >= _STRONG else joint.max_velocity,
    )


def _write_mimic(robot: Robot, element: Element, joint: MeasuredJoint) -> None:
    structure, row = robot.measured.structure, robot.measured.row
    assert isinstance(structure, ArticulationStructure)
    for mimic in structure.mimics:
        if mimic.joint == joint.name:
            multiplier, offset = float(mimic.multiplier.row(row)), float(mimic.offset.row(row))
            element.add("mimic", joint=mimic.source, multiplier=multiplier, offset=offset)


def _is_damped(joint: MeasuredJoint) -> bool:
    """Whether its drive does nothing but slow it down, which is the damping of a joint."""
    return joint.drive_mode == "force" and joint.stiffness == 0 and joint.drive_velocity_target == 0


def _tell(robot: Robot, joint: MeasuredJoint) -> None:
    lost, name, place = robot.lost, robot.name, joint.joint.origin
    if not _is_damped(joint) and (joint.stiffness or joint.damping):
        lost.leave_out(name, "the drive of a joint, but for its `force_limit`", place)
    if joint.armature:
        lost.leave_out(name, "`armature` of a joint", place)
    structure = robot.measured.structure
    follows = isinstance(structure, ArticulationStructure) and joint.name in {each.joint for each in structure.mimics}
    if joint.joint.qpos is not None and joint.qpos and not follows:
        lost.leave_out(name, "`qpos` of a joint", place)
    if joint.joint.qvel is not None and joint.qvel:
        lost.leave_out(name, "`qvel` of a joint", place)
    if joint.joint.friction is not None and joint.friction:
        words = "`friction` of a joint is a force in URDF; PhysX's grows with the joint's load"
        lost.change(name, words, place)
