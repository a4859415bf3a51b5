"""Images: what they are and how large, from their headers alone. No pixel is unpacked."""

from __future__ import annotations

import io
import re
import struct
from collections.abc import Callable
from typing import TYPE_CHECKING, BinaryIO

from scenecc.checks.image_exr import MAGIC, exr_size
from scenecc.checks.image_ktx import MAGICS, ktx_size
from scenecc.checks.image_size import ImageSize, exactly
from scenecc.checks.mesh_data import AssetError

if TYPE_CHECKING:
    from pathlib import Path

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tga", ".hdr", ".exr", ".ktx")
"""What SAPIEN's renderer loads as a texture."""

_BY_SUFFIX: dict[str, Callable[[BinaryIO], ImageSize]] = {".exr": exr_size, ".ktx": ktx_size}
"""What SAPIEN tells by the suffix, written small; the others by what they hold."""

_JPEG_FRAMES = {0xC0, 0xC1, 0xC2}
_HDR_SIZE = re.compile(rb"\n[-+]([XY]) (\d{1,9}) [-+]([XY]) (\d{1,9})\n")


def image_size(path: Path) -> ImageSize:
    """The size of an image that `check_image` took."""
    with path.open("rb") as file:
        return _size(file, path.suffix)


def check_image(file: BinaryIO, max_bytes: int, suffix: str = "") -> None:
    """Checks the header of an image.

    Args:
        file: the image, at its start.
        max_bytes: how much it may take once unpacked [bytes].
        suffix: of its name, by which SAPIEN tells EXR and KTX from all others; "": it is a part of another file.

    Raises:
        AssetError: it is no image that SAPIEN loads, cut short, or too large.
    """
    try:
        size = _size(file, suffix)
    except (struct.error, EOFError, ValueError) as error:
        raise AssetError("SC420", f"the image cannot be read: {error}", "save it again as PNG or JPEG") from error
    if size.columns < 1 or size.rows < 1:
        raise AssetError("SC420", f"the image has {size.columns} × {size.rows} pixels", "save it again as PNG or JPEG")
    if sum(size.level_bytes) * size.sides > max_bytes:
        raise AssetError(
            "SC607",
            f"the image has {size.columns} × {size.rows} pixels, unpacked more than {max_bytes} bytes",
            "make it smaller, or raise the limit with --limit asset_bytes=N",
        )


def _size(file: BinaryIO, suffix: str) -> ImageSize:
    by_suffix = _BY_SUFFIX.get(suffix)
    return _by_head(file) if by_suffix is None else by_suffix(file)


def _by_head(file: BinaryIO) -> ImageSize:
    head = file.read(32)
    if head.startswith(b"\x89PNG\r\n\x1a\n"):
        return _png(file)
    if head.startswith(b"\xff\xd8\xff"):
        return _jpeg(file)
    if head.startswith(b"BM"):
        columns, rows = struct.unpack_from("<ii", head, 18)
        return ImageSize(columns, abs(rows))
    if head.startswith((b"#?RADIANCE", b"#?RGBE")):
        return _hdr(head + file.read(65536))
    if head.startswith((MAGIC, *MAGICS)):
        right = ".exr" if head.startswith(MAGIC) else ".ktx"
        raise ValueError(f"SAPIEN reads what it is in a file of its own whose name ends in `{right}` alone")
    if len(head) >= 18 and head[1] in {0, 1} and head[2] in {1, 2, 3, 9, 10, 11} and head[16] in {8, 15, 16, 24, 32}:
        columns, rows = struct.unpack_from("<HH", head, 12)
        return ImageSize(columns, rows)
    raise ValueError("it is empty" if not head else "it is none of PNG, JPEG, BMP, TGA, HDR, EXR and KTX")


def _png(file: BinaryIO) -> ImageSize:
    """Walks the chunks to the end: a file that is cut short has no last one."""
    file.seek(8)
    size: ImageSize | None = None
    has_data = False
    while True:
        length, kind = struct.unpack(">I4s", exactly(file, 8))
        if size is None:
            if kind != b"IHDR" or length != 13:
                raise ValueError("its first chunk is not IHDR")
            columns, rows, depth = struct.unpack_from(">IIB", exactly(file, 13))
            size = ImageSize(columns, rows, 8 if depth == 16 else 4)
            file.seek(4, io.SEEK_CUR)
        elif kind == b"IEND":
            if not has_data:
                raise ValueError("it holds no pixels")
            return size
        else:
            has_data = has_data or kind == b"IDAT"
            file.seek(length + 4, io.SEEK_CUR)


def _jpeg(file: BinaryIO) -> ImageSize:
    file.seek(2)
    while True:
        if exactly(file, 1) != b"\xff":
            raise ValueError("a JPEG marker is missing")
        marker = 0xFF
        while marker == 0xFF:
            marker = exactly(file, 1)[0]
        if marker in {0x01, *range(0xD0, 0xD8)}:
            continue
        (length,) = struct.unpack(">H", exactly(file, 2))
        if marker in _JPEG_FRAMES:
            rows, columns = struct.unpack_from(">HH", exactly(file, 5), 1)
            return ImageSize(columns, rows)
        if 0xC0 <= marker <= 0xCF and marker not in {0xC4, 0xC8, 0xCC}:
            raise ValueError("it is a kind of JPEG that SAPIEN does not load (lossless or arithmetic)")
        if marker in {0xD9, 0xDA} or length < 2:
            raise ValueError("it ends before its size is told")
        file.seek(length - 2, io.SEEK_CUR)


def _hdr(head: bytes) -> ImageSize:
    match = _HDR_SIZE.search(head)
    if match is None:
        raise ValueError("its size is not told")
    first, second = int(match[2]), int(match[4])
    return ImageSize(second, first, 16) if match[1] == b"Y" else ImageSize(first, second, 16)
