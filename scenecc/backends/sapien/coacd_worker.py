"""The process that runs CoACD: a request as JSON on standard input, a PLY file out."""

from __future__ import annotations

import ctypes
import importlib
import json
import os
import signal
import sys
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from scenecc.files import read_checked

PLY_HEADER = """ply
format binary_little_endian 1.0
element vertex {vertices}
property uchar none
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
"""
"""The engine's reader takes a first byte of data that equals a line break for a part of the header, and loses its
place: so a byte of 0 that nobody reads stands before the numbers."""
_PR_SET_PDEATHSIG = 1


def encode_ply(parts: list[tuple[Any, Any]]) -> bytes:
    """One mesh of separate parts, each (vertices, faces)."""
    points = np.concatenate([np.asarray(points, dtype="<f4") for points, _ in parts])
    if not len(points):
        raise ValueError("no part has a vertex")
    vertices = np.zeros(len(points), dtype=[("none", "u1"), ("point", "<f4", 3)])
    vertices["point"] = points
    starts = np.cumsum([0, *(len(points) for points, _ in parts)])
    indices = np.concatenate([np.asarray(faces) + start for (_, faces), start in zip(parts, starts, strict=False)])
    faces = np.empty(len(indices), dtype=[("count", "u1"), ("indices", "<i4", 3)])
    faces["count"], faces["indices"] = 3, indices
    header = PLY_HEADER.format(vertices=len(vertices), faces=len(faces))
    return header.encode("ascii") + vertices.tobytes() + faces.tobytes()


def main() -> None:
    """Cuts one mesh into convex parts and writes them as one mesh of separate components."""
    request = json.load(sys.stdin)
    _exit_with_parent(request["parent"])
    coacd: Any = importlib.import_module("coacd")
    trimesh: Any = importlib.import_module("trimesh")
    coacd.set_log_level("error")
    # What was checked, and nothing that it names but buffers: trimesh would open materials and their images.
    mesh, buffers = request["mesh"], {name: read_checked(*each) for name, each in request["buffers"].items()}
    kind = Path(mesh[0]).suffix[1:].lower()
    whole = trimesh.load(BytesIO(read_checked(*mesh)), kind, resolver=buffers, force="mesh", skip_materials=True)
    parts = coacd.run_coacd(coacd.Mesh(whole.vertices, whole.faces), **request["arguments"])
    # SAPIEN passes each part through trimesh, which joins equal vertices; so must this, to be equal.
    meshes = [trimesh.Trimesh(vertices, faces) for vertices, faces in parts]
    with os.fdopen(request["output"], "wb") as file:
        file.write(encode_ply([(mesh.vertices, mesh.faces) for mesh in meshes]))


def _exit_with_parent(parent: int) -> None:
    """Has Linux end this process as soon as the one that asked for it ends, however that ends."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        sys.exit()


if __name__ == "__main__":
    main()
