"""The mesh formats that are read, by suffix.

They are read here and not by a library: a check has to be at least as strict as SAPIEN's readers, some of which end the
process on a broken file, and a file from a stranger must not make it use more memory than the limit allows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from scenecc.checks.mesh_dae import read_dae
from scenecc.checks.mesh_gltf import read_gltf
from scenecc.checks.mesh_obj import read_obj
from scenecc.checks.mesh_ply import read_ply
from scenecc.checks.mesh_stl import read_stl

if TYPE_CHECKING:
    from scenecc.checks.mesh_data import MeshData, Reading

_READERS: dict[str, Callable[[bytes, Reading], MeshData]] = {
    ".obj": read_obj,
    ".gltf": read_gltf,
    ".glb": read_gltf,
    ".stl": read_stl,
    ".ply": read_ply,
    ".dae": read_dae,
}

SEEN_SUFFIXES = (".dae",)
"""The formats that are read for what is only seen, by suffix in lower case."""

MESH_SUFFIXES = tuple(suffix for suffix in _READERS if suffix not in SEEN_SUFFIXES)
"""The formats that are read for every use, likewise."""


def read_mesh(data: bytes, suffix: str, reading: Reading) -> MeshData:
    """Reads a mesh.

    Args:
        data: the file.
        suffix: its suffix in lower case, one of `MESH_SUFFIXES` or `SEEN_SUFFIXES`.
        reading: what may be read beside it, and how much.

    Raises:
        AssetError: it cannot be read, or a file that it names cannot.
    """
    return _READERS[suffix](data, reading)
