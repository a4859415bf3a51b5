"""The process that runs CoACD: a request as JSON on standard input, a PLY file out."""

from __future__ import annotations

import json
import sys
from pathlib import Path


def main() -> None:
    """Cuts one mesh into convex parts and writes them as one mesh of separate components."""
    import coacd
    import trimesh

    request = json.load(sys.stdin)
    coacd.set_log_level("error")
    whole = trimesh.load(request["mesh"], force="mesh")
    parts = coacd.run_coacd(coacd.Mesh(whole.vertices, whole.faces), **request["arguments"])
    joined = trimesh.util.concatenate([trimesh.Trimesh(vertices, faces) for vertices, faces in parts])
    Path(request["output"]).write_bytes(joined.export(file_type="ply"))


if __name__ == "__main__":
    main()
