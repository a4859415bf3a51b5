"""Writes OBJ files, with the shortest numbers that give the same float32."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    ObjColumn = tuple[NDArray[np.floating], NDArray[np.int64]]
    """Values (N, k), and their indices for each triangle corner (F, 3)."""


def encode_obj(
    points: NDArray[np.floating],
    faces: NDArray[np.int64],
    uvs: ObjColumn | None = None,
    normals: ObjColumn | None = None,
) -> bytes:
    """Returns triangles as an OBJ file.

    Args:
        points: (P, 3) [m].
        faces: (F, 3), counterclockwise from outside.
        uvs: texture coordinates from the image's bottom left corner.
        normals: unit vectors.
    """
    kept = {"v": (points, faces)} | {kind: one for kind, one in (("vt", uvs), ("vn", normals)) if one is not None}
    lines = [f"{kind} {' '.join(row)}" for kind, (values, _) in kept.items() for row in _format_float32(values)]
    corner = {1: "{}", 2: "{}//{}" if uvs is None else "{}/{}", 3: "{}/{}/{}"}[len(kept)]
    line = f"f {corner} {corner} {corner}"
    corners = np.stack([indices for _, indices in kept.values()], axis=2).reshape(len(faces), -1) + 1
    return "\n".join([*lines, *(line.format(*row) for row in corners.tolist()), ""]).encode()


def _format_float32(values: NDArray[np.floating]) -> list[list[str]]:
    return values.astype(np.float32).astype(str).tolist()
