"""Pictures as files: what a pixel says, sheets, and videos."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from PIL import Image, ImageSequence
from plugins.segmentation import ids_of
from plugins.videos import decoded

from scenecc.render import images
from scenecc.render.images import (
    BAR,
    colors,
    encode_pixels,
    gif,
    grid_of,
    mp4,
    png,
    png_of_ids,
    sheet,
    sheet_size,
    video_pixels,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

VOC = {0: (0, 0, 0), 1: (128, 0, 0), 2: (0, 128, 0), 3: (128, 128, 0), 15: (192, 128, 128), 255: (224, 224, 192)}
"""Colours as in the development kit of PASCAL VOC."""


def opened(data: bytes) -> Any:
    return Image.open(BytesIO(data))


def test_colours_are_cut_to_eight_bits_as_in_sapiens_examples() -> None:
    pixels = np.array([[[0.0, 0.4999, 1.5, 0.0], [-1.0, 1.0, 0.9999, 1.0]]], np.float32)
    assert encode_pixels("color", pixels).tolist() == [[[0, 127, 255], [0, 255, 254]]]
    assert np.array_equal(video_pixels("color", pixels), encode_pixels("color", pixels))


def test_a_depth_is_in_millimetres() -> None:
    depth = np.array([[0, 0.0004, 1.2345, 1.2346, 65.535, 70, 1e9]], np.float32)[..., None]
    found = encode_pixels("depth", depth)
    assert found.dtype == np.uint16
    assert found.tolist() == [[0, 0, 1234, 1235, 65535, 65535, 65535]]


def test_a_depth_in_a_video_is_darker_farther_away() -> None:
    depth = np.array([[0, 1e-6, 1, 2, 1e9]], np.float32)[..., None]
    assert video_pixels("depth", depth)[0].tolist() == [[0] * 3, [255] * 3, [128] * 3, [85] * 3, [0] * 3]


def test_a_normal_component_of_0_is_half_bright() -> None:
    normals = np.array([[[0, 0, 0], [0, 0, 1], [-1, 0, 0]]], np.float32)
    assert encode_pixels("normal", normals).tolist() == [[[0, 0, 0], [128, 128, 255], [0, 128, 128]]]


def test_ids_have_the_colours_of_pascal_voc() -> None:
    for number, color in VOC.items():
        assert tuple(colors(np.array(number)).tolist()) == color
    ids = np.arange(70_000)
    assert np.array_equal(ids_of(colors(ids)), ids), "no two have one colour"
    assert ids_of(colors(np.array([2**24 - 1]))).tolist() == [2**24 - 1]


def test_a_segmentation_is_ids_with_a_palette() -> None:
    ids = np.array([[0, 1, 2], [3, 15, 255]], np.int32)
    image = opened(png_of_ids(ids))
    assert image.mode == "P"
    assert np.array_equal(np.asarray(image), ids)
    assert np.array_equal(np.asarray(image.convert("RGB")), colors(ids))
    beyond = np.array([[0, 256]], np.int32)
    image = opened(png_of_ids(beyond))
    assert image.mode == "RGB"
    assert np.array_equal(ids_of(np.asarray(image)), beyond)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_a_png_holds_the_pixels(kind: type) -> None:
    shape = (5, 7, 3) if kind is np.uint8 else (5, 7)
    pixels = np.random.default_rng(1).integers(0, np.iinfo(kind).max, shape, kind, endpoint=True)
    assert np.array_equal(np.asarray(opened(png(pixels))), pixels)


@pytest.mark.parametrize(("count", "grid"), [(1, (1, 1)), (2, (1, 2)), (3, (2, 2)), (5, (2, 3)), (16, (4, 4))])
def test_a_sheet_of_pictures_is_about_square(count: int, grid: tuple[int, int]) -> None:
    assert grid_of(count) == grid
    assert sheet_size(count, 10, 20) == (10 * grid[1], (20 + BAR) * grid[0])


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_pictures_lie_on_a_sheet_as_they_are_under_their_labels(kind: type) -> None:
    random = np.random.default_rng(0)
    shape = (30, 80, 3) if kind is np.uint8 else (30, 80)
    tiles = [random.integers(0, np.iinfo(kind).max, shape, kind) for _ in range(5)]
    whole = sheet(tiles, [f"scene {number}" for number in range(5)])
    assert (whole.shape[1], whole.shape[0]) == sheet_size(5, 80, 30)
    assert whole.dtype == kind
    labels: list[bytes] = []
    for number, tile in enumerate(tiles):
        top, left = number // 3 * (30 + BAR), number % 3 * 80
        assert np.array_equal(whole[top + BAR : top + BAR + 30, left : left + 80], tile)
        label = whole[top : top + BAR, left : left + 80]
        assert label.max() > 0.9 * np.iinfo(kind).max
        labels.append(label.tobytes())
    assert len(set(labels)) == 5, "each has its own"
    assert not whole[30 + BAR :, 160:].any(), "nothing where there is no picture"


def test_a_label_that_does_not_fit_is_cut_off() -> None:
    assert sheet([np.zeros((4, 3, 3), np.uint8)], ["scene 100000"]).shape == (4 + BAR, 3, 3)


def frames(count: int, height: int = 48, width: int = 64) -> Iterator[Any]:
    """A bar that grows to the right: no two frames are the same."""
    for number in range(count):
        frame = np.zeros((height, width, 3), np.uint8)
        frame[:, : 3 * (number + 1)] = (200, 100, 50)
        yield frame


@pytest.mark.parametrize("rate", [10.0, 100 / 3, 62.5])
def test_a_gif_has_its_frames_and_lasts_as_long(rate: float) -> None:
    image = opened(gif(frames(20), rate, 20))
    assert image.n_frames == 20
    lasts = [frame.info["duration"] for frame in ImageSequence.Iterator(image)]
    assert sum(lasts) == pytest.approx(20_000 / rate, abs=10)
    for number, frame in enumerate(ImageSequence.Iterator(image)):
        assert frame.convert("RGB").getpixel((3 * number + 1, 10)) == (200, 100, 50)


@pytest.mark.parametrize("rate", [10.0, 100 / 3, 62.5])
@pytest.mark.parametrize(("numbers", "lengths"), [([0] * 9, [9]), ([0, 0, 1, 2, 2, 2, 0], [2, 1, 3, 1])])
def test_equal_pictures_in_a_row_are_one_frame_of_a_gif_that_lasts_as_long(
    numbers: list[int], lengths: list[int], rate: float
) -> None:
    every = list(frames(3))
    image = opened(gif((every[number] for number in numbers), rate, len(numbers)))
    lasts = [frame.info["duration"] for frame in ImageSequence.Iterator(image)]
    assert lasts == [pytest.approx(1000 * length / rate, abs=10) for length in lengths]
    assert sum(lasts) == pytest.approx(1000 * len(numbers) / rate, abs=5)


def test_an_mp4_has_its_frames(tmp_path: Path) -> None:
    (tmp_path / "video.mp4").write_bytes(mp4(frames(20), 100 / 3))
    rate, found = decoded(tmp_path / "video.mp4")
    assert rate == pytest.approx(100 / 3, abs=0.01)
    assert len(found) == 20
    for number, frame in enumerate(found):
        assert np.abs(frame[10, 3 * number].astype(int) - (200, 100, 50)).max() < 40
        assert frame[10, 3 * number + 8 :].max(initial=0) < 40


def test_an_mp4_of_odd_size_repeats_its_last_pixels(tmp_path: Path) -> None:
    (tmp_path / "video.mp4").write_bytes(mp4((np.full((5, 7, 3), 200, np.uint8) for _ in range(2)), 10.0))
    _, found = decoded(tmp_path / "video.mp4")
    assert [frame.shape for frame in found] == [(6, 8, 3)] * 2
    assert all(np.abs(frame.astype(int) - 200).max() < 10 for frame in found)


def test_a_failing_encoder_is_reported_with_its_message(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(images, "_COLORS", ["-vf", "nonsense"])
    with pytest.raises(OSError, match=r"ffmpeg failed: .*nonsense"):
        mp4(frames(3), 10.0)


def test_a_frame_that_fails_stops_the_encoder() -> None:
    def failing() -> Iterator[Any]:
        yield from frames(2)
        raise RuntimeError("the renderer fails")

    with pytest.raises(RuntimeError, match="the renderer fails"):
        mp4(failing(), 10.0)


def test_a_missing_encoder_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    assert images.has_encoder()
    monkeypatch.setattr(images, "find_spec", lambda name: None)
    assert not images.has_encoder()
