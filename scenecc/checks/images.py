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
            _, check = _FORMATS[_detect_format(file, suffix)]
            check(file, blocks or JpegBlockBudget())
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
    size, _ = _FORMATS[_detect_format(file, suffix)]
    return size(file)


def _detect_format(file: BinaryIO, suffix: str) -> str:
    """A key of `_FORMATS`: by the suffix, or by the first bytes, at which the file then is."""
    file.seek(0)
    if suffix in _FORMATS:
        return suffix
    head = file.read(32)
    file.seek(0)
    found = next((kind for start, kind in _SIGNATURES.items() if head.startswith(start)), "tga" if is_tga(head) else "")
    if not found:
        raise ValueError("it is empty" if not head else "it is none of PNG, JPEG, BMP, TGA, HDR, EXR and KTX")
    if found.startswith("."):
        raise ValueError(f"SAPIEN reads what it is in a file of its own whose name ends in `{found}` alone")
    return found


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


_FORMATS: dict[str, tuple[Callable[[BinaryIO], ImageSize], Callable[[BinaryIO, JpegBlockBudget], None]]] = {
    ".exr": (exr_size, lambda file, _: check_exr(file)),
    ".ktx": (ktx_size, lambda _, __: None),
    "png": (lambda file: png_size(file)[0], lambda file, _: check_png(file)),
    "jpeg": (jpeg_size, check_jpeg),
    "bmp": (lambda file: bmp_size(file.read(32)), lambda file, _: check_bmp(file)),
    "hdr": (lambda file: hdr_size(file)[0], lambda file, _: check_hdr(file)),
    "tga": (lambda file: ImageSize(*struct.unpack_from("<HH", file.read(32), 12)), lambda file, _: check_tga(file)),
}
"""Readers of the size of a file at its start, and of all of it. SAPIEN tells those that begin with a dot by the suffix,
written small; the others by what they hold.
"""
