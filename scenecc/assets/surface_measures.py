"""Measures of a mesh file as a surface: its edges, winding and volumes. Only `scenecc check` asks for them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from scenecc.assets.measures import weld
from scenecc.assets.meshes import checked_content, read_mesh, read_triangles
from scenecc.geometry.hulls import hull_volume
from scenecc.geometry.triangles import join_parts

if TYPE_CHECKING:
    from scenecc.plan import AssetFile


@dataclass(frozen=True, slots=True)
class SurfaceMeasures:
    """A mesh as its file has it, without scale, vertices in one place joined.

    Attributes:
        low, high: corners of the bounding box (3,) [m].
        faces: how many triangles it has.
        degenerate: how many of these have no area.
        open_edges: how many edges have one triangle. 0: it is watertight, or worse.
        crowded_edges: how many edges have three triangles or more.
        consistent: whether neighbours wind the same way.
        volume: signed [m³]; below 0 its triangles face inwards. It has a meaning where there are no open edges.
        hull_volume: of its convex hull [m³]; 0: it is flat.
        unused: how many vertices no triangle uses.
        beyond: how far these lie outside of the box [m]; 0: all are in it.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    faces: int
    degenerate: int
    open_edges: int
    crowded_edges: int
    consistent: bool
    volume: float
    hull_volume: float
    unused: int
    beyond: float

    @property
    def is_watertight(self) -> bool:
        """Whether each edge has two triangles."""
        return self.open_edges == self.crowded_edges == 0


@lru_cache(maxsize=1024)
def measure_surface(file: AssetFile) -> SurfaceMeasures:
    """The measures of a mesh file. Raises AssetError where it cannot be read."""
    content = checked_content(file)
    record = read_mesh(content)
    vertices, faces = weld(*join_parts(read_triangles(content)))
    p, q, r = (vertices[faces[:, i]] for i in range(3))
    has_area = np.cross(q - p, r - p).any(axis=1)
    edges = np.concatenate([faces[has_area][:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    _, edge, times = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    # Of an edge with two triangles, neighbours that wind the same way name its ends in opposite orders.
    turns = np.bincount(edge.ravel(), np.where(edges[:, 0] < edges[:, 1], 1, -1), len(times))
    flat = len(vertices) < 4 or np.linalg.matrix_rank(vertices - vertices[0], tol=1e-9 * float(np.ptp(vertices))) < 3
    low, high = vertices.min(axis=0).tolist(), vertices.max(axis=0).tolist()
    return SurfaceMeasures(
        tuple(low),
        tuple(high),
        len(faces),
        int((~has_area).sum()),
        int((times == 1).sum()),
        int((times > 2).sum()),
        bool((turns[times == 2] == 0).all()),
        float(np.einsum("ij,ij->", p, np.cross(q, r))) / 6,
        0.0 if flat else hull_volume(vertices),
        record.unused,
        record.beyond,
    )
