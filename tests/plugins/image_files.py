"""Small pictures of every kind that is read: EXR, KTX and HDR byte by byte."""

from __future__ import annotations

import io
import struct
import zlib

from PIL import Image

GL_RGBA8 = (0x1401, 0x1908, 0x8058)
GL_RGBA16F = (0x140B, 0x1908, 0x881A)


def exr_head(columns: int, rows: int, *, version: int = 2, left: int = 0) -> bytes:
    """All that comes before the pixels of an EXR."""

    def attribute(name: bytes, kind: bytes, value: bytes) -> bytes:
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value

    window = struct.pack("<4i", left, 0, left + columns - 1, rows - 1)
    channels = b"".join(name + b"\0" + struct.pack("<I4B2I", 1, 0, 0, 0, 0, 1, 1) for name in (b"B", b"G", b"R"))
    return (
        struct.pack("<4sI", b"\x76\x2f\x31\x01", version)
        + attribute(b"channels", b"chlist", channels + b"\0")
        + attribute(b"compression", b"compression", b"\0")
        + attribute(b"dataWindow", b"box2i", window)
        + attribute(b"displayWindow", b"box2i", window)
        + attribute(b"lineOrder", b"lineOrder", b"\0")
        + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
        + attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0))
        + attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1))
        + b"\0"
    )


def exr(columns: int, rows: int) -> bytes:
    """A white one, of half-floats that are not compressed."""
    head = exr_head(columns, rows)
    line = struct.pack("<e", 1.0) * (3 * columns)
    lines = [struct.pack("<iI", row, len(line)) + line for row in range(rows)]
    start = len(head) + 8 * rows
    offsets = struct.pack(f"<{rows}Q", *(start + row * len(lines[0]) for row in range(rows)))
    return head + offsets + b"".join(lines)


def ktx(
    columns: int, rows: int, sides: int = 1, levels: int = 1, kind: tuple[int, int, int] = GL_RGBA8, order: str = "<"
) -> bytes:
    """One of version 1, of one grey."""
    numbers = (0x04030201, kind[0], 1, kind[1], kind[2], 0x1908, columns, rows, 0, 0, sides, levels, 0)
    data = b"\xabKTX 11\xbb\r\n\x1a\n" + struct.pack(f"{order}13I", *numbers)
    for level in range(levels):
        length = max(1, columns >> level) * max(1, rows >> level) * 4
        data += struct.pack(f"{order}I", length) + bytes([100]) * (length * sides)
    return data


def ktx2(columns: int, rows: int, *, kind: int = 37, packed: bool = False) -> bytes:
    """One of version 2, one level of one grey."""
    samples = b"".join(
        struct.pack("<HBB4BII", 8 * i, 7, channel, 0, 0, 0, 0, 0, 255) for i, channel in enumerate((0, 1, 2, 15))
    )
    block = struct.pack("<HHHH4B4B8B", 0, 0, 2, 24 + len(samples), 1, 1, 1, 0, 0, 0, 0, 0, 4, *bytes(7)) + samples
    pixels = bytes([100]) * (columns * rows * 4)
    held = zlib.compress(pixels) if packed else pixels
    start = (104 + 4 + len(block) + 15) // 16 * 16
    head = b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack("<9I", kind, 1, columns, rows, 0, 0, 1, 1, 3 if packed else 0)
    head += struct.pack("<4I2Q", 104, 4 + len(block), 0, 0, 0, 0) + struct.pack("<3Q", start, len(held), len(pixels))
    return (head + struct.pack("<I", 4 + len(block)) + block).ljust(start, b"\0") + held


def picture(kind: str, mode: str, columns: int = 9, rows: int = 5, **how: object) -> bytes:
    """A picture of no pattern, the same each time."""
    noise = bytes((i * i * 31 + i * 17) % 251 for i in range(columns * rows * 4))
    out = io.BytesIO()
    Image.frombytes("RGBA", (columns, rows), noise).convert(mode).save(out, kind, **how)
    return out.getvalue()


def hdr(columns: int, rows: int, *, packed: bool) -> bytes:
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {rows} +X {columns}\n".encode()
    if not packed:
        return head + bytes((7 * i) % 200 + 3 for i in range(columns * 4)) * rows
    run = bytes([128 + columns - 2, 9, 2, 1, 5])
    return head + (struct.pack(">BBH", 2, 2, columns) + run * 4) * rows


PICTURES: dict[str, bytes] = {
    "rgb.png": picture("PNG", "RGB"),
    "rgba.png": picture("PNG", "RGBA"),
    "grey.png": picture("PNG", "L"),
    "bits.png": picture("PNG", "1"),
    "palette.png": picture("PNG", "P"),
    "deep.png": picture("PNG", "I;16"),
    "rgb.jpg": picture("JPEG", "RGB", 33, 18),
    "restarts.jpg": picture("JPEG", "RGB", 33, 18, subsampling=0, restart_marker_blocks=1),
    "grey.jpg": picture("JPEG", "L", 33, 18),
    "progressive.jpg": picture("JPEG", "RGB", 33, 18, progressive=True),
    "cmyk.jpg": picture("JPEG", "CMYK", 33, 18),
    "rgb.bmp": picture("BMP", "RGB"),
    "palette.bmp": picture("BMP", "P"),
    "rgba.bmp": picture("BMP", "RGBA"),
    "rgb.tga": picture("TGA", "RGB"),
    "packed.tga": picture("TGA", "RGBA", compression="tga_rle"),
    "palette.tga": picture("TGA", "P"),
    "flat.hdr": hdr(4, 3, packed=False),
    "packed.hdr": hdr(16, 3, packed=True),
}
"""Whole ones, by name, of the kinds that tell their pixels' end."""
