"""Measures of triangles, and the convex parts that SAPIEN makes of a mesh file."""

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
"""How many triangles or points are measured at once: numbers in between take several times their size."""


PLANE_TOLERANCE: Final = 0.0007
"""`PxCookingParams::planeTolerance`: how far outside a hull PhysX drops a vertex [m], times half the sum of the sides
of its bounding box where that is above 1 m."""


@dataclass(frozen=True, slots=True)
class Measures:
    """Measures of triangles, without scale.

    Attributes:
        vertices, faces: how many there are.
        low, high: corners of the bounding box (3,) [m].
        thickness, length: extents along the principal axes, the smallest and the largest [m].
        degenerate: whether no triangle has an area in single precision.
        hull_volume: of the convex hull [m³]; None: not computed.
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
        """The largest coordinate [m]; NaN or infinite where one is."""
        return float(np.abs([self.low, self.high]).max())

    @property
    def plane_tolerance(self) -> float:
        """How far outside the hull PhysX drops a vertex [m]."""
        return PLANE_TOLERANCE * max(1.0, float(np.subtract(self.high, self.low).sum()) / 2)


def measure_triangles(vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> Measures:
    """Measures of triangles. Vertices that no face uses count as well."""
    with np.errstate(over="ignore"):
        measurable = np.isfinite(vertices.astype(np.float32)).all()
    thickness, length = _principal_extents(vertices) if measurable else (0.0, 0.0)
    low, high = vertices.min(axis=0).tolist(), vertices.max(axis=0).tolist()
    degenerate = _is_degenerate(vertices, faces)
    return Measures(len(vertices), len(faces), tuple(low), tuple(high), thickness, length, degenerate)


def measure_hull(vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> Measures:
    """`measure`, with the volume of the convex hull if it has one."""
    found = measure_triangles(vertices, faces)
    return replace(found, hull_volume=hull_volume(vertices) if found.thickness > 0 and len(vertices) > 3 else 0.0)


def _principal_extents(vertices: NDArray[np.floating]) -> tuple[float, float]:
    """Thickness and length of a cloud of points, finite in single precision, (n, 3), along its principal axes [m]."""
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
    """Whether PhysX drops all triangles: the square of a normal's length is 0 in single precision."""
    with np.errstate(all="ignore"):
        for start in range(0, len(faces), _CHUNK):
            corners = vertices[faces[start : start + _CHUNK]].astype(np.float32)
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            if (normals * normals).sum(axis=1).any():
                return False
    return True


CONNECTED_SUFFIXES: Final = (".ply", ".stl", ".dae")
"""Formats in which SAPIEN takes triangles that share vertices for one convex part; of others, each part of the file."""


def hull_parts(parts: Sequence[Triangles], suffix: str) -> list[Triangles]:
    """What SAPIEN cooks to one convex shape each, of the parts of a mesh file."""
    if suffix not in CONNECTED_SUFFIXES:
        return list(parts)
    # Vertices of an STL have no numbers, and a COLLADA becomes a PLY in which equal vertices are one.
    joined = parts if suffix == ".ply" else [weld(*part) for part in parts]
    return [one for part in joined for one in _connected_parts(*part)]


def weld(vertices: NDArray[np.floating], faces: NDArray[np.int64]) -> Triangles:
    """The same triangles with one vertex for all that are equal in single precision."""
    # In the order of the values: emitted Python has the same.
    _, first, index = np.unique(vertices.astype(np.float32), axis=0, return_index=True, return_inverse=True)
    return vertices[first], index.reshape(-1)[faces]


def _connected_parts(vertices: NDArray[np.floating], faces: NDArray[np.int64]) -> list[Triangles]:
    """The parts of a mesh that share no vertex. Vertices in the same place are two."""
    label = np.arange(len(vertices))
    while True:
        # The lowest of the trees that meet in a triangle takes the others, root and all: their number halves at least.
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
