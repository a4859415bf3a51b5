"""Materials, the common keys of shapes, and the unions of shapes by type.

`shapes` become a collision and a visual shape, `collisions` only collide, `visuals` are only visible.
"""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import ConfigDict, Field, Strict, StringConstraints, Tag
from typing_extensions import TypeAliasType

from scenecc.plan import properties
from scenecc.spec.base import (
    NOTE_SCHEMA,
    WHOLE,
    Finite,
    ImageName,
    Maybe,
    NameRole,
    NonNegative,
    OuterName,
    Positive,
    Positive3,
    SpecModel,
    Text,
    Unit,
    Vec3,
    key,
)
from scenecc.spec.nodes import COMPONENTS, MAPPING, NUMBER, WORD, LazyType, LazyUnion, union_by_kind
from scenecc.spec.pose import Pose
from scenecc.spec.repetition import REPEATABLE
from scenecc.spec.values import Fixed, Leaf
from scenecc.variation.conversions import COLOR_TEXT

ColorText = Annotated[str, StringConstraints(pattern=COLOR_TEXT)]

ColorList = Annotated[list[Unit], Field(min_length=3, max_length=4)]

Color = TypeAliasType(
    "Color",
    Leaf[
        Annotated[
            Annotated[ColorText, Tag(WORD)] | Annotated[ColorList, Tag(COMPONENTS)],
            union_by_kind('three or four numbers, or "#rrggbb" or "#rrggbbaa"'),
        ]
    ],
)
"""Three or four numbers in 0..1, or "#rrggbb" or "#rrggbbaa"."""

Radiance = Annotated[
    Annotated[ColorText, Tag(WORD)] | Annotated[list[NonNegative], Field(min_length=3, max_length=4), Tag(COMPONENTS)],
    union_by_kind('three or four numbers, or "#rrggbb" or "#rrggbbaa"'),
]
"""A colour that may be brighter than 1."""


class Physical(SpecModel):
    """Friction and restitution of a surface, and density of its shapes."""

    static_friction: Maybe[Leaf[NonNegative]] = key(
        "Coefficient of static friction.", default=properties.STATIC_FRICTION
    )
    dynamic_friction: Maybe[Leaf[NonNegative]] = key(
        "Coefficient of dynamic friction, at most the static one.", default=properties.DYNAMIC_FRICTION
    )
    restitution: Maybe[Leaf[NonNegative]] = key("Coefficient of restitution, 0 to 1.", default=properties.RESTITUTION)
    density: Maybe[Leaf[NonNegative]] = key(
        "Density [kg/m³] of shapes without their own.", default=properties.DEFAULT_DENSITY
    )


class TextureMapping(SpecModel):
    """An image and how it is sampled."""

    file: Leaf[ImageName] = Field(description="The image.")
    mipmap_levels: Maybe[Fixed[Annotated[int, Field(ge=1, le=32)]]] = key("Levels of detail.", default=1)
    filter_mode: Maybe[Fixed[Literal["nearest", "linear"]]] = key("Filter between texels.", default="linear")
    address_mode: Maybe[Fixed[Literal["repeat", "border", "edge", "mirror"]]] = key("Outside 0..1.", default="repeat")
    srgb: Maybe[Fixed[bool]] = key("Whether 8-bit values are sRGB: true for colours, false for the rest.", default=True)


if TYPE_CHECKING:
    _LazyTextureMapping = TextureMapping
else:
    _LazyTextureMapping = Annotated[Any, LazyType("scenecc.spec.shapes", "TextureMapping")]

Texture = TypeAliasType(
    "Texture",
    Leaf[
        Annotated[
            Annotated[ImageName, Tag(WORD)] | Annotated[_LazyTextureMapping, Tag(MAPPING)],
            union_by_kind("a file, or a mapping with `file`"),
        ]
    ],
)


class Visual(SpecModel):
    """Appearance of a surface: `sapien.render.RenderMaterial`."""

    base_color: Maybe[Color] = key("Base colour: linear RGB or RGBA, or an sRGB text.", default=[1, 1, 1, 1])
    emission: Maybe[Leaf[Radiance]] = key("Emitted colour: linear RGB or RGBA, or an sRGB text.", default=[0, 0, 0, 0])
    specular: Maybe[Leaf[Unit]] = key("Specular reflection of a dielectric.", default=0)
    roughness: Maybe[Leaf[Unit]] = key("Roughness.", default=1)
    metallic: Maybe[Leaf[Unit]] = key("Metallic factor.", default=0)
    transmission: Maybe[Leaf[Unit]] = key("Fraction of light that is transmitted (ray tracing).", default=0)
    ior: Maybe[Leaf[Annotated[float, Field(ge=1, allow_inf_nan=False)]]] = key("Index of refraction.", default=1.45)
    transmission_roughness: Maybe[Leaf[Unit]] = key("Roughness of the transmission.", default=0)
    base_color_texture: Maybe[Texture] = key("Image of the base colour.")
    normal_texture: Maybe[Texture] = key("Normal map.")
    roughness_texture: Maybe[Texture] = key("Image of the roughness.")
    metallic_texture: Maybe[Texture] = key("Image of the metallic factor.")
    emission_texture: Maybe[Texture] = key("Image of the emission.")
    transmission_texture: Maybe[Texture] = key("Image of the transmission.")


