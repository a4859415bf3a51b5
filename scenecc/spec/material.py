"""Materials: how a surface rubs and how it looks."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, StringConstraints, Tag
from typing_extensions import TypeAliasType

from scenecc.plan.properties import DEFAULT_DENSITY
from scenecc.spec.base import MaterialName, Maybe, NonNegative, SpecModel, Text, Unit, key
from scenecc.spec.nodes import COMPONENTS, MAPPING, WORD, LazyType, union_by_kind
from scenecc.spec.params import COLOR_TEXT
from scenecc.spec.values import Fixed, Leaf

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
    """How a surface rubs and bounces, and how heavy what it covers is."""

    static_friction: Maybe[Leaf[NonNegative]] = key("Coefficient of static friction.", default=0.3)
    dynamic_friction: Maybe[Leaf[NonNegative]] = key(
        "Coefficient of dynamic friction, at most the static one.", default=0.3
    )
    restitution: Maybe[Leaf[NonNegative]] = key("Coefficient of restitution, 0 to 1.", default=0.1)
    density: Maybe[Leaf[NonNegative]] = key("Density [kg/m³] of shapes that give none.", default=DEFAULT_DENSITY)


class TextureMapping(SpecModel):
    """An image and how it is sampled."""

    file: Leaf[Text] = Field(description="The image.")
    mipmap_levels: Maybe[Fixed[Annotated[int, Field(ge=1, le=32)]]] = key("Levels of detail.", default=1)
    filter_mode: Maybe[Fixed[Literal["nearest", "linear"]]] = key("Between texels.", default="linear")
    address_mode: Maybe[Fixed[Literal["repeat", "border", "edge", "mirror"]]] = key("Outside 0..1.", default="repeat")
    srgb: Maybe[Fixed[bool]] = key("Whether 8-bit values are sRGB: true for colours, false for the rest.", default=True)


if TYPE_CHECKING:
    _LazyTextureMapping = TextureMapping
else:
    _LazyTextureMapping = Annotated[Any, LazyType("scenecc.spec.material", "TextureMapping")]

Texture = TypeAliasType(
    "Texture",
    Leaf[
        Annotated[
            Annotated[Text, Tag(WORD)] | Annotated[_LazyTextureMapping, Tag(MAPPING)],
            union_by_kind("a file, or a mapping with `file`"),
        ]
    ],
)


class Visual(SpecModel):
    """How a surface looks: `sapien.render.RenderMaterial`."""

    base_color: Maybe[Color] = key("Base colour, linear RGB or RGBA.", default=[1, 1, 1, 1])
    emission: Maybe[Leaf[Radiance]] = key("Emitted colour, linear RGB or RGBA.", default=[0, 0, 0, 0])
    specular: Maybe[Leaf[Unit]] = key("Specular reflection of a dielectric.", default=0)
    roughness: Maybe[Leaf[Unit]] = key("Roughness.", default=1)
    metallic: Maybe[Leaf[Unit]] = key("Metallic share.", default=0)
    transmission: Maybe[Leaf[Unit]] = key("Share of light that passes (ray tracing).", default=0)
    ior: Maybe[Leaf[Annotated[float, Field(ge=1, allow_inf_nan=False)]]] = key("Index of refraction.", default=1.45)
    transmission_roughness: Maybe[Leaf[Unit]] = key("Roughness of what passes.", default=0)
    base_color_texture: Maybe[Texture] = key("Image of the base colour.")
    normal_texture: Maybe[Texture] = key("Normal map.")
    roughness_texture: Maybe[Texture] = key("Image of the roughness.")
    metallic_texture: Maybe[Texture] = key("Image of the metallic share.")
    emission_texture: Maybe[Texture] = key("Image of the emission.")
    transmission_texture: Maybe[Texture] = key("Image of the transmission.")


class Material(SpecModel):
    """A surface: how it rubs (`physical`) and how it looks (`visual`)."""

    physical: Maybe[Physical] = key("Friction, restitution and density.")
    visual: Maybe[Visual] = key("Visual properties.")


if TYPE_CHECKING:
    _LazyMaterial = Material
else:
    _LazyMaterial = Annotated[Any, LazyType("scenecc.spec.material", "Material")]

MaterialRef = TypeAliasType(
    "MaterialRef",
    Leaf[
        Annotated[
            Annotated[MaterialName, Tag(WORD)] | Annotated[_LazyMaterial, Tag(MAPPING)],
            union_by_kind("a name from `materials`, or a mapping with `physical` or `visual`"),
        ]
    ],
)
"""A name from `materials`, or the same mapping inline."""
