"""Meshes and images as files beside a file."""

from __future__ import annotations

import re
from hashlib import sha256
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_DIGITS = 8


class Beside:
    """Files in the folder beside a file. Those that hold the same are one.

    Attributes:
        folder: its name.
        files: by their paths from the folder in which the file lies.
    """

    def __init__(self, name: str) -> None:
        self.folder = f"{name}.assets"
        self.files: dict[str, bytes] = {}

    def add(self, stem: str, suffix: str, data: bytes) -> str:
        """Puts a file into the folder; its name there, with a part that only the same content has."""
        digest = sha256(data).hexdigest()[:_DIGITS]
        name = f"{re.sub(r'[^A-Za-z0-9_.-]+', '_', stem) or 'file'}-{digest}{suffix}"
        self.files[f"{self.folder}/{name}"] = data
        return name


def obj(vertices: NDArray[np.floating], faces: NDArray[np.int64], uvs: NDArray[np.floating] | None = None) -> bytes:
    """Triangles as an OBJ file.

    Args:
        vertices: (V, 3) [m].
        faces: (F, 3), counterclockwise from outside.
        uvs: (V, 2) from the image's top left corner.
    """
    lines = [f"v {x} {y} {z}" for x, y, z in _texts(vertices)]
    if uvs is None:
        lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    else:
        lines += [f"vt {u} {v}" for u, v in _texts(np.column_stack([uvs[:, 0], 1 - uvs[:, 1]]))]
        lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in (faces + 1).tolist()]
    return "\n".join([*lines, ""]).encode()


def _texts(values: NDArray[np.floating]) -> list[list[str]]:
    """The shortest texts that single precision reads as these numbers."""
    return values.astype(np.float32).astype(str).tolist()
