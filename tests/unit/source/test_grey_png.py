"""Grey PNGs as heights, against Pillow; and files that are none."""

from __future__ import annotations

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from scenecc.source.grey_png import read_grey_png


def png(pixels: np.ndarray, **options: object) -> bytes:
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, format="PNG", **options)
    return file.getvalue()


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@given(seed=st.integers(0, 2**32 - 1), rows=st.integers(1, 9), columns=st.integers(1, 9), smooth=st.booleans())
def test_pixels_are_those_that_were_written(dtype: type, seed: int, rows: int, columns: int, smooth: bool) -> None:
    most = np.iinfo(dtype).max
    pixels = np.random.default_rng(seed).integers(0, most, (rows, columns), dtype=dtype, endpoint=True)
    if smooth:  # for which Pillow picks other filters
        pixels = np.sort(np.sort(pixels, axis=0), axis=1)
    assert np.array_equal(np.array(read_grey_png(png(pixels), 100)), pixels / most)


GREY = png(np.arange(12, dtype=np.uint8).reshape(3, 4))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "no PNG"),
        (b"GIF89a", "no PNG"),
        (GREY[:40], "cut short"),
        (GREY[:-20], "cut short|damaged"),
        (GREY.replace(b"IDAT", b"IDAX"), "damaged"),
        (png(np.zeros((3, 4, 3), np.uint8)), "not grey"),
        (png(np.zeros((30, 40), np.uint8)), "at most 100"),
    ],
)
def test_what_is_no_grey_png_is_refused(data: bytes, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        read_grey_png(data, 100)


@given(st.binary(max_size=60), st.integers(8, len(GREY) - 1))
def test_damage_is_a_value_error_and_nothing_else(junk: bytes, at: int) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        read_grey_png(GREY[:at] + junk + b"\0", 100)
