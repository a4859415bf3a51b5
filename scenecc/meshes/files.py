"""Reads mesh files with trimesh, with materials as in SAPIEN.

A file without normals is flat shaded, as in SAPIEN. Exception: for a GLB or PLY with shared vertices, SAPIEN gives each
vertex the normal of one of its triangles.
"""

from __future__ import annotations

from hashlib import sha256
from importlib import import_module
from io import BytesIO
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.assets.collada import LAMPS, without_elements
from scenecc.assets.errors import AssetError
from scenecc.assets.obj_materials import image_of_words
from scenecc.files import ChangedError, read_checked
from scenecc.geometry.rotations import to_vector
from scenecc.meshes.primitives import make_surface
from scenecc.meshes.simplify import simplify_parts
from scenecc.meshes.surface import ImageCache, MeshPart, SurfaceMaterial, Vec4, convert_image

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from scenecc.plan import AssetFile, NamedFile

_WHITE: Final = (1.0, 1.0, 1.0, 1.0)
_GRAY: Final = (0.6, 0.6, 0.6, 1.0)
_DEFAULT_COLORS: Final = {".obj": _GRAY, ".dae": _GRAY}
"""Base colour of a file without a material, as in SAPIEN's readers; white for other formats."""

_METALLIC: Final = {".glb": 1.0, ".gltf": 1.0}
"""Metallic of a file without a material: glTF's default; 0 for other formats."""

_MTL_MAPS: Final = {
    "norm": "normal_image",
    "map_ke": "emission_image",
    "map_pr": "roughness_image",
    "map_pm": "metallic_image",
}
"""Maps of an OBJ material that SAPIEN loads, besides the colour."""

_LUMINANCE: Final = (0.2125, 0.7154, 0.0721)
_SPECULAR: Final = 0.5
"""Specular value of all materials from mesh files in SAPIEN."""


class MeshFiles:
    """Cache of mesh files; files with the same content are read once."""

    def __init__(self, max_triangles: int | None = None) -> None:
        """`max_triangles`: simplify meshes with more; None: none."""
        self._max_triangles = max_triangles
        self._paths: dict[Path, tuple[MeshPart, ...]] = {}
        self._contents: dict[tuple[object, ...], tuple[MeshPart, ...]] = {}

    def parts(self, file: AssetFile) -> tuple[MeshPart, ...]:
        """Returns the surfaces of a file in its own frame [m], with materials.

        Raises:
            AssetError: it cannot be read, or a package is missing.
        """
        if file.path not in self._paths:
            self._paths[file.path] = self._read_parts(file)
        return self._paths[file.path]

    def _read_parts(self, file: AssetFile) -> tuple[MeshPart, ...]:
        data = _read_file(file.path, file.sha256)
        key = (file.path.suffix.lower(), sha256(data).hexdigest(), *file.names)
        if key not in self._contents:
            parts = _read_mesh(data, file)
            self._contents[key] = simplify_parts(parts, self._max_triangles) if self._max_triangles else parts
        return self._contents[key]


class _MeshResolver:
    """Resolver for trimesh that only returns files that were checked."""

    def __init__(self, file: AssetFile) -> None:
        self._by_name = {one.uri: one for one in file.names}
        self._by_words = {" ".join(one.uri.split()): one for one in file.names}

    def get(self, name: str) -> bytes:
        """Returns the content of a file. Raises OSError if it is not among the checked files."""
        one = self._by_name.get(name) or self.image(name.split())
        if one is None or one.path is None:
            raise FileNotFoundError(f"the mesh refers to {name!r}, which was not checked")
        return _read_file(one.path, one.sha256)

    __getitem__ = get

    def image(self, words: Iterable[str]) -> NamedFile | None:
        """Returns the image of an MTL line, from the words after `map_…`; None if it is not among the checked files."""
        return self._by_words.get(image_of_words(" ".join(words)))


def _read_file(path: Path, digest: str | None) -> bytes:
    """Returns the content of a file. Raises AssetError if it changed since it was checked."""
    try:
        return read_checked(path, digest)
    except ChangedError as error:
        raise AssetError("SC422", f"'{path}' changed while the scene was built") from error
    except OSError as error:
        raise AssetError("SC747", f"'{path}' cannot be read: {error.strerror}") from error


def _read_mesh(data: bytes, file: AssetFile) -> tuple[MeshPart, ...]:
    images, named = ImageCache(), _MeshResolver(file)
    return tuple(
        _convert_part(moved, _convert_material(moved.visual, file.path, named, images), smooth=smooth)
        for moved, smooth in _load_meshes(data, file)
    )


def _load_meshes(data: bytes, file: AssetFile) -> list[tuple[Any, bool]]:
    """Returns each mesh of a file in the file's frame [m], and whether the file has vertex normals."""
    path, suffix = file.path, file.path.suffix.lower()
    trimesh: Any = import_module("trimesh")  # only partly typed

    try:
        data = without_elements(data, LAMPS) if suffix == ".dae" else data
        scene = trimesh.load_scene(BytesIO(data), suffix[1:], resolver=_MeshResolver(file), process=False)
    except Exception as error:  # trimesh's readers raise anything
        raise AssetError("SC747", f"'{path}' cannot be read: {error}", "export the mesh again") from error
    found: list[tuple[Any, bool]] = []
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            found.append(_place_mesh(mesh, np.asarray(place)))
    if not found:
        raise AssetError("SC747", f"'{path}' has no triangles", "export the mesh again")
    return found


