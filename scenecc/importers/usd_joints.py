"""USD joints: frames and degrees of freedom, as joints of a link tree or as constraints."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import (
    IDENTITY,
    IDENTITY_POSE,
    Vec3,
    compose,
    from_axis_angle,
    invert,
    relative_pose,
    rotate,
    to_vector,
)
from scenecc.importers.numbers import along_x
from scenecc.importers.usd_stage import UNITS
from scenecc.robots.description import DescribedConstraint, DescribedDrive, DriveAxis, LimitAxis, LinkName

if TYPE_CHECKING:
    from scenecc.geometry.rotations import Pose7
    from scenecc.importers.usd_stage import Prim, UsdStage

FREEDOMS: Final = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
"""UsdPhysics's degrees of freedom, in order of application."""

_NO_FORCE_LIMIT: Final = 1e38


@frozen
class Freedom:
    """A degree of freedom of a joint.

    Attributes:
        name: one of `FREEDOMS`.
        limits: lowest and highest position [m or rad].
        drive: None: no drive.
    """

    name: str
    limits: tuple[float, float] = (-math.inf, math.inf)
    drive: DescribedDrive | None = None

    @property
    def turns(self) -> bool:
        """Whether it is a rotation."""
        return self.name.startswith("rot")

    @property
    def axis(self) -> Vec3:
        """Unit vector of the translation or rotation."""
        return UNITS[self.name[-1]]

    def motion(self, position: float) -> Pose7:
        """Returns the child frame's displacement at a position."""
        x, y, z = self.axis
        if self.turns:
            return (0.0, 0.0, 0.0, *from_axis_angle(self.axis, position))
        return (x * position, y * position, z * position, *IDENTITY)

    def negated(self) -> Freedom:
        """Returns the same freedom with reversed sign, as counted from the other body."""
        low, high = self.limits
        drive = self.drive
        if drive is not None:
            drive = replace(drive, target=-(drive.target or 0.0), velocity_target=-drive.velocity_target)
        return Freedom(self.name, (-high, -low), drive)


@dataclass(frozen=True, slots=True)
class UsdJoint:
    """A joint.

    Attributes:
        prim: its prim.
        name: name of the prim.
        bodies: paths of its two bodies; "" is the world.
        frames: the joint's frame in each body.
        start: the second frame in the first at the stage's poses.
        freedoms: its degrees of freedom.
        distance: [min, max] of a distance joint [m].
        collides: whether its bodies collide with each other.
        excluded: whether it is excluded from articulations.
    """

    prim: Prim
    name: str
    bodies: tuple[str, str]
    frames: tuple[Pose7, Pose7]
    start: Pose7
    freedoms: tuple[Freedom, ...]
    distance: tuple[float, float] | None
    collides: bool
    excluded: bool

    def reversed(self) -> UsdJoint:
        """Returns the joint with exchanged bodies. With one freedom, positions keep their sign."""
        first, second = self.frames
        if len(self.freedoms) == 1:
            x, y, z = self.freedoms[0].axis
            half_turn: Pose7 = (0.0, 0.0, 0.0, 0.0, y, z, x)  # about an axis perpendicular to the joint's
            first, second, freedoms = compose(first, half_turn), compose(second, half_turn), self.freedoms
            start = compose(compose(invert(half_turn), invert(self.start)), half_turn)
        else:
            freedoms, start = tuple(each.negated() for each in reversed(self.freedoms)), invert(self.start)
        return replace(
            self,
            bodies=(self.bodies[1], self.bodies[0]),
            frames=(second, first),
            start=start,
            freedoms=freedoms,
        )

    def positions(self) -> tuple[list[float], float, float]:
        """Returns the position of each freedom in the stage, and the remaining offset of the frames [m, rad]."""
        rest, positions = self.start, [0.0] * len(self.freedoms)
        turning = [each.name[-1] for each in self.freedoms if each.turns]
        angles = _angles(rest, turning)
        reached = IDENTITY_POSE
        slides = [each for each in self.freedoms if not each.turns]
        first_turns = bool(self.freedoms) and self.freedoms[0].turns and bool(slides)
        point = invert(rest)[:3] if first_turns else rest[:3]
        for k, freedom in enumerate(self.freedoms):
            if freedom.turns:
                positions[k] = angles[freedom.name[-1]]
            else:
                along = sum(a * b for a, b in zip(point, freedom.axis, strict=True))
                positions[k] = -along if first_turns else along
            reached = compose(reached, freedom.motion(positions[k]))
        off = relative_pose(reached, rest)
        angle = 2 * math.atan2(math.hypot(*off[4:]), abs(off[3]))
        return positions, math.hypot(*off[:3]), angle


