"""Size and validity of PNG, BMP, TGA, HDR, EXR and KTX images. SAPIEN's own readers do not report truncated files."""

from __future__ import annotations

import io
import math
import re
import struct
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, BinaryIO

if TYPE_CHECKING:
    from collections.abc import Iterator


@dataclass(frozen=True, slots=True)
class ImageSize:
    """Size of an image, and bytes per pixel once it is decompressed.

    Attributes:
        sides: 6 for a cube map.
        levels: number of mipmap levels in the file, the image itself included; 0: the format has none.
    """

    columns: int
    rows: int
    pixel_bytes: int = 4
    sides: int = 1
    levels: int = 0

    def __str__(self) -> str:
        return f"{self.columns} × {self.rows} pixels of {self.pixel_bytes} bytes"

    @property
    def level_bytes(self) -> list[int]:
        """Bytes of one side at each mipmap level, each with half the columns and rows of the one before."""
        return [
            max(1, self.columns >> level) * max(1, self.rows >> level) * self.pixel_bytes
            for level in range(self.levels or 1)
        ]

    @property
    def has_all_levels(self) -> bool:
        """Whether its mipmap levels go down to a single pixel, if the format has any."""
        return self.levels in {0, max(self.columns, self.rows).bit_length()}


def read_exactly(file: BinaryIO, count: int) -> bytes:
    """The next bytes of a file. Raises EOFError if there are fewer."""
    at = file.tell()
    if count > file.seek(0, io.SEEK_END) - at:
        raise EOFError("it is cut short")
    file.seek(at)
    return file.read(count)


PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"

_PNG_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}

_PNG_BIT_DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}


_ADAM7_PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
"""First column and row of each pass of an interlaced image, and the steps between its columns and rows."""

_PNG_READ_SIZE = 1 << 20

_MAX_PNG_CHUNKS = 2**16
"""Bounds the time for a file of many empty chunks."""


def png_size(file: BinaryIO) -> tuple[ImageSize, int, int]:
    """The size, bits per pixel and interlacing of a PNG. The file is then after its header."""
    file.seek(len(PNG_SIGNATURE))
    kind, body = _read_png_chunk(file)
    if kind != b"IHDR" or len(body) != 13:
        raise ValueError("its first chunk is not IHDR")
    columns, rows, depth, colour, packing, filters, interlaced = struct.unpack(">IIBBBBB", body)
    if depth not in _PNG_BIT_DEPTHS.get(colour, ()) or packing or filters or interlaced > 1:
        raise ValueError("its header is not valid")
    return ImageSize(columns, rows, 8 if depth == 16 else 4), depth * _PNG_CHANNELS[colour], interlaced


def check_png(file: BinaryIO) -> None:
    """Checks a whole PNG.

    Raises:
        ValueError, EOFError, struct.error: it is truncated, or contradicts its header.
    """
    size, bits, interlaced = png_size(file)
    file.seek(len(PNG_SIGNATURE) + 8)
    indexed = read_exactly(file, 13)[9] == 3
    file.seek(4, 1)
    rows = _PngRows(size, bits, interlaced)
    palette = 0
    kinds, before = set[bytes](), b""
    for _ in range(_MAX_PNG_CHUNKS):
        kind, body = _read_png_chunk(file)
        if kind == b"IEND":
            rows.end()
            return
        first = kind not in kinds
        if kind == b"IDAT":
            if not first and before != kind:
                raise ValueError("its IDAT chunks are not consecutive")
            if indexed and not palette:
                raise ValueError("it has no palette")
            rows.take(body)
        elif kind in {b"PLTE", b"tRNS"} and (not first or b"IDAT" in kinds):
            raise ValueError(f"{kind.decode()} is repeated, or follows the pixels")
        elif kind == b"PLTE":
            palette = len(body) // 3
            if len(body) % 3 or not 1 <= palette <= 256:
                raise ValueError("its palette is not a whole number of colours, or has more than 256")
        elif kind == b"tRNS":
            _check_png_transparency(len(body), bits, palette, indexed=indexed)
        elif not kind[0] & 0x20:
            raise ValueError(f"it has the chunk {kind!r}, which is unknown and critical")
        kinds.add(kind)
        before = kind
    raise ValueError(f"it has more than {_MAX_PNG_CHUNKS} chunks")


