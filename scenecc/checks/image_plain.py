"""BMP, TGA and HDR, all of each: SAPIEN's reader draws nothing where such a file is cut short, and says nothing."""

from __future__ import annotations

import re
import struct
from typing import BinaryIO

from scenecc.checks.image_size import ImageSize, exactly

_HDR = re.compile(
    rb"#\?(?:RADIANCE|RGBE)\n(?:[^\n]+\n)*?FORMAT=32-bit_rle_rgbe\n(?:[^\n]+\n)*\n-Y ([0-9]{1,8}) +\+X ([0-9]{1,8})\n"
)
_CUT = "it has fewer pixels than its header says"


def is_tga(head: bytes) -> bool:
    """Whether a file can be a TGA, which has no signature: its header holds only what one of them may."""
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
    """Reads all of a BMP.

    Raises:
        ValueError, EOFError, struct.error: it is cut short, or of a kind that SAPIEN does not load.
    """
    size = bmp_size(head := exactly(file, 26))
    offset, length = struct.unpack_from("<II", head, 10)
    short = length == 12
    if length not in {12, 40, 56, 108, 124}:
        raise ValueError("its header is of no known length")
    header = head[14:] + (b"" if short else exactly(file, length - 12))
    planes, bits = struct.unpack_from("<HH", header, 8 if short else 12)
    packing = 0 if short else struct.unpack_from("<I", header, 16)[0]
    if planes != 1 or bits not in ({1, 4, 8, 24} if short else {1, 4, 8, 16, 24, 32}):
        raise ValueError("it has a number of planes or of bits that is none")
    if packing not in {0, 3} or (packing == 3 and bits not in {16, 32}):
        raise ValueError("it is packed, and SAPIEN reads BMP only as it is")
    masks = b""
    if packing == 3:
        masks = header[40:52] if length >= 108 else exactly(file, 12)
        if any(
            mask == 0 or mask.bit_length() - (mask & -mask).bit_length() > 7 for mask in struct.unpack("<3I", masks)
        ):
            raise ValueError("its masks of colours are none")
    read = 14 + length + (12 if packing == 3 and length < 108 else 0)
    entry = 3 if short else 4
    colours = (offset - read) // entry if bits <= 8 else 0
    if offset < read or (bits <= 8 and not 1 <= colours <= 256) or (bits > 8 and offset - read > 1024):
        raise ValueError("its pixels begin where they cannot")
    _skip(file, offset - read)
    _skip(file, (size.columns * bits + 31) // 32 * 4 * size.rows)


def check_tga(file: BinaryIO) -> None:
    """Reads all of a TGA. Raises like `check_bmp`."""
    head = exactly(file, 18)
    length, indexed, kind, _, colours, entry, _, _, columns, rows, bits, _ = struct.unpack("<BBBHHBHHHHBB", head)
    _skip(file, length)
    if indexed:
        if not colours:
            raise ValueError("it has no colours")
        _skip(file, colours * ((entry + 7) // 8))
    pixel = (bits + 7) // 8
    if kind < 8:
        _skip(file, columns * rows * pixel)
        return
    left = columns * rows
    while left > 0:
        packet = exactly(file, 1)[0]
        count = (packet & 127) + 1
        left -= count
        _skip(file, pixel if packet & 128 else pixel * min(count, count + left))


def hdr_size(file: BinaryIO) -> tuple[ImageSize, int]:
    """The size of an HDR, and where its pixels begin."""
    file.seek(0)
    match = _HDR.match(file.read(1 << 16))
    if match is None:
        raise ValueError("its header is not `FORMAT=32-bit_rle_rgbe`, an empty line, and `-Y rows +X columns`")
    return ImageSize(int(match[2]), int(match[1]), 16), match.end()


def check_hdr(file: BinaryIO) -> None:
    """Reads all of an HDR. Raises like `check_bmp`."""
    size, start = hdr_size(file)
    file.seek(start)
    data = file.read()
    if not 8 <= size.columns < 32768 or not data.startswith(b"\x02\x02"):
        if len(data) < 4 * size.columns * size.rows:
            raise ValueError(_CUT)
        return
    at = 0
    line = struct.pack(">BBH", 2, 2, size.columns)
    for _ in range(size.rows):
        if data[at : at + 4] != line:
            raise ValueError("a row of its pixels is not as long as its header says")
        at += 4
        for _ in range(4):
            left = size.columns
            while left:
                count = data[at] if at < len(data) else 0
                same = count > 128
                count -= 128 if same else 0
                if not 1 <= count <= left:
                    raise ValueError(_CUT)
                left -= count
                at += 2 if same else 1 + count
    if at > len(data):
        raise ValueError(_CUT)


def _skip(file: BinaryIO, count: int) -> None:
    at = file.tell()
    end = file.seek(0, 2)
    if at + count > end:
        raise EOFError(_CUT)
    file.seek(at + count)
