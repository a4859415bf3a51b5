"""Lights and cameras of a plan, and SAPIEN's shadow defaults."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Final, Literal

from scenecc.diagnostics.frozen import frozen
from scenecc.plan.properties import QUANTITIES
from scenecc.plan.value import Value, literal

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan.body import Mount, Texture


WIDTH, HEIGHT, FOVY_DEGREES, NEAR, FAR = 640, 480, 60, 0.01, 100
"""Defaults of a camera: [px], [degrees] and [m]."""

SHADOW_NEAR, SHADOW_FAR, SHADOW_MAP_SIZE = 0.1, 10, 2048
"""Defaults of a light's shadow: [m] and [px]."""

PARALLEL_SHADOW_NEAR, SHADOW_HALF_SIZE = -10, 10
"""Defaults of a directional light's shadow [m]."""


@frozen
class Shadow:
    """The shadow of a light.

    Attributes:
        on: (·,) whether it casts a shadow.
        near, far: (·,) [m]. half_size: (·,) [m], of a directional light. map_size: (·,) integer [px].
    """

    on: Value
    near: Value | None = None
    far: Value | None = None
    half_size: Value | None = None
    map_size: Value | None = None


@frozen
class DirectionalLight:
    """Parallel light along x of its pose."""


@frozen
class PointLight:
    """Light in all directions from the origin of its pose."""


@frozen
class SpotLight:
    """A cone of light along x of its pose.

    Attributes:
        inner_fov, outer_fov: (·,) [rad].
    """

    inner_fov: Value
    outer_fov: Value


@frozen
class AreaLight:
    """A parallelogram that shines along x of its pose. Visible only with ray tracing.

    Attributes:
        half_width, half_height: (·,) [m].
    """

    half_width: Value
    half_height: Value


@frozen
class TexturedLight:
    """A spot light that projects a picture.

    Attributes:
        inner_fov, outer_fov: (·,) [rad].
        texture: the picture.
    """

    inner_fov: Value
    outer_fov: Value
    texture: Texture


LIGHT_CLASSES: Final[dict[type, str]] = {
    DirectionalLight: "RenderDirectionalLightComponent",
    PointLight: "RenderPointLightComponent",
    SpotLight: "RenderSpotLightComponent",
    AreaLight: "RenderParallelogramLightComponent",
    TexturedLight: "RenderTexturedLightComponent",
}
"""SAPIEN's component for each type of light."""

LIGHT_NUMBERS: Final[dict[type, tuple[str, ...]]] = {
    kind: tuple(name.partition(".")[2] for name in QUANTITIES if name.startswith(f"{kind.__name__}."))
    for kind in LIGHT_CLASSES
}
"""Fields with a `Value` that only this type of light has. SAPIEN's components use the same names."""


@frozen
class Light:
    """One light in each of its scenes.

    Attributes:
        name: unique among the lights of the plan.
        scene_idxs: see `Entity`.
        light: type and type-specific values.
        pose: (·, 7) in the world, or in the frame of its mount; it shines along x. Its recipe follows its reference
            frames.
        color: (·, 3) linear, any brightness.
        mount: None: the world.
        shadow: None: it casts no shadow.
    """

    name: str
    scene_idxs: tuple[int, ...]
    light: DirectionalLight | PointLight | SpotLight | AreaLight | TexturedLight
    pose: Value
    color: Value
    mount: Mount | None = None
    shadow: Shadow | None = None
    origin: Origin | None = field(default=None, compare=False)


@frozen
class CubeMap:
    """Six pictures around the scene, (·,) indices into `ScenePlan.files`."""

    px: Value
    nx: Value
    py: Value
    ny: Value
    pz: Value
    nz: Value


@frozen
class SkyMap:
    """One file around the scene.

    Attributes:
        file: (·,) index into `ScenePlan.files`.
    """

    file: Value


@frozen
class Environment:
    """The surroundings of every scene.

    Attributes:
        ambient_light: (·, 3), one row per scene of the batch.
        map: background that also lights the scene, one row per scene.
    """

    ambient_light: Value | None = None
    map: SkyMap | CubeMap | None = None
    origin: Origin | None = field(default=None, compare=False)


