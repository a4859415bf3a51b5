"""JPEG, all of it: its segments and tables, and the codes of its pixels."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import ceil
from typing import BinaryIO

from scenecc.checks.image_jpeg_codes import Component, Scan, Table, check_codes, code_table
from scenecc.checks.image_size import Blocks, ImageSize, exactly

_FRAMES = {0xC0, 0xC1, 0xC2}
_TABLES = {0xC4, 0xDB, 0xDD}
_PASSED = {0xFE, *range(0xE0, 0xF0)}
_MOST_TABLES, _MOST_SCANS = 1024, 128
"""Pictures have 4 of the one and 10 of the other; each takes its time, however small it is."""
_MARKER = re.compile(rb"\xff+[^\xff\x00\xd0-\xd7]")
"""What ends a scan: neither a byte 0xFF of its own, nor a restart."""
_RESTART = re.compile(rb"\xff+([\xd0-\xd7])")


@dataclass(slots=True)
class _Picture:
    """What was told so far.

    Attributes:
        codes: tables of codes, those of the lowest frequency (0, n) and of the others (1, n).
        steps: the steps of the lowest frequency, by table.
        every: how many steps of a scan stand between two restarts; 0: all.
        shared: how many steps a scan of several colours has.
        tables, scans: how many of each there were.
    """

    codes: dict[tuple[int, int], Table] = field(default_factory=dict[tuple[int, int], Table])
    steps: dict[int, int] = field(default_factory=dict[int, int])
    every: int = 0
    components: dict[int, Component] = field(default_factory=dict[int, Component])
    progressive: bool = False
    shared: int = 0
    tables: int = 0
    scans: int = 0


def jpeg_size(file: BinaryIO) -> ImageSize:
    """The size that the first frame tells."""
    for marker, body in _segments(file):
        if marker in _FRAMES:
            rows, columns = struct.unpack_from(">HH", body, 1)
            return ImageSize(columns, rows)
        if marker == 0xDA:
            break
    raise ValueError("it ends before its size is told")


def check_jpeg(file: BinaryIO, blocks: Blocks) -> None:
    """Reads all of a JPEG, as long as there are `blocks` left.

    Raises:
        ValueError, EOFError, struct.error: it is cut short, damaged, or of a kind that SAPIEN does not load.
    """
    picture = _Picture()
    shown: set[int] = set()
    for marker, body in _segments(file):
        if marker in _TABLES:
            _tables(marker, body, picture)
        elif marker in _FRAMES:
            if picture.components:
                raise ValueError("it has two frames")
            _frame(body, picture)
            picture.progressive = marker == 0xC2
        elif marker == 0xDA:
            shown |= _scan(body, picture, file, blocks)
    if not shown or shown != set(picture.components):
        raise ValueError("it has no pixels of one of its colours")


def _segments(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Marker and content of each segment, up to the end of the image; who reads a scan goes past it himself."""
    file.seek(2)
    while True:
        if exactly(file, 1) != b"\xff":
            raise ValueError("a JPEG marker is missing")
        marker = 0xFF
        while marker == 0xFF:
            marker = exactly(file, 1)[0]
        if marker == 0xD9:
            return
        (length,) = struct.unpack(">H", exactly(file, 2))
        if marker not in {*_FRAMES, *_TABLES, *_PASSED, 0xDA} or length < 2:
            raise ValueError("it is damaged, or a kind of JPEG that SAPIEN does not load (lossless or arithmetic)")
        yield marker, exactly(file, length - 2)


def _tables(marker: int, body: bytes, picture: _Picture) -> None:
    """Tables of codes and of steps, and the interval of restarts."""
    if marker == 0xDD:
        (picture.every,) = struct.unpack(">H", body)
        return
    at = 0
    while at < len(body):
        kind, number = divmod(body[at], 16)
        picture.tables += 1
        if picture.tables > _MOST_TABLES:
            raise ValueError(f"it has more than {_MOST_TABLES} tables")
        sizes = body[at + 1 : at + 17]
        size = 17 + sum(sizes) if marker == 0xC4 else 129 if kind else 65
        if kind > 1 or number > 3 or at + size > len(body):
            raise ValueError("one of its tables is cut short, or none")
        if marker == 0xDB:
            picture.steps[number] = int.from_bytes(body[at + 1 : at + 1 + kind + 1], "big")
        else:
            if sum(sizes) > 256 or sum(count << (15 - i) for i, count in enumerate(sizes)) > 65536:
                raise ValueError("one of its tables has more codes than there can be")
            picture.codes[kind, number] = code_table(sizes, body[at + 17 : at + size])
        at += size


