"""Cameras."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Final, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.plan.body import Mount
    from scenecc.plan.value import Value

ShaderName = Literal["default", "minimal", "trivial", "rt", "shadow_catcher"]
"""SAPIEN's shader packs that make pictures of everything that a scene holds; the language has the same."""

RAY_TRACING_SHADERS: Final = frozenset(("rt", "shadow_catcher"))
"""Those that trace rays, which not every device can."""

SHADERS_WITHOUT_NORMALS: Final = frozenset(("minimal", "trivial"))
"""Those that have no picture of normals."""


@frozen
class Perspective:
    """A camera with a field of view.

    Attributes:
        fovx, fovy: (·,) [rad]. One is given at least; the other follows from square pixels.
    """

    fovx: Value | None = None
    fovy: Value | None = None


@frozen
class Intrinsic:
    """A camera with a matrix, in pixels.

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
        top: (·,) half of the height that it sees [m]; the width follows from square pixels.
    """

    top: Value


@frozen
class Camera:
    """One camera in each of its scenes. It looks along x, z is up.

    Attributes:
        name: unique among the cameras, entities and frames of the file.
        scene_idxs: as of an entity.
        pose: (·, 7) in the world, or in the frame of what it is mounted on. Its recipe follows what it stands relative
            to.
        width, height: [px], the same in every scene.
        lens: how it projects.
        near, far: (·,) [m].
        mount: None: it stands in the world.
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
