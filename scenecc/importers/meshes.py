"""Creates OBJ meshes: triangles of other formats, ellipsoids, extruded polygons."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.assets.images import read_heights
from scenecc.files import read_at_most
from scenecc.geometry.obj import encode_obj
from scenecc.geometry.triangles import join_parts
from scenecc.lower.shapes import MAX_HEIGHTS
from scenecc.meshes.primitives import sphere
from scenecc.named_files import asset_files
from scenecc.plan.body import AssetFile

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from scenecc.importers.imported_scene import ImportContext


class MeshError(ValueError):
    """Reason why a mesh cannot be made."""


def ellipsoid_obj() -> bytes:
    """Returns a unit sphere, to be scaled."""
    surface = sphere()
    return encode_obj(surface.vertices, surface.faces)


@dataclass(frozen=True, slots=True)
class MeshFile:
    """A loaded mesh file.

    Attributes:
        path: path of the file.
        content: content of the file.
        parts: vertices and faces of each part [m].
        missing: materials and images that it refers to but that do not exist.
    """

    path: Path
    content: bytes
    parts: list[tuple[NDArray[Any], NDArray[Any]]]
    missing: tuple[str, ...]


def load_mesh(path: Path, context: ImportContext) -> MeshFile:
    """Reads a mesh file inside the scope of the import.

    Raises:
        MeshError: it is not a mesh, is too large, or a buffer that it refers to is missing.
    """
    asset, files = AssetFile(path.name, path), asset_files(context.scope, context.limits)
    missing: list[str] = []
    try:
        for reference in files.mesh(asset).names:
            try:
                files.content(files.resolve(asset, reference))
            except AssetError:  # noqa: PERF203 - each file may be missing
                missing.append(reference.uri)
        return MeshFile(path, files.content(path), list(files.triangles(asset)), tuple(missing))
    except AssetError as error:
        raise MeshError(f"{path.name}: {error.message}") from error


def _read(path: Path, most: int) -> bytes:
    try:
        return read_at_most(path, most)
    except OSError as error:
        raise MeshError(f"{path.name} cannot be read: {error.strerror}") from error


def mesh_as_obj(mesh: MeshFile, *, submesh: str, scale: list[float], center: bool) -> bytes:
    """Returns the triangles of a mesh file as OBJ. A mirroring scale reverses their winding.

    Args:
        mesh: the file.
        submesh: name of the part to use; "": all parts.
        scale: factors along x, y and z.
        center: whether to centre the bounds at the origin.

    Raises:
        MeshError: it has no such part.
    """
    meshes = _named_parts(mesh, submesh) if submesh else mesh.parts
    vertices, faces = join_parts(meshes)
    vertices = vertices * scale
    if center:
        vertices = vertices - (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return encode_obj(vertices, faces[:, ::-1] if np.prod(scale) < 0 else faces)


def check_terrain_file(path: Path, context: ImportContext) -> None:
    """Raises MeshError if a file is not a terrain that a scene can use."""
    try:
        read_heights(_read(path, context.limits.asset_bytes), MAX_HEIGHTS)
    except ValueError as error:
        raise MeshError(str(error)) from error


def _named_parts(mesh: MeshFile, name: str) -> list[tuple[NDArray[Any], NDArray[Any]]]:
    import trimesh

    library: Any = trimesh
    try:
        scene = library.load_scene(BytesIO(mesh.content), mesh.path.suffix[1:].lower(), process=False)
    except Exception as error:  # trimesh's readers raise anything
        raise MeshError(f"{mesh.path.name} cannot be read: {error}") from error
    found: list[tuple[NDArray[Any], NDArray[Any]]] = []
    for node in scene.graph.nodes_geometry:
        place, key = scene.graph[node]
        if name in {node, key}:
            part = scene.geometry[key].copy()
            part.apply_transform(place)
            found.append((part.vertices, part.faces))
    if not found:
        raise MeshError(f"{mesh.path.name} has no part `{name[:60]}`")
    return found


def polyline_obj(corners: list[tuple[float, float]], height: float) -> bytes:
    """Returns a polygon in the plane z = 0, extruded along z [m], as OBJ.

    Raises:
        MeshError: it is not a simple polygon.
    """
    points = [corner for i, corner in enumerate(corners) if corner != corners[i - 1] or len(corners) == 1]
    if len(points) < 3:
        raise MeshError("has fewer than three corners")
    if len(points) > 1000:
        raise MeshError("has more than 1000 corners")
    if _area(points) < 0:
        points.reverse()
    cap, n = _triangulate_polygon(points), len(points)
    vertices = np.array([(x, y, z) for z in (0.0, height) for x, y in points])
    sides = [(i, (i + 1) % n, (i + 1) % n + n) for i in range(n)] + [(i, (i + 1) % n + n, i + n) for i in range(n)]
    top = [(a + n, b + n, c + n) for a, b, c in cap]
    return encode_obj(vertices, np.array([*((c, b, a) for a, b, c in cap), *top, *sides]))


def _area(points: list[tuple[float, float]]) -> float:
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(points, [*points[1:], points[0]], strict=True)) / 2


def _triangulate_polygon(points: list[tuple[float, float]]) -> list[tuple[int, int, int]]:
    """Triangulates a counterclockwise polygon by ear clipping."""
    left, found = list(range(len(points))), list[tuple[int, int, int]]()
    while len(left) > 2:
        for i in range(len(left)):
            a, b, c = left[i - 1], left[i], left[(i + 1) % len(left)]
            triangle = [points[a], points[b], points[c]]
            if _area(triangle) > 0 and not any(_is_inside(points[k], triangle) for k in left if k not in {a, b, c}):
                found.append((a, b, c))
                del left[i]
                break
        else:
            raise MeshError("crosses itself")
    return found


def _is_inside(point: tuple[float, float], triangle: list[tuple[float, float]]) -> bool:
    return all(_area([triangle[i], triangle[(i + 1) % 3], point]) >= 0 for i in range(3))
