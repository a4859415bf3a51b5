"""Mesh files for the tests, written by hand so that each has exactly one fault."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

from scenecc.checks.assets import check_assets
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Origin
from scenecc.plan import (
    BodyStructure,
    CoacdParams,
    CollisionShape,
    ConvexMesh,
    ConvexParts,
    Entity,
    Mesh,
    Physics,
    ScenePlan,
    TriangleMesh,
    VisualShape,
    constant,
)
from scenecc.plan.body import AssetFile

TETRA = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
POINTS = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
ONE = constant([1, 1, 1])


def stl(points: np.ndarray = POINTS, faces: np.ndarray = FACES) -> bytes:
    records = b"".join(struct.pack("<12fH", 0, 0, 1, *points[face].ravel(), 0) for face in faces)
    return bytes(80) + struct.pack("<I", len(faces)) + records


def stl_text(points: np.ndarray = POINTS, faces: np.ndarray = FACES) -> bytes:
    facets = [
        "facet normal 0 0 1\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*point) for point in points[face])
        + "endloop\nendfacet\n"
        for face in faces
    ]
    return ("solid a name\n" + "".join(facets) + "endsolid a name\n").encode()


def ply(points: np.ndarray = POINTS, faces: np.ndarray = FACES, *, kind: str = "binary_little_endian") -> bytes:
    header = (
        f"ply\nformat {kind} 1.0\ncomment made by hand\nelement vertex {len(points)}\n"
        "property float x\nproperty float y\nproperty float z\nproperty uchar red\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    if kind == "ascii":
        rows = ["{} {} {} 255".format(*p) for p in points] + ["3 {} {} {}".format(*f) for f in faces]
        return header + ("\n".join(rows) + "\n").encode()
    order = ">" if "big" in kind else "<"
    body = b"".join(struct.pack(order + "3fB", *p, 255) for p in points)
    return header + body + b"".join(struct.pack(order + "B3i", 3, *f) for f in faces)


def gltf_document(points: np.ndarray = POINTS, faces: np.ndarray = FACES) -> tuple[dict[str, Any], bytes]:
    body = points.astype("<f4").tobytes() + faces.astype("<u4").tobytes()
    size = points.size * 4
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": faces.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": size},
            {"buffer": 0, "byteOffset": size, "byteLength": len(body) - size},
        ],
        "buffers": [{"byteLength": len(body)}],
    }
    return document, body


def glb(document: dict[str, Any] | None = None, body: bytes | None = None) -> bytes:
    if document is None or body is None:
        document, body = gltf_document()
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body += bytes(-len(body) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def named_by(folder: Path) -> Any:
    """A resolver for what assets name: below the folder, or refused as the real one refuses."""

    def find(reference: str, asset: AssetFile) -> Path | tuple[str, str, str | None]:
        path = (asset.path.parent / reference).resolve()
        if "://" in reference or not path.is_relative_to(folder.resolve()):
            return "SC402", f"`{reference}` leaves", "stay"
        if path.exists() and not path.is_file():
            return "SC404", f"`{reference}` is no file", None
        return path if path.exists() else ("SC401", f"there is no file `{reference}`", None)

    return find


def geometry(use: str, file: Any = None) -> Any:
    file = constant(0, np.int64) if file is None else file
    return {
        "hull": ConvexMesh(file, ONE),
        "parts": ConvexParts(file, ONE),
        "decomposed": ConvexParts(file, ONE, CoacdParams()),
        "triangles": TriangleMesh(file, ONE),
        "visual": Mesh(file, ONE),
    }[use]


def plan_of(paths: list[Path], *uses: str, files: Any = None) -> ScenePlan:
    """One static body a use, each with one shape at `bodies[i]`."""
    entities = []
    for i, use in enumerate(uses):
        origin = Origin("scene.yaml", ("bodies", i))
        shape: Any = (VisualShape if use == "visual" else CollisionShape)(geometry(use, files), origin=origin)
        structure = (
            BodyStructure("static", visuals=(shape,))
            if use == "visual"
            else BodyStructure("static", collisions=(shape,))
        )
        scenes = tuple(range(len(files.data))) if files is not None else (0,)
        entities.append(Entity(f"body_{i}", scenes, constant([0, 0, 0, 1, 0, 0, 0]), (structure,)))
    table = tuple(AssetFile(path.name, path) for path in paths)
    return ScenePlan("plan", 1 if files is None else len(files.data), tuple(entities), Physics(), files=table)


def diagnose(path: Path, *uses: str, max_asset_bytes: int = 2**28) -> list[Diagnostic]:
    sink = Sink()
    plan = plan_of([path], *uses)
    check_assets(plan, sink, resolve_named=named_by(path.parent), max_asset_bytes=max_asset_bytes)
    return sink.diagnostics()


def checked(path: Path, *uses: str) -> AssetFile:
    """A file without fault, as its check leaves it."""
    sink = Sink()
    (file,) = check_assets(plan_of([path], *uses), sink, resolve_named=named_by(path.parent), max_asset_bytes=2**26)
    assert not sink.diagnostics()
    return file


def named(path: Path, *uses: str) -> dict[str, Path | None]:
    """What a file names of what a build opens."""
    return {one.uri: one.path for one in checked(path, *(uses or ("visual",))).names}


def codes(path: Path, *uses: str, max_asset_bytes: int = 2**28) -> list[str]:
    return [d.code for d in diagnose(path, *uses, max_asset_bytes=max_asset_bytes)]


def write(folder: Path, name: str, data: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return path
