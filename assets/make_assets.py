"""Makes the meshes and textures of the example scenes (`scenes/assets`) and of the prefabs.

    python assets/make_assets.py [FOLDER]

Run again it writes the same bytes: coordinates are rounded to micrometres before they are written, and the writers
below put nothing of the machine or of a library's version into a file. Units are metres, z is up.
"""

from __future__ import annotations

import json
import math
import struct
import sys
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Surface:
    """Triangles with one texture coordinate a vertex."""

    vertices: Floats
    uv: Floats
    faces: Ints


def lathe(profile: Floats, segments: int) -> Surface:
    """Turns a profile of (radius, z), bottom to top on the outside, around z.

    Its ends must lie on the axis. The seam is doubled for the texture.
    """
    angle = np.linspace(0, 2 * math.pi, segments + 1)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ring[-1] = ring[0]
    vertices = np.concatenate([np.column_stack([radius * ring, np.full(segments + 1, z)]) for radius, z in profile])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    uv = np.stack(np.meshgrid(angle / (2 * math.pi), length / length[-1]), axis=-1).reshape(-1, 2)
    faces: list[tuple[int, int, int]] = []
    for row in range(len(profile) - 1):
        for column in range(segments):
            a = row * (segments + 1) + column
            b = a + segments + 1
            if profile[row + 1][0] > 0:
                faces.append((a, b + 1, b))
            if profile[row][0] > 0:
                faces.append((a, a + 1, b + 1))
    rounded = np.round(vertices, 6).astype(np.float64) + 0.0
    return Surface(rounded, np.round(uv, 6).astype(np.float64), np.array(faces))


def bowl() -> Surface:
    """A bowl of 16 cm across and 6 cm high with walls of 5 mm: not convex, closed."""
    outer = [(0.08 * math.sin(a), 0.06 * (1 - math.cos(a))) for a in np.linspace(0, math.pi / 2, 9)]
    inner = [(0.075 * math.sin(a), 0.06 - 0.055 * math.cos(a)) for a in np.linspace(math.pi / 2, 0, 9)]
    profile = np.array([*outer, *inner])
    profile[[0, -1], 0] = 0.0
    return lathe(profile, 32)


def mug() -> dict[str, trimesh.Trimesh]:
    """A mug of convex parts: a bottom, twelve wall segments and three bars of a handle."""
    parts = {"bottom": trimesh.creation.cylinder(radius=0.034, height=0.008, sections=12)}
    parts["bottom"].apply_translation([0, 0, 0.004])
    step = 2 * math.pi / 12
    for i in range(12):
        corners = [
            (radius * math.cos(angle), radius * math.sin(angle), z)
            for angle in (i * step, (i + 1) * step)
            for radius in (0.034, 0.04)
            for z in (0.0, 0.09)
        ]
        parts[f"wall_{i:02d}"] = hexahedron(np.array(corners))
    for name, size, place in (
        ("handle_low", (0.03, 0.012, 0.008), (0.052, 0, 0.024)),
        ("handle_grip", (0.008, 0.012, 0.05), (0.063, 0, 0.045)),
        ("handle_high", (0.03, 0.012, 0.008), (0.052, 0, 0.066)),
    ):
        parts[name] = trimesh.creation.box(size, transform=trimesh.transformations.translation_matrix(place))
    return parts


def hexahedron(corners: Floats) -> trimesh.Trimesh:
    """Eight corners, numbered by the bits (angle, radius, z), as a closed solid."""
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    solid = trimesh.Trimesh(corners, faces, process=False)
    if solid.volume < 0:
        solid.invert()
    return solid


def gem() -> Surface:
    """A cut stone of 6 cm across: convex, with a flat top."""
    return lathe(np.array([(0.0, 0.0), (0.03, 0.03), (0.03, 0.034), (0.018, 0.045), (0.0, 0.045)]), 8)


def write_obj(surface: Surface, name: str, material: str) -> bytes:
    """One object with texture coordinates and a material of `NAME.mtl`."""
    lines = [f"mtllib {name}.mtl", f"o {name}"]
    lines += ["v " + " ".join(f"{x:.6f}" for x in vertex) for vertex in surface.vertices]
    lines += ["vt " + " ".join(f"{x:.6f}" for x in uv) for uv in surface.uv]
    lines += [f"usemtl {material}"]
    lines += ["f " + " ".join(f"{i + 1}/{i + 1}" for i in face) for face in surface.faces]
    return ("\n".join(lines) + "\n").encode()


def write_obj_parts(parts: dict[str, trimesh.Trimesh]) -> bytes:
    """One object a part: SAPIEN cooks each to a convex shape of its own."""
    lines: list[str] = []
    first = 1
    for name, part in parts.items():
        lines += [f"o {name}"]
        lines += ["v " + " ".join(f"{x:.6f}" for x in vertex + 0.0) for vertex in np.round(part.vertices, 6)]
        lines += ["f " + " ".join(str(first + i) for i in face) for face in part.faces]
        first += len(part.vertices)
    return ("\n".join(lines) + "\n").encode()


def write_stl(surface: Surface) -> bytes:
    """Binary STL with a blank header."""
    corners = surface.vertices[surface.faces].astype("<f4")
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    records = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records["normal"] = np.round(normals, 4) + 0.0
    records["corners"] = corners
    return bytes(80) + struct.pack("<I", len(records)) + records.tobytes()