def _read_png_chunk(file: BinaryIO) -> tuple[bytes, bytes]:
    length, kind = struct.unpack(">I4s", read_exactly(file, 8))
    body = read_exactly(file, length)
    (stated,) = struct.unpack(">I", read_exactly(file, 4))
    if zlib.crc32(kind + body) != stated:
        raise ValueError(f"the chunk {kind!r} is damaged")
    return kind, body


def _check_png_transparency(length: int, bits: int, palette: int, *, indexed: bool) -> None:
    channels = {1: 1, 2: 1, 4: 1, 8: 1, 16: 1, 24: 3, 48: 3}.get(bits)
    if (indexed and length > palette) or (not indexed and (channels is None or length != 2 * channels)):
        raise ValueError("tRNS has the wrong length")


class _PngRows:
    """Checks the rows of a PNG while they are decompressed: each begins with a filter type."""

    def __init__(self, size: ImageSize, bits: int, interlaced: int) -> None:
        passes = _ADAM7_PASSES if interlaced else ((0, 0, 1, 1),)
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
                found = self._packed.decompress(data, _PNG_READ_SIZE)
            except zlib.error as error:
                raise ValueError("its pixels cannot be decompressed") from error
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
                raise ValueError("a row of its pixels has an invalid filter")
            at += here
            self._at += here
            if self._at == length * rows:
                self._left.pop()
                self._at = 0

    def end(self) -> None:
        if self._left or not self._packed.eof:
            raise ValueError("it has fewer pixels than its header says")


_HDR_HEADER = re.compile(
    rb"#\?(?:RADIANCE|RGBE)\n(?:[^\n]+\n)*?FORMAT=32-bit_rle_rgbe\n(?:[^\n]+\n)*\n-Y ([0-9]{1,8}) +\+X ([0-9]{1,8})\n"
)

_TRUNCATED_PIXELS = "it has fewer pixels than its header says"


def is_tga(head: bytes) -> bool:
    """Whether a header can be that of a TGA, which has no signature."""
    if len(head) < 18 or head[1] > 1 or head[16] not in {8, 15, 16, 24, 32}:
        return False
    if head[1]:
        return head[2] in {1, 9} and head[7] in {8, 15, 16, 24, 32} and head[16] in {8, 16}
    return head[2] in {2, 3, 10, 11}


def bmp_size(head: bytes) -> ImageSize:
    """The size of a BMP."""
    form = "<HH" if head[14:18] == b"\x0c\0\0\0" else "<ii"
    columns, rows = struct.unpack_from(form, head, 18)
    return ImageSize(columns, abs(rows))