ShaderName = Literal["default", "minimal", "trivial", "rt", "shadow_catcher"]
"""SAPIEN's shader packs that render a complete scene. The language uses the same names."""

RAY_TRACING_SHADERS: Final = frozenset(("rt", "shadow_catcher"))
"""Shaders that trace rays, which not every device supports."""

SHADERS_WITHOUT_NORMALS: Final = frozenset(("minimal", "trivial"))
"""Shaders that cannot render normals."""


@frozen
class Perspective:
    """A camera with a field of view.

    Attributes:
        fovx, fovy: (·,) [rad]. At least one is given; the other follows from square pixels.
    """

    fovx: Value | None = None
    fovy: Value | None = None


@frozen
class Intrinsic:
    """A camera with an intrinsic matrix, in pixels.

    Attributes:
        fx, fy, cx, cy, skew: (·,).
    """

    fx: Value
    fy: Value
    cx: Value
    cy: Value
    skew: Value


@frozen
class Orthographic:
    """A camera without perspective.

    Attributes:
        top: (·,) half of the visible height [m]; the width follows from square pixels.
    """

    top: Value


@frozen
class Camera:
    """One camera in each of its scenes. It looks along x, z is up.

    Attributes:
        name: unique among the cameras, entities and frames of the file.
        scene_idxs: see `Entity`.
        pose: (·, 7) in the world, or in the frame of its mount. Its recipe follows its reference frames.
        width, height: [px], the same in every scene.
        lens: its projection.
        near, far: (·,) [m].
        mount: None: the world.
        shader: SAPIEN's name of a shader pack; None: its default.
    """

    name: str
    scene_idxs: tuple[int, ...]
    pose: Value
    width: int
    height: int
    lens: Perspective | Intrinsic | Orthographic
    near: Value
    far: Value
    mount: Mount | None = None
    shader: ShaderName | None = None
    origin: Origin | None = field(default=None, compare=False)


COLLISION_COLORS: Final = {
    "dynamic": (0.0437, 0.2051, 0.6867, 1.0),
    "kinematic": (0.8879, 0.2705, 0.0242, 1.0),
    "static": (0.3231, 0.3231, 0.3231, 1.0),
    "link": (0.1001, 0.3564, 0.0782, 1.0),
}
"""Colours of collision shapes by type of body: blue, orange, grey, green as linear RGBA."""

PLANE_HALF_SIZE: Final = 1e4
"""Half the side of a rendered plane [m], as in SAPIEN's viewer."""

FRAMING_DIRECTION: Final = (1.0, 0.75, 0.75)
"""Direction from the centre of a scene to a framing camera: in front, left and above."""

FLAT_THICKNESS: Final = 1e-4
"""Anything thinner than this [m] is ground or paint. A framing camera ignores it unless there is nothing else."""


def shadow_parameters(light: Light) -> dict[str, Value]:
    """The shadow settings of a light, by attribute of its component, in SAPIEN's order; {} for an area light.

    Distances are [m], the size of the map [px].
    """
    if isinstance(light.light, AreaLight):
        return {}
    parallel, given = isinstance(light.light, DirectionalLight), light.shadow
    left_out = {
        "shadow": literal(0, "bool"),
        "shadow_near": literal(float(PARALLEL_SHADOW_NEAR if parallel else SHADOW_NEAR)),
        "shadow_far": literal(float(SHADOW_FAR)),
        **({"shadow_half_size": literal(float(SHADOW_HALF_SIZE))} if parallel else {}),
        "shadow_map_size": literal(SHADOW_MAP_SIZE, "int64"),
    }
    if given is None:
        return left_out
    said = {
        "shadow": given.on,
        "shadow_near": given.near,
        "shadow_far": given.far,
        "shadow_half_size": given.half_size,
        "shadow_map_size": given.map_size,
    }
    return {name: said[name] or otherwise for name, otherwise in left_out.items()}
