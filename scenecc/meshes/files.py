"""Mesh files as surfaces, read by trimesh, with the looks that SAPIEN gives them.

Where a file has no normals, its triangles are flat. So they are in SAPIEN, but for a GLB or PLY whose triangles share
vertices: there each vertex has the normal of any one of them.
"""

from __future__ import annotations

from hashlib import sha256
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.meshes.images import Images, image_of
from scenecc.meshes.primitives import surface
from scenecc.meshes.surface import Look, MeshProblem, Part

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from scenecc.meshes.surface import Vec3, Vec4

_WHOLE: Final = frozenset({".stl", ".ply"})
"""Kinds of files that name no other."""

_WHITE: Final = (1.0, 1.0, 1.0, 1.0)
_GREY: Final = (0.6, 0.6, 0.6, 1.0)
_PLAIN: Final = {".obj": _GREY, ".dae": _GREY}
"""Colours that SAPIEN's readers give a file without a material; others are white."""

_METALLIC: Final = {".glb": 1.0, ".gltf": 1.0}
"""And how metallic: glTF's own default. Others are not."""

_MAPS: Final = {
    "norm": "normal_image",
    "map_ke": "emission_image",
    "map_pr": "roughness_image",
    "map_pm": "metallic_image",
}
"""Images of an OBJ's material that SAPIEN loads, beside that of its colour."""

_LUMINANCE: Final = (0.2125, 0.7154, 0.0721)
_SPECULAR: Final = 0.5
"""Of all materials of files in SAPIEN."""


class MeshFiles:
    """Mesh files that are read once, also where several hold the same."""

    def __init__(self) -> None:
        self._paths: dict[Path, tuple[Part, ...]] = {}
        self._contents: dict[tuple[str, ...], tuple[Part, ...]] = {}

    def parts(self, path: Path) -> tuple[Part, ...]:
        """The surfaces of a file in its own frame [m], and their looks.

        Raises:
            MeshProblem: it cannot be read, or a package is missing.
        """
        if path not in self._paths:
            self._paths[path] = self._found(path)
        return self._paths[path]

    def _found(self, path: Path) -> tuple[Part, ...]:
        suffix = path.suffix.lower()
        try:
            digest = sha256(path.read_bytes()).hexdigest()
        except OSError as error:
            raise MeshProblem("SC747", f"'{path}' cannot be read: {error.strerror}") from error
        # A file that names others holds the same only where these are the same, too: beside it.
        key = (suffix, digest) if suffix in _WHOLE else (suffix, digest, str(path.parent))
        if key not in self._contents:
            self._contents[key] = _read(path)
        return self._contents[key]


def _read(path: Path) -> tuple[Part, ...]:
    suffix = path.suffix.lower()
    if suffix == ".dae" and find_spec("collada") is None:
        raise MeshProblem(
            "SC813", f"'{path.name}' is COLLADA, which needs pycollada", 'run `pip install "scenecc[export]"`'
        )
    trimesh: Any = import_module("trimesh")  # which says half of its types

    try:
        scene = trimesh.load_scene(str(path), process=False)
    except Exception as error:  # trimesh's readers raise whatever comes
        raise MeshProblem("SC747", f"'{path}' cannot be read: {error}", "export the mesh again") from error
    parts: list[Part] = []
    images = Images()
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            parts.append(_part(mesh, np.asarray(place), _look(mesh.visual, path, images)))
    if not parts:
        raise MeshProblem("SC747", f"'{path}' shows no triangles", "export the mesh again")
    return tuple(parts)


def _part(mesh: Any, place: Any, look: Look) -> Part:
    # trimesh computes smooth normals for whoever asks; what a file itself has lies in this cache.
    smooth = "vertex_normals" in vars(mesh)["_cache"]
    moved = mesh.copy(include_cache=True)
    moved.apply_transform(place)
    moved.apply_scale(_unit(mesh))
    normals = moved.vertex_normals if smooth else None
    uv = getattr(mesh.visual, "uv", None)
    uvs = None if uv is None or len(uv) != len(mesh.vertices) else np.column_stack([uv[:, 0], 1 - uv[:, 1]])
    return Part(surface(moved.vertices, moved.faces, normals, uvs), look)