def _angles(pose: Pose7, axes: list[str]) -> dict[str, float]:
    """Decomposes a rotation into successive angles about some of x, y and z."""
    if not axes:
        return {}
    w, x, y, z = pose[3:]
    if len(axes) == 1:
        along = {"X": x, "Y": y, "Z": z}[axes[0]]
        return {axes[0]: math.remainder(2 * math.atan2(along, w), 2 * math.pi)}
    columns = [rotate(pose[3:], unit) for unit in UNITS.values()]
    m = [[columns[j][i] for j in range(3)] for i in range(3)]
    i, j = ("XYZ".index(each) for each in axes[:2])
    k = 3 - i - j
    even = 1.0 if (j - i) % 3 == 1 else -1.0
    middle = math.asin(max(-1.0, min(1.0, even * m[i][k])))
    first = math.atan2(-even * m[j][k], m[k][k])
    last = math.atan2(-even * m[i][j], m[i][i])
    found = {axes[0]: first, axes[1]: middle}
    return found if len(axes) == 2 else {**found, axes[2]: last}


class UsdJointReader:
    """Creates joints from UsdPhysics descriptors."""

    def __init__(self, stage: UsdStage, body_poses: dict[str, Pose7]) -> None:
        """`body_poses`: poses of all moving bodies, by path."""
        self._stage = stage
        self._poses = body_poses

    def read(self, parsed: Any, kind: str) -> UsdJoint | None:
        """Returns a joint; None if it has no effect or cannot be built, which is reported as a loss.

        Args:
            parsed: a `JointDesc`.
            kind: its `ObjectType`, such as "RevoluteJoint".
        """
        prim = self._stage.prim(parsed.primPath)
        if not parsed.jointEnabled:
            self._stage.lose("idle-joints", "a disabled joint", prim)
            return None
        ends = [self._resolve_end(prim, k, body) for k, body in ((0, parsed.body0), (1, parsed.body1))]
        bodies = (ends[0][0], ends[1][0])
        if bodies[0] == bodies[1]:
            self._stage.lose("idle-joints", "a joint that does not connect two bodies", prim)
            return None
        freedoms, distance = self._freedoms(parsed, kind)
        if freedoms is None:
            self._stage.lose("joints", f"a joint of type `{prim.GetTypeName()}`", prim)
            return None
        if math.isfinite(parsed.breakForce) and parsed.breakForce < _NO_FORCE_LIMIT:
            self._stage.lose("joint-breaks", "the force at which a joint breaks", prim)
        elif math.isfinite(parsed.breakTorque) and parsed.breakTorque < _NO_FORCE_LIMIT:
            self._stage.lose("joint-breaks", "the torque at which a joint breaks", prim)
        frames = [relative_pose(self._poses[body], world) if body else world for body, world in ends]
        return UsdJoint(
            prim,
            prim.GetName(),
            bodies,
            (frames[0], frames[1]),
            relative_pose(ends[0][1], ends[1][1]),
            freedoms,
            distance,
            bool(parsed.collisionEnabled),
            bool(parsed.excludeFromArticulation),
        )

    def _resolve_end(self, prim: Prim, k: int, body: Any) -> tuple[str, Pose7]:
        """Returns the path of a joint's body ("" for the world), and the joint's frame on that side in the world."""
        stage = self._stage
        targets = prim.GetRelationship(f"physics:body{k}").GetTargets()
        owner = stage.prim(targets[0]) if targets else None
        position = stage.value(prim, f"physics:localPos{k}", (0.0, 0.0, 0.0))
        rotation = stage.value(prim, f"physics:localRot{k}")
        world = stage.frames.frame_in(owner or None, position, rotation)
        path = str(body)
        return (path if path in self._poses else ""), world

    def _freedoms(self, parsed: Any, kind: str) -> tuple[tuple[Freedom, ...] | None, tuple[float, float] | None]:
        match kind:
            case "FixedJoint":
                found = []
            case "RevoluteJoint" | "PrismaticJoint":
                name = ("rot" if kind == "RevoluteJoint" else "trans") + str(parsed.axis)[-1]
                found = [self._freedom(name, parsed.limit, parsed.drive)]
            case "SphericalJoint":
                return self._spherical(parsed), None
            case "DistanceJoint":
                least = max(float(parsed.limit.lower), 0.0) if parsed.minEnabled else 0.0
                most = float(parsed.limit.upper) if parsed.maxEnabled else math.inf
                metres = self._stage.frames.metres
                return tuple(Freedom(name) for name in FREEDOMS), (least * metres, most * metres)
            case "D6Joint":
                limits = {_freedom_name(pair.first): pair.second for pair in parsed.jointLimits}
                drives = {_freedom_name(pair.first): pair.second for pair in parsed.jointDrives}
                if "distance" in limits:
                    return None, None
                found = [self._freedom(name, limits.get(name), drives.get(name)) for name in FREEDOMS]
            case _:
                return None, None
        return tuple(each for each in found if each is not None), None

    def _spherical(self, parsed: Any) -> tuple[Freedom, ...]:
        """Returns three rotations. UsdPhysics limits those perpendicular to the axis symmetrically."""
        axis = str(parsed.axis)[-1]
        across = [each for each in "XYZ" if each != axis]
        cones = dict(zip(across, (parsed.limit.lower, parsed.limit.upper), strict=True)) if parsed.limit.enabled else {}
        found: list[Freedom] = []
        for each in "XYZ":
            cone = math.radians(float(cones.get(each, -1.0)))
            limited = cone >= 0 and math.isfinite(cone)
            found.append(Freedom(f"rot{each}", (-cone, cone) if limited else (-math.inf, math.inf)))
        return tuple(found)

    def _freedom(self, name: str, limit: Any, drive: Any) -> Freedom | None:
        """Returns a freedom; None if it is locked (lower limit above the upper one)."""
        low, high = (-math.inf, math.inf) if limit is None else (float(limit.lower), float(limit.upper))
        if low > high:
            return None
        each = math.radians(1) if name.startswith("rot") else self._stage.frames.metres
        # usd-core represents "no limit" by the largest float32.
        limits = (
            low * each if low > -_NO_FORCE_LIMIT else -math.inf,
            high * each if high < _NO_FORCE_LIMIT else math.inf,
        )
        return Freedom(name, limits, self._drive(name, drive))

    def _drive(self, name: str, drive: Any) -> DescribedDrive | None:
        if drive is None or not drive.enabled or not (drive.stiffness or drive.damping):
            return None
        frames = self._stage.frames
        turns = name.startswith("rot")
        each = math.radians(1) if turns else frames.metres
        # Unit of a force or torque; an acceleration only has the unit of the position.
        force = frames.kilograms * frames.metres * (frames.metres if turns else 1.0)
        gain = 1.0 if drive.acceleration else force
        strength = gain / each if turns else gain / frames.metres
        if drive.acceleration:
            strength = 1 / each if turns else 1.0
        limit = float(drive.forceLimit)
        limit = (
            limit * (gain if turns else (frames.metres if drive.acceleration else gain))
            if limit < _NO_FORCE_LIMIT
            else math.inf
        )
        return DescribedDrive(
            float(drive.stiffness) * strength,
            float(drive.damping) * strength,
            limit,
            float(drive.targetPosition) * each,
            "acceleration" if drive.acceleration else "force",
            float(drive.targetVelocity) * each,
        )


