"""The size of an image, as its header tells it."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import BinaryIO


@dataclass(frozen=True, slots=True)
class ImageSize:
    """Pixels of an image and bytes of one once it is unpacked.

    Attributes:
        sides: 6 of a cube.
        levels: of detail that the file holds, the image itself the first; 0: the format has none.
    """

    columns: int
    rows: int
    pixel_bytes: int = 4
    sides: int = 1
    levels: int = 0

    def __str__(self) -> str:
        return f"{self.columns} × {self.rows} pixels of {self.pixel_bytes} bytes"

    @property
    def level_bytes(self) -> list[int]:
        """Bytes of one side at each level, of which the next has half as many columns and rows."""
        return [
            max(1, self.columns >> level) * max(1, self.rows >> level) * self.pixel_bytes
            for level in range(self.levels or 1)
        ]

    @property
    def has_all_levels(self) -> bool:
        """Whether its levels go down to a single pixel, where the format has any."""
        return self.levels in {0, max(self.columns, self.rows).bit_length()}


@dataclass(slots=True)
class Blocks:
    """Counts the blocks of 8 × 8 pixels of JPEGs that are looked at, those of each scan.

    A million takes half a dozen seconds. A picture of 16 million pixels has fewer; of what lies beyond, the headers
    alone are looked at.
    """

    left: int = 1_000_000


def exactly(file: BinaryIO, count: int) -> bytes:
    """The next bytes of a file. Raises EOFError if there are fewer."""
    at = file.tell()
    if count > file.seek(0, io.SEEK_END) - at:
        raise EOFError("it is cut short")
    file.seek(at)
    return file.read(count)
