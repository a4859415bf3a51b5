"""Shapes as plain triangles: scaled, and with what is seen of them outside."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.meshes.surface import Look, Shape


@frozen
class Baked:
    """Triangles in the frame of their shape.

    Attributes:
        vertices: (V, 3) float64 [m].
        faces: (F, 3) int64, counterclockwise from where they are seen.
        normals: (V, 3) float64 of unit length; None: every triangle is flat.
        uvs: (V, 2) float64 from the image's top left corner; None: (0, 0) everywhere.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    normals: NDArray[np.float64] | None
    uvs: NDArray[np.float64] | None
    look: Look


def baked(shape: Shape) -> tuple[Baked, ...]:
    """The parts of a shape, its scale taken in and its pose not."""
    scale = np.array(shape.scale)
    inside_out = (np.prod(scale) < 0) != shape.turned
    found: list[Baked] = []
    for part in shape.parts:
        surface = part.surface
        faces = surface.faces[:, ::-1] if inside_out else surface.faces
        normals = None
        if surface.normals is not None:
            normals = surface.normals / scale  # as normals go: by the inverse, transposed
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            normals *= -1 if shape.turned else 1
        uvs = None if surface.uvs is None else surface.uvs.astype(np.float64)
        found.append(Baked(surface.vertices.astype(np.float64) * scale, faces, normals, uvs, part.look))
    return tuple(found)
