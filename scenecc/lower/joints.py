"""What holds the two frames of a constraint together, as written to that of the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.lower.kinds import Kind, number, vector
from scenecc.lower.placing.shape_poses import local_pose
from scenecc.plan import AxisDrive, AxisLimit, Connection, Distance, Drive, Gear, Value, Weld, literal
from scenecc.spec.constraint_types import (
    DRIVE_AXES,
    LIMIT_AXES,
    ConnectionConstraint,
    DistanceConstraint,
    DriveConstraint,
    GearConstraint,
    WeldConstraint,
)

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.lower.leaves import Leaves

    Joint = Weld | Connection | Distance | Gear | Drive

_DISTANCES = Kind((2,), quantity="Distance.limits", fallback=(0.0, 0.0))
_LIMITS = Kind((2,), quantity="limits", fallback=(0.0, 0.0))
_RATIO = Kind(quantity="ratio", fallback=1.0)
_STIFFNESS, _DAMPING, _FORCE = number("stiffness"), number("damping"), number("force_limit")
_VELOCITY = vector(3, "")
_SCALES = vector(2, "inv_mass_scales")


def lower_joint(written: Any, leaves: Leaves, origin: Origin) -> Joint:
    """What holds the frames together.

    Args:
        written: the constraint.
        leaves: of it.
        origin: of it.
    """
    match written:
        case WeldConstraint():
            return Weld()
        case ConnectionConstraint():
            return Connection()
        case DistanceConstraint():
            return Distance(
                limits=leaves.value(written.limits, _DISTANCES, origin, "limits"),
                stiffness=leaves.given(written.stiffness, _STIFFNESS, origin, "stiffness"),
                damping=leaves.given(written.damping, _DAMPING, origin, "damping"),
            )
        case GearConstraint():
            ratio = leaves.value(written.ratio, _RATIO, origin, "ratio")
            return Gear(ratio, enable_hinges=bool(written.enable_hinges))
        case _:
            return _drive(written, leaves, origin)


def _drive(written: DriveConstraint, leaves: Leaves, origin: Origin) -> Drive:
    target = None
    if written.target is not None:
        target = local_pose(written.target, origin, ("target",), "the target of a drive", leaves, reset=True)
    velocity: Any = written.velocity_target
    linear, angular = (
        None
        if velocity is None
        else leaves.given(getattr(velocity, key), _VELOCITY, origin, "velocity_target", key, reset=True)
        for key in ("linear", "angular")
    )
    return Drive(
        limits=_limits(written, leaves, origin),
        drives=_drives(written, leaves, origin),
        target=target,
        linear_velocity_target=linear,
        angular_velocity_target=angular,
        inv_mass_scales=leaves.given(written.inv_mass_scales, _SCALES, origin, "inv_mass_scales"),
        inv_inertia_scales=leaves.given(written.inv_inertia_scales, _SCALES, origin, "inv_inertia_scales"),
    )


def _limits(written: DriveConstraint, leaves: Leaves, origin: Origin) -> tuple[AxisLimit, ...]:
    found: list[AxisLimit] = []
    for axis in LIMIT_AXES:
        limits = None if written.limits is None else getattr(written.limits, axis)
        spring: Any = None if written.limit_springs is None else getattr(written.limit_springs, axis)
        if limits is None:
            if spring is not None:
                message = f"a spring of the limits of `{axis}` does nothing: the axis has no limits"
                place = origin.child("limit_springs", axis)
                leaves.sink.report("SC115", message, place, at="key", hint=f"write `{axis}` under `limits` too")
            continue
        stiffness, damping = None, None
        if spring is not None:
            at = ("limit_springs", axis)
            stiffness = leaves.given(spring.stiffness, _STIFFNESS, origin, *at, "stiffness")
            damping = leaves.given(spring.damping, _DAMPING, origin, *at, "damping")
        found.append(AxisLimit(axis, leaves.value(limits, _LIMITS, origin, "limits", axis), stiffness, damping))
    return tuple(found)


def _drives(written: DriveConstraint, leaves: Leaves, origin: Origin) -> tuple[AxisDrive, ...]:
    found: list[AxisDrive] = []
    for axis in DRIVE_AXES:
        drive: Any = None if written.drive is None else getattr(written.drive, axis)
        if drive is None:
            continue
        at = ("drive", axis)
        stiffness = leaves.given(drive.stiffness, _STIFFNESS, origin, *at, "stiffness")
        damping = leaves.given(drive.damping, _DAMPING, origin, *at, "damping")
        force_limit = leaves.given(drive.force_limit, _FORCE, origin, *at, "force_limit")
        found.append(AxisDrive(axis, _or_0(stiffness), _or_0(damping), force_limit, drive.mode))
    return tuple(found)


def _or_0(value: Value | None) -> Value:
    return literal(0.0) if value is None else value
