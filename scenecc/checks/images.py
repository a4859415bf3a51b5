"""Checks that an image is whole: its format, its size and its data, since SAPIEN's readers take damaged ones."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import ceil
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
    read_exactly,
)
from scenecc.checks.mesh_data import AssetError
from scenecc.files import open_regular

if TYPE_CHECKING:
    from pathlib import Path


_STUFFED_BYTES = re.compile(rb"\xff+\x00")

_WORD_BYTES = 8
"""Bytes that are taken up at once."""


@dataclass(slots=True)
class JpegComponent:
    """A colour of a picture.

    Attributes:
        across: blocks of 8 × 8 pixels in a row of its own, and rows of them `down`; `per` blocks in a piece of a scan
            that several colours share.
        step: of its lowest frequency.
        filled: of a progressive one, which frequencies of each block are not zero: a bit each.
    """

    across: int
    down: int
    per: int
    table: int
    step: int = 1
    filled: list[int] = field(default_factory=list[int])


@dataclass(frozen=True, slots=True)
class JpegScan:
    """What a scan says: frequencies from `first` to `last`, whose bits above `low` were told before where `refines`."""

    first: int
    last: int
    low: int
    refines: bool
    progressive: bool


HuffmanTable = list[tuple[int, int, int]]
"""By the next 16 bits: the length of the code (0: none), how many bits follow it, how many zeros it tells."""


def build_huffman_table(sizes: bytes, symbols: bytes) -> HuffmanTable:
    """The table of codes of which so many have 1, 2, … 16 bits. It is no larger than its codes need."""
    table: HuffmanTable = []
    at = 0
    for length, count in enumerate(sizes, 1):
        for symbol in symbols[at : at + count]:
            table += [(length, symbol & 15, symbol >> 4)] * (1 << (16 - length))
        at += count
    return table + [(0, 0, 0)] * (65536 - len(table))


class _BitReader:
    """The bits of a piece of a scan, one after another; zeros behind its end."""

    def __init__(self, data: bytes) -> None:
        self._data = _STUFFED_BYTES.sub(b"\xff", data)
        self._at = 0
        self._held, self._count = 0, 0

    def take(self, count: int) -> int:
        while self._count < count:
            self._fill()
        self._count -= count
        return (self._held >> self._count) & ((1 << count) - 1)

    def code(self, table: HuffmanTable) -> tuple[int, int]:
        """Bits that follow a code, and zeros before."""
        while self._count < 16:
            self._fill()
        length, size, run = table[(self._held >> (self._count - 16)) & 0xFFFF]
        if not length:
            raise ValueError("its pixels have a code that is none")
        self._count -= length
        return size, run

    def _fill(self) -> None:
        if self._at > len(self._data) + _WORD_BYTES:
            raise EOFError("it is cut short within its pixels")
        word = self._data[self._at : self._at + _WORD_BYTES].ljust(_WORD_BYTES, b"\0")
        self._at += _WORD_BYTES
        self._held = ((self._held & ((1 << self._count) - 1)) << (8 * _WORD_BYTES)) | int.from_bytes(word, "big")
        self._count += 8 * _WORD_BYTES

    def end(self, *, last: bool) -> None:
        """Looks at what is left: zeros at most, behind the last piece."""
        at = self._at - self._count // 8
        if at > len(self._data):
            raise EOFError("it is cut short within its pixels")
        if self._data[at:].strip(b"\0") or (at < len(self._data) and not last):
            raise ValueError("it has more pixels than its header says")


def check_scan_codes(
    pieces: list[bytes],
    scan: JpegScan,
    shown: list[tuple[JpegComponent, HuffmanTable | None, HuffmanTable | None]],
    total: int,
    every: int,
) -> None:
    """Reads the pieces of a scan, which restarts part.

    Args:
        pieces: their bytes.
        scan: what its header says.
        shown: the colours that it is about, and their tables of the lowest and of the other frequencies.
        total: of how many steps it consists, of a block or of several colours' blocks each.
        every: how many steps stand between two restarts; 0: all.
    """
    every = every or total
    if len(pieces) != -(-total // every):
        raise ValueError("its pixels lack a piece between two restarts, or have one too many")
    for i, piece in enumerate(pieces):
        bits = _BitReader(piece)
        steps = range(i * every, min(total, (i + 1) * every))
        if scan.first:
            component, _, table = shown[0]
            (_refine_ac_coefficients if scan.refines else _read_ac_coefficients)(
                bits, scan, component, table or [], steps
            )
        else:
            _read_dc_scan(bits, scan, shown, len(steps))
        bits.end(last=i + 1 == len(pieces))


def _read_dc_scan(
    bits: _BitReader,
    scan: JpegScan,
    shown: list[tuple[JpegComponent, HuffmanTable | None, HuffmanTable | None]],
    steps: int,
) -> None:
    """The lowest frequency of each block; of a picture that is not progressive, all others too."""
    blocks = [
        (i, dc or [], ac or [], component.step if not scan.progressive else 1 << scan.low)
        for i, (component, dc, ac) in enumerate(shown)
        for _ in range(component.per if len(shown) > 1 else 1)
    ]
    before = [0] * len(shown)
    code, take = bits.code, bits.take
    for _ in range(steps):
        for i, dc, ac, step in blocks:
            if scan.refines:
                take(1)
                continue
            size, run = code(dc)
            if run:
                raise ValueError("its pixels have a code that is none")
            if size:
                value = take(size)
                before[i] += value if value >> (size - 1) else value - (1 << size) + 1
                if abs(before[i] * step) > 32767:
                    raise ValueError("its pixels are brighter than any can be")
            at = 64 if scan.progressive else 1
            while at < 64:
                size, run = code(ac)
                if size:
                    take(size)
                    at += run + 1
                else:
                    at += 16 if run == 15 else 64


def _read_ac_coefficients(
    bits: _BitReader, scan: JpegScan, component: JpegComponent, table: HuffmanTable, steps: range
) -> None:
    """Frequencies that are told for the first time."""
    empty = 0
    for block in steps:
        if empty:
            empty -= 1
            continue
        at = scan.first
        while at <= scan.last:
            size, run = bits.code(table)
            if size:
                at += run
                component.filled[block] |= 1 << (at & 63)
                bits.take(size)
                at += 1
            elif run < 15:
                empty = (1 << run) + bits.take(run) - 1
                break
            else:
                at += 16


def _refine_ac_coefficients(
    bits: _BitReader, scan: JpegScan, component: JpegComponent, table: HuffmanTable, steps: range
) -> None:
    """One more bit of frequencies that were told before, and frequencies of one bit."""
    empty = 0
    span = range(scan.first, scan.last + 1)
    for block in steps:
        filled = component.filled[block]
        if empty:
            empty -= 1
            bits.take(sum(filled >> at & 1 for at in span))
            continue
        at = scan.first
        while at <= scan.last:
            size, run = bits.code(table)
            if size > 1:
                raise ValueError("its pixels have a code that is none")
            if size:
                bits.take(1)
            elif run < 15:
                empty = (1 << run) + bits.take(run) - 1
                run = 64
            # A zero that is passed counts; what is filled has a bit of its own.
            while at <= scan.last:
                if filled >> at & 1:
                    bits.take(1)
                elif run:
                    run -= 1
                else:
                    component.filled[block] |= (1 if size else 0) << at
                    at += 1
                    break
                at += 1


_FRAME_MARKERS = {0xC0, 0xC1, 0xC2}

_TABLE_MARKERS = {0xC4, 0xDB, 0xDD}

_IGNORED_MARKERS = {0xFE, *range(0xE0, 0xF0)}

_MOST_TABLES, _MOST_SCANS = 1024, 128
"""Pictures have 4 of the one and 10 of the other; each takes its time, however small it is."""

_MARKER = re.compile(rb"\xff+[^\xff\x00\xd0-\xd7]")
"""What ends a scan: neither a byte 0xFF of its own, nor a restart."""

_RESTART_MARKER = re.compile(rb"\xff+([\xd0-\xd7])")


@dataclass(slots=True)
class _JpegState:
    """What was told so far.

    Attributes:
        codes: tables of codes, those of the lowest frequency (0, n) and of the others (1, n).
        steps: the steps of the lowest frequency, by table.
        every: how many steps of a scan stand between two restarts; 0: all.
        shared: how many steps a scan of several colours has.
        tables, scans: how many of each there were.
    """

    codes: dict[tuple[int, int], HuffmanTable] = field(default_factory=dict[tuple[int, int], HuffmanTable])
    steps: dict[int, int] = field(default_factory=dict[int, int])
    every: int = 0
    components: dict[int, JpegComponent] = field(default_factory=dict[int, JpegComponent])
    progressive: bool = False
    shared: int = 0
    tables: int = 0
    scans: int = 0


def jpeg_size(file: BinaryIO) -> ImageSize:
    """The size that the first frame tells."""
    for marker, body in _iterate_segments(file):
        if marker in _FRAME_MARKERS:
            rows, columns = struct.unpack_from(">HH", body, 1)
            return ImageSize(columns, rows)
        if marker == 0xDA:
            break
    raise ValueError("it ends before its size is told")


def check_jpeg(file: BinaryIO, blocks: JpegBlockBudget) -> None:
    """Reads all of a JPEG, as long as there are `blocks` left.

    Raises:
        ValueError, EOFError, struct.error: it is cut short, damaged, or of a kind that SAPIEN does not load.
    """
    picture = _JpegState()
    shown: set[int] = set()
    for marker, body in _iterate_segments(file):
        if marker in _TABLE_MARKERS:
            _read_tables(marker, body, picture)
        elif marker in _FRAME_MARKERS:
            if picture.components:
                raise ValueError("it has two frames")
            _read_frame(body, picture)
            picture.progressive = marker == 0xC2
        elif marker == 0xDA:
            shown |= _check_scan(body, picture, file, blocks)
    if not shown or shown != set(picture.components):
        raise ValueError("it has no pixels of one of its colours")


def _iterate_segments(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Marker and content of each segment, up to the end of the image; who reads a scan goes past it himself."""
    file.seek(2)
    while True:
        if read_exactly(file, 1) != b"\xff":
            raise ValueError("a JPEG marker is missing")
        marker = 0xFF
        while marker == 0xFF:
            marker = read_exactly(file, 1)[0]
        if marker == 0xD9:
            return
        (length,) = struct.unpack(">H", read_exactly(file, 2))
        if marker not in {*_FRAME_MARKERS, *_TABLE_MARKERS, *_IGNORED_MARKERS, 0xDA} or length < 2:
            raise ValueError("it is damaged, or a kind of JPEG that SAPIEN does not load (lossless or arithmetic)")
        yield marker, read_exactly(file, length - 2)


