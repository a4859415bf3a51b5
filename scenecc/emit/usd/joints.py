"""Joints of articulations. USD counts angles in degrees, and so the stiffness that works on them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan import ArticulationStructure

if TYPE_CHECKING:
    from scenecc.emit.usd.stage import Prim, Stage
    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredJoint

_NOT_OF_A_JOINT: Final = ("friction", "armature", "max_velocity", "qvel")
_NOT_OF_AN_ARTICULATION: Final = (
    "solver_position_iterations",
    "solver_velocity_iterations",
    "sleep_threshold",
    "linear_velocity",
    "angular_velocity",
)


def write_joints(stage: Stage, entity: MeasuredEntity, above: str, links: list[str]) -> None:
    """The joints of an articulation, whose prim is at `above`. `links`: paths of its links."""
    structure = entity.structure
    assert isinstance(structure, ArticulationStructure)
    name = entity.entity.name
    stage.physics.ArticulationRootAPI.Apply(stage.stage.GetPrimAtPath(above))
    if structure.fix_root_link:
        fixed = stage.physics.FixedJoint.Define(stage.stage, stage.path(above, "fix_root_link"))
        connect(stage, fixed, None, links[0], entity.bodies[0].pose, IDENTITY_POSE)
    for body, link, planned in zip(entity.bodies, links, structure.links, strict=True):
        if body.joint is not None and body.parent is not None and planned.joint is not None:
            _write_joint(stage, body, body.joint, above, (links[body.parent], link))
            of = f" of the joint `{body.joint.name}`" if body.joint.name else " of a joint"
            stage.lost.fields(name, planned.joint, _NOT_OF_A_JOINT, planned.joint.origin or structure.origin, of)
    for mimic in structure.mimics:
        words = f"that `{mimic.joint}` follows `{mimic.source}`"
        stage.lost.leave_out(name, words, mimic.origin or structure.origin)
    stage.lost.fields(name, structure, _NOT_OF_AN_ARTICULATION, structure.origin)


def _write_joint(stage: Stage, body: MeasuredBody, joint: MeasuredJoint, above: str, between: tuple[str, str]) -> None:
    path = stage.path(above, joint.name or f"{body.name}_joint")
    physics = stage.physics
    match joint.type:
        case "fixed":
            made = physics.FixedJoint.Define(stage.stage, path)
        case "prismatic":
            made = physics.PrismaticJoint.Define(stage.stage, path)
        case _:
            made = physics.RevoluteJoint.Define(stage.stage, path)
    connect(stage, made, *between, joint.pose_in_parent, joint.pose_in_child)
    if joint.type == "fixed":
        return
    angular = joint.type != "prismatic"
    made.CreateAxisAttr(stage.geom.Tokens.x)
    low, high = (_angle(limit) if angular else limit for limit in joint.limits)
    if math.isfinite(low):
        made.CreateLowerLimitAttr(low)
    if math.isfinite(high):
        made.CreateUpperLimitAttr(high)
    if joint.stiffness or joint.damping:
        _drive(stage, made, joint, angular=angular)


def _drive(stage: Stage, made: Prim, joint: MeasuredJoint, *, angular: bool) -> None:
    drive = stage.physics.DriveAPI.Apply(made.GetPrim(), "angular" if angular else "linear")
    each = math.radians(1) if angular else 1.0
    drive.CreateTypeAttr(joint.drive_mode)
    drive.CreateStiffnessAttr(joint.stiffness * each)
    drive.CreateDampingAttr(joint.damping * each)
    drive.CreateTargetPositionAttr(joint.drive_target / each)
    drive.CreateTargetVelocityAttr(joint.drive_velocity_target / each)
    if math.isfinite(joint.force_limit):
        drive.CreateMaxForceAttr(joint.force_limit)


def _angle(limit: float) -> float:
    return math.degrees(limit) if math.isfinite(limit) else limit


def connect(
    stage: Stage, made: Prim, parent: str | None, child: str, in_parent: tuple[float, ...], in_child: tuple[float, ...]
) -> None:
    """Puts a joint between two bodies, by their paths. `parent`: None is the world. Frames: p then q (wxyz)."""
    if parent is not None:
        made.CreateBody0Rel().SetTargets([parent])
    made.CreateBody1Rel().SetTargets([child])
    made.CreateLocalPos0Attr(stage.vec3(in_parent[:3]))
    made.CreateLocalRot0Attr(stage.quat(in_parent))
    made.CreateLocalPos1Attr(stage.vec3(in_child[:3]))
    made.CreateLocalRot1Attr(stage.quat(in_child))
