"""Heights of terrain from grey PNGs, and files that are refused."""

from __future__ import annotations

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from scenecc.assets.images import read_heights


def png(pixels: np.ndarray, **options: object) -> bytes:
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, format="PNG", **options)
    return file.getvalue()


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@given(seed=st.integers(0, 2**32 - 1), rows=st.integers(1, 9), columns=st.integers(1, 9), smooth=st.booleans())
def test_heights_are_the_pixels_of_a_grey_png(dtype: type, seed: int, rows: int, columns: int, smooth: bool) -> None:
    most = np.iinfo(dtype).max
    pixels = np.random.default_rng(seed).integers(0, most, (rows, columns), dtype=dtype, endpoint=True)
    if smooth:  # for which Pillow picks other filters
        pixels = np.sort(np.sort(pixels, axis=0), axis=1)
    assert np.array_equal(np.array(read_heights(png(pixels), 100)), pixels / most)


GREY = png(np.arange(12, dtype=np.uint8).reshape(3, 4))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "not a PNG"),
        (b"GIF89a", "not a PNG"),
        (GREY[:40], "broken"),
        (GREY[:-20], "truncated"),
        (GREY.replace(b"IDAT", b"IDAX"), "checksum"),
        (GREY[:50] + bytes([GREY[50] ^ 1]) + GREY[51:], "checksum"),
        (png(np.zeros((3, 4, 3), np.uint8)), "not a grey PNG"),
        (png(np.zeros((3, 4), bool)), "not a grey PNG"),
        (png(np.zeros((3, 4), np.uint8), transparency=0), "not a grey PNG"),
        (png(np.zeros((30, 40), np.uint8)), "at most 100"),
    ],
)
def test_heights_from_other_images_are_refused(data: bytes, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        read_heights(data, 100)


@given(st.binary(max_size=60), st.integers(8, len(GREY) - 1))
def test_a_damaged_height_image_raises_only_value_error(junk: bytes, at: int) -> None:
    try:
        found = read_heights(GREY[:at] + junk + b"\0", 100)
    except ValueError:
        return
    assert found == read_heights(GREY, 100)  # only what follows the pixels is damaged
