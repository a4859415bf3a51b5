"""Mesh readers by file suffix, and what a mesh must satisfy for each use so that PhysX cooks what the file shows.

The readers are scenecc's own: a check must be at least as strict as SAPIEN's readers, some of which end the process
on a broken file, and an untrusted file must not use more memory than the limit allows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from scenecc.checks.mesh_collada import read_collada
from scenecc.checks.mesh_data import AssetError, MeshData, connected_parts, principal_extents, surface_area
from scenecc.checks.mesh_gltf import read_gltf
from scenecc.checks.mesh_obj import read_obj
from scenecc.checks.mesh_ply import read_ply
from scenecc.checks.mesh_stl import read_stl

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.checks.mesh_data import MeshReadContext


_READERS: dict[str, Callable[[bytes, MeshReadContext], MeshData]] = {
    ".obj": read_obj,
    ".gltf": read_gltf,
    ".glb": read_gltf,
    ".stl": read_stl,
    ".ply": read_ply,
    ".dae": read_collada,
}

VISUAL_ONLY_SUFFIXES = (".dae",)
"""The formats that are read for what is only seen, by suffix in lower case."""

MESH_SUFFIXES = tuple(suffix for suffix in _READERS if suffix not in VISUAL_ONLY_SUFFIXES)
"""The formats that are read for every use, likewise."""


def read_mesh(data: bytes, suffix: str, reading: MeshReadContext) -> MeshData:
    """Reads a mesh.

    Args:
        data: the file.
        suffix: its suffix in lower case, one of `MESH_SUFFIXES` or `VISUAL_ONLY_SUFFIXES`.
        reading: what may be read beside it, and how much.

    Raises:
        AssetError: it cannot be read, or a file that it names cannot.
    """
    return _READERS[suffix](data, reading)


MAX_COORDINATE = 1e6
"""Largest coordinate [m]. At 1e9 m PhysX can no longer compute the mass of a hull."""

MIN_THICKNESS = 1e-5
"""Thickness below which a hull is refused [m]. PhysX cooks a thinner one to something else, or not at all."""

HULL_TOLERANCE = 0.0007
"""PhysX's hull leaves out corners that are this close to it [m] (`PxCookingParams::planeTolerance`)."""

_MIN_LENGTH = 0.01
"""Length of a mesh at which that tolerance takes a tenth of its volume and more [m]."""


def check_mesh_use(mesh: MeshData, use: str, suffix: str) -> Iterator[AssetError]:
    """Faults of a mesh in one use, the first of a part alone.

    Args:
        mesh: what was read.
        use: "hull", "parts", "triangles", "decomposed" or "seen".
        suffix: of the file, in lower case.
    """
    if not mesh.parts:
        yield AssetError("SC413", "the mesh has no triangles", "export it with its faces")
        return
    vertices = np.concatenate([one.vertices for one in mesh.parts])
    fault = _coordinate_fault(vertices)
    if fault is not None:
        yield fault
        return
    if use == "seen" and mesh.fault is not None:
        yield mesh.fault
    if use == "parts" and suffix == ".stl":
        yield AssetError(
            "SC421",
            "an STL has no parts: SAPIEN guesses them from its triangles",
            "export the parts as objects of an OBJ",
        )
    if use in {"triangles", "decomposed"} and all(surface_area(one) == 0 for one in mesh.parts):
        yield AssetError("SC415", "all triangles of the mesh are points or lines", "export the mesh again")
    if use == "hull":
        yield from _hull_faults([vertices], "")
    if use == "parts":
        parts = (
            [loose for one in mesh.parts for loose in connected_parts(one)]
            if suffix in {".ply", ".stl"}
            else mesh.parts
        )
        yield from _hull_faults([one.vertices for one in parts], " of one of its parts")


def _coordinate_fault(vertices: NDArray[np.float32]) -> AssetError | None:
    largest = float(np.abs(vertices).max())
    if not np.isfinite(largest):
        return AssetError("SC414", "the mesh has coordinates that are not finite", "export it again")
    if largest > MAX_COORDINATE:
        return AssetError(
            "SC417",
            f"the mesh reaches {largest:.3g} m from its origin, and {MAX_COORDINATE:.0e} m is the most",
            "export it in metres, about its own centre",
        )
    return None


def _hull_faults(clouds: list[NDArray[np.float32]], whose: str) -> Iterator[AssetError]:
    sizes = [principal_extents(cloud) for cloud in clouds]
    thin = min(thickness for thickness, _ in sizes)
    if thin < MIN_THICKNESS:
        yield AssetError(
            "SC415", f"the hull{whose} has no volume: it is {thin:.3g} m thick", "give it a thickness, or use a box"
        )
        return
    small = min(length for _, length in sizes)
    if thin < 2 * HULL_TOLERANCE or small < _MIN_LENGTH:
        yield AssetError(
            "SC416",
            f"the hull{whose} is {thin:.3g} m thick and {small:.3g} m long, and PhysX leaves out corners within "
            f"{HULL_TOLERANCE} m",
            "store the mesh larger and give the shape a `scale`: corners are left out before it is scaled",
        )
