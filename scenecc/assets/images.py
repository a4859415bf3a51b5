"""Checks that images are complete, and reads their sizes. Pillow decodes PNG, JPEG, BMP and TGA.

Pillow does not read HDR, EXR and KTX. They are checked as far as SAPIEN needs it: a truncated HDR hangs SAPIEN, and a
truncated KTX crashes it. It reports a damaged EXR itself.
"""

from __future__ import annotations

import io
import re
import struct
import warnings
import zlib
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any

from scenecc.assets.errors import AssetError

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tga", ".hdr", ".exr", ".ktx")
"""Image formats that SAPIEN's renderer loads."""


@dataclass(frozen=True, slots=True)
class ImageSize:
    """Size of an image, and bytes per pixel after decompression.

    Attributes:
        sides: 6 for a cube map.
        levels: number of mipmap levels in the file, including the image itself; 0: the format has none.
        grey: whether SAPIEN loads it as a texture with one channel, red.
    """

    columns: int
    rows: int
    pixel_bytes: int = 4
    sides: int = 1
    levels: int = 0
    grey: bool = field(default=False, compare=False)

    def __str__(self) -> str:
        return f"{self.columns} × {self.rows} pixels of {self.pixel_bytes} bytes"

    @property
    def level_bytes(self) -> list[int]:
        """Returns the bytes of one side at each mipmap level, each with half the columns and rows of the one before."""
        return [
            max(1, self.columns >> level) * max(1, self.rows >> level) * self.pixel_bytes
            for level in range(self.levels or 1)
        ]

    @property
    def unpacked(self) -> int:
        """Returns the decompressed size of all sides and levels [bytes]."""
        return sum(self.level_bytes) * self.sides

    @property
    def has_all_levels(self) -> bool:
        """Returns whether its mipmap levels go down to a single pixel, or its format has none."""
        return self.levels in {0, max(self.columns, self.rows).bit_length()}


def check_image(data: bytes, max_bytes: float, suffix: str = "") -> ImageSize:
    """Checks a whole image, and returns its size.

    Args:
        data: the content of the file.
        max_bytes: maximum decompressed size [bytes]. No pixel of a larger image is decompressed.
        suffix: of the file, by which SAPIEN recognizes EXR and KTX. "": it is embedded in another file.

    Raises:
        AssetError: it is damaged, truncated, too large, or of a format that SAPIEN does not load.
    """
    try:
        with _plain_errors():
            kind = _detect_format(data, suffix)
            size = _read_size(data, kind)
            if size.columns < 1 or size.rows < 1:
                raise ValueError(f"it has {size.columns} × {size.rows} pixels")  # noqa: TRY301 - as any other fault
            if size.unpacked <= max_bytes:
                _check_pixels(data, kind)
    except ValueError as error:
        hint = "export it again" if suffix in {".hdr", ".exr", ".ktx"} else "save it again as PNG or JPEG"
        raise AssetError("SC420", f"the image cannot be read: {error}", hint) from error
    if size.unpacked > max_bytes:
        raise AssetError(
            "SC607",
            f"the image has {size}, unpacked {size.unpacked} bytes, but the limit asset_bytes is {max_bytes}",
            f"make it smaller, or raise the limit with --limit asset_bytes={size.unpacked}",
        )
    return size


def read_heights(data: bytes, max_pixels: int) -> tuple[tuple[float, ...], ...]:
    """Returns the rows of a grey PNG from the top, 0 for black and 1 for white.

    Args:
        data: the content of the file.
        max_pixels: maximum number of pixels. No pixel of a larger image is decompressed.

    Raises:
        ValueError: it is damaged, too large, or not a grey PNG.
    """
    import numpy as np  # noqa: PLC0415 - loaded where a scene has terrain from a file

    with _plain_errors():
        picture = _open_with_pillow(data, "Png")
        columns, rows = picture.size
        if columns * rows > max_pixels:
            raise ValueError(f"it has {columns} × {rows} pixels, but a heightfield may have at most {max_pixels}")
        if picture.mode not in _GREY_MODES - {"1"} or "transparency" in picture.info:
            raise ValueError("it is not a grey PNG of 8 or 16 bits without alpha")
        _check_pixels(data, "Png")
        heights = np.asarray(picture) / (255 if picture.mode == "L" else 65535)
    return tuple(map(tuple, heights.tolist()))


