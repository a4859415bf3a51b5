"""The codes of a JPEG's pixels: that each is one of its table's, and that there are enough.

Nothing is drawn. A code that is in no table ends the loading of a picture, and what is missing is drawn as grey.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

_STUFFED = re.compile(rb"\xff+\x00")
_WORD = 8
"""Bytes that are taken up at once."""


@dataclass(slots=True)
class Component:
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
class Scan:
    """What a scan says: frequencies from `first` to `last`, whose bits above `low` were told before where `refines`."""

    first: int
    last: int
    low: int
    refines: bool
    progressive: bool


Table = list[tuple[int, int, int]]
"""By the next 16 bits: the length of the code (0: none), how many bits follow it, how many zeros it tells."""


def code_table(sizes: bytes, symbols: bytes) -> Table:
    """The table of codes of which so many have 1, 2, … 16 bits. It is no larger than its codes need."""
    table: Table = []
    at = 0
    for length, count in enumerate(sizes, 1):
        for symbol in symbols[at : at + count]:
            table += [(length, symbol & 15, symbol >> 4)] * (1 << (16 - length))
        at += count
    return table + [(0, 0, 0)] * (65536 - len(table))


class _Bits:
    """The bits of a piece of a scan, one after another; zeros behind its end."""

    def __init__(self, data: bytes) -> None:
        self._data = _STUFFED.sub(b"\xff", data)
        self._at = 0
        self._held, self._count = 0, 0

    def take(self, count: int) -> int:
        while self._count < count:
            self._fill()
        self._count -= count
        return (self._held >> self._count) & ((1 << count) - 1)

    def code(self, table: Table) -> tuple[int, int]:
        """Bits that follow a code, and zeros before."""
        while self._count < 16:
            self._fill()
        length, size, run = table[(self._held >> (self._count - 16)) & 0xFFFF]
        if not length:
            raise ValueError("its pixels have a code that is none")
        self._count -= length
        return size, run

    def _fill(self) -> None:
        if self._at > len(self._data) + _WORD:
            raise EOFError("it is cut short within its pixels")
        word = self._data[self._at : self._at + _WORD].ljust(_WORD, b"\0")
        self._at += _WORD
        self._held = ((self._held & ((1 << self._count) - 1)) << (8 * _WORD)) | int.from_bytes(word, "big")
        self._count += 8 * _WORD

    def end(self, *, last: bool) -> None:
        """Looks at what is left: zeros at most, behind the last piece."""
        at = self._at - self._count // 8
        if at > len(self._data):
            raise EOFError("it is cut short within its pixels")
        if self._data[at:].strip(b"\0") or (at < len(self._data) and not last):
            raise ValueError("it has more pixels than its header says")


def check_codes(
    pieces: list[bytes], scan: Scan, shown: list[tuple[Component, Table | None, Table | None]], total: int, every: int
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
        bits = _Bits(piece)
        steps = range(i * every, min(total, (i + 1) * every))
        if scan.first:
            component, _, table = shown[0]
            (_refine if scan.refines else _frequencies)(bits, scan, component, table or [], steps)
        else:
            _lowest(bits, scan, shown, len(steps))
        bits.end(last=i + 1 == len(pieces))


def _lowest(bits: _Bits, scan: Scan, shown: list[tuple[Component, Table | None, Table | None]], steps: int) -> None:
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


def _frequencies(bits: _Bits, scan: Scan, component: Component, table: Table, steps: range) -> None:
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


def _refine(bits: _Bits, scan: Scan, component: Component, table: Table, steps: range) -> None:
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
