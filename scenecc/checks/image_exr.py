"""The header of an OpenEXR, which SAPIEN's renderer hands to OpenEXR's own reader."""

from __future__ import annotations

import struct
from typing import BinaryIO

from scenecc.checks.image_size import ImageSize, exactly

MAGIC = b"\x76\x2f\x31\x01"
_DEEP = 0x800
_MOST_OF_A_HEADER = 1 << 20
"""Bytes; attributes before the size may hold a small picture."""


def exr_size(file: BinaryIO) -> ImageSize:
    """The size of an EXR at its start; the renderer keeps four half-floats a pixel.

    Raises:
        ValueError, EOFError: it is none, or none that SAPIEN loads.
    """
    magic, version = struct.unpack("<4sI", exactly(file, 8))
    if magic != MAGIC or version & 0xFF != 2:
        raise ValueError("it is no EXR, and SAPIEN goes by the suffix")
    if version & _DEEP:
        raise ValueError("it is a deep EXR, which SAPIEN does not load")
    header = file.read(_MOST_OF_A_HEADER)
    at = 0
    while (end := header.find(b"\0", at)) > at:
        kind = header.find(b"\0", end + 1)
        if kind < 0 or len(header) < kind + 5:
            break
        (length,) = struct.unpack_from("<I", header, kind + 1)
        if header[at:end] == b"dataWindow":
            left, top, right, bottom = struct.unpack_from("<4i", header, kind + 5)
            return ImageSize(right - left + 1, bottom - top + 1, 8)
        at = kind + 5 + length
    raise ValueError("its size is not told")
