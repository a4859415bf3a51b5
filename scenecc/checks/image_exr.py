"""The header of an OpenEXR, which SAPIEN's renderer hands to OpenEXR's own reader."""

from __future__ import annotations

import math
import struct
import zlib
from typing import BinaryIO

from scenecc.checks.image_size import ImageSize, exactly

MAGIC = b"\x76\x2f\x31\x01"
_DEEP, _LONG_NAMES, _IN_PIECES = 0x800, 0x400, 0x1200
"""Flags of the version; in pieces: of tiles, or of several parts."""
_MOST_OF_A_HEADER = 1 << 20
"""Bytes; attributes before the size may hold a small picture."""


def exr_size(file: BinaryIO) -> ImageSize:
    """The size of an EXR at its start; the renderer keeps four half-floats a pixel.

    Raises:
        ValueError, EOFError: it is none, or none that SAPIEN loads.
    """
    left, top, right, bottom = struct.unpack("<4i", _attributes(file)[0]["dataWindow"])
    return ImageSize(right - left + 1, bottom - top + 1, 8)


def check_exr(file: BinaryIO) -> None:
    """Looks at all blocks of an EXR of rows, and unpacks what zlib packed; of tiles and parts, at the header alone.

    Raises:
        ValueError, EOFError, struct.error: it is cut short, or not what its header says.
    """
    found, flags = _attributes(file)
    packing = found["compression"][0]
    if packing >= len(_ROWS):
        raise ValueError("it is packed in a way that is none")
    left, top, right, bottom = struct.unpack("<4i", found["dataWindow"])
    view = struct.unpack("<4i", found["displayWindow"])
    if view[0] > view[2] or view[1] > view[3] or max(map(abs, (left, top, right, bottom, *view))) >= 2**30:
        raise ValueError("its windows are none")
    row = _row_bytes(found["channels"], right - left + 1, bottom - top + 1)
    if flags & _IN_PIECES or row is None:
        return
    rows = _ROWS[packing]
    blocks = -(-(bottom - top + 1) // rows)
    offsets = struct.unpack(f"<{blocks}Q", exactly(file, 8 * blocks))
    for i, offset in enumerate(offsets):
        file.seek(min(offset, 2**62))
        y, size = struct.unpack("<ii", exactly(file, 8))
        whole = row * min(rows, bottom + 1 - y)
        if y != top + i * rows or not 0 < size <= whole or (packing == 0 and size != whole):
            raise ValueError("a block of its pixels is not where or as large as its header says")
        data = exactly(file, size)
        if packing in _ZLIB and size < whole:
            packed = zlib.decompressobj()
            try:
                if len(packed.decompress(data, whole)) != whole or packed.unconsumed_tail:
                    raise ValueError("a block of its pixels has another size than its header says")
            except zlib.error as error:
                raise ValueError("its pixels cannot be unpacked") from error


_KINDS = {
    "channels": b"chlist",
    "compression": b"compression",
    "dataWindow": b"box2i",
    "displayWindow": b"box2i",
    "lineOrder": b"lineOrder",
    "pixelAspectRatio": b"float",
    "screenWindowCenter": b"v2f",
    "screenWindowWidth": b"float",
}
_SIZES = {b"compression": 1, b"box2i": 16, b"lineOrder": 1, b"float": 4, b"v2f": 8}
_ROWS = (1, 1, 1, 16, 32, 16, 32, 32, 32, 256)
"""How many rows a block has, by how it is packed."""
_ZLIB = {2, 3}


def _attributes(file: BinaryIO) -> tuple[dict[str, bytes], int]:
    """What the header says, all that every header must say among it, and its flags; the file is then behind it."""
    magic, version = struct.unpack("<4sI", exactly(file, 8))
    if magic != MAGIC or version & 0xFF != 2:
        raise ValueError("it is no EXR, and SAPIEN goes by the suffix")
    flags = version & ~0xFF
    if flags & _DEEP:
        raise ValueError("it is a deep EXR, which SAPIEN does not load")
    if flags & ~(_LONG_NAMES | _IN_PIECES):
        raise ValueError("its header has flags that are none")
    header = file.read(_MOST_OF_A_HEADER)
    found: dict[str, bytes] = {}
    at = 0
    while (end := header.find(b"\0", at)) > at:
        kind = header.find(b"\0", end + 1)
        if kind < 0 or len(header) < kind + 5:
            break
        (length,) = struct.unpack_from("<I", header, kind + 1)
        name, value = header[at:end].decode("latin-1"), header[kind + 5 : kind + 5 + length]
        right = _KINDS.get(name)
        size = _SIZES.get(header[end + 1 : kind], len(value))
        if (right is not None and header[end + 1 : kind] != right) or len(value) != length or length != size:
            raise ValueError(f"`{name[:40]}` of its header is of another kind or size than it should be")
        found[name] = value
        at = kind + 5 + length
    if at >= len(header) or header[at] or not _KINDS.keys() <= found.keys():
        raise ValueError("its header is cut short, or lacks something")
    ratio, width = (struct.unpack("<f", found[name])[0] for name in ("pixelAspectRatio", "screenWindowWidth"))
    if not 1e-6 <= ratio <= 1e6 or not 0 <= width < math.inf or found["lineOrder"][0] > 2:
        raise ValueError("its header says what no EXR has")
    file.seek(8 + at + 1)
    return found, flags


def _row_bytes(channels: bytes, columns: int, rows: int) -> int | None:
    """Bytes of a row of pixels; None: some channels have fewer pixels than others."""
    total, at, even = 0, 0, True
    while (end := channels.find(b"\0", at)) > at:
        kind, _, across, down = struct.unpack_from("<iIii", channels, end + 1)
        if kind not in {0, 1, 2} or across < 1 or down < 1:
            raise ValueError("one of its channels is none")
        total += 2 if kind == 1 else 4
        if across * down > 1:
            # Of brightness and two colours, the colours may have half as many.
            if channels[at:end] not in {b"RY", b"BY"} or (across, down) != (2, 2) or columns % 2 or rows % 2:
                raise ValueError("one of its channels has another number of pixels than the others")
            even = False
        at = end + 17
    if end != at or at != len(channels) - 1 or not total:
        raise ValueError("its channels are cut short, or none")
    return total * columns if even else None
