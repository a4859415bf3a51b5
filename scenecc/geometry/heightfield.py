"""Heightfields as triangles. Emitted scripts bring this function with them as it is written here."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def heightfield_surface(size: Any, heights: Any) -> tuple[NDArray[Any], ...]:
    """The triangles of a heightfield about its origin.

    Args:
        size: extents along x and y, and how high a 1 is [m].
        heights: (R, C), rows from +y to -y, each from -x to +x.

    Returns:
        Vertices (V, 3) [m], triangles (T, 3) counterclockwise from above, normals (V, 3), and
        texture coordinates (V, 2) from the image's top left corner.
    """
    levels = np.array(heights, np.float64)
    rows, columns = len(levels), len(levels[0])
    across, down = np.linspace(0, 1, columns), np.linspace(0, 1, rows)
    u, v = np.meshgrid(across, down)
    grid = np.stack([u - 0.5, 0.5 - v, levels], axis=-1) * np.array(size, np.float64)
    here = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    a, b, c, d = here, here + columns, here + columns + 1, here + 1
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    along_x = np.gradient(grid[..., 2], axis=1) / np.gradient(grid[..., 0], axis=1)
    along_y = np.gradient(grid[..., 2], axis=0) / np.gradient(grid[..., 1], axis=0)
    normals = np.stack([-along_x, -along_y, np.ones_like(levels)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    uvs = np.stack([u, v], axis=-1)
    return grid.reshape(-1, 3), triangles, normals.reshape(-1, 3), uvs.reshape(-1, 2)