def _freedom_name(dof: Any) -> str:
    """Converts `JointDOF.RotX` to the name in UsdPhysics attributes."""
    name = str(dof).rpartition(".")[2]
    return name[0].lower() + name[1:]


def usd_constraint(
    joint: UsdJoint, parent: LinkName, child: LinkName, stage: UsdStage, *, collide: bool
) -> DescribedConstraint | None:
    """Returns a joint as a constraint between links; None if it constrains nothing, which is reported as a loss."""
    if joint.freedoms:
        _report_lost(joint.prim, stage)
    turn = along_x(joint.freedoms[0].axis) if len(joint.freedoms) == 1 else IDENTITY_POSE
    frames = [compose(frame, turn) for frame in joint.frames]
    ends = joint.name, "weld", parent, child, frames[0], frames[1], stage.place
    made = DescribedConstraint(*ends, collide=collide)
    if joint.distance is not None:
        return replace(made, type="distance", span=joint.distance)
    if not joint.freedoms:
        return made
    if len(joint.freedoms) == 1:
        (only,) = joint.freedoms
        axis: DriveAxis = "twist" if only.turns else "x"
        motor = () if only.drive is None else ((axis, only.drive),)
        span = _twist_limits(only.limits) if only.turns else only.limits
        return replace(made, type="hinge" if only.turns else "slider", span=span, drives=motor)
    free = {each.name: each for each in joint.freedoms}
    limits = _limits_of(free)
    drives: dict[DriveAxis, DescribedDrive] = {
        axis: drive for axis, name in _AXES.items() if name in free and (drive := free[name].drive) is not None
    }
    _add_swing(drives, free, joint, stage)
    if not limits and not drives:
        stage.lose("idle-joints", "a joint without any constraint", joint.prim)
        return None
    if not drives and limits == _BALL_LIMITS:
        return replace(made, type="ball")
    target, velocity = _targets(free)
    rows = tuple(drives.items())
    return replace(made, type="drive", limits=limits, drives=rows, target=target, velocity_target=velocity)


