"""Reads grey PNGs as numbers, of 8 or 16 bits. A file may come from a stranger: it is small, or refused."""

from __future__ import annotations

import struct
import zlib
from typing import Final

_SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"

_ADVICE: Final = "save it as a grey PNG of 16 bits without alpha and interlacing"


def read_grey_png(data: bytes, max_pixels: int) -> tuple[tuple[float, ...], ...]:
    """The rows of a grey PNG from its top, 0 for black and 1 for white.

    Args:
        data: the file.
        max_pixels: of a larger one nothing is unpacked.

    Raises:
        ValueError: it is none, damaged, of another kind or too large.
    """
    try:
        columns, rows, depth, packed = _read_chunks(data, max_pixels)
    except struct.error:
        raise ValueError("it is cut short") from None
    step = depth // 8
    width = columns * step
    unpack = zlib.decompressobj()
    try:
        raw = unpack.decompress(packed, rows * (width + 1) + 1)
    except zlib.error:
        raise ValueError("its pixels cannot be unpacked") from None
    if len(raw) != rows * (width + 1) or not unpack.eof:
        raise ValueError("it has more or fewer pixels than its header says")
    above, found = bytes(width), list[tuple[float, ...]]()
    whole = (1 << depth) - 1
    for start in range(0, len(raw), width + 1):
        above = _unfiltered(raw[start], raw[start + 1 : start + 1 + width], above, step)
        samples = above if step == 1 else struct.unpack(f">{columns}H", above)
        found.append(tuple(sample / whole for sample in samples))
    return tuple(found)


def _read_chunks(data: bytes, max_pixels: int) -> tuple[int, int, int, bytes]:
    """Columns, rows, bits a pixel and the packed pixels."""
    if not data.startswith(_SIGNATURE):
        raise ValueError(f"it is no PNG; {_ADVICE}")
    at, header, packed = len(_SIGNATURE), b"", list[bytes]()
    while True:
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + length]
        (stated,) = struct.unpack_from(">I", data, at + 8 + length)
        if zlib.crc32(kind + body) != stated:
            raise ValueError(f"the chunk {kind!r} is damaged")
        if (kind == b"IHDR") == bool(header):
            raise ValueError("IHDR is not its first chunk alone")
        if kind == b"tRNS":
            raise ValueError(f"some of its pixels are transparent; {_ADVICE}")
        if kind == b"IHDR":
            header = body
            columns, rows, depth, *others = struct.unpack(">IIBBBBB", body)
            if depth not in {8, 16} or any(others):
                raise ValueError(f"it is not grey with 8 or 16 bits; {_ADVICE}")
            if not columns or not rows:
                raise ValueError("it has no pixels")
            if columns * rows > max_pixels:
                raise ValueError(f"it has {columns} × {rows} pixels, and a heightfield at most {max_pixels}")
        elif kind == b"IDAT":
            packed.append(body)
        elif kind == b"IEND":
            return columns, rows, depth, b"".join(packed)  # pyright: ignore[reportPossiblyUnboundVariable]
        at += 12 + length


def _unfiltered(kind: int, row: bytes, above: bytes, step: int) -> bytes:
    """A row of bytes without its filter, of which PNG has five."""
    if kind == 0:
        return row
    if kind > 4:
        raise ValueError("a row of its pixels has a filter that is none")
    made = bytearray(row)
    for i, byte in enumerate(row):
        left = made[i - step] if i >= step else 0
        up, corner = above[i], above[i - step] if i >= step else 0
        made[i] = (byte + (left, up, (left + up) // 2, _paeth(left, up, corner))[kind - 1]) & 0xFF
    return bytes(made)


def _paeth(left: int, up: int, corner: int) -> int:
    """Which of three is nearest to their plane."""
    middle = left + up - corner
    return min((left, up, corner), key=lambda one: abs(middle - one))
