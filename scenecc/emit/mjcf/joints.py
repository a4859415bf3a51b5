"""Joints of articulations and the actuators that are their drives."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from scenecc.emit.mjcf.model import Start
from scenecc.emit.xml import frames

if TYPE_CHECKING:
    from scenecc.emit.mjcf.model import Model
    from scenecc.emit.xml.elements import Element
    from scenecc.plan.snapshot import MeasuredEntity, MeasuredJoint

FAR: Final = 1e10
"""Where MuJoCo, whose ranges have two ends, has the end that a joint has not [m, rad]."""

_STRONG: Final = 1e38
"""A limit of force above which there is none."""


def write_joint(model: Model, measured: MeasuredEntity, number: int, element: Element) -> None:
    """The joint by which link `number` hangs on its parent; nothing for a fixed one."""
    body = measured.bodies[number]
    joint = body.joint
    if joint is None or joint.type == "fixed":
        return
    entity = measured.entity.name
    name = model.name("joint", f"{entity}/{joint.name or body.name}")
    if joint.name:
        model.joints[entity, joint.name] = name
    made = element.add(
        "joint",
        name=name,
        type="slide" if joint.type == "prismatic" else "hinge",
        pos=joint.pose_in_child[:3],
        axis=frames.turn(joint.pose_in_child, (1.0, 0.0, 0.0)),
        ref=joint.qpos or None,
        range=_range(joint),
        armature=joint.armature or None,
        damping=joint.damping if is_damped(joint) and joint.damping else None,
        frictionloss=None if joint.joint.friction is None else joint.friction or None,
    )
    model.starts[id(made)] = Start((joint.qpos,), (joint.qvel,))
    low, high = joint.limits
    if low == high:
        # A range has two ends.
        hold = low - joint.qpos
        model.sections["equality"].add("joint", joint1=name, polycoef=(hold, 0, 0, 0, 0))
    _write_drive(model, entity, name, joint)
    _tell(model, entity, joint)


def _range(joint: MeasuredJoint) -> tuple[float, float] | None:
    low, high = joint.limits
    if low == high or (math.isinf(low) and math.isinf(high)):
        return None
    return max(low, -FAR), min(high, FAR)


def is_damped(joint: MeasuredJoint) -> bool:
    """Whether its drive does nothing but slow it down, which is the damping of a joint."""
    plain = joint.drive_mode == "force" and joint.force_limit >= _STRONG
    return plain and joint.stiffness == 0 and joint.drive_velocity_target == 0


def _write_drive(model: Model, entity: str, name: str, joint: MeasuredJoint) -> None:
    """An actuator that pulls as the drive does: stiffness · (control - position) - damping · velocity."""
    if is_damped(joint) or (joint.stiffness == 0 and joint.damping == 0):
        return
    if joint.drive_mode == "acceleration":
        model.lost.leave_out(entity, "the drive of a joint in the mode `acceleration`", joint.joint.origin)
        return
    strength = joint.stiffness or joint.damping
    wanted = joint.stiffness * joint.drive_target + joint.damping * joint.drive_velocity_target
    limit = joint.force_limit
    model.sections["actuator"].add(
        "general",
        name=model.name("actuator", name),
        joint=name,
        gainprm=(strength,),
        biastype="affine",
        biasprm=(0, -joint.stiffness, -joint.damping),
        forcerange=None if limit >= _STRONG else (-limit, limit),
    )
    model.controls.append(wanted / strength)


def _tell(model: Model, entity: str, joint: MeasuredJoint) -> None:
    lost, plan = model.lost, joint.joint
    lost.fields(entity, plan, ("max_velocity",), plan.origin, " of a joint")
    if plan.friction is not None and joint.friction:
        words = "`friction` of a joint is written as `frictionloss`, a force; PhysX's grows with the joint's load"
        lost.change(entity, words, plan.origin)
