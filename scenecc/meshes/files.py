"""Mesh files as surfaces, read by trimesh, with the looks that SAPIEN gives them.

Where a file has no normals, its triangles are flat. So they are in SAPIEN, but for a GLB or PLY whose triangles share
vertices: there each vertex has the normal of any one of them.
"""

from __future__ import annotations

from hashlib import sha256
from importlib import import_module
from importlib.util import find_spec
from io import BytesIO
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.files import ChangedError, read_checked
from scenecc.meshes.primitives import surface
from scenecc.meshes.surface import Look, MeshProblem, Part
from scenecc.meshes.textures import Images, image_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from scenecc.meshes.surface import Vec3, Vec4
    from scenecc.plan import AssetFile, NamedFile

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
        self._contents: dict[tuple[object, ...], tuple[Part, ...]] = {}

    def parts(self, file: AssetFile) -> tuple[Part, ...]:
        """The surfaces of a file in its own frame [m], and their looks.

        Raises:
            MeshProblem: it cannot be read, or a package is missing.
        """
        if file.path not in self._paths:
            self._paths[file.path] = self._found(file)
        return self._paths[file.path]

    def _found(self, file: AssetFile) -> tuple[Part, ...]:
        data = _checked(file.path, file.sha256)
        key = (file.path.suffix.lower(), sha256(data).hexdigest(), *file.names)
        if key not in self._contents:
            self._contents[key] = _read(data, file)
        return self._contents[key]


class _Named:
    """The files that a mesh names and that were checked, as trimesh asks for them: it reads a mesh in ways of its own.

    It takes this for a resolver.
    """

    def __init__(self, file: AssetFile) -> None:
        self._by_name = {one.uri: one for one in file.names}

    def get(self, name: str) -> bytes:
        """The content of a file. Raises OSError where the mesh was not found to name it."""
        one = self._by_name.get(name)
        if one is None or one.path is None:
            raise FileNotFoundError(f"the mesh names no file {name!r} that was checked")
        return _checked(one.path, one.sha256)

    __getitem__ = get

    def find(self, name: str) -> NamedFile | None:
        """A file; None where the mesh was not found to name it."""
        return self._by_name.get(name)


def _checked(path: Path, digest: str | None) -> bytes:
    """The content of a file. Raises MeshProblem where it is not what it was when it was checked."""
    try:
        return read_checked(path, digest)
    except ChangedError as error:
        raise MeshProblem("SC422", f"'{path}' changed while the scene was built") from error
    except OSError as error:
        raise MeshProblem("SC747", f"'{path}' cannot be read: {error.strerror}") from error


def _read(data: bytes, file: AssetFile) -> tuple[Part, ...]:
    path, named = file.path, _Named(file)
    suffix = path.suffix.lower()
    if suffix == ".dae" and find_spec("collada") is None:
        raise MeshProblem(
            "SC813", f"'{path.name}' is COLLADA, which needs pycollada", 'run `pip install "scenecc[export]"`'
        )
    trimesh: Any = import_module("trimesh")  # which says half of its types

    try:
        scene = trimesh.load_scene(BytesIO(data), suffix[1:], resolver=named, process=False)
    except Exception as error:  # trimesh's readers raise whatever comes
        raise MeshProblem("SC747", f"'{path}' cannot be read: {error}", "export the mesh again") from error
    parts: list[Part] = []
    images = Images()
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            parts.append(_part(mesh, np.asarray(place), _look(mesh.visual, path, named, images)))
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


def _look(visual: Any, path: Path, named: _Named, images: Images) -> Look:
    """Colours of vertices are in no picture of SAPIEN's, so they are in none here."""
    material = getattr(visual, "material", None)
    if material is None:
        suffix = path.suffix.lower()
        plain, metallic = _PLAIN.get(suffix, _WHITE), _METALLIC.get(suffix, 0.0)
        return Look(base_color=plain, specular=_SPECULAR, metallic=metallic)
    return _of_glossy(material, path, named, images) if hasattr(material, "glossiness") else _of_pbr(material, path)


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


def _of_glossy(material: Any, path: Path, named: _Named, images: Images) -> Look:
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
        **_maps(given, named, images),
    )


def _maps(given: dict[str, Any], files: _Named, images: Images) -> dict[str, Any]:
    """Images of a material that trimesh leaves as words. The file's name is the last of them, after options."""
    named = {field: files.find(given[key][-1]) for key, field in _MAPS.items() if given.get(key)}
    try:
        return {
            field: images.file(one.path, one.sha256, {"srgb": field == "emission_image"})
            for field, one in named.items()
            if one is not None and one.path is not None
        }
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
