"""EXR and KTX files, byte by byte."""

from __future__ import annotations

import struct
import zlib

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
