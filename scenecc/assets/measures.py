"""Measures of triangles, and the convex parts that SAPIEN makes from a mesh file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.geometry.hulls import hull_volume

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Triangles = tuple[NDArray[np.floating[Any]], NDArray[np.int64]]
    """Vertices (n, 3) [m] and faces (m, 3)."""

_CHUNK: Final = 2**18
"""Number of triangles or points that are measured at once. Intermediate values need several times their memory."""


PLANE_TOLERANCE: Final = 0.0007
"""`PxCookingParams::planeTolerance`: how far outside a hull PhysX drops a vertex [m], times half the sum of the sides
of its bounding box if that exceeds 1 m.
"""


@dataclass(frozen=True, slots=True)
class Measures:
    """Measures of triangles, without scale.

    Attributes:
        vertices, faces: their numbers.
        low, high: corners of the bounding box (3,) [m].
        thickness, length: smallest and largest extent along the principal axes [m].
        degenerate: whether every triangle has area 0 in float32.
        hull_volume: of the convex hull [m³]. None: not computed.
    """

    vertices: int
    faces: int
    low: tuple[float, ...]
    high: tuple[float, ...]
    thickness: float
    length: float
    degenerate: bool
    hull_volume: float | None = None

    @property
    def reach(self) -> float:
        """The largest absolute coordinate [m]; NaN or infinite if one is."""
        return float(np.abs([self.low, self.high]).max())

    @property
    def plane_tolerance(self) -> float:
        """How far outside the hull PhysX drops a vertex [m]."""
        return PLANE_TOLERANCE * max(1.0, float(np.subtract(self.high, self.low).sum()) / 2)


def measure_triangles(vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> Measures:
    """Measures triangles. Vertices that no face uses are included."""
    with np.errstate(over="ignore"):
        measurable = np.isfinite(vertices.astype(np.float32)).all()
    thickness, length = _principal_extents(vertices) if measurable else (0.0, 0.0)
    low, high = vertices.min(axis=0).tolist(), vertices.max(axis=0).tolist()
    degenerate = _is_degenerate(vertices, faces)
    return Measures(len(vertices), len(faces), tuple(low), tuple(high), thickness, length, degenerate)


def measure_hull(vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> Measures:
    """Measures like `measure_triangles`, and adds the volume of the convex hull if it has one."""
    found = measure_triangles(vertices, faces)
    return replace(found, hull_volume=hull_volume(vertices) if found.thickness > 0 and len(vertices) > 3 else 0.0)


def _principal_extents(vertices: NDArray[np.floating]) -> tuple[float, float]:
    """Returns thickness and length along the principal axes [m] of points (n, 3) that are finite in float32."""
    centre = vertices.mean(axis=0, dtype=np.float64)
    pieces = range(0, len(vertices), _CHUNK)
    spread = np.zeros((3, 3))
    for start in pieces:
        centred = vertices[start : start + _CHUNK] - centre
        spread += centred.T @ centred
    axes = np.linalg.eigh(spread)[1]
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for start in pieces:
        along = (vertices[start : start + _CHUNK] - centre) @ axes
        low, high = np.minimum(low, along.min(axis=0)), np.maximum(high, along.max(axis=0))
    size = high - low
    return float(size.min()), float(size.max())


def _is_degenerate(vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> bool:
    """Returns whether PhysX drops all triangles, because the squared length of every normal is 0 in float32."""
    with np.errstate(all="ignore"):
        for start in range(0, len(faces), _CHUNK):
            corners = vertices[faces[start : start + _CHUNK]].astype(np.float32)
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            if (normals * normals).sum(axis=1).any():
                return False
    return True


CONNECTED_SUFFIXES: Final = (".ply", ".stl", ".dae")
"""Formats in which SAPIEN takes connected triangles as one convex part. In others it takes each part of the file."""


def hull_parts(parts: Sequence[Triangles], suffix: str) -> list[Triangles]:
    """Returns the meshes that SAPIEN cooks to one convex shape each, from the parts of a mesh file."""
    if suffix not in CONNECTED_SUFFIXES:
        return list(parts)
    # An STL has no vertex indices, and a COLLADA becomes a PLY with equal vertices merged.
    joined = parts if suffix == ".ply" else [weld(*part) for part in parts]
    return [one for part in joined for one in _connected_parts(*part)]


def weld(vertices: NDArray[np.floating], faces: NDArray[np.int64]) -> Triangles:
    """Returns the triangles with vertices merged that are equal in float32."""
    # Ordered by value, as in emitted Python.
    _, first, index = np.unique(vertices.astype(np.float32), axis=0, return_index=True, return_inverse=True)
    return vertices[first], index.reshape(-1)[faces]


def _connected_parts(vertices: NDArray[np.floating], faces: NDArray[np.int64]) -> list[Triangles]:
    """Splits a mesh into parts that share no vertex. Vertices in the same place may differ."""
    label = np.arange(len(vertices))
    while True:
        # In each triangle, the lowest root takes over the other trees. Their number at least halves each time.
        roots = label[faces]
        lowest = roots.min(axis=1)
        if bool((roots == lowest[:, None]).all()):
            break
        np.minimum.at(label, roots.ravel(), np.repeat(lowest, 3))
        while not np.array_equal(label, label[label]):
            label = label[label]
    order = np.argsort(label[faces[:, 0]], kind="stable")
    starts = np.flatnonzero(np.diff(label[faces[order, 0]])) + 1
    found: list[Triangles] = []
    for rows in np.split(order, starts):
        used, flat = np.unique(faces[rows], return_inverse=True)
        found.append((vertices[used], flat.reshape(-1, 3).astype(np.int64)))
    return found
