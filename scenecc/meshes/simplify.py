"""Simplifies surfaces of mesh files with many triangles, for exports that are smaller."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.meshes.surface import MeshPart, Surface

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

_FINEST: Final = 4096
"""Maximum number of grid cells along the longest side of a mesh."""


_SMALL: Final = 100
"""Number of triangles up to which a part stays as it is."""


def simplify_parts(parts: Sequence[MeshPart], most: int) -> tuple[MeshPart, ...]:
    """Returns the parts of a mesh with about `most` triangles together, and each with its share of them.

    A part with too many has the vertices in each cell of a grid merged into one, at their mean (J. Rossignac and P.
    Borrel, "Multi-resolution 3D approximations for rendering complex scenes", 1993), on the finest grid that suffices.
    """
    total = sum(len(part.surface.faces) for part in parts)
    if total <= most:
        return tuple(parts)
    shares = [max(_SMALL, most * len(part.surface.faces) // total) for part in parts]
    return tuple(MeshPart(_simplify(part.surface, share), part.look) for part, share in zip(parts, shares, strict=True))


def _simplify(surface: Surface, most: int) -> Surface:
    if len(surface.faces) <= most:
        return surface
    coarse, fine = 1, _FINEST
    while fine - coarse > 1:
        middle = (coarse + fine) // 2
        fits = len(_merged_faces(surface, _cells(surface, middle)[1])) <= most
        coarse, fine = (middle, fine) if fits else (coarse, middle)
    first, cell = _cells(surface, coarse)
    faces = _merged_faces(surface, cell)
    if not len(faces):
        return surface
    vertices = _means(surface.vertices, cell)
    normals = None if surface.normals is None else _means(surface.normals, cell)
    if normals is not None:
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.float32(1e-12))
    return Surface(vertices, faces, normals, None if surface.uvs is None else surface.uvs[first])


def _cells(surface: Surface, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Returns the first vertex in each cell of a grid, and the cell of each vertex (V,)."""
    low = surface.vertices.min(axis=0)
    size = float((surface.vertices.max(axis=0) - low).max()) / count or 1.0
    x, y, z = ((surface.vertices - low) / size).astype(np.int64).T
    key: Any = (x * (_FINEST + 1) + y) * (_FINEST + 1) + z
    _, first, cell = np.unique(key, return_index=True, return_inverse=True)
    return first, cell.reshape(-1)


def _merged_faces(surface: Surface, cell: NDArray[np.int64]) -> NDArray[np.int64]:
    """Returns the triangles whose corners are in three cells, each once."""
    faces = cell[surface.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    faces = np.take_along_axis(faces, (faces.argmin(axis=1)[:, None] + np.arange(3)) % 3, axis=1)
    return np.unique(faces, axis=0)


def _means(rows: NDArray[np.float32], cell: NDArray[np.int64]) -> NDArray[np.float32]:
    count = np.bincount(cell)
    columns = [np.bincount(cell, column) / count for column in rows.T]
    return np.stack(columns, axis=1).astype(np.float32)
