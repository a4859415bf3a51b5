"""The tables of a plan: materials, textures and files. Shapes hold indices into them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from pathlib import Path

Rgba = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class AssetFile:
    """A file that the scene uses.

    Attributes:
        uri: `pkg://…` or `asset://…` as written, else the path relative to the top scene's folder
            (posix), else an absolute path.
        path: where it was found on this machine; not part of the plan's identity.
    """

    uri: str
    path: Path = field(compare=False)


@dataclass(frozen=True, slots=True)
class PhysicalMaterial:
    """`sapien.physx.PhysxMaterial`. Frictions and restitution have no unit."""

    static_friction: float
    dynamic_friction: float
    restitution: float


@dataclass(frozen=True, slots=True)
class Texture:
    """An image and how it is sampled; None is what `sapien.render.RenderTexture2D` does without it.

    `file` is an index into `ScenePlan.files`.
    """

    file: int
    mipmap_levels: int | None = None
    filter_mode: Literal["nearest", "linear"] | None = None
    address_mode: Literal["repeat", "border", "edge", "mirror"] | None = None
    srgb: bool | None = None


@dataclass(frozen=True, slots=True)
class VisualMaterial:
    """`sapien.render.RenderMaterial`; None leaves SAPIEN's own. Colours are linear RGBA in 0..1."""

    base_color: Rgba | None = None
    emission: Rgba | None = None
    specular: float | None = None
    roughness: float | None = None
    metallic: float | None = None
    transmission: float | None = None
    ior: float | None = None
    transmission_roughness: float | None = None
    base_color_texture: Texture | None = None
    normal_texture: Texture | None = None
    roughness_texture: Texture | None = None
    metallic_texture: Texture | None = None
    emission_texture: Texture | None = None
    transmission_texture: Texture | None = None
