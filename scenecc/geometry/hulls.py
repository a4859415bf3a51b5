"""Convex hulls of point clouds, built as PhysX builds them: the farthest corner first, until all are near enough."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

PLANE_TOLERANCE = 0.0007
"""`PxCookingParams::planeTolerance`: how far outside a hull PhysX leaves out a corner [m], by half the sum of the sides
of its bounding box where that is above 1 m."""

_FINENESS = 64
"""By how much the volume of a hull itself is computed more closely than PhysX does."""

MAX_CORNERS = 300
"""How many corners of a hull are looked at. PhysX takes fewer: its hulls have 255 polygons."""

_JITTER = 1e-6
"""By how much of its size points are moved: those that lie in one plane would make triangles without area."""


def plane_tolerance(points: NDArray[np.floating]) -> float:
    """How far outside the hull of points (n, 3) PhysX leaves out a corner [m]."""
    return PLANE_TOLERANCE * max(1.0, float(np.ptp(points, axis=0).sum()) / 2)


def cooked_volume_ratio(points: NDArray[np.floating]) -> float:
    """The volume of the hull that PhysX cooks of a cloud, by that of its hull.

    Within a few percent of what it cooks, of which a limit of 255 polygons takes up to 5 percent more.

    Args:
        points: (n, 3), finite and not in one plane [m].
    """
    cloud = points.astype(np.float64) - points.mean(axis=0, dtype=np.float64)
    tolerance = plane_tolerance(cloud)
    own = _hull_volumes(cloud, _simplex(cloud, 0.0), tolerance, tolerance / _FINENESS)
    moved = cloud.copy()
    corners = _simplex(moved, tolerance)
    cooked = own[0] if np.array_equal(moved, cloud) else _hull_volumes(moved, corners, tolerance)[0]
    return cooked / own[-1]


def _simplex(cloud: NDArray[np.float64], tolerance: float) -> tuple[int, int, int, int]:
    """Four corners far apart. As PhysX does, it moves those that are nearer than a tolerance to the others' plane."""
    axis = int(np.ptp(cloud, axis=0).argmax())
    a, b = int(cloud[:, axis].argmax()), int(cloud[:, axis].argmin())
    along = (cloud[b] - cloud[a]) / np.linalg.norm(cloud[b] - cloud[a])
    normals = np.cross(along, cloud - cloud[a])
    distances = np.linalg.norm(normals, axis=1)
    c = int(distances.argmax())
    normal = normals[c] / distances[c]
    if distances[c] < tolerance:
        cloud[c] += np.cross(normal, along) * tolerance
    heights = (cloud - cloud[c]) @ normal
    d = int(np.abs(heights).argmax())
    if abs(heights[d]) < tolerance:
        cloud[d] += np.copysign(tolerance, heights[d]) * normal
    return (a, b, c, d) if heights[d] < 0 else (b, a, c, d)


def _hull_volumes(points: NDArray[np.float64], simplex: tuple[int, int, int, int], *tolerances: float) -> list[float]:
    """Volumes [m³] of the hulls that leave out no point farther outside than each tolerance (falling) [m]."""
    size = float(np.ptp(points, axis=0).max())
    cloud = points + np.random.default_rng(0).uniform(-_JITTER * size, _JITTER * size, points.shape)
    a, b, c, d = simplex
    faces = np.array([[a, b, c], [a, d, b], [b, d, c], [c, d, a]])
    normals, offsets = _planes(cloud, faces)
    outside = np.delete(np.arange(len(cloud)), simplex)
    corners = len(simplex)
    owners, distances = _farthest_planes(cloud[outside], normals, offsets)
    volumes: list[float] = []
    for tolerance in tolerances:
        while len(distances) and distances.max() > tolerance and corners < MAX_CORNERS:
            corners += 1
            farthest = int(distances.argmax())
            eye = int(outside[farthest])
            seen = normals @ cloud[eye] > offsets
            seen[owners[farthest]] = True
            kept, lost = ~seen, seen[owners]
            new = _cone(faces[seen], eye)
            new_normals, new_offsets = _planes(cloud, new)
            owners = (np.cumsum(kept) - 1)[owners]
            owners[lost], distances[lost] = _farthest_planes(cloud[outside[lost]], new_normals, new_offsets)
            owners[lost] += np.count_nonzero(kept)
            rest = (distances > tolerances[-1]) & (outside != eye)
            outside, owners, distances = outside[rest], owners[rest], distances[rest]
            faces = np.concatenate([faces[kept], new])
            normals = np.concatenate([normals[kept], new_normals])
            offsets = np.concatenate([offsets[kept], new_offsets])
        p, q, r = (cloud[faces[:, i]] for i in range(3))
        volumes.append(abs(float(np.einsum("ij,ij->", p, np.cross(q, r)))) / 6)
    return volumes


def _cone(seen: NDArray[np.int64], eye: int) -> NDArray[np.int64]:
    """Triangles (·, 3) from the border of those that a corner sees to that corner."""
    edges = np.concatenate([seen[:, [0, 1]], seen[:, [1, 2]], seen[:, [2, 0]]]).tolist()
    inner = {(b, a) for a, b in edges}
    return np.array([(a, b, eye) for a, b in edges if (a, b) not in inner], dtype=np.int64)


def _planes(cloud: NDArray[np.float64], faces: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit normals (·, 3) and offsets of triangles."""
    p, q, r = (cloud[faces[:, i]] for i in range(3))
    normals = np.cross(q - p, r - p)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, np.einsum("ij,ij->i", normals, p)


def _farthest_planes(
    cloud: NDArray[np.float64], normals: NDArray[np.float64], offsets: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Of each point, the plane that it is farthest outside of, and how far."""
    heights = cloud @ normals.T - offsets
    owners = heights.argmax(axis=1)
    return owners, heights[np.arange(len(cloud)), owners]


def hull_volume(points: NDArray[np.floating]) -> float:
    """The volume of the hull of points (n, 3), finite and not in one plane [m³]; within a few percent."""
    cloud = points.astype(np.float64) - points.mean(axis=0, dtype=np.float64)
    tolerance = plane_tolerance(cloud)
    return float(_hull_volumes(cloud, _simplex(cloud, 0.0), tolerance, tolerance / _FINENESS)[-1])