_WORDED_ERRORS = (OSError, SyntaxError, ValueError)
_OTHER_ERRORS = (ArithmeticError, AttributeError, EOFError, LookupError, TypeError, struct.error, zlib.error)
"""Errors that Pillow raises for damaged files, some without a text for users."""

_PLAIN_WORDS = {
    "Truncated File Read": "it is truncated",
    "not identified by this driver": "it has no pixels, or its header is damaged",
    "cannot load this image": "it has no pixels",
    "": "it is truncated or damaged",
}


@contextmanager
def _plain_errors() -> Generator[None]:
    """Converts any error of a reader to a ValueError in plain words, and suppresses Pillow's warnings."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except (*_WORDED_ERRORS, *_OTHER_ERRORS) as error:
        # Pillow wraps other errors in a SyntaxError with the same text.
        worded = isinstance(error, _WORDED_ERRORS) and not isinstance(error.__cause__, _OTHER_ERRORS)
        words = str(error) if worded else ""
        raise ValueError(_PLAIN_WORDS.get(words, words)) from error


_SIGNATURES = {
    b"\x89PNG\r\n\x1a\n": "Png",
    b"\xff\xd8": "Jpeg",
    b"BM": "Bmp",
    b"#?RADIANCE": "hdr",
    b"#?RGBE": "hdr",
    b"\x76\x2f\x31\x01": ".exr",
    b"\xabKTX 11\xbb\r\n\x1a\n": ".ktx",
    b"\xabKTX 20\xbb\r\n\x1a\n": ".ktx",
}
"""First bytes → format. A TGA has none. Pillow's module and class of a format have the same name."""


def _detect_format(data: bytes, suffix: str) -> str:
    """Returns the format of an image as SAPIEN does: by its first bytes, and EXR and KTX by the suffix."""
    found = next((kind for start, kind in _SIGNATURES.items() if data.startswith(start)), "Tga")
    if suffix in {".exr", ".ktx"} and found != suffix:
        raise ValueError(f"it is not an image of the format that its suffix `{suffix}` names")
    if found.startswith(".") and found != suffix:
        raise ValueError(f"SAPIEN reads this format only from a file with the suffix `{found}`")
    return found


def _read_size(data: bytes, kind: str) -> ImageSize:
    if kind in _SIZES:
        return _SIZES[kind](data)
    picture = _open_with_pillow(data, kind)
    grey = kind != "Bmp" and picture.mode in _GREY_MODES and "transparency" not in picture.info
    columns, rows = picture.size
    return ImageSize(columns, rows, 8 if kind == "Png" and data[24] == 16 else 4, grey=grey)


_GREY_MODES = {"1", "L", "I", "I;16"}
"""Pillow's modes of images with one channel and without alpha."""

_MOST_SCANS = 128
"""Each scan of 50 bytes covers the whole JPEG, so a small file could take hours. Usual files have 1 to 10 scans."""


def _check_pixels(data: bytes, kind: str) -> None:
    """Checks the content after the header. Raises errors that `_plain_errors` converts."""
    if kind == ".exr":
        _check_exr_blocks(data)
    elif kind == "hdr":
        _check_hdr_rows(data)
    elif kind != ".ktx":
        if kind == "Png":
            _open_with_pillow(data, kind).verify()  # checks the chunks' checksums, which `load` ignores
            _check_png_length(data)
        elif kind == "Bmp":
            _check_bmp_header(data)
        elif kind == "Jpeg" and data.count(b"\xff\xda") > _MOST_SCANS:
            raise ValueError(f"it has more than {_MOST_SCANS} scans")
        _open_with_pillow(data, kind).load()