def check_bmp(file: BinaryIO) -> None:
    """Checks a whole BMP.

    Raises:
        ValueError, EOFError, struct.error: it is truncated, or of a kind that SAPIEN does not load.
    """
    size = bmp_size(head := read_exactly(file, 26))
    offset, length = struct.unpack_from("<II", head, 10)
    short = length == 12
    if length not in {12, 40, 56, 108, 124}:
        raise ValueError("its header has an unknown length")
    header = head[14:] + (b"" if short else read_exactly(file, length - 12))
    planes, bits = struct.unpack_from("<HH", header, 8 if short else 12)
    packing = 0 if short else struct.unpack_from("<I", header, 16)[0]
    if planes != 1 or bits not in ({1, 4, 8, 24} if short else {1, 4, 8, 16, 24, 32}):
        raise ValueError("its number of planes or bits per pixel is invalid")
    if packing not in {0, 3} or (packing == 3 and bits not in {16, 32}):
        raise ValueError("it is compressed, and SAPIEN reads uncompressed BMP only")
    masks = b""
    if packing == 3:
        masks = header[40:52] if length >= 108 else read_exactly(file, 12)
        if any(
            mask == 0 or mask.bit_length() - (mask & -mask).bit_length() > 7 for mask in struct.unpack("<3I", masks)
        ):
            raise ValueError("its colour masks are invalid")
    read = 14 + length + (12 if packing == 3 and length < 108 else 0)
    entry = 3 if short else 4
    colours = (offset - read) // entry if bits <= 8 else 0
    if offset < read or (bits <= 8 and not 1 <= colours <= 256) or (bits > 8 and offset - read > 1024):
        raise ValueError("the offset of its pixels is invalid")
    _skip_bytes(file, offset - read)
    _skip_bytes(file, (size.columns * bits + 31) // 32 * 4 * size.rows)


def check_tga(file: BinaryIO) -> None:
    """Checks a whole TGA. Raises like `check_bmp`."""
    head = read_exactly(file, 18)
    length, indexed, kind, _, colours, entry, _, _, columns, rows, bits, _ = struct.unpack("<BBBHHBHHHHBB", head)
    _skip_bytes(file, length)
    if indexed:
        if not colours:
            raise ValueError("its colour map is empty")
        _skip_bytes(file, colours * ((entry + 7) // 8))
    pixel = (bits + 7) // 8
    if kind < 8:
        _skip_bytes(file, columns * rows * pixel)
        return
    left = columns * rows
    while left > 0:
        packet = read_exactly(file, 1)[0]
        count = (packet & 127) + 1
        left -= count
        _skip_bytes(file, pixel if packet & 128 else pixel * min(count, count + left))


def hdr_size(file: BinaryIO) -> tuple[ImageSize, int]:
    """The size of an HDR, and where its pixels begin."""
    file.seek(0)
    match = _HDR_HEADER.match(file.read(1 << 16))
    if match is None:
        raise ValueError("its header is not `FORMAT=32-bit_rle_rgbe`, an empty line, and `-Y rows +X columns`")
    return ImageSize(int(match[2]), int(match[1]), 16), match.end()


def check_hdr(file: BinaryIO) -> None:
    """Checks a whole HDR. Raises like `check_bmp`."""
    size, start = hdr_size(file)
    file.seek(start)
    data = file.read()
    if not 8 <= size.columns < 32768 or not data.startswith(b"\x02\x02"):
        if len(data) < 4 * size.columns * size.rows:
            raise ValueError(_TRUNCATED_PIXELS)
        return
    at = 0
    line = struct.pack(">BBH", 2, 2, size.columns)
    for _ in range(size.rows):
        if data[at : at + 4] != line:
            raise ValueError("the length of a row differs from the header")
        at += 4
        for _ in range(4):
            left = size.columns
            while left:
                count = data[at] if at < len(data) else 0
                same = count > 128
                count -= 128 if same else 0
                if not 1 <= count <= left:
                    raise ValueError(_TRUNCATED_PIXELS)
                left -= count
                at += 2 if same else 1 + count
    if at > len(data):
        raise ValueError(_TRUNCATED_PIXELS)


def _skip_bytes(file: BinaryIO, count: int) -> None:
    at = file.tell()
    end = file.seek(0, 2)
    if at + count > end:
        raise EOFError(_TRUNCATED_PIXELS)
    file.seek(at + count)


EXR_MAGIC = b"\x76\x2f\x31\x01"

_DEEP, _LONG_NAMES, _IN_PIECES = 0x800, 0x400, 0x1200
"""Flags of the version field; in pieces: tiled, or with several parts."""

_MAX_EXR_HEADER = 1 << 20
"""Maximum header size [bytes]; attributes may hold a preview image."""


def exr_size(file: BinaryIO) -> ImageSize:
    """The size of an EXR; the renderer stores four half-floats per pixel.

    Raises:
        ValueError, EOFError: it is invalid, or SAPIEN does not load it.
    """
    left, top, right, bottom = struct.unpack("<4i", _read_exr_attributes(file)[0]["dataWindow"])
    return ImageSize(right - left + 1, bottom - top + 1, 8)


def check_exr(file: BinaryIO) -> None:
    """Checks all blocks of a scan line EXR, and decompresses zlib ones; of tiled and multi-part files, only the header.

    Raises:
        ValueError, EOFError, struct.error: it is truncated, or contradicts its header.
    """
    found, flags = _read_exr_attributes(file)
    packing = found["compression"][0]
    if packing >= len(_EXR_BLOCK_ROWS):
        raise ValueError("its compression method is unknown")
    left, top, right, bottom = struct.unpack("<4i", found["dataWindow"])
    view = struct.unpack("<4i", found["displayWindow"])
    if view[0] > view[2] or view[1] > view[3] or max(map(abs, (left, top, right, bottom, *view))) >= 2**30:
        raise ValueError("its data or display window is invalid")
    row = _exr_row_bytes(found["channels"], right - left + 1, bottom - top + 1)
    if flags & _IN_PIECES or row is None:
        return
    rows = _EXR_BLOCK_ROWS[packing]
    blocks = -(-(bottom - top + 1) // rows)
    offsets = struct.unpack(f"<{blocks}Q", read_exactly(file, 8 * blocks))
    for i, offset in enumerate(offsets):
        file.seek(min(offset, 2**62))
        y, size = struct.unpack("<ii", read_exactly(file, 8))
        whole = row * min(rows, bottom + 1 - y)
        if y != top + i * rows or not 0 < size <= whole or (packing == 0 and size != whole):
            raise ValueError("the position or size of a block of pixels is wrong")
        data = read_exactly(file, size)
        if packing in _EXR_ZLIB_COMPRESSIONS and size < whole:
            packed = zlib.decompressobj()
            try:
                if len(packed.decompress(data, whole)) != whole or packed.unconsumed_tail:
                    raise ValueError("the decompressed size of a block of pixels is wrong")
            except zlib.error as error:
                raise ValueError("its pixels cannot be decompressed") from error


_EXR_ATTRIBUTE_TYPES = {
    "channels": b"chlist",
    "compression": b"compression",
    "dataWindow": b"box2i",
    "displayWindow": b"box2i",
    "lineOrder": b"lineOrder",
    "pixelAspectRatio": b"float",
    "screenWindowCenter": b"v2f",
    "screenWindowWidth": b"float",
}

_EXR_TYPE_SIZES = {b"compression": 1, b"box2i": 16, b"lineOrder": 1, b"float": 4, b"v2f": 8}

_EXR_BLOCK_ROWS = (1, 1, 1, 16, 32, 16, 32, 32, 32, 256)
"""Rows per block, by compression method."""

_EXR_ZLIB_COMPRESSIONS = {2, 3}


def _read_exr_attributes(file: BinaryIO) -> tuple[dict[str, bytes], int]:
    """The attributes of the header, all required ones included, and its flags. The file is then after the header."""
    magic, version = struct.unpack("<4sI", read_exactly(file, 8))
    if magic != EXR_MAGIC or version & 0xFF != 2:
        raise ValueError("it is not an EXR, although its suffix says so")
    flags = version & ~0xFF
    if flags & _DEEP:
        raise ValueError("it is a deep EXR, which SAPIEN does not load")
    if flags & ~(_LONG_NAMES | _IN_PIECES):
        raise ValueError("its header has unknown flags")
    header = file.read(_MAX_EXR_HEADER)
    found: dict[str, bytes] = {}
    at = 0
    while (end := header.find(b"\0", at)) > at:
        kind = header.find(b"\0", end + 1)
        if kind < 0 or len(header) < kind + 5:
            break
        (length,) = struct.unpack_from("<I", header, kind + 1)
        name, value = header[at:end].decode("latin-1"), header[kind + 5 : kind + 5 + length]
        right = _EXR_ATTRIBUTE_TYPES.get(name)
        size = _EXR_TYPE_SIZES.get(header[end + 1 : kind], len(value))
        if (right is not None and header[end + 1 : kind] != right) or len(value) != length or length != size:
            raise ValueError(f"`{name[:40]}` of its header has the wrong type or size")
        found[name] = value
        at = kind + 5 + length
    if at >= len(header) or header[at] or not _EXR_ATTRIBUTE_TYPES.keys() <= found.keys():
        raise ValueError("its header is truncated or incomplete")
    ratio, width = (struct.unpack("<f", found[name])[0] for name in ("pixelAspectRatio", "screenWindowWidth"))
    if not 1e-6 <= ratio <= 1e6 or not 0 <= width < math.inf or found["lineOrder"][0] > 2:
        raise ValueError("its header is not valid")
    file.seek(8 + at + 1)
    return found, flags


def _exr_row_bytes(channels: bytes, columns: int, rows: int) -> int | None:
    """Bytes per row of pixels; None: some channels are subsampled."""
    total, at, even = 0, 0, True
    while (end := channels.find(b"\0", at)) > at:
        kind, _, across, down = struct.unpack_from("<iIii", channels, end + 1)
        if kind not in {0, 1, 2} or across < 1 or down < 1:
            raise ValueError("one of its channels is invalid")
        total += 2 if kind == 1 else 4
        if across * down > 1:
            # Chroma channels may have half the resolution.
            if channels[at:end] not in {b"RY", b"BY"} or (across, down) != (2, 2) or columns % 2 or rows % 2:
                raise ValueError("one of its channels has a different number of pixels")
            even = False
        at = end + 17
    if end != at or at != len(channels) - 1 or not total:
        raise ValueError("its channel list is truncated or empty")
    return total * columns if even else None


KTX_MAGICS = (b"\xabKTX 11\xbb\r\n\x1a\n", b"\xabKTX 20\xbb\r\n\x1a\n")


_KTX1_RGBA8 = (0x1401, 0x1908, 0x8058)
"""GL_UNSIGNED_BYTE, GL_RGBA, GL_RGBA8."""


_KTX2_RGBA8 = 37


_KTX2_COMPRESSIONS = {2, 3}
"""Zstandard and zlib; the transcoded scheme has no format of its own."""

_UNSUPPORTED_KTX = "SAPIEN loads KTX of the format R8G8B8A8 (UNORM) only"

_TRUNCATED_KTX = "it is truncated, or its mipmap levels have the wrong size"


def ktx_size(file: BinaryIO) -> ImageSize:
    """The size of a KTX, with a check that all its mipmap levels are there.

    Raises:
        ValueError, EOFError, struct.error: it is invalid, or SAPIEN does not load it.
    """
    magic = file.read(12)
    if magic not in KTX_MAGICS:
        raise ValueError("it is not a KTX, although its suffix says so")
    return _ktx1_size(file) if magic == KTX_MAGICS[0] else _ktx2_size(file)


def _ktx1_size(file: BinaryIO) -> ImageSize:
    order = "<" if (mark := read_exactly(file, 4)) == b"\1\2\3\4" else ">"
    if order == ">" and mark != b"\4\3\2\1":
        raise ValueError("its byte order mark is invalid")
    kind, _, layout, internal, _, columns, rows, *more, pairs = struct.unpack(f"{order}12I", read_exactly(file, 48))
    if (kind, layout, internal) != _KTX1_RGBA8:
        raise ValueError(_UNSUPPORTED_KTX)
    size = _checked_ktx_size(columns, rows, *more)
    at, end = 64 + pairs, file.seek(0, io.SEEK_END)
    for expected in size.level_bytes:
        file.seek(at)
        (length,) = struct.unpack(f"{order}I", read_exactly(file, 4))
        at += 4 + length * size.sides
        if length != expected or at > end:
            raise ValueError(_TRUNCATED_KTX)
    return size


def _ktx2_size(file: BinaryIO) -> ImageSize:
    kind, _, columns, rows, *more, scheme = struct.unpack("<9I", read_exactly(file, 36))
    if kind != _KTX2_RGBA8 or scheme not in {0, *_KTX2_COMPRESSIONS}:
        raise ValueError(_UNSUPPORTED_KTX)
    size = _checked_ktx_size(columns, rows, *more)
    file.seek(80)
    index = read_exactly(file, 24 * size.levels)
    end = file.seek(0, io.SEEK_END)
    for expected, (at, length, unpacked) in zip(size.level_bytes, _ktx2_levels(index), strict=True):
        if at + length > end or (unpacked if scheme else length) != expected * size.sides:
            raise ValueError(_TRUNCATED_KTX)
    return size


def _ktx2_levels(index: bytes) -> Iterator[tuple[int, int, int]]:
    yield from struct.iter_unpack("<3Q", index)


def _checked_ktx_size(columns: int, rows: int, depth: int, elements: int, sides: int, levels: int) -> ImageSize:
    if depth or elements or sides not in {1, 6}:
        raise ValueError("it is neither a single image nor a cube map")
    if not 1 <= levels <= max(columns, rows).bit_length():
        raise ValueError("its number of mipmap levels is invalid")
    return ImageSize(columns, rows, sides=sides, levels=levels)
