"""Placement of an entity: the keys of `place`. Imported on first use."""

from typing import Annotated, Any, Literal

from pydantic import Field, Strict, Tag, model_validator

from scenecc.plan.placement import APART, GAP, TRIES
from scenecc.spec.base import (
    MAPPING_KEY,
    VALUE_NAME,
    EntityName,
    Finite,
    FrameName,
    Maybe,
    NonNegative,
    Positive,
    SpecModel,
    Vec3,
    custom_error,
    key,
)
from scenecc.spec.nodes import COMPONENTS, LIST, MAPPING, WORD, is_mapping, is_sequence, union_by_kind
from scenecc.spec.pose import Quaternion, WholeAxisAngle
from scenecc.spec.values import ExpressionOnly, Fixed, Leaf

Vec2 = Annotated[tuple[Finite, Finite], Strict(strict=False)]

Corner = Annotated[list[Finite], Field(min_length=2, max_length=3)]
"""[x, y] or [x, y, z]."""


class DiskRegion(SpecModel):
    """A disk for the origin of the placed entity."""

    center: Leaf[Vec2] = Field(description="[x, y] [m].")
    radius: Leaf[Positive] = Field(description="[m].")

    @model_validator(mode="before")
    @classmethod
    def _is_no_rectangle(cls, data: Any) -> Any:
        if not data or not is_mapping(data) or not data.keys() <= {"x", "y", "min", "max", "low", "high"}:
            return data
        from scenecc.spec.key_hints import flow

        low, high = (data.get(one, data.get(other)) for one, other in (("min", "low"), ("max", "high")))
        sides = [data.get("x"), data.get("y")]
        if all(is_sequence(side) and len(side) == 2 for side in sides):
            low, high = zip(*sides, strict=True)
        corners = flow([[*low], [*high]]) if is_sequence(low) and is_sequence(high) else "[[x, y], [x, y]]"
        message = f"{VALUE_NAME} must be two corners, {{center, radius}} or the name of a frame with `region`"
        raise custom_error("SC103", message, hint=f"write two corners: `region: {corners}`")


Region = Annotated[
    Annotated[list[Leaf[Corner]], Field(min_length=2, max_length=2), Tag(LIST)]
    | Annotated[DiskRegion, Tag(MAPPING)]
    | Annotated[FrameName, Tag(WORD)],
    union_by_kind("[[x, y], [x, y]], {center, radius} or the name of a frame with `region`"),
]
"""Two corners, a disk, or the name of a frame."""

Distances = Annotated[tuple[NonNegative, NonNegative], Strict(strict=False)]


TARGETS = ("on", "inside", "above")

TURNS = ("yaw", "yaw_deg", "facing", "q", "rpy", "rpy_deg", "axis_angle")


class NextToSpec(SpecModel):
    """Puts an entity next to another by their bounding boxes, without a draw."""

    of: Fixed[EntityName] = Field(description="ENTITY or ENTITY/LINK.")
    side: Fixed[Literal["front", "back", "left", "right"]] = Field(
        description="Its side: `front` is +x of the axes, `back` -x, `left` +y, `right` -y."
    )
    gap: Fixed[NonNegative] = Field(default=GAP, description="Distance between the two bounding boxes [m].")


class PlaceSpec(SpecModel):
    """Places an entity by random tries so that it overlaps nothing."""

    on: Maybe[Fixed[EntityName]] = key("ENTITY or ENTITY/LINK that it is placed on.", excludes=TARGETS)
    inside: Maybe[Fixed[EntityName]] = key("ENTITY or ENTITY/LINK that it is placed in.", excludes=TARGETS)
    above: Maybe[Fixed[EntityName]] = key("ENTITY or ENTITY/LINK that it starts above, in the air.", excludes=TARGETS)
    at: Maybe[Leaf[Vec2]] = key("Position of its origin: [x, y] [m].")
    region: Maybe[Region] = key(
        "Region of its origin: two corners, a disk or the name of a frame with a region [m]. Default: the top.",
        examples=[[[-0.3, -0.2], [0.3, 0.2]], {"center": [0, 0], "radius": 0.2}],
        excludes=("at",),
    )
    next_to: Maybe[NextToSpec] = key(
        "Position of its origin: beside another entity.",
        examples=[{"of": "box_1", "side": "left", "gap": 0.02}],
        excludes=("at", "region", "facing"),
    )
    align: Maybe[Fixed[Literal["min", "center", "max"]]] = key(
        "With `next_to`: which ends of the two bounding boxes, along the side, are level. Default: center."
    )
    relative_to: Maybe[Fixed[EntityName]] = key(
        "Object whose axes are used, rotated only by its heading. Default: the target."
    )
    yaw: Maybe[Leaf[Finite]] = key("Rotation about z [rad].", excludes=TURNS)
    yaw_deg: Maybe[Leaf[Finite]] = key("Rotation about z [degrees].", examples=[{"uniform": [0, 360]}], excludes=TURNS)
    q: Maybe[ExpressionOnly[Quaternion]] = key(
        "Rotation as a unit quaternion [w, x, y, z], or `uniform`.", excludes=TURNS
    )
    rpy: Maybe[Leaf[Vec3]] = key("Rotation about the fixed axes x, y, z [rad].", excludes=TURNS)
    rpy_deg: Maybe[Leaf[Vec3]] = key("Rotation about the fixed axes x, y, z [degrees].", excludes=TURNS)
    axis_angle: Maybe[WholeAxisAngle] = key("Rotation about one axis.", excludes=TURNS)
    facing: Maybe[
        Annotated[
            Annotated[Leaf[Vec2], Tag(COMPONENTS)] | Annotated[EntityName, Tag(WORD)],
            union_by_kind("[x, y] or the name of an entity"),
        ]
    ] = key("What its +x points to, by a rotation about z: an entity, or a point [x, y] [m].", excludes=TURNS)
    near: dict[Annotated[EntityName, MAPPING_KEY], Fixed[Distances]] = Field(
        default_factory=dict,
        description="Entity → minimum and maximum distance between the collision shapes [m].",
        examples=[{"mug": [0.05, 0.15]}],
    )
    apart: Fixed[NonNegative] = Field(default=APART, description="Minimum distance from every other body [m].")
    gap: Fixed[NonNegative] = Field(default=GAP, description="Distance between its lowest point and the surface [m].")
    height: Maybe[Leaf[Vec2]] = key("With `above`: minimum and maximum height above the target's top [m].")
    tries: Fixed[Annotated[int, Field(ge=1, le=10_000)]] = Field(
        default=TRIES, description="Number of tries in each scene."
    )