def _check_bmp_header(data: bytes) -> None:
    """Raises ValueError for files of which SAPIEN 3.0 shows wrong pixels, as measured for each bit depth."""
    if int.from_bytes(data[14:18], "little") == 12:
        raise ValueError("it is an OS/2 BMP, which SAPIEN misreads")
    if int.from_bytes(data[28:30], "little") == 1:
        raise ValueError("it is a BMP with one bit per pixel, which SAPIEN misreads")


def _check_png_length(data: bytes) -> None:
    """Raises ValueError if a PNG does not unpack to the size in its header: SAPIEN hangs at 2 GB."""
    most, unpacked, at = 2 * _read_size(data, "Png").unpacked + 2**16, 0, 8
    unpacker = zlib.decompressobj()
    while (kind := data[at + 4 : at + 8]) not in {b"IEND", b""}:
        start, end = at + 8, at + 8 + int.from_bytes(data[at : at + 4], "big")
        if kind == b"CgBI":
            raise ValueError("it is an Xcode PNG, which only Apple's programs read")
        for part in range(start, end if kind == b"IDAT" else start, 2**14):
            if unpacker.eof:
                return
            unpacked += len(unpacker.decompress(data[part : min(part + 2**14, end)]))
            if unpacked > most:
                raise ValueError("it has more pixels than its header says")
        at = end + 4
    if not unpacker.eof:
        raise ValueError("its pixel data is incomplete")


def _open_with_pillow(data: bytes, kind: str) -> Any:
    """Opens an image without decompressing its pixels.

    `PIL.Image.open` has its own process-wide limit of pixels, and loads the readers of more formats.
    """
    try:
        return getattr(import_module(f"PIL.{kind}ImagePlugin"), f"{kind}ImageFile")(io.BytesIO(data))
    except SyntaxError:
        if kind == "Tga":
            raise ValueError("it is not a PNG, JPEG, BMP, TGA, HDR, EXR or KTX" if data else "it is empty") from None
        raise


_HDR_HEADER = re.compile(
    rb"#\?(?:RADIANCE|RGBE)\n(?:[^\n]+\n)*?FORMAT=32-bit_rle_rgbe\n(?:[^\n]+\n)*\n-Y ([0-9]{1,8}) +\+X ([0-9]{1,8})\n"
)


def _parse_hdr_header(data: bytes) -> tuple[int, int, int]:
    """Returns columns, rows, and the position of the pixels."""
    match = _HDR_HEADER.match(data, 0, 1 << 16)
    if match is None:
        raise ValueError("its header is not `FORMAT=32-bit_rle_rgbe`, an empty line, and `-Y rows +X columns`")
    return int(match[2]), int(match[1]), match.end()


def _hdr_size(data: bytes) -> ImageSize:
    columns, rows, _ = _parse_hdr_header(data)
    return ImageSize(columns, rows, 16)


def _check_hdr_rows(data: bytes) -> None:
    columns, rows, at = _parse_hdr_header(data)
    if not 8 <= columns < 32768 or data[at : at + 2] != b"\2\2":  # not compressed
        at, rows = at + 4 * columns * rows, 0
    for _ in range(rows):
        if data[at : at + 4] != struct.pack(">BBH", 2, 2, columns):
            raise ValueError("the length of a row differs from the header")
        at += 4
        for _ in range(4):  # red, green, blue and exponent, each as runs of one byte or plain bytes
            left = columns
            while left:
                count = data[at]
                at += 2 if count > 128 else 1 + count
                count -= 128 if count > 128 else 0
                if not 1 <= count <= left:
                    raise ValueError("its pixels are damaged")
                left -= count
    if at > len(data):
        raise ValueError("it has fewer pixels than its header says")


_EXR_TILED_OR_IN_PARTS, _EXR_LONG_NAMES = 0x1200, 0x400

_EXR_BLOCK_ROWS = (1, 1, 1, 16, 32, 16, 32, 32, 32, 256)
"""Rows per block, by compression method; SAPIEN supports no further methods."""


_EXR_ATTRIBUTE = re.compile(rb"([^\0]{1,255})\0[^\0]{1,255}\0(.{4})", re.DOTALL)
"""Name, type and length of an attribute, before its value."""