def _unit(mesh: Any) -> float:
    """The length of a COLLADA's unit [m], as SAPIEN heeds it; other files are in metres."""
    number, times, _ = str(mesh.metadata.get("units", "")).partition(" * meters")
    return float(number) if times else 1.0


def _look(visual: Any, path: Path, images: Images) -> Look:
    """Colours of vertices are in no picture of SAPIEN's, so they are in none here."""
    material = getattr(visual, "material", None)
    if material is None:
        suffix = path.suffix.lower()
        plain, metallic = _PLAIN.get(suffix, _WHITE), _METALLIC.get(suffix, 0.0)
        return Look(base_color=plain, specular=_SPECULAR, metallic=metallic)
    return _of_glossy(material, path, images) if hasattr(material, "glossiness") else _of_pbr(material, path)


def _of_pbr(material: Any, path: Path) -> Look:
    name = path.stem
    shared = material.metallicRoughnessTexture
    color, glow = material.baseColorFactor, material.emissiveFactor
    image = image_of(material.baseColorTexture, name, srgb=True)
    return Look(
        base_color=_WHITE if color is None else _rgba(np.asarray(color) / 255),
        emission=_rgb(glow) if glow is not None else (0.0, 0.0, 0.0),
        specular=_SPECULAR,
        roughness=_number(material.roughnessFactor, 1.0),
        metallic=_number(material.metallicFactor, 1.0),
        base_color_image=image,
        normal_image=image_of(material.normalTexture, name, srgb=False),
        roughness_image=image_of(shared, name, "g", srgb=False),
        metallic_image=image_of(shared, name, "b", srgb=False),
        emission_image=image_of(material.emissiveTexture, name, srgb=True),
    )


def _of_glossy(material: Any, path: Path, images: Images) -> Look:
    """A material of an OBJ, whose roughness SAPIEN's reader makes of `Ns` and `Ks`.

    Raises:
        MeshProblem: one of its images cannot be read.
    """
    given: dict[str, Any] = material.kwargs
    shine = min(max(_number(given.get("ns"), 0.0) / 1000, 0.0), 1.0) ** 0.5
    bright = float(np.dot(_rgb(given.get("ks", (0.0, 0.0, 0.0))), _LUMINANCE))
    opaque = _first(given.get("d"), 1.0)
    red, green, blue = _rgb(given.get("kd", _GREY[:3]))
    return Look(
        base_color=(red, green, blue, opaque),
        emission=_rgb(given.get("ke", (0.0, 0.0, 0.0))),
        specular=_SPECULAR,
        roughness=1 - shine * bright,
        base_color_image=image_of(material.image, path.stem, srgb=True),
        **_maps(given, path.parent, images),
    )


def _maps(given: dict[str, Any], folder: Path, images: Images) -> dict[str, Any]:
    """Images of a material that trimesh leaves as words. The file's name is the last of them, after options."""
    named = {field: given[key][-1] for key, field in _MAPS.items() if given.get(key)}
    try:
        return {field: images.file(folder / name, {"srgb": field == "emission_image"}) for field, name in named.items()}
    except MeshProblem as problem:
        code = (
            "SC747" if problem.code == "SC748" else problem.code
        )  # nothing stands in its place, as in a scene's texture
        raise MeshProblem(code, problem.message, problem.hint) from problem


def _first(words: Sequence[str] | None, default: float) -> float:
    return default if not words else float(words[0])


def _number(value: Any, default: float) -> float:
    return default if value is None else float(value)


def _rgb(values: Any) -> Vec3:
    red, green, blue = (float(value) for value in values)
    return red, green, blue


def _rgba(values: Any) -> Vec4:
    red, green, blue, alpha = (float(value) for value in values)
    return red, green, blue, alpha
