"""The process that reads mesh files with trimesh and pycollada, and returns triangles and measures.

A part is what SAPIEN loads as one mesh: a mesh of a glTF or a primitive of a COLLADA, once for each node that shows it;
an object or group of an OBJ; a whole STL or PLY.
"""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Iterator
from dataclasses import asdict
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.assets.collada import LAMPS, LOOKS, without_elements
from scenecc.assets.errors import AssetError
from scenecc.assets.images import check_image
from scenecc.assets.measures import hull_parts, measure_hull, measure_triangles
from scenecc.assets.mesh_colors import shows_colors
from scenecc.assets.names import MeshNames, scan_names
from scenecc.geometry.triangles import join_parts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.worker_process import Answer, Message

    Vertices = NDArray[np.float64]
    """(n, 3) [m]."""

    Triangles = tuple[NDArray[np.float64], NDArray[np.int64]]
    """Vertices (n, 3) [m] and faces (m, 3)."""


TRIANGLES_RATIO = 3
"""Largest size of the triangles, relative to the limit of a file."""

_TRIANGLE_BYTES = 24
"""Size of a vertex, and of the indices of a face."""

_UNUSED = ("networkx", "scipy", "shapely")
"""Packages that trimesh imports if they are installed, which is slow. They are not needed here."""


_HULLS = {"hull": (False, measure_hull), "hulls": (True, measure_hull), "parts": (True, measure_triangles)}
"""Requested measures of hulls: whether of all convex parts, and the measuring function."""


