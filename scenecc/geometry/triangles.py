"""Joins triangle meshes."""

from __future__ import annotations

from typing import Any

import numpy as np


def join_parts(parts: list[tuple[Any, Any]]) -> tuple[Any, Any]:
    """Joins the vertices (V, 3) and faces (F, 3) of several parts into one mesh.

    Raises:
        ValueError: there are no parts.
    """
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = [np.asarray(face) + start for (_, face), start in zip(parts, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)
