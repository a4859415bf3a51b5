"""Surface measures of a mesh file: edges, winding and volumes. Used only by `scenecc check`."""

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
    """Measures of a mesh file without scale, with vertices in the same place merged.

    Attributes:
        low, high: corners of the bounding box (3,) [m].
        faces: number of triangles.
        degenerate: number of triangles without area.
        open_edges: number of edges with one triangle. 0 does not imply that the mesh is watertight.
        crowded_edges: number of edges with three triangles or more.
        consistent: whether neighbours have the same winding.
        volume: signed [m³]; negative if its triangles face inwards. Only meaningful without open edges.
        hull_volume: of its convex hull [m³]; 0: it is flat.
        unused: number of vertices without triangles.
        beyond: how far these are outside the box [m]; 0: all are inside.
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
    """Returns the measures of a mesh file. Raises AssetError if it cannot be read."""
    content = checked_content(file)
    record = read_mesh(content)
    vertices, faces = weld(*join_parts(read_triangles(content)))
    p, q, r = (vertices[faces[:, i]] for i in range(3))
    has_area = np.cross(q - p, r - p).any(axis=1)
    edges = np.concatenate([faces[has_area][:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    _, edge, times = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    # If the two triangles of an edge have the same winding, they name its ends in opposite orders.
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
