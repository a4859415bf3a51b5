"""The sections `lights`, `environment` and `cameras`. Imported on first use."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, StringConstraints, Tag
from typing_extensions import TypeAliasType

from scenecc.plan import rendering as plan
from scenecc.spec.base import (
    BodyName,
    Finite,
    ImageName,
    Maybe,
    NonNegative3,
    OpeningAngle,
    OpeningDegrees,
    Positive,
    SpecModel,
    Vec3,
    key,
)
from scenecc.spec.body import SceneIdxs
from scenecc.spec.nodes import COMPONENTS, MAPPING, WORD, LazyType, LazyUnion, union_by_kind
from scenecc.spec.pose import Pose
from scenecc.spec.repetition import REPEATABLE, RepeatKeys
from scenecc.spec.shapes import Texture
from scenecc.spec.values import Fixed, Leaf

LIGHT_COLOR_TEXT = r"^#[0-9A-Fa-f]{6}$"

LightColor = TypeAliasType(
    "LightColor",
    Leaf[
        Annotated[
            Annotated[str, StringConstraints(pattern=LIGHT_COLOR_TEXT), Tag(WORD)]
            | Annotated[NonNegative3, Tag(COMPONENTS)],
            union_by_kind('three numbers, or "#rrggbb"'),
        ]
    ],
)
"""Three linear numbers of any brightness, or "#rrggbb"."""

_MapSize = Annotated[int, Field(ge=1, le=16384)]


class LightKeys(RepeatKeys):
    """Keys of every light."""

    color: LightColor = Field(description='Colour times brightness: linear RGB, which may exceed 1, or sRGB "#rrggbb".')
    pose: Maybe[Pose] = key(
        "Pose of the light, which shines along x: in the world, in the frame of `relative_to`, or in that of `mount`."
    )
    mount: Maybe[Fixed[BodyName]] = key("ENTITY or ENTITY/LINK to mount it on.", examples=["robot/hand"])
    scene_idxs: Maybe[SceneIdxs] = key(
        'The scenes it exists in: indices, a slice such as "0:8", or a list of both. Default: every scene.'
    )


class PositionKeys(SpecModel):
    """Position of a light, instead of a pose."""

    position: Maybe[Leaf[Vec3]] = key("Position, instead of `pose` [m].", default=[0, 0, 0], excludes=("pose",))


class DirectionKeys(PositionKeys):
    """Position and direction of a light, instead of a pose."""

    direction: Maybe[Leaf[Vec3]] = key("Direction of the light, of any length; instead of `pose`.", excludes=("pose",))


class ShadowKeys(SpecModel):
    """Keys of lights that may cast shadows."""

    shadow: Maybe[Leaf[bool]] = key("Whether it casts shadows.", default=False)
    shadow_near: Maybe[Leaf[Positive]] = key(
        "Distance from the light at which shadows begin [m].", default=plan.SHADOW_NEAR
    )
    shadow_far: Maybe[Leaf[Positive]] = key("Where they end [m].", default=plan.SHADOW_FAR)
    shadow_map_size: Maybe[Leaf[_MapSize]] = key("Size of the shadow map [px].", default=plan.SHADOW_MAP_SIZE)


class LightConeKeys(SpecModel):
    """The cone of a light."""

    inner_fov: Maybe[Leaf[OpeningAngle]] = key("Angle of the cone of full brightness [rad]; this or `inner_fov_deg`.")
    inner_fov_deg: Maybe[Leaf[OpeningDegrees]] = key("The same [degrees].", excludes=("inner_fov",))
    outer_fov: Maybe[Leaf[OpeningAngle]] = key(
        "Angle of the cone beyond which it is dark [rad]; this or `outer_fov_deg`."
    )
    outer_fov_deg: Maybe[Leaf[OpeningDegrees]] = key("The same [degrees].", excludes=("outer_fov",))


class DirectionalLightSpec(LightKeys, DirectionKeys, ShadowKeys):
    """Parallel light from far away: `Scene.add_directional_light`."""

    type: Literal["directional"]
    # A directional light has no position, so shadows may also begin behind it.
    shadow_near: Maybe[Leaf[Finite]] = key(  # pyright: ignore[reportIncompatibleVariableOverride]
        "Distance along the light at which shadows begin [m].", default=plan.PARALLEL_SHADOW_NEAR
    )
    shadow_far: Maybe[Leaf[Finite]] = key("Where they end [m].", default=plan.SHADOW_FAR)  # pyright: ignore[reportIncompatibleVariableOverride]
    shadow_scale: Maybe[Leaf[Positive]] = key(
        "Half the edge of the square with shadows [m].", default=plan.SHADOW_HALF_SIZE
    )


class PointLightSpec(LightKeys, PositionKeys, ShadowKeys):
    """Light in all directions: `Scene.add_point_light`."""

    type: Literal["point"]


class SpotLightSpec(LightKeys, DirectionKeys, ShadowKeys, LightConeKeys):
    """A cone of light: `Scene.add_spot_light`."""

    type: Literal["spot"]


class AreaLightSpec(LightKeys):
    """A rectangle of light, visible only with ray tracing: `Scene.add_area_light_for_ray_tracing`."""

    type: Literal["area"]
    half_width: Leaf[Positive] = Field(description="Along y of its pose [m].")
    half_height: Leaf[Positive] = Field(description="Along z of its pose [m].")


class TexturedLightSpec(LightKeys, DirectionKeys, ShadowKeys, LightConeKeys):
    """A cone of light that projects an image: `sapien.render.RenderTexturedLightComponent`."""

    type: Literal["textured"]
    texture: Texture = Field(description="The image: a file, or a mapping with `file`.")


LIGHT_TYPES = ("directional", "point", "spot", "area", "textured")

Light = Annotated[Any, LazyUnion("LightSpec", {"rendering": LIGHT_TYPES}), REPEATABLE]
"""An entry of `lights`."""


class CubeMapKeys(SpecModel):
    """Six images around the scene, one along each axis."""

    px: Leaf[ImageName] = Field(description="Image towards +x.")
    nx: Leaf[ImageName] = Field(description="Image towards -x.")
    py: Leaf[ImageName] = Field(description="Image towards +y.")
    ny: Leaf[ImageName] = Field(description="Image towards -y.")
    pz: Leaf[ImageName] = Field(description="Image towards +z.")
    nz: Leaf[ImageName] = Field(description="Image towards -z.")


if TYPE_CHECKING:
    _LazyCubeMap = CubeMapKeys
else:
    _LazyCubeMap = Annotated[Any, LazyType("scenecc.spec.rendering", "CubeMapKeys")]

EnvironmentMap = Leaf[
    Annotated[
        Annotated[ImageName, Tag(WORD)] | Annotated[_LazyCubeMap, Tag(MAPPING)],
        union_by_kind("a file, or a mapping with px, nx, py, ny, pz, nz"),
    ]
]
"""A file, or six images."""


class EnvironmentSpec(SpecModel):
    """Ambient light and the environment map."""

    ambient_light: Maybe[LightColor] = key('Linear RGB, which may exceed 1, or sRGB "#rrggbb".', default=[0, 0, 0])
    map: Maybe[EnvironmentMap] = key("Environment map: a file, or six images.")


_Pixels = Annotated[int, Field(ge=1, le=16384)]


class IntrinsicKeys(SpecModel):
    """The matrix of a pinhole camera."""

    fx: Leaf[Positive] = Field(description="Focal length in pixel widths [px].")
    fy: Leaf[Positive] = Field(description="Focal length in pixel heights [px].")
    cx: Maybe[Leaf[Finite]] = key("Principal point, from the left [px]; default: half the width.")
    cy: Maybe[Leaf[Finite]] = key("Principal point, from the top [px]; default: half the height.")
    skew: Maybe[Leaf[Finite]] = key("Skew of the pixels [px].", default=0)


class OrthographicKeys(SpecModel):
    """A camera without perspective."""

    top: Leaf[Positive] = Field(description="Half height of the view [m]; pixels are square.")


_LENSES = ("fovy", "fovy_deg", "fovx", "fovx_deg", "intrinsic", "orthographic")


class CameraSpec(RepeatKeys):
    """A camera. It looks along x of its pose, z is up."""

    pose: Maybe[Pose] = key(
        "Pose in the world, in the frame of `relative_to`, or in that of `mount`; `look_at` aims it."
    )
    width: Maybe[Fixed[_Pixels]] = key("[px]", default=plan.WIDTH)
    height: Maybe[Fixed[_Pixels]] = key("[px]", default=plan.HEIGHT)
    fovy: Maybe[Leaf[OpeningAngle]] = key("Vertical field of view [rad].", excludes=_LENSES)
    fovy_deg: Maybe[Leaf[OpeningDegrees]] = key("The same [degrees].", default=plan.FOVY_DEGREES, excludes=_LENSES)
    fovx: Maybe[Leaf[OpeningAngle]] = key("Horizontal field of view [rad].", excludes=_LENSES)
    fovx_deg: Maybe[Leaf[OpeningDegrees]] = key("The same [degrees].", excludes=_LENSES)
    intrinsic: Maybe[IntrinsicKeys] = key("Intrinsic matrix, instead of an angle.", excludes=_LENSES)
    orthographic: Maybe[OrthographicKeys] = key("Orthographic projection, instead of an angle.", excludes=_LENSES)
    near: Maybe[Leaf[Positive]] = key("Near plane [m].", default=plan.NEAR)
    far: Maybe[Leaf[Positive]] = key("Far plane [m].", default=plan.FAR)
    mount: Maybe[Fixed[BodyName]] = key("ENTITY or ENTITY/LINK to mount it on.", examples=["robot/hand"])
    shader: Maybe[Fixed[plan.ShaderName]] = key("SAPIEN's shader pack.", default="default")
    scene_idxs: Maybe[SceneIdxs] = key(
        'The scenes it exists in: indices, a slice such as "0:8", or a list of both. Default: every scene.'
    )
