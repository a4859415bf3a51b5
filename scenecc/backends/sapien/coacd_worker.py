"""The process that runs CoACD: JSON request on standard input, PLY file on standard output."""

from __future__ import annotations

import importlib
import json
import os
import sys
from io import BytesIO
from pathlib import Path
from typing import Any

from scenecc.files import read_checked
from scenecc.geometry.ply import encode_parts
from scenecc.interrupt import exit_with_parent


def main() -> None:
    """Decomposes one mesh into convex parts and writes them as one mesh of separate components."""
    request = json.load(sys.stdin)
    exit_with_parent(request["parent"])
    coacd: Any = importlib.import_module("coacd")
    trimesh: Any = importlib.import_module("trimesh")
    coacd.set_log_level("error")
    # Only the checked file and its buffers: trimesh would also open materials and their images.
    mesh, buffers = request["mesh"], {name: read_checked(*each) for name, each in request["buffers"].items()}
    kind = Path(mesh[0]).suffix[1:].lower()
    whole = trimesh.load(BytesIO(read_checked(*mesh)), kind, resolver=buffers, force="mesh", skip_materials=True)
    parts = coacd.run_coacd(coacd.Mesh(whole.vertices, whole.faces), **request["arguments"])
    # SAPIEN passes each part through trimesh, which merges equal vertices; this does the same for equal results.
    meshes = [trimesh.Trimesh(vertices, faces) for vertices, faces in parts]
    with os.fdopen(request["output"], "wb") as file:
        file.write(encode_parts([(mesh.vertices, mesh.faces) for mesh in meshes]))


if __name__ == "__main__":
    main()