class Material(SpecModel):
    """A surface: friction and restitution (`physical`) and appearance (`visual`)."""

    physical: Maybe[Physical] = key("Friction, restitution and density.")
    visual: Maybe[Visual] = key("Visual properties.")


if TYPE_CHECKING:
    _LazyMaterial = Material
else:
    _LazyMaterial = Annotated[Any, LazyType("scenecc.spec.shapes", "Material")]

MaterialRef = TypeAliasType(
    "MaterialRef",
    Annotated[
        Leaf[
            Annotated[
                Annotated[OuterName, NameRole("material"), Tag(WORD)] | Annotated[_LazyMaterial, Tag(MAPPING)],
                union_by_kind("a name from `materials`, or a mapping with `physical` or `visual`"),
            ]
        ],
        WHOLE,
    ],
)
"""A name from `materials`, or the same mapping inline."""

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
"""One number or [x, y, z], not 0; negative mirrors."""


def _allow_repeat(schema: dict[str, Any]) -> None:
    """Adds `repeat` to the JSON Schema of a shape. The models lack the key, because expansion removes it."""
    schema["patternProperties"] = NOTE_SCHEMA
    schema["properties"]["repeat"] = {"x-ref": "Repeat", "description": "As for an entity."}


class ShapeKeys(SpecModel):
    """Keys of every shape."""

    model_config = ConfigDict(json_schema_extra=_allow_repeat)

    pose: Maybe[Pose] = key("Pose in the body's frame: [x, y, z] or a mapping.")
    material: Maybe[MaterialRef] = key("A name from `materials`, or {physical, visual}.")


_Bits = Fixed[Annotated[int, Field(ge=0, lt=2**32)]]
_Ids = Fixed[Annotated[int, Field(ge=0, lt=2**16)]]
CollisionBits = Annotated[tuple[_Bits, _Bits, _Bits, _Ids], Strict(strict=False)]


class CollisionKeys(ShapeKeys):
    """Keys of shapes that collide."""

    density: Maybe[Leaf[NonNegative]] = key("Density [kg/m³].", default=properties.DEFAULT_DENSITY)
    contact_offset: Maybe[Leaf[Positive]] = key(
        "Distance at which contacts are generated [m].", default=properties.CONTACT_OFFSET
    )
    rest_offset: Maybe[Leaf[Finite]] = key(
        "Distance at which shapes rest, below `contact_offset` [m].", default=properties.REST_OFFSET
    )
    patch_radius: Maybe[Leaf[NonNegative]] = key("Radius of the torsional friction patch [m].", default=0)
    min_patch_radius: Maybe[Leaf[NonNegative]] = key("Smallest radius of the torsional friction patch [m].", default=0)
    collision_bits: Maybe[Fixed[CollisionBits]] = key("SAPIEN's four integers, instead of the body's.")


class VisualKeys(ShapeKeys):
    """Keys of shapes that are visible."""

    name: Maybe[Fixed[Text]] = key("Name of the render shape.")
    front_face: Maybe[Fixed[Literal["counterclockwise", "clockwise"]]] = key(
        "Which side of a triangle is its front.", default="counterclockwise"
    )
    color: Maybe[Color] = key("Base colour, replacing that of the material.")


class ShapeBothKeys(CollisionKeys, VisualKeys):
    """Keys of shapes that collide and are visible."""


class MeshFileKeys(SpecModel):
    """A mesh file."""

    file: Leaf[Annotated[Text, NameRole("mesh file")]] = Field(
        description="The mesh: a path from this file's folder, pkg://PACKAGE/PATH or asset://PATH."
    )


_PRIMITIVES = ("box", "sphere", "capsule", "cylinder", "cone", "ring", "plane", "heightfield")

_COLLIDING = {"primitive_shapes": _PRIMITIVES, "mesh_shapes": ("convex_mesh", "convex_parts", "triangle_mesh")}

_VISIBLE = {"primitive_shapes": (*_PRIMITIVES, "tiled_plane"), "mesh_shapes": ("convex_mesh", "mesh")}

CollisionSpec = Annotated[Any, LazyUnion("Collision", _COLLIDING), REPEATABLE]

VisualSpec = Annotated[Any, LazyUnion("Visual", _VISIBLE), REPEATABLE]

ShapeSpec = Annotated[Any, LazyUnion("Shape", _COLLIDING), REPEATABLE]