def prepare() -> Answer:
    """Imports the libraries, since the process may not open files later, and returns the function for requests."""
    for name in _UNUSED:
        sys.modules[name] = None  # pyright: ignore[reportArgumentType] - importing it raises ImportError
    libraries = import_module("trimesh"), import_module("collada")
    import_module("PIL.Image").init()

    def answer(header: dict[str, Any], parts: list[bytes]) -> Message:
        """Reads one file.

        Args:
            header: `suffix` of the file in lower case; `buffers`, the names of further parts, or None if they are not
                known yet; `max_bytes` of an image, and a third of the limit of triangles; `wanted`: "record",
                "triangles", "hull", "hulls" or "parts".
            parts: content of the file and of its buffers.

        Returns:
            A header with `error` (code, message, hint), or with the data of `MeshRecord`, or with only `names` if
                buffers are needed. For triangles, vertices (float64) and faces (int64) of each part follow. For "hull",
                all convex parts ("hulls") or these without volumes ("parts"), the header has measures as `hulls`.
        """
        try:
            names = scan_names(parts[0], header["suffix"])
            found: dict[str, Any] = {"names": [[one.uri, one.kind, one.escaped] for one in names.references]}
            if header["buffers"] is None and any(one.kind == "buffer" for one in names.references):
                return found, []
            buffers: dict[str, bytes] = dict(zip(header["buffers"] or (), parts[1:], strict=True))
            unused: list[Vertices] = []
            colors: list[NDArray[np.uint8]] = []
            most = header["max_bytes"]
            read = list(_read(libraries, parts[0], header["suffix"], buffers, TRIANGLES_RATIO * most, unused, colors))
            if header["wanted"] == "triangles":
                return found, [array.tobytes() for part in read for array in part]
            if header["wanted"] in _HULLS:
                suffix, (parts_only, measured) = header["suffix"], _HULLS[header["wanted"]]
                hulls = hull_parts(read, suffix) if parts_only else [_hull_points(read, unused, suffix)]
                return found | {"hulls": [asdict(measured(*hull)) for hull in hulls]}, []
            faults, unpacked = _check_images(names, most)
            found |= {"visual_faults": [[one.code, one.message, one.hint] for one in faults]}
            found |= {"vertex_colors": shows_colors(parts[0], header["suffix"], colors)}
            found |= {"bytes": max(unpacked, _triangle_bytes(read) // TRIANGLES_RATIO)}
            return found | {"parts": [asdict(measure_triangles(*part)) for part in read]} | _total_measures(
                read, unused
            ), []
        except AssetError as error:
            return {"error": [error.code, error.message, error.hint]}, []

    return answer


def _check_images(names: MeshNames, max_bytes: float) -> tuple[list[AssetError], int]:
    """Returns why a mesh cannot be rendered, and the size of its largest image [bytes]."""
    faults = [] if names.visual_fault is None else [names.visual_fault]
    largest = 0
    for image in names.images:
        try:
            largest = max(largest, check_image(image, max_bytes).unpacked)
        except AssetError as error:  # noqa: PERF203 - each image has its own
            faults.append(error)
    return faults, largest


def _triangle_bytes(parts: list[Triangles]) -> int:
    return sum(_TRIANGLE_BYTES * (len(vertices) + len(faces)) for vertices, faces in parts)


_UNHELPFUL_ERRORS = (ArithmeticError, AttributeError, LookupError, TypeError)
"""Errors of the libraries whose text does not help a user."""


def _read(
    libraries: tuple[Any, Any],
    data: bytes,
    suffix: str,
    buffers: dict[str, bytes],
    most: float,
    unused: list[Vertices],
    colors: list[NDArray[np.uint8]],
) -> Iterator[Triangles]:
    """Yields the parts that have triangles. Raises AssetError.

    Adds vertices without triangles to `unused`, and colours (n, 4) of vertices or faces to `colors`.
    """
    trimesh, collada = libraries
    taken = 0
    try:
        for vertices, faces in (
            _collada_parts(collada, data) if suffix == ".dae" else _parts(trimesh, data, suffix, buffers, colors)
        ):
            if not len(faces):
                continue
            used, flat = np.unique(faces, return_inverse=True)
            taken += _TRIANGLE_BYTES * (len(used) + len(faces))
            _check_part(used, len(vertices), taken, most)
            unused.append(np.delete(vertices, used, axis=0))
            yield vertices[used], flat.reshape(-1, 3).astype(np.int64)
    except AssetError:
        raise
    except MemoryError as error:
        raise AssetError("SC607", "the mesh takes too much memory", "simplify it") from error
    except Exception as error:  # the libraries may raise anything
        words = _plain_words(error)
        raise AssetError("SC412", f"the mesh cannot be read: {words}", "export the mesh again") from error


_UNHELPFUL_WORDS = (
    ("string or file could not be read to its end", "a number in it cannot be read"),
    ("invalid literal for int()", "a number in it cannot be read"),
    ("PLY is unexpected length", "it is truncated or damaged"),
    ("No active exception", "it has an element that pycollada does not read"),
)


def _plain_words(error: Exception) -> str:
    if isinstance(error, _UNHELPFUL_ERRORS):
        return "it is truncated or damaged"
    words = " ".join(str(error).split())[:200]
    return next((plain for beginning, plain in _UNHELPFUL_WORDS if words.startswith(beginning)), words)


def _check_part(used: NDArray[np.int64], vertices: int, taken: int, most: float) -> None:
    """Raises AssetError if faces refer to missing vertices, or the triangles so far take too many bytes."""
    if used[0] < 0 or used[-1] >= vertices:
        raise AssetError("SC412", "a face refers to a missing vertex", "export the mesh again")
    if taken > most:
        hint = "simplify it, or raise the limit with --limit asset_bytes=N"
        raise AssetError("SC607", f"the triangles of the mesh take more than {most} bytes", hint)


def _parts(
    trimesh: Any, data: bytes, suffix: str, buffers: dict[str, bytes], colors: list[NDArray[np.uint8]]
) -> Iterator[Triangles]:
    options: dict[str, Any] = {"process": False, "skip_materials": True}
    data = _plain_text(data, suffix)
    if suffix == ".obj":
        options |= {"group_material": False, "split_objects": True, "split_groups": True}
    scene = trimesh.load_scene(io.BytesIO(data), suffix[1:], resolver=buffers, **options)
    found: dict[str, list[Triangles]] = {}
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh):
            vertices = np.asarray(mesh.vertices, np.float64)
            if mesh.visual.kind in {"face", "vertex"}:
                colors.append(np.asarray(getattr(mesh.visual, f"{mesh.visual.kind}_colors")))
            if not np.array_equal(place, np.eye(4)):
                vertices = vertices @ place[:3, :3].T + place[:3, 3]
            # Primitives of one glTF mesh are children of its node.
            whole = scene.graph.transforms.parents[node] if mesh.metadata.get("from_gltf_primitive") else node
            found.setdefault(whole, []).append((vertices, np.asarray(mesh.faces)))
    _check_length(data, suffix, sum(len(faces) for parts in found.values() for _, faces in parts))
    yield from (join_parts(parts) if len(parts) > 1 else parts[0] for parts in found.values())


_PLY_HEADER = re.compile(rb"ply\s.*?\bend_header\b", re.DOTALL)


def _plain_text(data: bytes, suffix: str) -> bytes:
    """Returns a text file in the form that trimesh needs: UTF-8, and without tabs for an OBJ. May raise ValueError."""
    if suffix == ".obj":
        data = data.replace(b"\t", b" ")
    header = _PLY_HEADER.match(data) if suffix == ".ply" else None
    is_text = suffix == ".obj" or (suffix == ".stl" and not _is_binary(data))
    end = header.end() if header is not None else len(data) if is_text else 0
    return data if data[:end].isascii() else data[:end].decode("utf-8", "replace").encode() + data[end:]


def _is_binary(data: bytes) -> bool:
    """Returns whether an STL is binary, by its length, since its header may begin like text. May raise ValueError."""
    if len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        return True
    if not data.lstrip().startswith(b"solid"):
        raise ValueError("its length does not match the number of triangles in its header")
    return False


_PLY_FACES = re.compile(rb"\nelement[ \t]+face[ \t]+(\d+)")


def _check_length(data: bytes, suffix: str, faces: int) -> None:
    """Raises ValueError if trimesh has read fewer faces than the file has, since it skips text that it cannot read."""
    if suffix == ".ply" and (match := _PLY_FACES.search(data)) is not None and faces < int(match[1]):
        raise ValueError(f"its header declares {int(match[1])} faces, but it has {faces}")
    if suffix == ".stl" and not _is_binary(data):
        vertices = data.lower().count(b"vertex")
        if vertices > 3 * faces:
            raise ValueError(f"it is truncated or damaged: it has {vertices} vertices and only {faces} whole triangles")


_MOST_INSTANCES = 20_000
"""Largest number of geometry instances in a COLLADA, because a small file can place one very often."""


def _collada_parts(collada: Any, data: bytes) -> Iterator[Triangles]:
    """Yields the primitives of a COLLADA [m]. SAPIEN applies its unit and ignores its `up_axis`."""
    # pycollada skips geometry whose effect it cannot read.
    document = collada.Collada(io.BytesIO(without_elements(data, LAMPS | LOOKS)))
    if document.scene is None:
        raise ValueError("it does not have exactly one visual scene")
    if len(document.controllers):
        raise AssetError("SC410", "the COLLADA has a skin or a morph", "export only the mesh, as GLB")
    unit = float(document.assetInfo.unitmeter or 1.0)
    for number, geometry in enumerate(document.scene.objects("geometry")):
        if number == _MOST_INSTANCES:
            raise AssetError("SC607", f"the COLLADA places more than {_MOST_INSTANCES} geometries", "simplify the mesh")
        for primitive in geometry.primitives():
            triangles = primitive.triangleset() if hasattr(primitive, "triangleset") else primitive
            if isinstance(triangles, collada.triangleset.BoundTriangleSet) and triangles.vertex_index is not None:
                yield np.asarray(triangles.vertex, np.float64) * unit, np.asarray(triangles.vertex_index)


def _total_measures(read: list[Triangles], unused: list[Vertices]) -> dict[str, Any]:
    """Returns measures of all parts together, and of the vertices without triangles."""
    if not read:
        return {"whole": None, "unused": 0, "beyond": 0.0}
    whole = measure_triangles(*join_parts(read))
    points = np.concatenate(unused)
    beyond = float(np.maximum(whole.low - points, points - whole.high).max(initial=0.0))
    return {"whole": asdict(whole), "unused": len(points), "beyond": beyond}


def _hull_points(read: list[Triangles], unused: list[Vertices], suffix: str) -> Triangles:
    """Returns all parts, for a PLY with its vertices without triangles, which SAPIEN includes in the hull."""
    vertices, faces = join_parts(read)
    return (np.concatenate([vertices, *unused]) if suffix == ".ply" else vertices), faces
