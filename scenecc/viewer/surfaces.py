"""Surfaces of a page as files."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from itertools import count
from typing import TYPE_CHECKING

import numpy as np

from scenecc.emit.glb import part_to_glb
from scenecc.meshes.surface import SurfaceMaterial as Material

if TYPE_CHECKING:
    from scenecc.meshes import Surface
    from scenecc.meshes.surface import MeshPart, Vec4


class SurfaceFiles:
    """Surfaces as files. A file is kept as long as something on the page uses it.

    Attributes:
        contents: the files that are written, by the name of their part.
    """

    def __init__(self) -> None:
        self._numbers = count()
        self._names: dict[tuple[str, Material, bool], str] = {}
        self._parts: dict[str, tuple[MeshPart, bool]] = {}
        self._surfaces: dict[Surface, str] = {}
        self.contents: dict[str, bytes] = {}

    def name(self, part: MeshPart, *, turned: bool) -> str:
        """Returns a name for a part, the same for equal parts."""
        key = (self._digest(part.surface), part.look, turned)
        if key not in self._names:
            name = self._names[key] = str(next(self._numbers))
            self._parts[name] = part, turned
        return self._names[key]

    def plain(self, name: str) -> str | None:
        """Returns the name of a part in plain white, as transparent; None if its material is not just a colour, with
        or without gloss.
        """
        part, turned = self._parts[name]
        look = part.look
        images = look.base_color_image, look.normal_image, look.roughness_image, look.metallic_image
        if any((*images, look.emission_image, look.transmission_image, *look.emission, look.transmission)):
            return None
        return self.name(replace(part, look=Material(visibility=look.tint[3])), turned=turned)

    def tint(self, name: str) -> Vec4:
        """Returns the colour of a part, linear RGBA."""
        return self._parts[name][0].look.tint

    def write(self, name: str) -> None:
        """Adds the file of a part to `contents`."""
        if name not in self.contents:
            part, turned = self._parts[name]
            self.contents[name] = part_to_glb(_shade_part(part), turned=turned)

    def surface(self, name: str) -> Surface:
        """Returns the surface of a part."""
        part, turned = self._parts[name]
        surface = _shade_part(part).surface
        return replace(surface, faces=surface.faces[:, ::-1]) if turned else surface

    def keep(self, used: set[str]) -> None:
        """Drops every file that is not among these."""
        self._surfaces = {}
        self._names = {key: name for key, name in self._names.items() if name in used}
        self._parts = {name: part for name, part in self._parts.items() if name in used}
        self.contents = {name: content for name, content in self.contents.items() if name in used}

    def _digest(self, surface: Surface) -> str:
        if surface not in self._surfaces:
            digest = sha256()
            for array in (surface.vertices, surface.faces, surface.normals, surface.uvs):
                digest.update(b"-" if array is None else b"%d:" % array.size + array.tobytes())
            self._surfaces[surface] = digest.hexdigest()
        return self._surfaces[surface]


def _shade_part(part: MeshPart) -> MeshPart:
    """Returns a part that viser shades as SAPIEN does.

    viser computes vertex normals from all adjacent triangles. It overwrites the file's normals, and also the vertices
    if both arrays are equal, as for a ball. So the part has no normals, and flat triangles have separate vertices.
    """
    surface = part.surface
    if surface.normals is not None:
        return replace(part, surface=replace(surface, normals=None))
    corners = surface.faces.ravel()
    uvs = None if surface.uvs is None else surface.uvs[corners]
    apart = replace(surface, vertices=surface.vertices[corners], faces=np.arange(len(corners)).reshape(-1, 3), uvs=uvs)
    return replace(part, surface=apart)