def _read_tables(marker: int, body: bytes, picture: _JpegState) -> None:
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
            picture.codes[kind, number] = build_huffman_table(sizes, body[at + 17 : at + size])
        at += size


def _read_frame(body: bytes, picture: _JpegState) -> None:
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
        picture.components[body[6 + 3 * i]] = JpegComponent(*blocks, per=a * d, table=body[8 + 3 * i], filled=filled)
    if len(picture.components) < count:
        raise ValueError("two of its colours have one number")
    picture.shared = ceil(columns / (8 * across)) * ceil(rows / (8 * down))


def _check_scan(body: bytes, picture: _JpegState, file: BinaryIO, blocks: JpegBlockBudget) -> set[int]:
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
    scan = JpegScan(first, last, low, bool(high), picture.progressive)
    shown: list[tuple[JpegComponent, HuffmanTable | None, HuffmanTable | None]] = []
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
    pieces = _restart_intervals(file)
    if blocks.left >= 0:
        check_scan_codes(pieces, scan, shown, total, picture.every)
    return set(numbers)


def _restart_intervals(file: BinaryIO) -> list[bytes]:
    """The pieces of a scan, between restarts that count from 0 to 7 and around; the file is then at the next marker."""
    start = file.tell()
    data = file.read()
    match = _MARKER.search(data)
    if match is None:
        raise EOFError("it is cut short within its pixels")
    file.seek(start + match.start())
    parts = _RESTART_MARKER.split(data[: match.start()])
    if [part[0] & 7 for part in parts[1::2]] != [i % 8 for i in range(len(parts) // 2)]:
        raise ValueError("its pixels lack a piece between two restarts")
    return parts[::2]


@dataclass(slots=True)
class JpegBlockBudget:
    """Counts the blocks of 8 × 8 pixels of JPEGs that are looked at, those of each scan.

    A million takes half a dozen seconds. A picture of 16 million pixels has fewer; of what lies beyond, the headers
    alone are looked at.
    """

    left: int = 1_000_000


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
