"""Surfaces and convex parts of solids of revolution, ellipsoids and terrain."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


Profile = tuple[tuple[float, float], ...]


def revolved_points(profile: Any, turn: float = 0.0) -> NDArray[Any]:
    """Returns the corners of a profile revolved about x, (corners, 32, 3) [m].

    `turn`: start angle of the circles, in steps between corners.
    """
    x, radius = np.array(profile, np.float64).T[:, :, None]
    angle = (np.arange(32) + turn) * (2 * np.pi / 32)
    y, z = radius * np.cos(angle), radius * np.sin(angle)
    return np.stack(np.broadcast_arrays(x, y, z), axis=-1)


def revolved_parts(profile: Any) -> list[NDArray[Any]]:
    """Returns the convex parts of a solid of revolution, (V, 3) [m]: 1 if it touches x, else 32."""
    circles = revolved_points(profile)
    radii = [radius for _, radius in profile]
    if min(radii) == 0:
        corners = zip(circles, radii, strict=True)
        return [np.concatenate([circle if radius else circle[:1] for circle, radius in corners])]
    return [np.concatenate([circles[:, side - 1], circles[:, side]]) for side in range(32)]


def revolved_surface(profile: Any) -> tuple[NDArray[Any], ...]:
    """Returns the surface of a solid of revolution, with an edge at each corner of its profile.

    Returns:
        Vertices (V, 3) [m], triangles (T, 3) counterclockwise from outside, normals (V, 3), and
        texture coordinates (V, 2), all (0, 0).
    """
    vertices: list[NDArray[Any]] = []
    normals: list[NDArray[Any]] = []
    triangles: list[NDArray[Any]] = []
    here = np.arange(32)
    there = (here + 1) % 32
    for start, end in zip(profile, (*profile[1:], profile[0]), strict=True):
        if not start[1] and not end[1]:
            continue
        along, inward = end[0] - start[0], start[1] - end[1]
        normal = np.array([inward, along]) / np.hypot(along, inward)
        first = 32 * len(vertices)
        for (x, radius), half in ((start, -0.5), (end, 0.5)):
            turn = 0.0 if radius else half  # normals at a tip are those of the triangle centres
            vertices.append(revolved_points([(x, radius)], turn)[0])
            normals.append(revolved_points([normal], turn)[0])
        if start[1]:
            triangles.append(first + np.stack([here, there, 32 + here], axis=1))
        if end[1]:
            triangles.append(first + np.stack([there, 32 + there, 32 + here], axis=1))
    points = np.concatenate(vertices)
    uvs = np.zeros((len(points), 2))
    return points, np.concatenate(triangles), np.concatenate(normals), uvs


@lru_cache(maxsize=64)
def cached_parts(profile: Profile) -> tuple[NDArray[Any], ...]:
    """Like `revolved_parts`, but returns the same arrays for the same profile. They must not be modified."""
    return tuple(revolved_parts(profile))


def ellipsoid_surface(radii: Any) -> tuple[NDArray[Any], ...]:
    """Returns a convex polyhedron with the volume of an ellipsoid about its origin, since SAPIEN has no ellipsoids.

    It is a stretched globe with 22 meridians and 10 parallels, poles on z. Its 222 corners and 242 faces are within
    PhysX's limit of 255 for a hull. An inscribed one would have 3.4 % less volume; these corners lie 1.1 % outside.

    Args:
        radii: along x, y and z [m].

    Returns:
        As `revolved_surface`; the poles have duplicate vertices.
    """
    down, around = np.meshgrid(np.linspace(0, np.pi, 12), np.arange(22) * (2 * np.pi / 22), indexing="ij")
    globe = np.stack([np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)], -1).reshape(-1, 3)
    globe[:22], globe[-22:] = (0, 0, 1), (0, 0, -1)
    a = np.arange(11 * 22)
    b = a - a % 22 + (a + 1) % 22
    triangles = np.concatenate([np.stack([a, a + 22, b + 22], 1)[:-22], np.stack([a, b + 22, b], 1)[22:]])
    inscribed = np.linalg.det(globe[triangles]).sum() / 6
    vertices = globe * (4 / 3 * np.pi / inscribed) ** (1 / 3) * np.array(radii, np.float64)
    normals = globe / radii
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return vertices, triangles, normals, np.zeros((len(vertices), 2))


def heightfield_surface(size: Any, heights: Any) -> tuple[NDArray[Any], ...]:
    """Returns the triangles of a heightfield about its origin.

    Args:
        size: extents along x and y, and height of the value 1 [m].
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
    # MuJoCo splits height field cells along the same diagonal.
    triangles = np.concatenate([np.stack([a, b, d], axis=1), np.stack([b, c, d], axis=1)])
    along_x = np.gradient(grid[..., 2], axis=1) / np.gradient(grid[..., 0], axis=1)
    along_y = np.gradient(grid[..., 2], axis=0) / np.gradient(grid[..., 1], axis=0)
    normals = np.stack([-along_x, -along_y, np.ones_like(levels)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    uvs = np.stack([u, v], axis=-1)
    return grid.reshape(-1, 3), triangles, normals.reshape(-1, 3), uvs.reshape(-1, 2)
