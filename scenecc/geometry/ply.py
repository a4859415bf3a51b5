"""Meshes as binary PLY, which SAPIEN reads without changes: its vertices, in their order, to the bit."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenecc.geometry.triangles import join_parts


def encode_ply(vertices: Any, triangles: Any, normals: Any = None, uvs: Any = None) -> bytes:
    """A mesh as a PLY of float32 and int32.

    Args:
        vertices: (V, 3).
        triangles: (T, 3) indices of vertices, counterclockwise from outside.
        normals: (V, 3); None: SAPIEN gives each vertex that of one of its triangles.
        uvs: (V, 2) texture coordinates from the image's top left corner.
    """
    # The engine's reader takes a first byte of data that equals a line break for a part of the header, and loses its
    # place: so a byte of 0 that nobody reads stands before the numbers.
    columns: list[tuple[str, str]] = [("none", "u1"), *((axis, "<f4") for axis in "xyz")]
    numbers = [np.asarray(vertices, "<f4")]
    if normals is not None:
        columns += [(f"n{axis}", "<f4") for axis in "xyz"]
        numbers.append(np.asarray(normals, "<f4"))
    if uvs is not None:
        columns += [("s", "<f4"), ("t", "<f4")]
        # A PLY has them from the bottom.
        numbers.append(np.asarray(uvs, np.float64) * (1, -1) + (0, 1))
    rows = np.zeros(len(numbers[0]), columns)
    for (name, _), column in zip(columns[1:], np.concatenate(numbers, axis=1).T, strict=True):
        rows[name] = column
    faces = np.empty(len(triangles), [("count", "u1"), ("indices", "<i4", 3)])
    faces["count"], faces["indices"] = 3, triangles
    properties = [f"property {'uchar' if kind == 'u1' else 'float'} {name}" for name, kind in columns]
    header = [
        *("ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}", *properties),
        *(f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header\n"),
    ]
    return "\n".join(header).encode("ascii") + rows.tobytes() + faces.tobytes()


def encode_parts(parts: list[tuple[Any, Any]]) -> bytes:
    """One mesh of separate parts, each (vertices, triangles).

    Raises:
        ValueError: no part has a vertex.
    """
    if not any(len(vertices) for vertices, _ in parts):
        raise ValueError("no part has a vertex")
    return encode_ply(*join_parts(parts))