def write_glb(surface: Surface, image: bytes) -> bytes:
    """One mesh with an embedded PNG as its base colour. glTF is y-up: SAPIEN turns nothing, so z stays up here."""
    image += bytes(-len(image) % 4)
    blocks = [
        surface.vertices.astype("<f4").tobytes(),
        surface.uv.astype("<f4").tobytes(),
        surface.faces.astype("<u2").tobytes(),
        image,
    ]
    blocks = [block + bytes(-len(block) % 4) for block in blocks]
    starts = np.cumsum([0, *(len(block) for block in blocks)]).tolist()
    views = [{"buffer": 0, "byteOffset": start, "byteLength": len(b)} for start, b in zip(starts, blocks, strict=False)]
    views[2]["byteLength"] = surface.faces.size * 2
    vertices = surface.vertices.astype("<f4")
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "bowl"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0, "roughnessFactor": 0.5}}
        ],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"}
            | {"min": vertices.min(axis=0).tolist(), "max": vertices.max(axis=0).tolist()},
            {"bufferView": 1, "componentType": 5126, "count": len(vertices), "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": surface.faces.size, "type": "SCALAR"},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": starts[-1]}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    body = b"".join(blocks)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(body), 0x004E4942) + body
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def write_png(pixels: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    """An RGB image, (rows, columns, 3) of 8 bits, or a grey one, (rows, columns) of 16.

    Stored, not packed: zlib's output differs between its versions.
    """
    rows, columns = pixels.shape[:2]
    depth, color = (8, 2) if pixels.ndim == 3 else (16, 0)
    raw = b"".join(b"\0" + row.astype(row.dtype.newbyteorder(">")).tobytes() for row in pixels)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    stored = [raw[i : i + 65535] for i in range(0, len(raw), 65535)]
    deflated = b"\x78\x01" + b"".join(
        struct.pack("<BHH", i == len(stored) - 1, len(block), len(block) ^ 0xFFFF) + block
        for i, block in enumerate(stored)
    )
    deflated += struct.pack(">I", zlib.adler32(raw))
    header = struct.pack(">IIBBBBB", columns, rows, depth, color, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", deflated) + chunk(b"IEND", b"")


def checker(size: int = 64, squares: int = 8) -> NDArray[np.uint8]:
    """Light and dark squares."""
    index = np.arange(size) * squares // size
    dark = (index[:, None] + index[None, :]) % 2 == 1
    return np.where(dark[..., None], [60, 90, 120], [230, 220, 200]).astype(np.uint8)


def bumps(size: int = 64, count: int = 4) -> NDArray[np.uint8]:
    """A normal map of round bumps: x and y of the normal as 0..255 about 128, z in blue."""
    place = (np.arange(size) * count % size / size - 0.5) * 2
    x, y = np.meshgrid(place, place)
    radius2 = x**2 + y**2
    inside = radius2 < 0.8
    normal = np.stack(
        [np.where(inside, x, 0), np.where(inside, -y, 0), np.sqrt(1 - np.where(inside, radius2, 0))], axis=-1
    )
    return np.round(normal * 127 + 128).astype(np.uint8)


def wear(size: int = 64) -> NDArray[np.uint8]:
    """A roughness map that goes from polished to worn, left to right, in bands."""
    level = np.linspace(40, 220, size).astype(np.uint8) // 20 * 20
    return np.broadcast_to(level[None, :, None], (size, size, 3)).copy()


def tiles(size: int = 128, count: int = 4) -> NDArray[np.uint8]:
    """A floor of tiles, light and less light in turn, with dark joints; it repeats without a seam."""
    place = np.arange(size) * count
    index, offset = place // size, place % size
    light = (index[:, None] + index[None, :]) % 2 == 0
    joint = (offset < count) | (offset >= size - count)
    grey = np.where(joint[:, None] | joint[None, :], 140, np.where(light, 225, 205))
    return np.repeat(grey[..., None], 3, axis=2).astype(np.uint8)


def terrain(size: int = 65) -> NDArray[np.uint16]:
    """Heights of gentle hills, from 0 to 65535."""
    place = np.linspace(-1, 1, size)
    x, y = np.meshgrid(place, -place)
    hills = ((-0.5, 0.4, 0.9, 1.0), (0.6, 0.5, 0.6, 0.6), (0.2, -0.5, 0.8, 0.8), (-0.7, -0.6, 0.5, 0.5))
    # Polynomials, since sines differ between machines in the last bit.
    heights = sum(
        h * np.clip(1 - ((x - cx) ** 2 + (y - cy) ** 2) / radius**2, 0, None) ** 2 for cx, cy, radius, h in hills
    )
    return np.rint(heights / np.max(heights) * 65535).astype(np.uint16)


def make() -> dict[str, bytes]:
    """Every file, by its path from the root: a scene reads only below its own folder, a prefab in the package."""
    dish, stone, cup = bowl(), gem(), mug()
    for name, surface in (("bowl", dish), ("gem", stone)):
        solid = trimesh.Trimesh(surface.vertices, surface.faces)
        if not solid.is_watertight or solid.volume <= 0:
            raise ValueError(f"{name} is not a closed solid")
    for name, part in cup.items():
        if not part.is_watertight or part.volume <= 0:
            raise ValueError(f"{name} of the mug is not a closed solid")
    image = write_png(checker())
    scenes = {
        "checker.png": image,
        "bumps.png": write_png(bumps()),
        "wear.png": write_png(wear()),
        "terrain.png": write_png(terrain()),
        "bowl.obj": write_obj(dish, "bowl", "glaze"),
        "bowl.mtl": b"newmtl glaze\nKd 0.9 0.85 0.78\nKs 0.2 0.2 0.2\nNs 60\nmap_Kd checker.png\n",
        "bowl.glb": write_glb(dish, image),
        "mug.obj": write_obj_parts(cup),
        "gem.stl": write_stl(stone),
    }
    return {
        "scenecc/prefabs/tiles.png": write_png(tiles()),
        **{f"scenes/assets/{name}": scenes[name] for name in scenes},
    }


def main(root: Path) -> None:
    """Writes all files below a folder."""
    for name, data in make().items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent)
