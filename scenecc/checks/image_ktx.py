"""The header of a KTX, of version 1 or 2. SAPIEN's renderer loads those of four bytes a pixel, R8G8B8A8Unorm, alone."""

from __future__ import annotations

import io
import struct
from typing import TYPE_CHECKING, BinaryIO

from scenecc.checks.image_size import ImageSize, exactly

if TYPE_CHECKING:
    from collections.abc import Iterator

MAGICS = (b"\xabKTX 11\xbb\r\n\x1a\n", b"\xabKTX 20\xbb\r\n\x1a\n")

_RGBA8_OF_GL = (0x1401, 0x1908, 0x8058)
"""GL_UNSIGNED_BYTE, GL_RGBA, GL_RGBA8."""

_RGBA8_OF_VULKAN = 37
_PACKED = {2, 3}
"""Zstandard and zlib; the transcoded scheme has no format of its own."""

_ONE_KIND = "SAPIEN loads no KTX but of R8G8B8A8 (UNORM)"
_CUT = "it is cut short, or its levels are not as large as its header says"


def ktx_size(file: BinaryIO) -> ImageSize:
    """The size of a KTX at its start, all of whose levels are there.

    Raises:
        ValueError, EOFError, struct.error: it is none, or none that SAPIEN loads.
    """
    magic = file.read(12)
    if magic not in MAGICS:
        raise ValueError("it is no KTX, and SAPIEN goes by the suffix")
    return _first(file) if magic == MAGICS[0] else _second(file)


def _first(file: BinaryIO) -> ImageSize:
    order = "<" if (mark := exactly(file, 4)) == b"\1\2\3\4" else ">"
    if order == ">" and mark != b"\4\3\2\1":
        raise ValueError("the order of its bytes is not told")
    kind, _, layout, internal, _, columns, rows, *more, pairs = struct.unpack(f"{order}12I", exactly(file, 48))
    if (kind, layout, internal) != _RGBA8_OF_GL:
        raise ValueError(_ONE_KIND)
    size = _checked(columns, rows, *more)
    at, end = 64 + pairs, file.seek(0, io.SEEK_END)
    for expected in size.level_bytes:
        file.seek(at)
        (length,) = struct.unpack(f"{order}I", exactly(file, 4))
        at += 4 + length * size.sides
        if length != expected or at > end:
            raise ValueError(_CUT)
    return size


def _second(file: BinaryIO) -> ImageSize:
    kind, _, columns, rows, *more, scheme = struct.unpack("<9I", exactly(file, 36))
    if kind != _RGBA8_OF_VULKAN or scheme not in {0, *_PACKED}:
        raise ValueError(_ONE_KIND)
    size = _checked(columns, rows, *more)
    file.seek(80)
    index = exactly(file, 24 * size.levels)
    end = file.seek(0, io.SEEK_END)
    for expected, (at, length, unpacked) in zip(size.level_bytes, _triples(index), strict=True):
        if at + length > end or (unpacked if scheme else length) != expected * size.sides:
            raise ValueError(_CUT)
    return size


def _triples(index: bytes) -> Iterator[tuple[int, int, int]]:
    yield from struct.iter_unpack("<3Q", index)


def _checked(columns: int, rows: int, depth: int, elements: int, sides: int, levels: int) -> ImageSize:
    if depth or elements or sides not in {1, 6}:
        raise ValueError("it is neither one picture nor the six sides of a cube")
    if not 1 <= levels <= max(columns, rows).bit_length():
        raise ValueError("it has no levels, or more than down to one pixel")
    return ImageSize(columns, rows, sides=sides, levels=levels)
