"""The keys of every shape in a list."""

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, Tag
from typing_extensions import TypeAliasType

from scenecc.spec.base import NOTES, Maybe, Model, Text, key
from scenecc.spec.leaf import Fixed, Leaf
from scenecc.spec.material import Color, MaterialRef
from scenecc.spec.pose import Pose
from scenecc.spec.scalars import (
    Finite,
    NonNegative,
    Positive,
    Positive3,
    Vec3,
)
from scenecc.spec.unions import COMPONENTS, NUMBER, by_kind

Scale = TypeAliasType(
    "Scale",
    Leaf[
        Annotated[
            Annotated[Positive, Tag(NUMBER)] | Annotated[Positive3, Tag(COMPONENTS)],
            by_kind("a number or [x, y, z]"),
        ]
    ],
)
"""One number or [x, y, z], positive."""

MirrorScale = TypeAliasType(
    "MirrorScale",
    Leaf[
        Annotated[
            Annotated[Finite, Tag(NUMBER)] | Annotated[Vec3, Tag(COMPONENTS)],
            by_kind("a number or [x, y, z]", nonzero=True),
        ]
    ],
)
"""One number or [x, y, z]; negative mirrors, zero is refused by a check."""


def _repeatable(schema: dict[str, Any]) -> None:
    """Shapes take `repeat`, which expansion takes out before their models see it."""
    schema["patternProperties"] = NOTES
    schema["properties"]["repeat"] = {"x-ref": "Repeat", "description": "As of an entity."}


class ShapeKeys(Model):
    """Keys of every shape."""

    model_config = ConfigDict(json_schema_extra=_repeatable)

    pose: Maybe[Pose] = key("In the body's frame: [x, y, z] or a mapping.")
    material: Maybe[MaterialRef] = key("A name from `materials`, or {physical, visual}.")


class CollisionKeys(ShapeKeys):
    """Keys of shapes that collide."""

    density: Maybe[Leaf[NonNegative]] = key("Density [kg/m³].", default=1000)
    contact_offset: Maybe[Leaf[Positive]] = key("Distance at which contacts begin to be made [m].", default=0.01)
    rest_offset: Maybe[Leaf[Finite]] = key("Distance at which shapes rest, below `contact_offset` [m].", default=0)
    patch_radius: Maybe[Leaf[NonNegative]] = key("Radius of the torsional friction patch [m].", default=0)
    min_patch_radius: Maybe[Leaf[NonNegative]] = key("Smallest radius of the torsional friction patch [m].", default=0)


class VisualKeys(ShapeKeys):
    """Keys of shapes that are seen."""

    name: Maybe[Fixed[Text]] = key("Name of the render shape.")
    front_face: Maybe[Fixed[Literal["counterclockwise", "clockwise"]]] = key(
        "Which side of a triangle is its front.", default="counterclockwise"
    )
    color: Maybe[Color] = key("Base colour; leaves the rest of the material.")


class BothKeys(CollisionKeys, VisualKeys):
    """Keys of shapes that collide and are seen."""


class FileKeys(Model):
    """A mesh file."""

    file: Leaf[Text] = Field(
        description="The mesh: a path from this file's folder, pkg://PACKAGE/PATH or asset://PATH."
    )
