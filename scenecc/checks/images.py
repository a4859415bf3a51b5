"""Images: what they are, how large, and that all of each is there, since SAPIEN's readers say little of what is not."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import TYPE_CHECKING, BinaryIO

from scenecc.checks.image_formats import (
    EXR_MAGIC,
    KTX_MAGICS,
    PNG_SIGNATURE,
    ImageSize,
    bmp_size,
    check_bmp,
    check_exr,
    check_hdr,
    check_png,
    check_tga,
    exr_size,
    hdr_size,
    is_tga,
    ktx_size,
    png_size,
)
from scenecc.checks.image_jpeg import JpegBlockBudget, check_jpeg, jpeg_size
from scenecc.checks.mesh_data import AssetError
from scenecc.files import open_regular

if TYPE_CHECKING:
    from pathlib import Path


IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tga", ".hdr", ".exr", ".ktx")
"""What SAPIEN's renderer loads as a texture."""

_SIZE_READERS: dict[str, Callable[[BinaryIO], ImageSize]] = {".exr": exr_size, ".ktx": ktx_size}
"""What SAPIEN tells by the suffix, written small; the others by what they hold."""


def image_size(path: Path) -> ImageSize:
    """The size of an image that `check_image` took."""
    with open_regular(path) as file:
        return _read_size(file, path.suffix)


def check_image(file: BinaryIO, max_bytes: int, suffix: str = "", blocks: JpegBlockBudget | None = None) -> None:
    """Checks all of an image.

    Args:
        file: the image, at its start.
        max_bytes: how much it may take once unpacked [bytes].
        suffix: of its name, by which SAPIEN tells EXR and KTX from all others; "": it is a part of another file.
        blocks: how much of JPEGs is looked at, this one among others; None: of this one as much as ever.

    Raises:
        AssetError: it is no image that SAPIEN loads, cut short, or too large.
    """
    try:
        size = _read_size(file, suffix)
        if size.columns >= 1 and size.rows >= 1 and sum(size.level_bytes) * size.sides <= max_bytes:
            _check_pixels(file, suffix, blocks or JpegBlockBudget())
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


def _read_size(file: BinaryIO, suffix: str) -> ImageSize:
    by_suffix = _SIZE_READERS.get(suffix)
    return _size_by_signature(file) if by_suffix is None else by_suffix(file)


def _size_by_signature(file: BinaryIO) -> ImageSize:
    head = file.read(32)
    match _detect_format(head):
        case "png":
            return png_size(file)[0]
        case "jpeg":
            return jpeg_size(file)
        case "bmp":
            return bmp_size(head)
        case "hdr":
            return hdr_size(file)[0]
        case "tga":
            columns, rows = struct.unpack_from("<HH", head, 12)
            return ImageSize(columns, rows)
        case "":
            raise ValueError("it is empty" if not head else "it is none of PNG, JPEG, BMP, TGA, HDR, EXR and KTX")
        case other:
            raise ValueError(f"SAPIEN reads what it is in a file of its own whose name ends in `{other}` alone")


def _detect_format(head: bytes) -> str:
    """What a file is, by its first bytes; "": nothing that is read."""
    for start, kind in _SIGNATURES.items():
        if head.startswith(start):
            return kind
    return "tga" if is_tga(head) else ""


def _check_pixels(file: BinaryIO, suffix: str, blocks: JpegBlockBudget) -> None:
    """Reads an image to its end."""
    file.seek(0)
    kind = suffix if suffix in _SIZE_READERS else _detect_format(file.read(32))
    file.seek(0)
    if kind == "jpeg":
        check_jpeg(file, blocks)
    elif kind in _CHECKS:
        _CHECKS[kind](file)


_SIGNATURES = {
    PNG_SIGNATURE: "png",
    b"\xff\xd8": "jpeg",
    b"BM": "bmp",
    b"#?RADIANCE": "hdr",
    b"#?RGBE": "hdr",
    EXR_MAGIC: ".exr",
    KTX_MAGICS[0]: ".ktx",
    KTX_MAGICS[1]: ".ktx",
}

_CHECKS = {
    ".exr": check_exr,
    "png": check_png,
    "bmp": check_bmp,
    "hdr": check_hdr,
    "tga": check_tga,
}
