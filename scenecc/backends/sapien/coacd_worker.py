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

from scenecc.files import read_checked
from scenecc.geometry.ply import encode_parts

_PR_SET_PDEATHSIG = 1


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
        file.write(encode_parts([(mesh.vertices, mesh.faces) for mesh in meshes]))


def _exit_with_parent(parent: int) -> None:
    """Has Linux end this process as soon as the one that asked for it ends, however that ends."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        sys.exit()


if __name__ == "__main__":
    main()
