"""Uses of a mesh."""

from __future__ import annotations

from typing import Literal

from scenecc.plan import ConvexMesh, ConvexParts, Mesh, MeshGeometry

MeshUse = Literal["hull", "parts", "decomposed", "triangles", "visual"]
"""Its convex hull, the hulls of its parts, the hulls of CoACD's decomposition, its triangles, or a visual."""


def mesh_use(geometry: MeshGeometry) -> MeshUse:
    """Returns how a shape uses its mesh."""
    match geometry:
        case ConvexMesh():
            return "hull"
        case ConvexParts():
            return "parts" if geometry.coacd is None else "decomposed"
        case Mesh():
            return "visual"
        case _:
            return "triangles"
