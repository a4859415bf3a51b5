"""Poses: where something is, and how it is turned."""

from typing import Annotated, Literal

from pydantic import Field, Strict, Tag
from typing_extensions import TypeAliasType

from scenecc.spec.base import Finite, Maybe, Model, Name, Vec3, Vec4, key
from scenecc.spec.unions import by_kind

AxisName = Literal["x", "y", "z"]


Direction = Annotated[
    Annotated[Vec3, Tag("#list")] | Annotated[AxisName, Tag("#word")], by_kind("[x, y, z] or one of x, y, z")
]


class AxisAngle(Model):
    """A turn about one axis."""

    axis: Direction = Field(description="[x, y, z] (of any length) or one of x, y, z.")
    angle: Maybe[Finite] = key("Angle [rad]; this or `angle_deg`.")
    angle_deg: Maybe[Finite] = key("Angle [degrees]; this or `angle`.")


Row = Annotated[tuple[Finite, Finite, Finite, Finite], Strict(strict=False)]


class PoseMapping(Model):
    """A position and at most one rotation, or a matrix alone."""

    p: Maybe[Vec3] = key("Position [m].", default=[0, 0, 0])
    q: Maybe[Vec4] = key("Rotation as a unit quaternion [w, x, y, z].", default=[1, 0, 0, 0])
    rpy: Maybe[Vec3] = key("Rotation about the fixed axes x, y, z: roll, pitch, yaw [rad].")
    rpy_deg: Maybe[Vec3] = key("Rotation about the fixed axes x, y, z: roll, pitch, yaw [degrees].")
    axis_angle: Maybe[AxisAngle] = key("Rotation about one axis.")
    look_at: Maybe[Vec3] = key(
        "A point in the frame of the pose that +x points to, +z as far up as it goes (SAPIEN's camera) [m]."
    )
    matrix: Maybe[Annotated[tuple[Row, Row, Row, Row], Strict(strict=False)]] = key(
        "A rigid 4×4 transformation, row by row; stands alone."
    )
    relative_to: Maybe[Name] = key("The entity, frame or camera in whose frame this pose stands.")


Pose = TypeAliasType(
    "Pose",
    Annotated[
        Annotated[Vec3, Tag("#list")] | Annotated[PoseMapping, Tag("#mapping")],
        by_kind("[x, y, z] or a mapping with p, q, rpy, …"),
    ],
)
"""[x, y, z] or a mapping."""
