"""Reads a mesh file into `MeshData`: a table of formats."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from typing import Any, cast

import numpy as np

from scenecc.checks.mesh_data import AssetError, MeshData, Part, Reading, part
from scenecc.checks.mesh_gltf import read_gltf
from scenecc.checks.mesh_obj import read_obj

_PLY_COUNT = re.compile(rb"element\s+\w+\s+(\d+)")

Reader = Callable[[bytes, Reading], MeshData]


def read_mesh(data: bytes, suffix: str, reading: Reading) -> MeshData:
    """Reads a mesh.

    Args:
        data: the file.
        suffix: its suffix in lower case, one of `MESH_SUFFIXES`.
        reading: what may be read beside it, and how much.

    Raises:
        AssetError: it cannot be read, or a file that it names cannot.
    """
    return _READERS[suffix](data, reading)


def _by_trimesh(kind: str) -> Reader:
    def read(data: bytes, reading: Reading) -> MeshData:
        del reading
        if kind == "ply":
            _check_ply_counts(data)
        return MeshData(_load(data, kind))

    return read


def _check_ply_counts(data: bytes) -> None:
    """A PLY may claim any number of vertices; each takes at least a byte."""
    header = data[: data.find(b"end_header") + 1][:65536]
    if any(len(digits) > 12 or int(digits) > len(data) for digits in _PLY_COUNT.findall(header)):
        raise AssetError("SC412", "the PLY is cut short: it claims more elements than it has bytes", "export it again")


def _load(data: bytes, kind: str) -> tuple[Part, ...]:
    # Only where a mesh is used: loading it takes longer than checking most scenes.
    import trimesh

    try:
        loaded = cast("Any", trimesh).load(io.BytesIO(data), file_type=kind, process=False)
    except Exception as error:
        # trimesh's readers run into whatever a broken file leads them to (IndexError, struct.error, AttributeError, …),
        # and promise no set of exceptions. Nothing but the reading of this one file stands in the try.
        said = str(error) or type(error).__name__
        raise AssetError(
            "SC412", f"the {kind.upper()} cannot be read: {said[:200]}", "export the mesh again"
        ) from error
    found: list[Any] = list(loaded.geometry.values()) if hasattr(loaded, "geometry") else [loaded]
    return tuple(
        part(np.asarray(one.vertices, dtype=np.float64), np.asarray(one.faces, dtype=np.int64).reshape(-1, 3))
        for one in found
        if len(getattr(one, "faces", ()))
    )


_READERS: dict[str, Reader] = {
    ".obj": read_obj,
    ".gltf": read_gltf,
    ".glb": read_gltf,
    ".stl": _by_trimesh("stl"),
    ".ply": _by_trimesh("ply"),
    ".off": _by_trimesh("off"),
}

MESH_SUFFIXES = tuple(_READERS)
"""The formats that are read, by suffix."""