def _frame(body: bytes, picture: _Picture) -> None:
    depth, rows, columns, count = struct.unpack_from(">BHHB", body)
    if depth != 8 or count not in {1, 3, 4} or len(body) != 6 + 3 * count or not rows or not columns:
        raise ValueError("it has not 8 bits a colour, or another number of colours than 1, 3 and 4")
    factors = [divmod(body[7 + 3 * i], 16) for i in range(count)]
    across, down = (max(factor[axis] for factor in factors) for axis in (0, 1))
    if any(not 1 <= one <= 4 for factor in factors for one in factor):
        raise ValueError("its colours are sampled in a way that none is")
    if any(across % a or down % d for a, d in factors):
        raise ValueError("its colours are sampled in a way that SAPIEN does not load")
    for i, (a, d) in enumerate(factors):
        blocks = (ceil(ceil(columns * a / across) / 8), ceil(ceil(rows * d / down) / 8))
        filled = [0] * (blocks[0] * blocks[1])
        picture.components[body[6 + 3 * i]] = Component(*blocks, per=a * d, table=body[8 + 3 * i], filled=filled)
    if len(picture.components) < count:
        raise ValueError("two of its colours have one number")
    picture.shared = ceil(columns / (8 * across)) * ceil(rows / (8 * down))


def _scan(body: bytes, picture: _Picture, file: BinaryIO, blocks: Blocks) -> set[int]:
    """Reads a scan, and gives the numbers of its colours."""
    count = body[0] if body else 0
    if not 1 <= count <= len(picture.components) or len(body) != 4 + 2 * count:
        raise ValueError("the header of a scan is none")
    first, last, bits = struct.unpack_from(">BBB", body, 1 + 2 * count)
    high, low = divmod(bits, 16)
    if not picture.progressive:
        wrong = first or bits
    else:
        wrong = not first <= last <= 63 or high > 13 or low > 13 or (not first and last) or (first and count > 1)
    numbers = list(body[1 : 1 + 2 * count : 2])
    if wrong or len(set(numbers)) < count or not set(numbers) <= set(picture.components):
        raise ValueError("the header of a scan is none")
    scan = Scan(first, last, low, bool(high), picture.progressive)
    shown: list[tuple[Component, Table | None, Table | None]] = []
    for number, tables in zip(numbers, body[2 : 2 + 2 * count : 2], strict=True):
        component = picture.components[number]
        if component.table not in picture.steps:
            raise ValueError("a colour names a table of steps that is not there")
        component.step = picture.steps[component.table]
        dc, ac = picture.codes.get((0, tables >> 4)), picture.codes.get((1, tables & 15))
        if (dc is None and not first and not high) or (ac is None and (first or not picture.progressive)):
            raise ValueError("a scan names a table of codes that is not there")
        shown.append((component, dc, ac))
    alone = shown[0][0]
    total = picture.shared if count > 1 else alone.across * alone.down
    picture.scans += 1
    blocks.left -= total * sum(component.per if count > 1 else 1 for component, _, _ in shown)
    if picture.scans > _MOST_SCANS:
        raise ValueError(f"it has more than {_MOST_SCANS} scans")
    pieces = _pieces(file)
    if blocks.left >= 0:
        check_codes(pieces, scan, shown, total, picture.every)
    return set(numbers)


def _pieces(file: BinaryIO) -> list[bytes]:
    """The pieces of a scan, between restarts that count from 0 to 7 and around; the file is then at the next marker."""
    start = file.tell()
    data = file.read()
    match = _MARKER.search(data)
    if match is None:
        raise EOFError("it is cut short within its pixels")
    file.seek(start + match.start())
    parts = _RESTART.split(data[: match.start()])
    if [part[0] & 7 for part in parts[1::2]] != [i % 8 for i in range(len(parts) // 2)]:
        raise ValueError("its pixels lack a piece between two restarts")
    return parts[::2]
