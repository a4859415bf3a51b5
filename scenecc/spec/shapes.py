"""Keys that all shapes share, and the unions of shapes by type.

`shapes` become a collision and a visual shape, `collisions` only collide, `visuals` are only visible.
"""

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, Tag
from typing_extensions import TypeAliasType

from scenecc.plan.properties import DEFAULT_DENSITY
from scenecc.spec.base import NOTE_SCHEMA, Finite, Maybe, NonNegative, Positive, Positive3, SpecModel, Text, Vec3, key
from scenecc.spec.material import Color, MaterialRef
from scenecc.spec.nodes import COMPONENTS, NUMBER, LazyUnion, union_by_kind
from scenecc.spec.pose import Pose
from scenecc.spec.repetition import REPEATABLE
from scenecc.spec.values import Fixed, Leaf

Scale = TypeAliasType(
    "Scale",
    Leaf[
        Annotated[
            Annotated[Positive, Tag(NUMBER)] | Annotated[Positive3, Tag(COMPONENTS)],
            union_by_kind("a number or [x, y, z]"),
        ]
    ],
)
"""One number or [x, y, z], positive."""

MirrorScale = TypeAliasType(
    "MirrorScale",
    Leaf[
        Annotated[
            Annotated[Finite, Tag(NUMBER)] | Annotated[Vec3, Tag(COMPONENTS)],
            union_by_kind("a number or [x, y, z]", nonzero=True),
        ]
    ],
)
"""One number or [x, y, z]; negative mirrors, zero is refused by a check."""


def _allow_repeat(schema: dict[str, Any]) -> None:
    """Shapes take `repeat`, which expansion takes out before their models see it."""
    schema["patternProperties"] = NOTE_SCHEMA
    schema["properties"]["repeat"] = {"x-ref": "Repeat", "description": "As of an entity."}


class ShapeKeys(SpecModel):
    """Keys of every shape."""

    model_config = ConfigDict(json_schema_extra=_allow_repeat)

    pose: Maybe[Pose] = key("In the body's frame: [x, y, z] or a mapping.")
    material: Maybe[MaterialRef] = key("A name from `materials`, or {physical, visual}.")


class CollisionKeys(ShapeKeys):
    """Keys of shapes that collide."""

    density: Maybe[Leaf[NonNegative]] = key("Density [kg/m³].", default=DEFAULT_DENSITY)
    contact_offset: Maybe[Leaf[Positive]] = key("Distance at which contacts are generated [m].", default=0.01)
    rest_offset: Maybe[Leaf[Finite]] = key("Distance at which shapes rest, below `contact_offset` [m].", default=0)
    patch_radius: Maybe[Leaf[NonNegative]] = key("Radius of the torsional friction patch [m].", default=0)
    min_patch_radius: Maybe[Leaf[NonNegative]] = key("Smallest radius of the torsional friction patch [m].", default=0)


class VisualKeys(ShapeKeys):
    """Keys of shapes that are seen."""

    name: Maybe[Fixed[Text]] = key("Name of the render shape.")
    front_face: Maybe[Fixed[Literal["counterclockwise", "clockwise"]]] = key(
        "Which side of a triangle is its front.", default="counterclockwise"
    )
    color: Maybe[Color] = key("Base colour, replacing that of the material.")


class ShapeBothKeys(CollisionKeys, VisualKeys):
    """Keys of shapes that collide and are seen."""


class MeshFileKeys(SpecModel):
    """A mesh file."""

    file: Leaf[Text] = Field(
        description="The mesh: a path from this file's folder, pkg://PACKAGE/PATH or asset://PATH."
    )


_PRIMITIVES = ("box", "sphere", "capsule", "cylinder", "cone", "ring", "plane", "heightfield")
_COLLIDING = {"primitive_shapes": _PRIMITIVES, "mesh_shapes": ("convex_mesh", "convex_parts", "triangle_mesh")}
_VISIBLE = {"primitive_shapes": (*_PRIMITIVES, "tiled_plane"), "mesh_shapes": ("convex_mesh", "mesh")}

CollisionSpec = Annotated[Any, LazyUnion("Collision", _COLLIDING), REPEATABLE]
VisualSpec = Annotated[Any, LazyUnion("Visual", _VISIBLE), REPEATABLE]
ShapeSpec = Annotated[Any, LazyUnion("Shape", _COLLIDING), REPEATABLE]
