"""Lights and surroundings. None means that the file said nothing; what a light then has stands beside it."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.plan.body import Mount
    from scenecc.plan.material import Texture
    from scenecc.plan.value import Value


@frozen
class Shadow:
    """How a light's shadow is made.

    Attributes:
        on: (·,) flag, whether it throws one.
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
    """A parallelogram that shines along x of its pose; only ray tracing shows it.

    Attributes:
        half_width, half_height: (·,) [m].
    """

    half_width: Value
    half_height: Value


@frozen
class TexturedLight:
    """A spot light that throws a picture.

    Attributes:
        inner_fov, outer_fov: (·,) [rad].
        texture: the picture.
    """

    inner_fov: Value
    outer_fov: Value
    texture: Texture


@frozen
class Light:
    """One light in each of its scenes.

    Attributes:
        name: unique among the lights of the plan.
        scene_idxs: as of an entity.
        light: type and what only that has.
        pose: (·, 7) in the world, or in the frame of what it is mounted on; it shines along x. Its recipe follows what
            it stands relative to.
        color: (·, 3) linear, any brightness.
        mount: None: it stands in the world.
        shadow: None: it throws none.
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
    """What surrounds every scene.

    Attributes:
        ambient_light: (·, 3), a row a scene of the batch.
        map: what is seen far away, and lights the scene; likewise.
    """

    ambient_light: Value | None = None
    map: SkyMap | CubeMap | None = None
    origin: Origin | None = field(default=None, compare=False)
