"""Poses and named frames."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, Field, Strict, Tag
from typing_extensions import TypeAliasType

from scenecc.spec.base import WHOLE, EntityName, Finite, Maybe, SpecModel, Vec3, Vec4, key
from scenecc.spec.nodes import COMPONENTS, MAPPING, WORD, LazyType, union_by_kind
from scenecc.spec.values import ExpressionOnly, Fixed, Leaf

AxisName = Literal["x", "y", "z"]


Direction = Annotated[
    Annotated[Vec3, Tag(COMPONENTS)] | Annotated[AxisName, Tag(WORD)], union_by_kind("[x, y, z] or one of x, y, z")
]


class AxisAngle(SpecModel):
    """A rotation about one axis."""

    axis: Leaf[Direction] = Field(description="[x, y, z] (of any length) or one of x, y, z.")
    angle: Maybe[Leaf[Finite]] = key("Angle [rad]; this or `angle_deg`.")
    angle_deg: Maybe[Leaf[Finite]] = key("Angle [degrees]; this or `angle`.", excludes=("angle",))


WholeAxisAngle = Annotated[AxisAngle, WHOLE]

Matrix = Annotated[tuple[Vec4, Vec4, Vec4, Vec4], Strict(strict=False)]


def _read_random_rotation(_word: str) -> Any:
    from scenecc.variation.forms import RandomRotation

    return RandomRotation()


Quaternion = Annotated[
    Annotated[Vec4, Tag(COMPONENTS)] | Annotated[Literal["uniform"], AfterValidator(_read_random_rotation), Tag(WORD)],
    union_by_kind("[w, x, y, z], or `uniform`"),
]


ROTATIONS = ("q", "rpy", "rpy_deg", "axis_angle", "look_at")


class PoseMapping(SpecModel):
    """A position and at most one rotation, or a matrix."""

    p: Maybe[Leaf[Vec3]] = key("Position [m].", default=[0, 0, 0])
    q: Maybe[ExpressionOnly[Quaternion]] = key(
        "Rotation as a unit quaternion [w, x, y, z], or `uniform`: a uniformly random rotation.",
        default=[1, 0, 0, 0],
        excludes=ROTATIONS,
    )
    rpy: Maybe[Leaf[Vec3]] = key("Rotation about the fixed axes x, y, z: roll, pitch, yaw [rad].", excludes=ROTATIONS)
    rpy_deg: Maybe[Leaf[Vec3]] = key(
        "Rotation about the fixed axes x, y, z: roll, pitch, yaw [degrees].", excludes=ROTATIONS
    )
    axis_angle: Maybe[WholeAxisAngle] = key("Rotation about one axis.", excludes=ROTATIONS)
    look_at: Maybe[Leaf[Vec3]] = key(
        "Point in the frame of the pose that +x points to; +z points up as far as possible (SAPIEN's camera) [m].",
        excludes=ROTATIONS,
    )
    matrix: Maybe[ExpressionOnly[Matrix]] = key(
        "A rigid 4×4 transformation, row by row; excludes the other keys.", excludes=("p", "anchor", *ROTATIONS)
    )
    anchor: Maybe[Fixed[Literal["bottom", "center", "top"]]] = key(
        "The point of an entity's bounds that is at `p`, instead of its origin."
    )
    relative_to: Maybe[Fixed[EntityName]] = key(
        "The entity, ENTITY/LINK, frame or camera that this pose is relative to."
    )


if TYPE_CHECKING:
    _LazyPoseMapping = PoseMapping
else:
    _LazyPoseMapping = Annotated[Any, LazyType("scenecc.spec.pose", "PoseMapping")]

Pose = TypeAliasType(
    "Pose",
    Leaf[
        Annotated[
            Annotated[Vec3, Tag(COMPONENTS)] | Annotated[_LazyPoseMapping, Tag(MAPPING)],
            union_by_kind("[x, y, z] or a mapping with p, q, rpy, …"),
        ]
    ],
)
"""[x, y, z] or a mapping."""


if TYPE_CHECKING:
    from scenecc.spec.placing import PlaceSpec, Region
else:
    PlaceSpec = Annotated[Any, LazyType("scenecc.spec.placing", "PlaceSpec")]
    Region = Annotated[Any, LazyType("scenecc.spec.placing", "Region")]


class FrameSpec(SpecModel):
    """A named pose without a body, for `relative_to`."""

    pose: Pose = Field(description="Pose in the world, or in the frame of `relative_to`: [x, y, z] or a mapping.")
    region: Maybe[Region] = key("Region in the axes of this frame, for `place` of bodies.")
    place: Maybe[PlaceSpec] = key("For instances only.")
