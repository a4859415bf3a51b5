"""Meshes for the tests, made where they are used and never committed."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING

import numpy as np
import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


@pytest.fixture(scope="module")
def other_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Another current folder: MuJoCo writes a log into it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("log"))
        yield


@pytest.fixture(scope="session")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A convex mesh, another one, one of two separate parts, and a non-convex one."""
    import trimesh

    folder = tmp_path_factory.mktemp("meshes")
    rock = trimesh.creation.icosphere(subdivisions=2, radius=0.1)
    rock.vertices = rock.vertices * [1.0, 0.8, 0.6]
    wedge = trimesh.creation.cylinder(radius=0.1, height=0.15, sections=5)
    left, right = trimesh.creation.box((0.1, 0.1, 0.1)), trimesh.creation.icosphere(subdivisions=1, radius=0.07)
    left.apply_translation([-0.1, 0, 0])
    right.apply_translation([0.1, 0, 0.02])
    ring = trimesh.creation.torus(0.12, 0.04, major_sections=12, minor_sections=8)
    # SAPIEN crashes on what CoACD makes of `ring`; this one it can read.
    hoop = trimesh.creation.torus(0.13, 0.04, major_sections=12, minor_sections=8)
    pair = trimesh.util.concatenate([left, right])
    made = {"rock": rock, "wedge": wedge, "pair": pair, "ring": ring, "hoop": hoop}
    paths = {name: folder / f"{name}.obj" for name in made}
    for name, mesh in made.items():
        mesh.export(paths[name])
    return paths


@pytest.fixture(scope="session")
def image(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small texture: 16 by 16 pixels, three channels, eight bits each."""
    squares = (np.indices((16, 16)).sum(axis=0) // 4 % 2 * 255).astype(np.uint8)
    pixels = np.stack([squares, 255 - squares, squares // 2], axis=-1)
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    path = tmp_path_factory.mktemp("images") / "checks.png"
    header = struct.pack(">IIBBBBB", 16, 16, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*chunk) for chunk in chunks))
    return path


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
