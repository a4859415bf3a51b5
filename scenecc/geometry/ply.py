"""Writes binary PLY files, which SAPIEN reads with exact vertices in the same order."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenecc.geometry.triangles import join_parts


def encode_ply(vertices: Any, triangles: Any, normals: Any = None, uvs: Any = None) -> bytes:
    """Returns a mesh as a PLY with float32 and int32.

    Args:
        vertices: (V, 3).
        triangles: (T, 3) vertex indices, counterclockwise from outside.
        normals: (V, 3); None: SAPIEN gives each vertex that of one of its triangles.
        uvs: (V, 2) texture coordinates from the image's top left corner.
    """
    # If the first data byte equals a line break, the engine's reader takes it as part of the header. An unused zero
    # byte prevents this.
    columns: list[tuple[str, str]] = [("none", "u1"), *((axis, "<f4") for axis in "xyz")]
    numbers = [np.asarray(vertices, "<f4")]
    if normals is not None:
        columns += [(f"n{axis}", "<f4") for axis in "xyz"]
        numbers.append(np.asarray(normals, "<f4"))
    if uvs is not None:
        columns += [("s", "<f4"), ("t", "<f4")]
        # PLY counts v from the bottom.
        numbers.append(np.asarray(uvs, np.float64) * (1, -1) + (0, 1))
    rows = np.zeros(len(numbers[0]), columns)
    for (name, _), column in zip(columns[1:], np.concatenate(numbers, axis=1).T, strict=True):
        rows[name] = column
    faces = np.empty(len(triangles), [("count", "u1"), ("indices", "<i4", 3)])
    faces["count"], faces["indices"] = 3, triangles
    properties = [f"property {'uchar' if k == 'u1' else 'float'} {name}" for name, k in columns]
    header = [
        *("ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}", *properties),
        *(f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header\n"),
    ]
    return "\n".join(header).encode("ascii") + rows.tobytes() + faces.tobytes()


def encode_parts(parts: list[tuple[Any, Any]]) -> bytes:
    """Returns separate parts, each (vertices, triangles), as one mesh.

    Raises:
        ValueError: no part has a vertex.
    """
    if not any(len(vertices) for vertices, _ in parts):
        raise ValueError("no part has a vertex")
    return encode_ply(*join_parts(parts))
