"""Computes volumes of convex hulls: adds the farthest vertex until all points are close enough."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_TOLERANCE: Final = 1e-5
"""Allowed distance of a point outside the hull, relative to the largest side of the bounding box."""

_MOST_VERTICES: Final = 300
"""Maximum number of vertices. PhysX allows fewer: its hulls have at most 255 polygons."""

_JITTER: Final = 1e-6
"""Random displacement of points, relative to the size: coplanar points would give degenerate triangles."""


def hull_volume(points: NDArray[np.floating[Any]]) -> float:
    """Returns the volume of the hull of points (n, 3), finite and not coplanar [m³], within a few percent."""
    cloud: NDArray[np.float64] = points.astype(np.float64) - points.mean(axis=0, dtype=np.float64)
    size = float(np.ptp(cloud, axis=0).max())
    cloud += np.random.default_rng(0).uniform(-_JITTER * size, _JITTER * size, cloud.shape)
    a, b, c, d = first = _simplex(cloud)
    faces = np.array([[a, b, c], [a, d, b], [b, d, c], [c, d, a]])
    normals, offsets = _planes(cloud, faces)
    outside = np.delete(np.arange(len(cloud)), first)
    owners, distances = _farthest_planes(cloud[outside], normals, offsets)
    for _ in range(_MOST_VERTICES - len(first)):
        if not len(distances) or distances.max() <= _TOLERANCE * size:
            break
        farthest = int(distances.argmax())
        eye = int(outside[farthest])
        visible = normals @ cloud[eye] > offsets
        visible[owners[farthest]] = True
        kept, lost = ~visible, visible[owners]
        new = _cone(faces[visible], eye)
        new_normals, new_offsets = _planes(cloud, new)
        owners = (np.cumsum(kept) - 1)[owners]
        owners[lost], distances[lost] = _farthest_planes(cloud[outside[lost]], new_normals, new_offsets)
        owners[lost] += np.count_nonzero(kept)
        rest = (distances > _TOLERANCE * size) & (outside != eye)
        outside, owners, distances = outside[rest], owners[rest], distances[rest]
        faces = np.concatenate([faces[kept], new])
        normals = np.concatenate([normals[kept], new_normals])
        offsets = np.concatenate([offsets[kept], new_offsets])
    p, q, r = (cloud[faces[:, i]] for i in range(3))
    return abs(float(np.einsum("ij,ij->", p, np.cross(q, r)))) / 6


def _simplex(cloud: NDArray[np.float64]) -> tuple[int, int, int, int]:
    """Returns four points that are far apart."""
    axis = int(np.ptp(cloud, axis=0).argmax())
    a, b = int(cloud[:, axis].argmax()), int(cloud[:, axis].argmin())
    normals = np.cross(cloud[b] - cloud[a], cloud - cloud[a])
    c = int((normals * normals).sum(axis=1).argmax())
    heights = (cloud - cloud[c]) @ normals[c]
    d = int(np.abs(heights).argmax())
    return (a, b, c, d) if heights[d] < 0 else (b, a, c, d)


def _cone(visible: NDArray[np.int64], eye: int) -> NDArray[np.int64]:
    """Returns triangles (·, 3) from the border of the faces visible from a vertex to that vertex."""
    edges = np.concatenate([visible[:, [0, 1]], visible[:, [1, 2]], visible[:, [2, 0]]]).tolist()
    inner = {(b, a) for a, b in edges}
    return np.array([(a, b, eye) for a, b in edges if (a, b) not in inner], dtype=np.int64)


def _planes(cloud: NDArray[np.float64], faces: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Returns unit normals (·, 3) and offsets of triangles."""
    p, q, r = (cloud[faces[:, i]] for i in range(3))
    normals = np.cross(q - p, r - p)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, np.einsum("ij,ij->i", normals, p)


def _farthest_planes(
    cloud: NDArray[np.float64], normals: NDArray[np.float64], offsets: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Returns, for each point, the plane that it is farthest outside, and the distance."""
    heights = cloud @ normals.T - offsets
    owners = heights.argmax(axis=1)
    return owners, heights[np.arange(len(cloud)), owners]
