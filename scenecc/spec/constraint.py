"""The section `constraints`: SAPIEN's joints between two bodies, or a body and the world."""

from typing import Annotated, Any, Literal, get_args

from pydantic import Field, Strict

from scenecc.plan.articulation import DriveMode
from scenecc.plan.constraint import DriveAxis, LimitAxis
from scenecc.spec.base import BodyName, ExtendedFloat, Finite, Maybe, NonNegative, NonNegative2, SpecModel, Vec3, key
from scenecc.spec.body import SceneIdxs
from scenecc.spec.nodes import LazyUnion
from scenecc.spec.pose import Direction, Pose
from scenecc.spec.repetition import REPEATABLE, RepeatKeys
from scenecc.spec.values import Fixed, Leaf

LIMIT_AXES: tuple[LimitAxis, ...] = get_args(LimitAxis)

DRIVE_AXES: tuple[DriveAxis, ...] = get_args(DriveAxis)

AxisRange = Annotated[tuple[ExtendedFloat, ExtendedFloat], Strict(strict=False)]


class ConstraintKeys(RepeatKeys):
    """Keys of every constraint."""

    parent: Fixed[BodyName] = Field(
        description="ENTITY, ENTITY/LINK or `world`: the parent body.", examples=["world", "robot/hand"]
    )
    child: Fixed[BodyName] = Field(description="ENTITY or ENTITY/LINK: the child body.", examples=["cube"])
    pose_in_parent: Maybe[Pose] = key(
        "Frame of the constraint in the parent's frame; default: the initial pose of the child's frame."
    )
    pose_in_child: Maybe[Pose] = key("Frame of the constraint in the child's frame.", default=[0, 0, 0])
    enabled: Maybe[Leaf[bool]] = key(
        "Whether it acts at the start; `batch.constraints[NAME].enabled` changes that.", default=True
    )
    collide: Maybe[Fixed[bool]] = key(
        "Whether both bodies collide with each other, which a constraint otherwise prevents.",
        default=False,
    )
    scene_idxs: Maybe[SceneIdxs] = key(
        'The scenes it exists in: indices, a slice such as "0:8", or a list of both. Default: those with both bodies.'
    )


class WeldConstraint(ConstraintKeys):
    """Holds both frames together: a drive whose six axes are all locked."""

    type: Literal["weld"]


class ConnectionConstraint(ConstraintKeys):
    """Holds the origins of both frames together; rotation is free: `Scene.create_connection`."""

    type: Literal["connection"]


class DistanceConstraint(ConstraintKeys):
    """Keeps the distance of the origins of both frames within limits: `sapien.physx.PhysxDistanceJointComponent`."""

    type: Literal["distance"]
    limits: Leaf[NonNegative2] = Field(description="[least, most] [m].")
    stiffness: Maybe[Leaf[NonNegative]] = key("Stiffness of the limits; 0: hard limits [N/m].", default=0)
    damping: Maybe[Leaf[NonNegative]] = key("Damping of the limits [N·s/m].", default=0)


class GearConstraint(ConstraintKeys):
    """Couples the rotations of two bodies about the x axes of its frames: `sapien.physx.PhysxGearComponent`."""

    type: Literal["gear"]
    ratio: Leaf[Finite] = Field(description="The child makes −`ratio` turns per turn of the parent; not 0.")
    enable_hinges: Maybe[Fixed[bool]] = key("Whether it also adds SAPIEN's hinges.", default=False)


class SpringKeys(SpecModel):
    """A spring instead of a hard stop."""

    stiffness: Maybe[Leaf[NonNegative]] = key("Stiffness beyond the limit [N/m; N·m/rad].", default=0)
    damping: Maybe[Leaf[NonNegative]] = key("Damping beyond the limit [N·s/m; N·m·s/rad].", default=0)


class AxisDriveKeys(SpringKeys):
    """The drive of an axis."""

    stiffness: Maybe[Leaf[NonNegative]] = key("Stiffness: force per position error [N/m; N·m/rad].", default=0)
    damping: Maybe[Leaf[NonNegative]] = key("Damping: force per velocity error [N·s/m; N·m·s/rad].", default=0)
    force_limit: Maybe[Leaf[NonNegative]] = key("Maximum force [N or N·m]. Default: none.")
    mode: Maybe[Fixed[DriveMode]] = key(
        "Whether stiffness and damping scale a force or an acceleration.", default="force"
    )


class VelocityTarget(SpecModel):
    """Target velocity of the child's frame in the parent's frame."""

    linear: Maybe[Leaf[Vec3]] = key("[m/s]", default=[0, 0, 0])
    angular: Maybe[Leaf[Vec3]] = key("[rad/s]", default=[0, 0, 0])


