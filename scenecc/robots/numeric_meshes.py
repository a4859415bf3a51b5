"""Meshes that are known by their numbers alone, such as those that only MuJoCo's compiler can read."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.files import keep_file
from scenecc.geometry.ply import encode_ply
from scenecc.geometry.rotations import to_vector
from scenecc.robots.description import MeshGeometry

if TYPE_CHECKING:
    from numpy.typing import NDArray

MIN_EXTENT: Final = 1e-5
"""Half the length along an axis up to which a mesh is flat there [m]."""


def numeric_mesh(
    name: str, vertices: NDArray[Any], triangles: NDArray[Any], normals: Any = None, uvs: Any = None
) -> MeshGeometry:
    """A mesh of numbers. It collides as its convex hull, unless the scene decomposes meshes, and is seen as it is.

    It is kept as a PLY in the user's cache folder, by its content, so that a process cooks equal meshes once, and it
    goes with the plan. Each of its axes has a length of 2 there and the scale has its size: PhysX leaves out corners
    within 0.7 mm of a hull before it is scaled, so that small and oblong meshes would lose half of their mass.

    Args:
        name: what messages call it.
        vertices: (V, 3) [m].
        triangles: (T, 3) indices of vertices, counterclockwise from outside.
        normals: (V, 3) of unit length; None: each vertex has that of one of its triangles.
        uvs: (V, 2) texture coordinates from the image's top left corner.

    Raises:
        OSError: the cache folder cannot be written.
    """
    extent = np.ptp(vertices, axis=0) / 2
    scale = np.where(extent > MIN_EXTENT, extent, 1.0)
    if normals is not None:
        normals = normals * scale
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    data = encode_ply(vertices / scale, triangles, normals, uvs)
    uri = f"mesh://{re.sub(r'[^A-Za-z0-9_.-]', '_', name)[:80]}.ply"
    return MeshGeometry(uri, keep_file("meshes", data, ".ply"), to_vector(scale), data=data)
