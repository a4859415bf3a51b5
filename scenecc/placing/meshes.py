"""Colliding meshes of files: the corners and triangles that PhysX cooks."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.meshes.files import read_collada_triangles

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan import AssetFile

    Floats = NDArray[np.float64]

Mesh = tuple[Any, Any]
"""Corners (V, 3) [m] and triangles (T, 3)."""


@lru_cache(maxsize=256)
def mesh_of(file: AssetFile) -> Mesh:
    """All of a file as one mesh, corners in one place joined.

    Raises:
        MeshError: it cannot be read.
    """
    parts = read_collada_triangles(file)
    first = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    vertices = np.concatenate([vertices for vertices, _ in parts]).astype(np.float64)
    faces = np.concatenate([faces + start for (_, faces), start in zip(parts, first, strict=False)])
    points, index = np.unique(vertices, axis=0, return_inverse=True)
    return points, index.reshape(-1)[faces]


@lru_cache(maxsize=256)
def connected_hulls(file: AssetFile) -> tuple[Floats, ...]:
    """The corners of each connected part of a file [m]."""
    points, faces = mesh_of(file)
    label = np.arange(len(points))
    while True:
        least = label[faces].min(axis=1)
        before = label.copy()
        np.minimum.at(label, faces, least[:, None])
        label = label[label]
        if (label == before).all():
            break
    used = np.unique(faces)
    return tuple(points[used][label[used] == one] for one in np.unique(label[used]))
