"""Checks that an image is valid: format, size and data. SAPIEN's readers accept damaged images."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from hashlib import sha256
from math import ceil
from typing import TYPE_CHECKING, BinaryIO

from scenecc.assets.errors import AssetError
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
from scenecc.files import open_regular

if TYPE_CHECKING:
    from pathlib import Path


_STUFFED_BYTES = re.compile(rb"\xff+\x00")

_WORD_BYTES = 8
"""Bytes that are buffered at once."""


@dataclass(slots=True)
class JpegComponent:
    """A component of a JPEG.

    Attributes:
        across, down: number of blocks of 8 × 8 pixels per row, and of rows of blocks.
        per: blocks in one unit of a scan of several components.
        table: number of its quantization table.
        step: quantization step of the DC coefficient.
        filled: in a progressive JPEG, the nonzero coefficients of each block, as bits.
    """

    across: int
    down: int
    per: int
    table: int
    step: int = 1
    filled: list[int] = field(default_factory=list[int])


@dataclass(frozen=True, slots=True)
class JpegScan:
    """Header of a scan: coefficients `first` to `last`, bits from `low` on; `refines`: adds a bit to earlier scans."""

    first: int
    last: int
    low: int
    refines: bool
    progressive: bool


HuffmanTable = list[tuple[int, int, int]]
"""By the next 16 bits: length of the code (0: invalid), number of bits after it, run of zeros before."""


def build_huffman_table(sizes: bytes, symbols: bytes) -> HuffmanTable:
    """The table of codes. `sizes`: how many codes have 1, 2, … 16 bits."""
    table: HuffmanTable = []
    at = 0
    for length, count in enumerate(sizes, 1):
        for symbol in symbols[at : at + count]:
            table += [(length, symbol & 15, symbol >> 4)] * (1 << (16 - length))
        at += count
    return table + [(0, 0, 0)] * (65536 - len(table))


class _BitReader:
    """Reads the bits of a restart interval; zeros after its end."""

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
        """Reads a code: the number of bits after it, and the run of zeros before."""
        while self._count < 16:
            self._fill()
        length, size, run = table[(self._held >> (self._count - 16)) & 0xFFFF]
        if not length:
            raise ValueError("its pixels have an invalid Huffman code")
        self._count -= length
        return size, run

    def _fill(self) -> None:
        if self._at > len(self._data) + _WORD_BYTES:
            raise EOFError("its pixels are truncated")
        word = self._data[self._at : self._at + _WORD_BYTES].ljust(_WORD_BYTES, b"\0")
        self._at += _WORD_BYTES
        self._held = ((self._held & ((1 << self._count) - 1)) << (8 * _WORD_BYTES)) | int.from_bytes(word, "big")
        self._count += 8 * _WORD_BYTES

    def end(self, *, last: bool) -> None:
        """Checks the rest: at most zeros, after the last interval."""
        at = self._at - self._count // 8
        if at > len(self._data):
            raise EOFError("its pixels are truncated")
        if self._data[at:].strip(b"\0") or (at < len(self._data) and not last):
            raise ValueError("it has more pixels than its header says")


def check_scan_codes(
    pieces: list[bytes],
    scan: JpegScan,
    shown: list[tuple[JpegComponent, HuffmanTable | None, HuffmanTable | None]],
    total: int,
    every: int,
) -> None:
    """Reads the restart intervals of a scan.

    Args:
        pieces: their bytes.
        scan: its header.
        shown: its components, with their DC and AC Huffman tables.
        total: its number of units: a block, or blocks of several components.
        every: units between two restarts; 0: all.
    """
    every = every or total
    if len(pieces) != -(-total // every):
        raise ValueError("its number of restart intervals is wrong")
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
    """Reads the DC coefficient of each block; in a sequential JPEG, the AC coefficients too."""
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
                raise ValueError("its pixels have an invalid Huffman code")
            if size:
                value = take(size)
                before[i] += value if value >> (size - 1) else value - (1 << size) + 1
                if abs(before[i] * step) > 32767:
                    raise ValueError("a DC coefficient is out of range")
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
    """Reads AC coefficients for the first time."""
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
    """Reads one more bit of earlier AC coefficients, and new ones of one bit."""
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
                raise ValueError("its pixels have an invalid Huffman code")
            if size:
                bits.take(1)
            elif run < 15:
                empty = (1 << run) + bits.take(run) - 1
                run = 64
            # Zeros count towards the run; nonzero coefficients have a bit of their own.
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
"""Usual images have 4 and 10; each takes time, however small it is."""

_KNOWN_JPEGS: dict[bytes, int] = {}
"""JPEGs that this process found to be valid: SHA-256 → their blocks. To read the texture of a table takes 2 s."""

_MOST_KNOWN = 4096

_MARKER = re.compile(rb"\xff+[^\xff\x00\xd0-\xd7]")
"""A marker that ends a scan: neither an escaped 0xFF nor a restart."""

_RESTART_MARKER = re.compile(rb"\xff+([\xd0-\xd7])")


@dataclass(slots=True)
class _JpegState:
    """State of a JPEG while it is read.

    Attributes:
        codes: Huffman tables, DC (0, n) and AC (1, n).
        steps: DC quantization steps, by table.
        every: units of a scan between two restarts; 0: all.
        shared: units of a scan of several components.
        tables, scans: number of each so far.
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
    """The size in the first frame header."""
    for marker, body in _iterate_segments(file):
        if marker in _FRAME_MARKERS:
            rows, columns = struct.unpack_from(">HH", body, 1)
            return ImageSize(columns, rows)
        if marker == 0xDA:
            break
    raise ValueError("it has no frame header")


