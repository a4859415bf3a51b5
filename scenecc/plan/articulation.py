"""Articulations: links in a tree and the joints between them. None means that nothing was said, as everywhere."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Final, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.diagnostics import Origin
    from scenecc.plan.body import BodyStructure
    from scenecc.plan.value import Value


JointType = Literal["fixed", "revolute", "revolute_unwrapped", "prismatic"]
"""SAPIEN's. A URDF's `continuous` is a `revolute` without limits, as SAPIEN's own loader has it."""

DriveMode = Literal["force", "acceleration"]

MAX_LINKS = 255
"""Of an articulation on the CPU, where PhysX counts links in eight bits: with 257 it counts none."""

VELOCITY_FIELDS = ("linear_velocity", "angular_velocity")
"""Fields of a body and of an articulation, of which a reset sets what they say anew."""

JOINT_STATE_FIELDS = ("qpos", "qvel", "drive_target", "drive_velocity_target")
"""Fields of a joint, likewise."""


@frozen
class Joint:
    """The joint between a link and its parent. Positions are [m] of a prismatic one and [rad] of others.

    Attributes:
        type: of the degree of freedom, which a fixed joint has not; what only that has is None there.
        name: unique in the articulation where it is not "".
        pose_in_parent, pose_in_child: (·, 7) its frame in the parent's and in the child's; it moves along or about x.
        limits: (·, 2) lowest and highest position; infinite on a side that has none.
        friction, armature, max_velocity: (·,).
        stiffness, damping, force_limit: (·,) of the drive; a joint with damping alone has a drive of no stiffness.
        drive_mode: what the drive's numbers are of; None: "force".
        qpos, qvel: (·,) at the start.
        drive_target, drive_velocity_target: (·,) where to and how fast the drive pulls at the start.
        limits_origin: where its limits are written, where that is a place of their own.
    """

    type: JointType
    name: str = ""
    pose_in_parent: Value | None = None
    pose_in_child: Value | None = None
    limits: Value | None = None
    friction: Value | None = None
    armature: Value | None = None
    max_velocity: Value | None = None
    stiffness: Value | None = None
    damping: Value | None = None
    force_limit: Value | None = None
    drive_mode: DriveMode | None = None
    qpos: Value | None = None
    qvel: Value | None = None
    drive_target: Value | None = None
    drive_velocity_target: Value | None = None
    origin: Origin | None = field(default=None, compare=False)
    limits_origin: Origin | None = field(default=None, compare=False)


@frozen
class Link:
    """One body of an articulation.

    Attributes:
        name: unique in the articulation.
        body: of type "link". Its velocities, its locked axes, its solver's iterations and its sleep threshold are
            None: the articulation has these, or nothing has.
        parent: number of the link that it hangs on, which stands before it; None: it is the root.
        joint: to the parent; None at the root alone.
    """

    name: str
    body: BodyStructure
    parent: int | None = None
    joint: Joint | None = None


@frozen
class Mimic:
    """A joint that moves as another does: its position is multiplier · (the other's) + offset.

    Attributes:
        joint, source: names of the two joints, neither fixed.
        multiplier: not 0. offset: [m] or [rad].
    """

    joint: str
    source: str
    multiplier: Value
    offset: Value
    origin: Origin | None = field(default=None, compare=False)


@frozen
class ArticulationStructure:
    """Links in a tree, and what is said of all of them.

    Attributes:
        links: in the order in which they are built, the root first.
        fix_root_link: whether the root is fixed to the world.
        mimics: joints that follow others.
        solver_position_iterations, solver_velocity_iterations: (·,) integers.
        sleep_threshold: (·,) [m²/s²].
        linear_velocity, angular_velocity: (·, 3) of the root at the start, world frame [m/s, rad/s]; of a free one.
        file: index into `ScenePlan.files` of the description that it was read from; None: it is the scene's own.
    """

    links: tuple[Link, ...]
    fix_root_link: bool = False
    mimics: tuple[Mimic, ...] = ()
    solver_position_iterations: Value | None = None
    solver_velocity_iterations: Value | None = None
    sleep_threshold: Value | None = None
    linear_velocity: Value | None = None
    angular_velocity: Value | None = None
    file: Value | None = None
    origin: Origin | None = field(default=None, compare=False)

    @property
    def bodies(self) -> tuple[BodyStructure, ...]:
        """The bodies that it is made of, in build order."""
        return tuple(link.body for link in self.links)

    @property
    def active_joints(self) -> tuple[Joint, ...]:
        """The joints that move, in build order of their links (SAPIEN's own order may be another)."""
        return tuple(link.joint for link in self.links if link.joint is not None and link.joint.type != "fixed")


def breadth_first_order(parents: Iterable[int | None]) -> list[int]:
    """Numbers of links in the engine's order, in which it numbers joints too: by distance from the root, then as built.

    Args:
        parents: of each link the number of the one that it hangs on; the first is the root.
    """
    children: dict[int, list[int]] = {}
    for number, parent in enumerate(parents):
        if parent is not None:
            children.setdefault(parent, []).append(number)
    order = [0]
    for number in order:
        order += children.get(number, ())
    return order


NON_LINK_FIELDS: Final = (
    "linear_velocity",
    "angular_velocity",
    "locked_motion_axes",
    "sleep_threshold",
    "solver_position_iterations",
    "solver_velocity_iterations",
)

MOVING_JOINT_FIELDS: Final = (
    "limits",
    "friction",
    "armature",
    "max_velocity",
    "stiffness",
    "damping",
    "force_limit",
    "drive_mode",
    "qpos",
    "qvel",
    "drive_target",
    "drive_velocity_target",
)