def _report_lost(prim: Prim, stage: UsdStage) -> None:
    """Reports what a constraint cannot hold of a joint."""
    for each in prim.GetAuthoredAttributes():
        name = str(each.GetName())
        found = next(((kind, words) for pattern, kind, words in _ONLY_OF_TREES if pattern.fullmatch(name)), None)
        value = None if found is None else stage.authored(prim, name)
        if found is not None and value and value < NO_SPEED_LIMIT:
            stage.lose(found[0], f"the {found[1]} of a joint that becomes a constraint", prim)


_FRICTIONS: Final = r"physxJoint:jointFriction|physxJointAxis:\w+:dynamicFrictionEffort|mjc:frictionloss"

_ONLY_OF_TREES: Final = (
    (re.compile(_FRICTIONS), "joint-friction", "friction"),
    (re.compile(r"physxJoint:maxJointVelocity"), "joint-limits", "velocity limit"),
    (re.compile(r"physxJoint:armature"), "vendor-attributes", "armature"),
)
"""Attributes of joints that a constraint cannot hold: names, kind of the loss, and words."""

NO_SPEED_LIMIT: Final = 1e6
"""PhysX represents "no limit" by velocities from this on, in the stage's units."""

_AXES: Final[dict[LimitAxis, str]] = {"x": "transX", "y": "transY", "z": "transZ", "twist": "rotX"}
"""Axis of a `drive` that can have limits → its UsdPhysics name."""


_BALL_LIMITS: Final[tuple[tuple[LimitAxis, float, float], ...]] = (("x", 0.0, 0.0), ("y", 0.0, 0.0), ("z", 0.0, 0.0))
"""Limits of a joint that turns freely about all axes."""


def _twist_limits(limits: tuple[float, float]) -> tuple[float, float]:
    """Returns limits of a twist, which PhysX measures from -π to π."""
    low, high = (each if abs(each) < math.pi - 1e-6 else math.copysign(math.inf, each) for each in limits)
    return low, high


def _limits_of(free: dict[str, Freedom]) -> tuple[tuple[LimitAxis, float, float], ...]:
    """Returns the limits of a constraint, axes that are not free at 0."""
    found: list[tuple[LimitAxis, float, float]] = []
    for axis, name in _AXES.items():
        low, high = free[name].limits if name in free else (0.0, 0.0)
        if axis == "twist":
            low, high = _twist_limits((low, high))
        if math.isfinite(low) or math.isfinite(high):
            found.append((axis, low, high))
    return tuple(found)


def _add_swing(
    drives: dict[DriveAxis, DescribedDrive], free: dict[str, Freedom], joint: UsdJoint, stage: UsdStage
) -> None:
    """Adds the drive about y and z. It also holds locked axes, since SAPIEN offers no swing limits."""
    swings = [free[name] for name in ("rotY", "rotZ") if name in free]
    if not swings:
        drives["swing"] = _HOLD
        return
    if len(swings) == 1:
        stage.lose("swing-limits", "a lock about y or z of a joint, which turns freely", joint.prim)
        return
    if any(math.isfinite(limit) for each in swings for limit in each.limits):
        stage.lose("swing-limits", "swing limits of a joint, which turns freely", joint.prim)
    first, second = (None if each.drive is None else _gains(each.drive) for each in swings)
    if first != second:
        stage.lose("swing-limits", "different drives about y and z of a joint", joint.prim)
    elif first is not None and "twist" in drives and _gains(drives["twist"]) == first:
        del drives["twist"]
        drives["slerp"] = first
    elif first is not None:
        drives["swing"] = first


_HOLD: Final = DescribedDrive(1e10, 1e4, mode="acceleration")
"""Spring by which `weld` holds axes that PhysX's limits do not."""


def _gains(drive: DescribedDrive) -> DescribedDrive:
    return replace(drive, target=None, velocity_target=0.0)


def _targets(free: dict[str, Freedom]) -> tuple[Pose7, tuple[Vec3, Vec3] | None]:
    """Returns position and velocity targets of the drives along the axes and about x."""
    drives = {name: each.drive for name, each in free.items() if each.drive is not None}
    x, y, z = (drives[name].target or 0.0 if name in drives else 0.0 for name in FREEDOMS[:3])
    speed = to_vector(drives[name].velocity_target if name in drives else 0.0 for name in FREEDOMS[:3])
    twist = drives.get("rotX")
    angle, spin = (0.0, 0.0) if twist is None else (twist.target or 0.0, twist.velocity_target)
    target: Pose7 = (x, y, z, *from_axis_angle((1.0, 0.0, 0.0), angle))
    return target, (speed, (-spin, 0.0, 0.0)) if any((*speed, spin)) else None  # PhysX turns the other way
