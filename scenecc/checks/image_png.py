"""PNG, all of it: its chunks in order and whole, and as many pixels in them as its header says."""

from __future__ import annotations

import struct
import zlib
from typing import BinaryIO

from scenecc.checks.image_size import ImageSize, exactly

SIGNATURE = b"\x89PNG\r\n\x1a\n"
_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
_DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}
_PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
"""Of an interlaced picture: first column and row of each pass, and the steps between its columns and rows."""
_PIECE = 1 << 20
_MOST_CHUNKS = 2**16
"""A large file of empty ones would take its time."""


def png_size(file: BinaryIO) -> tuple[ImageSize, int, int]:
    """What its header says: the size, bits a pixel, and whether it is interlaced. The file is read past the header."""
    file.seek(len(SIGNATURE))
    kind, body = _chunk(file)
    if kind != b"IHDR" or len(body) != 13:
        raise ValueError("its first chunk is not IHDR")
    columns, rows, depth, colour, packing, filters, interlaced = struct.unpack(">IIBBBBB", body)
    if depth not in _DEPTHS.get(colour, ()) or packing or filters or interlaced > 1:
        raise ValueError("its header says what no PNG has")
    return ImageSize(columns, rows, 8 if depth == 16 else 4), depth * _CHANNELS[colour], interlaced


def check_png(file: BinaryIO) -> None:
    """Reads all of a PNG.

    Raises:
        ValueError, EOFError, struct.error: it is cut short, or not what its header says.
    """
    size, bits, interlaced = png_size(file)
    file.seek(len(SIGNATURE) + 8)
    indexed = exactly(file, 13)[9] == 3
    file.seek(4, 1)
    rows = _Rows(size, bits, interlaced)
    palette = 0
    seen, before = set[bytes](), b""
    for _ in range(_MOST_CHUNKS):
        kind, body = _chunk(file)
        if kind == b"IEND":
            rows.end()
            return
        first = kind not in seen
        if kind == b"IDAT":
            if not first and before != kind:
                raise ValueError("its pixels stand in pieces among other chunks")
            if indexed and not palette:
                raise ValueError("it has no palette")
            rows.take(body)
        elif kind in {b"PLTE", b"tRNS"} and (not first or b"IDAT" in seen):
            raise ValueError(f"{kind.decode()} stands twice, or after the pixels")
        elif kind == b"PLTE":
            palette = len(body) // 3
            if len(body) % 3 or not 1 <= palette <= 256:
                raise ValueError("its palette has no whole number of colours, or too many")
        elif kind == b"tRNS":
            _check_transparent(len(body), bits, palette, indexed=indexed)
        elif not kind[0] & 0x20:
            raise ValueError(f"it has the chunk {kind!r}, which no reader knows")
        seen.add(kind)
        before = kind
    raise ValueError(f"it has more than {_MOST_CHUNKS} chunks")


def _chunk(file: BinaryIO) -> tuple[bytes, bytes]:
    length, kind = struct.unpack(">I4s", exactly(file, 8))
    body = exactly(file, length)
    (stated,) = struct.unpack(">I", exactly(file, 4))
    if zlib.crc32(kind + body) != stated:
        raise ValueError(f"the chunk {kind!r} is damaged")
    return kind, body


def _check_transparent(length: int, bits: int, palette: int, *, indexed: bool) -> None:
    channels = {1: 1, 2: 1, 4: 1, 8: 1, 16: 1, 24: 3, 48: 3}.get(bits)
    if (indexed and length > palette) or (not indexed and (channels is None or length != 2 * channels)):
        raise ValueError("tRNS is of another length than it should have")


class _Rows:
    """The rows of a PNG, as they are unpacked: each begins with the number of a filter."""

    def __init__(self, size: ImageSize, bits: int, interlaced: int) -> None:
        passes = _PASSES if interlaced else ((0, 0, 1, 1),)
        self._left: list[tuple[int, int]] = []
        for column, row, across, down in passes:
            columns, rows = -(-(size.columns - column) // across), -(-(size.rows - row) // down)
            if columns > 0 and rows > 0:
                self._left.append((1 + (columns * bits + 7) // 8, rows))
        self._left.reverse()
        self._at = 0
        self._packed = zlib.decompressobj()

    def take(self, data: bytes) -> None:
        while data:
            try:
                found = self._packed.decompress(data, _PIECE)
            except zlib.error as error:
                raise ValueError("its pixels cannot be unpacked") from error
            self._look(found)
            data = self._packed.unconsumed_tail

    def _look(self, found: bytes) -> None:
        at = 0
        while at < len(found):
            if not self._left:
                raise ValueError("it has more pixels than its header says")
            length, rows = self._left[-1]
            here = min(len(found) - at, length * rows - self._at)
            first = -self._at % length
            filters = found[at + first : at + here : length]
            if filters and max(filters) > 4:
                raise ValueError("a row of its pixels has a filter that is none")
            at += here
            self._at += here
            if self._at == length * rows:
                self._left.pop()
                self._at = 0

    def end(self) -> None:
        if self._left or not self._packed.eof:
            raise ValueError("it has fewer pixels than its header says")
