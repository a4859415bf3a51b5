"""The tables of a plan: materials, textures and files. Shapes hold indices into them.

Rows of a material's values follow the scenes of the entities whose shapes have it.
"""

from __future__ import annotations

import os
from dataclasses import field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.files import State
    from scenecc.plan.value import Value


@frozen
class NamedFile:
    """A file that another names: a material file, a texture, a buffer.

    Attributes:
        uri: as it is named, relative to the file that names it.
        sha256, path, state: as of an `AssetFile`.
    """

    uri: str
    sha256: str
    path: Path | None = field(default=None, compare=False)
    state: State | None = field(default=None, compare=False)


@frozen
class AssetFile:
    """A file that the scene uses.

    Attributes:
        uri: `pkg://…` or `asset://…` as written, else the path relative to the top scene's folder
            (posix), else an absolute path.
        path: where it was found on this machine; not part of the plan's identity.
        sha256: of what it held when it was checked; None of what no build opens (a robot's description), and of a
            plan whose files nobody has checked.
        names: the files that it names in turn, and which a build opens.
        state: it was in when it was checked, by which a build tells that it changed since.
    """

    uri: str
    path: Path = field(compare=False)
    sha256: str | None = None
    names: tuple[NamedFile, ...] = ()
    state: State | None = field(default=None, compare=False)


@frozen
class Friction:
    """The numbers of a `sapien.physx.PhysxMaterial`, the same in every scene. They have no unit."""

    static_friction: float
    dynamic_friction: float
    restitution: float


@frozen
class PhysicalMaterial:
    """`sapien.physx.PhysxMaterial`: (·,) each, without unit."""

    static_friction: Value
    dynamic_friction: Value
    restitution: Value

    def values(self) -> tuple[Value, ...]:
        """All values of it."""
        return (self.static_friction, self.dynamic_friction, self.restitution)

    def row(self, index: int) -> Friction:
        """What it is in scene number `index` (a row, not a scene index) of an entity."""
        return Friction(*(float(value.row(index)) for value in self.values()))


@frozen
class Texture:
    """An image and how it is sampled; None is what `sapien.render.RenderTexture2D` does without it.

    `file`: (·,) index into `ScenePlan.files`.
    """

    file: Value
    mipmap_levels: int | None = None
    filter_mode: Literal["nearest", "linear"] | None = None
    address_mode: Literal["repeat", "border", "edge", "mirror"] | None = None
    srgb: bool | None = None

    def sampling(self) -> dict[str, int | str | bool]:
        """How it is sampled, where the plan says so, by the names of these fields and of SAPIEN's arguments."""
        given = {item.name: getattr(self, item.name) for item in fields(self) if item.name != "file"}
        return {name: value for name, value in given.items() if value is not None}


@frozen
class VisualMaterial:
    """`sapien.render.RenderMaterial`; None leaves SAPIEN's own.

    Attributes:
        base_color, emission: (·, 4), linear RGBA in 0..1 (an emission may be brighter).
        specular, roughness, metallic, transmission, ior, transmission_roughness: (·,).
    """

    base_color: Value | None = None
    emission: Value | None = None
    specular: Value | None = None
    roughness: Value | None = None
    metallic: Value | None = None
    transmission: Value | None = None
    ior: Value | None = None
    transmission_roughness: Value | None = None
    base_color_texture: Texture | None = None
    normal_texture: Texture | None = None
    roughness_texture: Texture | None = None
    metallic_texture: Texture | None = None
    emission_texture: Texture | None = None
    transmission_texture: Texture | None = None

    def numbers(self) -> dict[str, Value]:
        """What is given of the colours and numbers, by field."""
        given = {item.name: getattr(self, item.name) for item in fields(self)}
        return {name: item for name, item in given.items() if item is not None and not isinstance(item, Texture)}

    def textures(self) -> dict[str, Texture]:
        """The textures that are given, by field."""
        given = {item.name: getattr(self, item.name) for item in fields(self)}
        return {name: item for name, item in given.items() if isinstance(item, Texture)}

    def values(self) -> tuple[Value, ...]:
        """All values of it, those of its textures included."""
        return (*self.numbers().values(), *(texture.file for texture in self.textures().values()))

    def row(self, index: int) -> dict[str, float | list[float]]:
        """The colours and numbers that are given in scene number `index` (a row) of an entity, by field."""
        return {name: value.row(index).tolist() for name, value in self.numbers().items()}


def rebase_file(file: AssetFile, base: Path) -> AssetFile:
    """The same file, named for a document in the folder `base`: a relative uri starts there, others stay."""
    if "://" in file.uri or Path(file.uri).is_absolute():
        return file
    return replace(file, uri=Path(os.path.relpath(file.path, base.absolute())).as_posix())