def _parse_exr_header(data: bytes) -> tuple[dict[bytes, bytes], int, int]:
    """Returns the attributes, the flags, and the end of the header."""
    (version,) = struct.unpack_from("<I", data, 4)
    flags = version & ~0xFF
    if version & 0xFF != 2 or flags & ~(_EXR_TILED_OR_IN_PARTS | _EXR_LONG_NAMES):
        raise ValueError("it is a deep EXR, or not of version 2")
    found: dict[bytes, bytes] = {}
    at = 8
    while data[at]:
        match = _EXR_ATTRIBUTE.match(data, at)
        if match is None:
            raise ValueError("its header is damaged")
        at = match.end() + int.from_bytes(match[2], "little")
        found[match[1]] = data[match.end() : at]
    return found, flags, at + 1


def _exr_size(data: bytes) -> ImageSize:
    """Returns the size of an EXR, of which the renderer stores four half-floats per pixel."""
    left, top, right, bottom = struct.unpack("<4i", _parse_exr_header(data)[0][b"dataWindow"])
    return ImageSize(right - left + 1, bottom - top + 1, 8)


def _check_exr_blocks(data: bytes) -> None:
    """Checks that the blocks of rows lie within the file."""
    found, flags, at = _parse_exr_header(data)
    _, top, _, bottom = struct.unpack("<4i", found[b"dataWindow"])
    starts = range(top, bottom + 1, _EXR_BLOCK_ROWS[found[b"compression"][0]])
    if flags & _EXR_TILED_OR_IN_PARTS:
        return
    for start, offset in zip(starts, struct.unpack_from(f"<{len(starts)}Q", data, at), strict=True):
        row, length = struct.unpack_from("<ii", data, offset)
        if row != start or not 0 < length <= len(data) - offset - 8:
            raise ValueError("it is truncated, or a block of its pixels is damaged")


_KTX1_RGBA8 = (0x1401, 0x1908, 0x8058)
"""GL_UNSIGNED_BYTE, GL_RGBA, GL_RGBA8."""

_KTX2_RGBA8, _KTX2_COMPRESSIONS = 37, (0, 2, 3)
"""None, Zstandard and zlib. The Basis scheme has no format of its own."""


def _ktx_size(data: bytes) -> ImageSize:
    """Returns the size of a KTX, and checks that all its mipmap levels are complete."""
    order, at, scheme = "<", 0, 0
    first = data.startswith(b"\xabKTX 11")
    if first:
        order = {b"\1\2\3\4": "<", b"\4\3\2\1": ">"}[data[12:16]]
        kind, _, layout, internal, _, *numbers, pairs = struct.unpack_from(f"{order}12I", data, 16)
        supported = (kind, layout, internal) == _KTX1_RGBA8
        at = 64 + pairs
    else:
        kind, _, *numbers, scheme = struct.unpack_from("<9I", data, 12)
        supported = kind == _KTX2_RGBA8 and scheme in _KTX2_COMPRESSIONS
    if not supported:
        raise ValueError("SAPIEN only loads KTX in the format R8G8B8A8 (UNORM)")
    columns, rows, depth, elements, sides, levels = numbers
    if depth or elements or sides not in {1, 6}:
        raise ValueError("it is neither a single image nor a cube map")
    if not 1 <= levels <= max(columns, rows).bit_length():
        raise ValueError("its number of mipmap levels is invalid")
    size = ImageSize(columns, rows, sides=sides, levels=levels)
    for level, expected in enumerate(size.level_bytes):
        if first:
            (length,) = struct.unpack_from(f"{order}I", data, at)
            at += 4 + length * sides
            unpacked, end = length * sides, at
        else:
            start, length, unpacked = struct.unpack_from("<3Q", data, 80 + 24 * level)
            unpacked, end = unpacked if scheme else length, start + length
        if unpacked != expected * sides or end > len(data):
            raise ValueError("it is truncated, or its mipmap levels have the wrong size")
    return size


_SIZES: dict[str, Callable[[bytes], ImageSize]] = {".exr": _exr_size, ".ktx": _ktx_size, "hdr": _hdr_size}
