"""Joints of drafts to joints of the plan, with all that is said of them, of their drives, and where they start."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.lower.articulations.maps import said
from scenecc.lower.articulations.written_limits import doubt_limits, limits_fit
from scenecc.lower.kinds import number
from scenecc.plan import literal
from scenecc.plan.articulation import Joint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.lower.articulations.draft import DraftJoint, Layer
    from scenecc.lower.articulations.limits import Targets
    from scenecc.lower.articulations.said import Said
    from scenecc.plan import Value

_OF_JOINTS = ("friction", "armature", "max_velocity")
_KINDS = {key: number(key) for key in (*_OF_JOINTS, "stiffness", "damping", "force_limit")}
_TARGET, _VELOCITY = number("drive_target"), number("drive_velocity_target")


def with_said(joint: DraftJoint, layers: Sequence[Layer], values: Said) -> DraftJoint:
    """A joint with what `joints` says of it."""
    if not joint.moves or not layers:
        return joint
    changed: dict[str, Any] = {
        key: found for key in _OF_JOINTS if (found := values.value(layers, key, _KINDS[key])) is not None
    }
    limits = said(layers, "limits", "limits_deg")
    if limits is not None:
        keys, origin = limits
        limits_fit(keys, joint.type, origin, values.leaves.sink)
        doubt_limits(keys, joint.type, origin, values.leaves.sink)
        changed["limits"] = values.limits(limits)
        changed["limits_origin"] = origin.child("limits" if keys.limits_deg is None else "limits_deg")
    return replace(joint, **changed) if changed else joint


def joint_of(
    joint: DraftJoint,
    drives: Sequence[Layer],
    start: tuple[Value | None, Value | None],
    values: Said,
    targets: Targets,
) -> Joint:
    """A joint of the plan.

    Args:
        joint: with what is said of it.
        drives: what is said of its drive.
        start: its position and velocity at the start; None: nothing is said, so that they are 0.
        values: of the articulation.
        targets: judge where the drive pulls to.
    """
    qpos, qvel = start
    if not joint.moves:
        return Joint("fixed", joint.name, joint.pose_in_parent, joint.pose_in_child, origin=joint.origin)
    made = Joint(
        type=joint.type,
        name=joint.name,
        pose_in_parent=joint.pose_in_parent,
        pose_in_child=joint.pose_in_child,
        limits=joint.limits,
        friction=joint.friction,
        armature=joint.armature,
        max_velocity=joint.max_velocity,
        damping=joint.damping,
        qpos=qpos,
        qvel=qvel,
        origin=joint.origin,
        limits_origin=joint.limits_origin,
    )
    if not drives:
        return made
    aimed, target = said(drives, "target"), None
    if aimed is not None:
        target = values.of(aimed, "target", _TARGET, reset=True)
        targets.judge(joint, target, aimed[1].child("target"))
    mode = said(drives, "mode")
    force_limit = values.value(drives, "force_limit", _KINDS["force_limit"])
    return replace(
        made,
        stiffness=values.value(drives, "stiffness", _KINDS["stiffness"]) or literal(0.0),
        damping=values.value(drives, "damping", _KINDS["damping"]) or literal(0.0),
        force_limit=joint.effort if force_limit is None else force_limit,
        drive_mode=None if mode is None else mode[0].mode,
        drive_target=qpos if target is None else target,
        drive_velocity_target=values.value(drives, "velocity_target", _VELOCITY, reset=True),
    )