class AxisLimits(SpecModel):
    """Limits of each axis: [lowest, highest], `-.inf` and `.inf` for no limit."""

    x: Maybe[Leaf[AxisRange]] = key("Along x of the parent's frame [m].")
    y: Maybe[Leaf[AxisRange]] = key("Along y [m].")
    z: Maybe[Leaf[AxisRange]] = key("Along z [m].")
    twist: Maybe[Leaf[AxisRange]] = key("About x [rad].")


class AxisSprings(SpecModel):
    """Springs of limits."""

    x: Maybe[SpringKeys] = key("Of the limits along x.")
    y: Maybe[SpringKeys] = key("Of the limits along y.")
    z: Maybe[SpringKeys] = key("Of the limits along z.")
    twist: Maybe[SpringKeys] = key("Of the limits of the rotation about x.")


class AxisDrives(SpecModel):
    """Drives of axes."""

    x: Maybe[AxisDriveKeys] = key("Along x of the parent's frame.")
    y: Maybe[AxisDriveKeys] = key("Along y.")
    z: Maybe[AxisDriveKeys] = key("Along z.")
    twist: Maybe[AxisDriveKeys] = key("About x.")
    swing: Maybe[AxisDriveKeys] = key("About y and z.")
    slerp: Maybe[AxisDriveKeys] = key(
        "Drive of the whole rotation along the shortest path; instead of `twist` and `swing`."
    )


class DriveConstraint(ConstraintKeys):
    """A joint of six degrees of freedom, all free unless limited: `Scene.create_drive`."""

    type: Literal["drive"]
    limits: Maybe[AxisLimits] = key("Limits of the axes; an axis without limits is free.", examples=[{"x": [0, 0]}])
    limit_springs: Maybe[AxisSprings] = key("Soft limits of the same axes.")
    drive: Maybe[AxisDrives] = key("Drives of the axes.", examples=[{"x": {"stiffness": 100, "damping": 10}}])
    target: Maybe[Pose] = key(
        "Target pose of the child's frame in the parent's frame; default: identity.", default=[0, 0, 0]
    )
    velocity_target: Maybe[VelocityTarget] = key("Target velocity.")
    inv_mass_scales: Maybe[Leaf[NonNegative2]] = key(
        "Factors of the inverse masses of parent and child for this constraint.", default=[1, 1]
    )
    inv_inertia_scales: Maybe[Leaf[NonNegative2]] = key("Factors of their inverse inertias.", default=[1, 1])


class AxisMotorKeys(AxisDriveKeys):
    """The drive of the one axis of a hinge or a slider."""

    target: Maybe[Leaf[Finite]] = key("Target position [rad or m].", default=0)
    velocity_target: Maybe[Leaf[Finite]] = key("Target velocity [rad/s or m/s].", default=0)


class AxisKeys(ConstraintKeys):
    """Keys of a constraint with one axis."""

    axis: Maybe[Leaf[Direction]] = key(
        "Axis in the child's frame, or in the frame `pose_in_child`: [x, y, z] or one of x, y, z.", default="x"
    )


class HingeConstraint(AxisKeys):
    """Leaves one rotation free, about its axis: a drive whose other axes are locked."""

    type: Literal["hinge"]
    limits: Maybe[Leaf[AxisRange]] = key(
        "Lowest and highest angle about the axis [rad]. Default: no limits.", examples=[[0, 1.57]]
    )
    limits_deg: Maybe[Leaf[AxisRange]] = key("The same in degrees.", examples=[[0, 90]], excludes=("limits",))
    drive: Maybe[AxisMotorKeys] = key("Its drive.", examples=[{"stiffness": 10, "damping": 1}])


class SliderConstraint(AxisKeys):
    """Leaves one translation free, along its axis: a drive whose other axes are locked."""

    type: Literal["slider"]
    limits: Maybe[Leaf[AxisRange]] = key(
        "Lowest and highest position along the axis [m]. Default: no limits.", examples=[[0, 0.3]]
    )
    drive: Maybe[AxisMotorKeys] = key("Its drive.", examples=[{"stiffness": 100, "damping": 10}])


class BallConstraint(ConstraintKeys):
    """Holds the origins of both frames together and leaves all rotations free: a drive with x, y and z locked."""

    type: Literal["ball"]
    limits: Maybe[Leaf[AxisRange]] = key(
        "Lowest and highest twist about x of its frames [rad]. Default: no limits.", examples=[[-0.5, 0.5]]
    )
    limits_deg: Maybe[Leaf[AxisRange]] = key("The same in degrees.", examples=[[-30, 30]], excludes=("limits",))
    drive: Maybe[AxisDriveKeys] = key(
        "Drive of the whole rotation: `stiffness` makes the frames parallel, `damping` slows the rotation.",
        examples=[{"damping": 0.001}],
    )


CONSTRAINT_TYPES = ("weld", "ball", "connection", "distance", "gear", "drive", "hinge", "slider")

Constraint = Annotated[Any, LazyUnion("Constraint", {"constraint": CONSTRAINT_TYPES}), REPEATABLE]
"""An entry of `constraints`."""
