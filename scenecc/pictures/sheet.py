"""A contact sheet: pictures of one size in rows, each under its label."""

from __future__ import annotations

from math import ceil, sqrt
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

BAR: Final = 18
"""Height of a label [px]."""

_LETTERS: Final = 12
_MARGIN: Final = 4


def grid_of(count: int) -> tuple[int, int]:
    """Rows and columns of a sheet of so many pictures: as many columns as rows, or one more."""
    columns = ceil(sqrt(count))
    return ceil(count / columns), columns


def sheet_size(count: int, width: int, height: int) -> tuple[int, int]:
    """Width and height [px] of a sheet of `count` pictures of this size."""
    rows, columns = grid_of(count)
    return columns * width, rows * (height + BAR)


def sheet(tiles: Sequence[NDArray[Any]], labels: Sequence[str]) -> NDArray[Any]:
    """Pictures (H, W) or (H, W, 3) of one integer type as one; labels are white on black, above each.

    The picture of row r and column c begins at pixel (r · (H + BAR) + BAR, c · W).
    """
    rows, columns = grid_of(len(tiles))
    height, width, *channels = tiles[0].shape
    whole = np.zeros((rows * (height + BAR), columns * width, *channels), tiles[0].dtype)
    for number, (tile, label) in enumerate(zip(tiles, labels, strict=True)):
        top, left = number // columns * (height + BAR), number % columns * width
        letters = _letters(label, width) * (np.iinfo(whole.dtype).max // 255)
        whole[top : top + BAR, left : left + width] = letters[..., None] if channels else letters
        whole[top + BAR : top + BAR + height, left : left + width] = tile
    return whole


def _letters(text: str, width: int) -> NDArray[np.uint16]:
    """A text (BAR, width), 0 to 255; what does not fit is cut off."""
    from PIL import Image, ImageDraw, ImageFont

    image = Image.new("L", (width, BAR))
    draw = ImageDraw.Draw(image)
    draw.text((_MARGIN, BAR / 2), text, fill=255, font=ImageFont.load_default(_LETTERS), anchor="lm")
    return np.asarray(image, np.uint16)
