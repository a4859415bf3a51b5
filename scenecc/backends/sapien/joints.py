"""Joints of an articulation as prepared calls: what SAPIEN's builder sets of one, then what it leaves out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.columns import Column, at, poses, scalars, side_by_side, taken
from scenecc.backends.sapien.engine import physx, sapien
from scenecc.backends.sapien.knobs import Knob, Knobs
from scenecc.backends.sapien.shapes import apply, split

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.backends.sapien.knobs import Step
    from scenecc.plan import Joint, Value

_Joint = physx.PhysxArticulationJoint

NO_LIMITS = (-np.inf, np.inf)
"""What SAPIEN's builder gives a joint of which nothing is said; a fresh joint of the engine cannot move."""

FORCE_LIMIT = float(np.finfo(np.float32).max)
"""SAPIEN's, of a drive of which nothing is said."""


def _single(data: NDArray[Any]) -> Column:
    """float32 arrays of one number, which is how SAPIEN takes what a joint has for each of its degrees of freedom."""
    return list(data.astype(np.float32)[:, None])


def _limits(data: NDArray[Any]) -> Column:
    return list(data.astype(np.float32)[:, None, :])


PARENT_POSE = Knob(_Joint.set_pose_in_parent, "pose_in_parent", poses, None)
CHILD_POSE = Knob(_Joint.set_pose_in_child, "pose_in_child", poses, None)
LIMITS = Knob(_Joint.set_limits, "limits", _limits, None)

JOINT_KNOBS = Knobs(
    {
        "friction": Knob(_Joint.set_friction, "friction", scalars),
        "armature": Knob(_Joint.set_armature, "armature", _single),
        "max_velocity": Knob(_Joint.set_max_velocity, "max_velocity", scalars),
        "drive_target": Knob(_Joint.set_drive_target, "drive_target", scalars),
        "drive_velocity_target": Knob(_Joint.set_drive_velocity_target, "drive_velocity_target", scalars),
    }
)
"""Fields of `Joint` that a user sets once SAPIEN's builder is done, in the order in which they are set."""


class JointSteps:
    """What is called on a link's joint, row by row."""

    __slots__ = ("_child", "_drives", "_knobs", "_limits", "_parent", "name", "type")

    def __init__(self, joint: Joint, rows: NDArray[np.intp]) -> None:
        self.name = joint.name
        self.type = joint.type
        # Set also where nothing is said: shapes have moved the centre of mass by then, in whose frame the engine keeps
        # them, and rounds.
        self._parent = _column(PARENT_POSE, joint.pose_in_parent, rows) or [sapien.Pose()]
        self._child = _column(CHILD_POSE, joint.pose_in_child, rows) or [sapien.Pose()]
        self._limits: Column = []
        self._drives: list[tuple[Any, ...]] = []
        found: list[Step] = []
        if joint.type != "fixed":
            self._limits = _column(LIMITS, joint.limits, rows) or _limits(np.array([NO_LIMITS]))
            self._drives = drives(joint, rows)
            found = JOINT_KNOBS.steps(joint, rows)
        self._knobs = split(found)

    def apply(self, joint: Any, row: int) -> None:
        """Makes the joint of a new link what the plan says, in the order of SAPIEN's builder."""
        joint.set_name(self.name)
        joint.set_type(self.type)
        joint.set_pose_in_child(at(self._child, row))
        joint.set_pose_in_parent(at(self._parent, row))
        if self._limits:
            joint.set_limits(at(self._limits, row))
            joint.set_drive_properties(*at(self._drives, row))
        apply(self._knobs, joint, row)


def drives(joint: Joint, rows: NDArray[np.intp]) -> list[tuple[Any, ...]]:
    """Stiffness, damping, force limit and mode, a row or one for all; SAPIEN's where nothing is said."""
    given = (joint.stiffness, joint.damping, joint.force_limit)
    columns = [
        [default] if value is None else scalars(taken(value, rows))
        for value, default in zip(given, (0.0, 0.0, FORCE_LIMIT), strict=True)
    ]
    return side_by_side([*columns, [joint.drive_mode or "force"]])


def _column(knob: Knob, value: Value | None, rows: NDArray[np.intp]) -> Column:
    return [] if value is None else knob.convert(taken(value, rows))
