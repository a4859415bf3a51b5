"""Constraints between two bodies, or a body and the world."""

from __future__ import annotations

from dataclasses import field, replace
from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan.articulation import DriveMode
    from scenecc.plan.body import Mount
    from scenecc.plan.value import Value

DriveAxis = Literal["x", "y", "z", "twist", "swing", "slerp"]
LimitAxis = Literal["x", "y", "z", "twist"]


WELD_SWING = (1e10, 1e4)
"""Stiffness and damping of the drive that holds a weld's rotation about y and z, in the mode "acceleration".

A drive's limits hold x, y, z and the twist. SAPIEN stores swing limits but does not apply them. A spring of this
stiffness holds as well for any mass, since PhysX solves it implicitly.
"""


@frozen
class Weld:
    """Holds two frames together: a drive with x, y, z and twist limited to 0, and `WELD_SWING` for the swing."""


@frozen
class Connection:
    """SAPIEN's connection: holds the origins of two frames together and leaves rotation free."""


@frozen
class Distance:
    """Limits the distance between the origins of two frames.

    Attributes:
        limits: (·, 2) [m]. stiffness: (·,) [N/m]. damping: (·,) [N·s/m].
    """

    limits: Value
    stiffness: Value | None = None
    damping: Value | None = None


@frozen
class Gear:
    """Turns the child -ratio times as fast as the parent, each about the x axis of its frame.

    Attributes:
        ratio: (·,) not 0.
        enable_hinges: for two links, whether the ratio also applies to their joint angles, so that errors do not
            accumulate. Does not add hinges.
    """

    ratio: Value
    enable_hinges: bool = False


@frozen
class AxisLimit:
    """Limits of one axis of a drive.

    Attributes:
        limits: (·, 2) [m], of the twist [rad]; infinite on a side without a limit.
        stiffness, damping: (·,) of a spring that replaces the hard stop.
    """

    axis: LimitAxis
    limits: Value
    stiffness: Value | None = None
    damping: Value | None = None


@frozen
class AxisDrive:
    """The drive of one axis.

    Attributes:
        stiffness, damping, force_limit: (·,).
        mode: None: "force".
    """

    axis: DriveAxis
    stiffness: Value
    damping: Value
    force_limit: Value | None = None
    mode: DriveMode | None = None


@frozen
class Drive:
    """PhysX's joint with six degrees of freedom, all free unless limited.

    Attributes:
        limits, drives: one per axis.
        target: (·, 7) pose of the child's frame in the parent's, a reset may change it.
        linear_velocity_target, angular_velocity_target: (·, 3) [m/s, rad/s], a reset may change them.
        inv_mass_scales, inv_inertia_scales: (·, 2) of the parent and the child.
        separate_swing: whether a component of its own, without targets, drives the swing. PhysX rotates the torques of
            the swing by the target, so beyond 0.8 rad they no longer hold an axis.
    """

    limits: tuple[AxisLimit, ...] = ()
    drives: tuple[AxisDrive, ...] = ()
    target: Value | None = None
    linear_velocity_target: Value | None = None
    angular_velocity_target: Value | None = None
    inv_mass_scales: Value | None = None
    inv_inertia_scales: Value | None = None
    separate_swing: bool = False


ConstraintJoint = Weld | Connection | Distance | Gear | Drive


@frozen
class Constraint:
    """One constraint in each of its scenes.

    Attributes:
        name: unique among the constraints of the plan.
        scene_idxs: see `Entity`.
        child: the body that carries it.
        pose_in_parent, pose_in_child: (·, 7) its frame in the parent's (the world's) and in the child's;
            None: the identity.
        parent: None: the world.
        enabled: (·,) bool, initial, a reset may change it; None: enabled.
        collide: whether the two bodies collide with each other, if all constraints between them say so.
    """

    name: str
    scene_idxs: tuple[int, ...]
    joint: ConstraintJoint
    child: Mount
    parent: Mount | None = None
    pose_in_parent: Value | None = None
    pose_in_child: Value | None = None
    enabled: Value | None = None
    collide: bool = False
    origin: Origin | None = field(default=None, compare=False)


def component_joints(joint: ConstraintJoint) -> tuple[ConstraintJoint, ...]:
    """Returns what each of SAPIEN's components of a constraint does: two for a drive with a separate swing."""
    if not (isinstance(joint, Drive) and joint.separate_swing):
        return (joint,)
    swing = tuple(drive for drive in joint.drives if drive.axis == "swing")
    others = tuple(drive for drive in joint.drives if drive.axis != "swing")
    scales = joint.inv_mass_scales, joint.inv_inertia_scales
    return replace(joint, drives=others), Drive((), swing, None, None, None, *scales)


def is_ball(joint: ConstraintJoint) -> bool:
    """Returns whether a joint is the drive that `type: ball` of a scene becomes."""
    if not isinstance(joint, Drive) or replace(joint, limits=(), drives=()) != Drive():
        return False
    held = [each for each in joint.limits if each.axis != "twist"]
    is_locked = all(each.limits.is_constant and not any(each.limits.numbers()) for each in held)
    is_hard = all(each.stiffness is None and each.damping is None for each in joint.limits)
    return len(held) == 3 and is_locked and is_hard and all(each.axis == "slerp" for each in joint.drives)


def colliding_constraints(constraints: Iterable[Constraint]) -> dict[str, frozenset[int]]:
    """Returns where two bodies collide that constraints connect: where all of these that exist have `collide`.

    By the name of the constraint that is the last between both in these scenes.
    """
    found: dict[frozenset[Mount], list[Constraint]] = {}
    for each in constraints:
        if each.parent is not None:
            found.setdefault(frozenset((each.child, each.parent)), []).append(each)
    colliding: dict[str, frozenset[int]] = {}
    for ones in found.values():
        done = frozenset(index for one in ones if not one.collide for index in one.scene_idxs)
        for one in reversed(ones):
            scenes = frozenset(one.scene_idxs) - done
            if scenes:
                colliding[one.name] = scenes
                done |= scenes
    return colliding
