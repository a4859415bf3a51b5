"""Constraints between bodies as joints of UsdPhysics; a drive is one of six degrees of freedom, as PhysX has it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.emit.usd.joints import connect
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan import Connection, Distance, Drive, Weld

if TYPE_CHECKING:
    from scenecc.emit.usd.stage import Prim, Stage
    from scenecc.plan import AxisDrive, AxisLimit, Constraint, Value

_FREEDOMS: Final = {
    "x": ("transX",),
    "y": ("transY",),
    "z": ("transZ",),
    "twist": ("rotX",),
    "swing": ("rotY", "rotZ"),
    "slerp": ("rotX", "rotY", "rotZ"),
}
"""An axis of a drive as USD's degrees of freedom."""

_KINDS: Final[dict[type, str]] = {
    Weld: "FixedJoint",
    Connection: "SphericalJoint",
    Distance: "DistanceJoint",
    Drive: "Joint",
}

_NOT_OF_A_DRIVE: Final = ("inv_mass_scales", "inv_inertia_scales")


def write_constraint(stage: Stage, constraint: Constraint, row: int, paths: dict[tuple[str, str | None], str]) -> None:
    """Writes a constraint. `row`: of the scene in its values; `paths`: of entities and links."""
    joint = constraint.joint
    kind = _KINDS.get(type(joint))
    if kind is None:
        stage.lost.leave_out(constraint.name, "a gear", constraint.origin)
        return
    path = stage.path(stage.root, constraint.name)
    made = getattr(stage.physics, kind).Define(stage.stage, path)
    parent = None if constraint.parent is None else paths[constraint.parent.entity, constraint.parent.link]
    in_parent, in_child = (
        IDENTITY_POSE if pose is None else tuple(map(float, pose.row(row)))
        for pose in (constraint.pose_in_parent, constraint.pose_in_child)
    )
    connect(stage, made, parent, paths[constraint.child.entity, constraint.child.link], in_parent, in_child)
    made.CreateExcludeFromArticulationAttr(defaultValue=True)
    made.CreateCollisionEnabledAttr(defaultValue=True)
    if isinstance(joint, Distance):
        low, high = map(float, joint.limits.row(row))
        made.CreateMinDistanceAttr(low)
        if math.isfinite(high):
            made.CreateMaxDistanceAttr(high)
        stage.lost.fields(constraint.name, joint, ("stiffness", "damping"), constraint.origin)
    elif isinstance(joint, Drive):
        _write_drive(stage, made, constraint, joint, row)


def _write_drive(stage: Stage, made: Prim, constraint: Constraint, joint: Drive, row: int) -> None:
    for limit in joint.limits:
        _limit(stage, made, limit, row)
        stage.lost.fields(
            constraint.name, limit, ("stiffness", "damping"), constraint.origin, f" of the limit of {limit.axis}"
        )
    targets = _targets(joint, row)
    if joint.target is not None and not np.allclose(np.abs(joint.target.row(row)[3:]), IDENTITY_POSE[3:], atol=1e-6):
        stage.lost.leave_out(constraint.name, "the rotation of `target`", constraint.origin)
    if joint.angular_velocity_target is not None and joint.angular_velocity_target.row(row).any():
        stage.lost.leave_out(constraint.name, "`angular` of `velocity_target`", constraint.origin)
    for drive in joint.drives:
        for freedom in _FREEDOMS[drive.axis]:
            _drive(stage, made, drive, freedom, row, targets.get(freedom, (0.0, 0.0)))
    stage.lost.fields(constraint.name, joint, _NOT_OF_A_DRIVE, constraint.origin)


def _limit(stage: Stage, made: Prim, limit: AxisLimit, row: int) -> None:
    angular = limit.axis == "twist"
    api = stage.physics.LimitAPI.Apply(made.GetPrim(), _FREEDOMS[limit.axis][0])
    low, high = map(float, limit.limits.row(row))
    if math.isfinite(low):
        api.CreateLowAttr(math.degrees(low) if angular else low)
    if math.isfinite(high):
        api.CreateHighAttr(math.degrees(high) if angular else high)


def _targets(joint: Drive, row: int) -> dict[str, tuple[float, float]]:
    """Position and velocity along each axis that the drive pulls to [m, m/s]."""

    def rows(value: Value | None) -> list[float]:
        return [0.0] * 3 if value is None else [float(number) for number in value.row(row)[:3]]

    along = zip("XYZ", rows(joint.target), rows(joint.linear_velocity_target), strict=True)
    return {f"trans{axis}": (position, speed) for axis, position, speed in along}


def _drive(stage: Stage, made: Prim, drive: AxisDrive, freedom: str, row: int, target: tuple[float, float]) -> None:
    each = math.radians(1) if freedom.startswith("rot") else 1.0
    api = stage.physics.DriveAPI.Apply(made.GetPrim(), freedom)
    api.CreateTypeAttr(drive.mode or "force")
    api.CreateStiffnessAttr(float(drive.stiffness.row(row)) * each)
    api.CreateDampingAttr(float(drive.damping.row(row)) * each)
    api.CreateTargetPositionAttr(target[0])
    api.CreateTargetVelocityAttr(target[1])
    if drive.force_limit is not None and math.isfinite(limit := float(drive.force_limit.row(row))):
        api.CreateMaxForceAttr(limit)