def check_jpeg(file: BinaryIO, blocks: JpegBlockBudget) -> None:
    """Checks a whole JPEG, as long as there are `blocks` left.

    Raises:
        ValueError, EOFError, struct.error: it is truncated, damaged, or of a kind that SAPIEN does not load.
    """
    digest = sha256(file.read()).digest()
    used = _KNOWN_JPEGS.get(digest)
    if used is not None and used <= blocks.left:
        blocks.left -= used
        return
    before = blocks.left
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
        raise ValueError("it has no scan of one of its components")
    if blocks.left >= 0:  # else only headers were checked
        if len(_KNOWN_JPEGS) >= _MOST_KNOWN:
            del _KNOWN_JPEGS[next(iter(_KNOWN_JPEGS))]
        _KNOWN_JPEGS[digest] = before - blocks.left


def _iterate_segments(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Marker and content of each segment, up to the end of the image. The caller reads past the data of a scan."""
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
    """Reads Huffman tables, quantization tables, or the restart interval."""
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
            raise ValueError("one of its tables is truncated or invalid")
        if marker == 0xDB:
            picture.steps[number] = int.from_bytes(body[at + 1 : at + 1 + kind + 1], "big")
        else:
            if sum(sizes) > 256 or sum(count << (15 - i) for i, count in enumerate(sizes)) > 65536:
                raise ValueError("one of its Huffman tables has too many codes")
            picture.codes[kind, number] = build_huffman_table(sizes, body[at + 17 : at + size])
        at += size


def _read_frame(body: bytes, picture: _JpegState) -> None:
    depth, rows, columns, count = struct.unpack_from(">BHHB", body)
    if depth != 8 or count not in {1, 3, 4} or len(body) != 6 + 3 * count or not rows or not columns:
        raise ValueError("it does not have 8 bits per component, or not 1, 3 or 4 components")
    factors = [divmod(body[7 + 3 * i], 16) for i in range(count)]
    across, down = (max(factor[axis] for factor in factors) for axis in (0, 1))
    if any(not 1 <= one <= 4 for factor in factors for one in factor):
        raise ValueError("its sampling factors are invalid")
    if any(across % a or down % d for a, d in factors):
        raise ValueError("SAPIEN does not load its sampling factors")
    for i, (a, d) in enumerate(factors):
        blocks = (ceil(ceil(columns * a / across) / 8), ceil(ceil(rows * d / down) / 8))
        filled = [0] * (blocks[0] * blocks[1])
        picture.components[body[6 + 3 * i]] = JpegComponent(*blocks, per=a * d, table=body[8 + 3 * i], filled=filled)
    if len(picture.components) < count:
        raise ValueError("two of its components have the same number")
    picture.shared = ceil(columns / (8 * across)) * ceil(rows / (8 * down))


def _check_scan(body: bytes, picture: _JpegState, file: BinaryIO, blocks: JpegBlockBudget) -> set[int]:
    """Checks a scan and returns the numbers of its components."""
    count = body[0] if body else 0
    if not 1 <= count <= len(picture.components) or len(body) != 4 + 2 * count:
        raise ValueError("the header of a scan is invalid")
    first, last, bits = struct.unpack_from(">BBB", body, 1 + 2 * count)
    high, low = divmod(bits, 16)
    if not picture.progressive:
        wrong = first or bits
    else:
        wrong = not first <= last <= 63 or high > 13 or low > 13 or (not first and last) or (first and count > 1)
    numbers = list(body[1 : 1 + 2 * count : 2])
    if wrong or len(set(numbers)) < count or not set(numbers) <= set(picture.components):
        raise ValueError("the header of a scan is invalid")
    scan = JpegScan(first, last, low, bool(high), picture.progressive)
    shown: list[tuple[JpegComponent, HuffmanTable | None, HuffmanTable | None]] = []
    for number, tables in zip(numbers, body[2 : 2 + 2 * count : 2], strict=True):
        component = picture.components[number]
        if component.table not in picture.steps:
            raise ValueError("a component refers to a missing quantization table")
        component.step = picture.steps[component.table]
        dc, ac = picture.codes.get((0, tables >> 4)), picture.codes.get((1, tables & 15))
        if (dc is None and not first and not high) or (ac is None and (first or not picture.progressive)):
            raise ValueError("a scan refers to a missing Huffman table")
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
    """The restart intervals of a scan, whose markers count modulo 8. The file is then at the next marker."""
    start = file.tell()
    data = file.read()
    match = _MARKER.search(data)
    if match is None:
        raise EOFError("its pixels are truncated")
    file.seek(start + match.start())
    parts = _RESTART_MARKER.split(data[: match.start()])
    if [part[0] & 7 for part in parts[1::2]] != [i % 8 for i in range(len(parts) // 2)]:
        raise ValueError("a restart interval is missing")
    return parts[::2]


@dataclass(slots=True)
class JpegBlockBudget:
    """Budget of the blocks of 8 × 8 pixels of JPEGs to decode, counted for each scan.

    A million takes about six seconds. An image of 16 million pixels has fewer; beyond the budget only headers are
    checked.
    """

    left: int = 1_000_000


IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tga", ".hdr", ".exr", ".ktx")
"""Image formats that SAPIEN's renderer loads."""


def image_size(path: Path) -> ImageSize:
    """The size of an image that passed `check_image`."""
    with open_regular(path) as file:
        return _read_size(file, path.suffix)


def check_image(file: BinaryIO, max_bytes: int, suffix: str = "", blocks: JpegBlockBudget | None = None) -> None:
    """Checks a whole image.

    Args:
        file: the image, at its start.
        max_bytes: maximum size once it is decompressed [bytes].
        suffix: of its name, by which SAPIEN recognizes EXR and KTX; "": it is embedded in another file.
        blocks: budget shared by several JPEGs; None: the image has one of its own.

    Raises:
        AssetError: SAPIEN does not load it, or it is truncated or too large.
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
    """The key of `_FORMATS`, by suffix or by the first bytes. The file is then at its start."""
    file.seek(0)
    if suffix in _FORMATS:
        return suffix
    head = file.read(32)
    file.seek(0)
    found = next((kind for start, kind in _SIGNATURES.items() if head.startswith(start)), "tga" if is_tga(head) else "")
    if not found:
        raise ValueError("it is empty" if not head else "it is not a PNG, JPEG, BMP, TGA, HDR, EXR or KTX")
    if found.startswith("."):
        raise ValueError(f"SAPIEN reads this format only from a file with the suffix `{found}`")
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
"""By format: reader of the size, and check of the whole file. SAPIEN recognizes formats that begin with a dot by the
lower case suffix, and others by content.
"""