def _place_mesh(mesh: Any, place: Any) -> tuple[Any, bool]:
    # trimesh computes smooth normals on request; normals from the file are in this cache.
    smooth = "vertex_normals" in vars(mesh)["_cache"]
    moved = mesh.copy(include_cache=True)
    moved.apply_transform(place)
    moved.apply_scale(_collada_unit(mesh))
    return moved, smooth


def _convert_part(moved: Any, look: SurfaceMaterial, *, smooth: bool) -> MeshPart:
    normals = moved.vertex_normals if smooth else None
    uv = getattr(moved.visual, "uv", None)
    uvs = None if uv is None or len(uv) != len(moved.vertices) else np.column_stack([uv[:, 0], 1 - uv[:, 1]])
    return MeshPart(make_surface(moved.vertices, moved.faces, normals, uvs), look)


def _collada_unit(mesh: Any) -> float:
    """Returns COLLADA's unit of length [m], as applied by SAPIEN; other files are in metres."""
    number, times, _ = str(mesh.metadata.get("units", "")).partition(" * meters")
    return float(number) if times else 1.0


def _convert_material(visual: Any, path: Path, named: _MeshResolver, images: ImageCache) -> SurfaceMaterial:
    """Converts the material of a mesh. Vertex colours are ignored, as in SAPIEN."""
    material = getattr(visual, "material", None)
    if material is None:
        suffix = path.suffix.lower()
        plain, metallic = _DEFAULT_COLORS.get(suffix, _WHITE), _METALLIC.get(suffix, 0.0)
        return SurfaceMaterial(base_color=plain, specular=_SPECULAR, metallic=metallic)
    return (
        _convert_simple(material, path, named, images)
        if hasattr(material, "glossiness")
        else _convert_pbr(material, path)
    )


def _convert_pbr(material: Any, path: Path) -> SurfaceMaterial:
    name = path.stem
    shared = material.metallicRoughnessTexture
    color, glow = material.baseColorFactor, material.emissiveFactor
    image = convert_image(material.baseColorTexture, name, srgb=True)
    return SurfaceMaterial(
        base_color=_WHITE if color is None else _rgba(np.asarray(color) / 255),
        emission=to_vector(glow) if glow is not None else (0.0, 0.0, 0.0),
        specular=_SPECULAR,
        roughness=_number(material.roughnessFactor, 1.0),
        metallic=_number(material.metallicFactor, 1.0),
        base_color_image=image,
        normal_image=convert_image(material.normalTexture, name, srgb=False),
        roughness_image=convert_image(shared, name, "g", srgb=False),
        metallic_image=convert_image(shared, name, "b", srgb=False),
        emission_image=convert_image(material.emissiveTexture, name, srgb=True),
    )


def _convert_simple(material: Any, path: Path, named: _MeshResolver, images: ImageCache) -> SurfaceMaterial:
    """Converts an OBJ material. SAPIEN's reader derives roughness from `Ns` and `Ks`.

    Raises:
        AssetError: one of its images cannot be read.
    """
    given: dict[str, Any] = material.kwargs
    shine = min(max(_number(given.get("ns"), 0.0) / 1000, 0.0), 1.0) ** 0.5
    bright = float(np.dot(to_vector(given.get("ks", (0.0, 0.0, 0.0))), _LUMINANCE))
    opaque = _first(given.get("d"), 1.0)
    red, green, blue = to_vector(given.get("kd", _GRAY[:3]))
    return SurfaceMaterial(
        base_color=(red, green, blue, opaque),
        emission=to_vector(given.get("ke", (0.0, 0.0, 0.0))),
        specular=_SPECULAR,
        roughness=1 - shine * bright,
        base_color_image=convert_image(material.image, path.stem, srgb=True),
        **_mtl_images(given, named, images),
    )


def _mtl_images(given: dict[str, Any], files: _MeshResolver, images: ImageCache) -> dict[str, Any]:
    """Returns the images of a material that trimesh leaves as text."""
    named = {field: files.image(given[key]) for key, field in _MTL_MAPS.items() if given.get(key)}
    try:
        return {
            field: images.file(one.path, one.sha256, {"srgb": field == "emission_image"})
            for field, one in named.items()
            if one is not None and one.path is not None
        }
    except AssetError as problem:
        code = "SC747" if problem.code == "SC748" else problem.code  # a mesh's image cannot be left out
        raise AssetError(code, problem.message, problem.hint) from problem


def _first(words: Sequence[str] | None, default: float) -> float:
    return default if not words else float(words[0])


def _number(value: Any, default: float) -> float:
    return default if value is None else float(value)


def _rgba(values: Any) -> Vec4:
    red, green, blue, alpha = (float(value) for value in values)
    return red, green, blue, alpha
