"""Pictures as files: camera data as pixels, contact sheets, and the bytes of PNG, GIF and MP4.

Works on arrays and does not depend on scenes. Pillow and ffmpeg are loaded when needed.
"""

from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager, suppress
from fractions import Fraction
from importlib import import_module
from importlib.util import find_spec
from io import BytesIO
from itertools import chain, pairwise
from math import ceil, sqrt
from subprocess import DEVNULL, PIPE
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from scenecc.interrupt import child

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Sequence

    from numpy.typing import NDArray
    from PIL import Image as Images


What = Literal["color", "depth", "segmentation", "normal"]

_MILLIMETRES: Final = 1000.0
_FARTHEST: Final = 65535


def encode_pixels(what: What, pixels: NDArray[Any]) -> NDArray[Any]:
    """Returns the pixels of a PNG: (H, W) uint16 for a depth [mm], otherwise (H, W, 3) uint8."""
    return millimetres(pixels) if what == "depth" else video_pixels(what, pixels)


def video_pixels(what: What, pixels: NDArray[Any]) -> NDArray[np.uint8]:
    """Returns the pixels of a film (H, W, 3): like `encode_pixels`, with a depth in shades of grey."""
    if what == "color":
        # Truncated, not rounded, as in SAPIEN's examples and in ManiSkill.
        return (np.clip(pixels[..., :3], 0, 1) * 255).astype(np.uint8)
    if what == "depth":
        return _grey_pixels(pixels[..., 0])
    if what == "segmentation":
        return colors(pixels[..., 0])
    return _normal_pixels(pixels)


def millimetres(depth: NDArray[Any]) -> NDArray[np.uint16]:
    """Converts a depth (H, W, 1) [m] to (H, W) [mm]: 0 where there is nothing, 65535 from 65.535 m on."""
    return np.clip(np.rint(depth[..., 0] * _MILLIMETRES), 0, _FARTHEST).astype(np.uint16)


def colors(ids: NDArray[Any]) -> NDArray[np.uint8]:
    """Returns the colour (…, 3) of each id as in PASCAL VOC, unique for ids below 2²⁴. 0 is black.

    The bits of an id go to red, green and blue in turn, the lowest bit first, and fill each from its highest bit down.
    """
    bits = np.asarray(ids, np.uint32)
    found = np.zeros((*bits.shape, 3), np.uint8)
    for place in range(8):
        for channel in range(3):
            bit = (bits >> np.uint32(3 * place + channel)) & np.uint32(1)
            found[..., channel] |= (bit << np.uint32(7 - place)).astype(np.uint8)
    return found


def _grey_pixels(depth: NDArray[Any]) -> NDArray[np.uint8]:
    """Returns shades of grey: white at the lens, half as bright at 1 m, a third at 2 m; black where empty."""
    grey = np.where(depth > 0, np.rint(255 / (1 + np.maximum(depth, 0))), 0).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)


def _normal_pixels(pixels: NDArray[Any]) -> NDArray[np.uint8]:
    """Maps -1 to 1 of each axis to 0 to 255; black where there is nothing."""
    nothing = ~pixels.any(axis=2, keepdims=True)
    return np.where(nothing, 0, np.rint((np.clip(pixels, -1, 1) + 1) * 127.5)).astype(np.uint8)


BAR: Final = 18
"""Height of a label [px]."""

_LETTERS: Final = 12
_MARGIN: Final = 4


def grid_of(count: int) -> tuple[int, int]:
    """Returns rows and columns of a sheet of `count` pictures: as many columns as rows, or one more."""
    columns = ceil(sqrt(count))
    return ceil(count / columns), columns


def sheet_size(count: int, width: int, height: int) -> tuple[int, int]:
    """Returns width and height [px] of a sheet of `count` pictures of this size."""
    rows, columns = grid_of(count)
    return columns * width, rows * (height + BAR)


def sheet(tiles: Sequence[NDArray[Any]], labels: Sequence[str]) -> NDArray[Any]:
    """Joins pictures (H, W) or (H, W, 3) of one integer type; labels are white on black, above each.

    The picture of row r and column c begins at pixel (r · (H + BAR) + BAR, c · W).
    """
    rows, columns = grid_of(len(tiles))
    height, width, *channels = tiles[0].shape
    whole = np.zeros((rows * (height + BAR), columns * width, *channels), tiles[0].dtype)
    for number, (tile, label) in enumerate(zip(tiles, labels, strict=True)):
        top, left = number // columns * (height + BAR), number % columns * width
        letters = _render_text(label, width) * (np.iinfo(whole.dtype).max // 255)
        whole[top : top + BAR, left : left + width] = letters[..., None] if channels else letters
        whole[top + BAR : top + BAR + height, left : left + width] = tile
    return whole


def _render_text(text: str, width: int) -> NDArray[np.uint16]:
    """Renders a text as (BAR, width), 0 to 255; longer text is cut off."""
    from PIL import Image, ImageDraw, ImageFont

    image = Image.new("L", (width, BAR))
    draw = ImageDraw.Draw(image)
    draw.text((_MARGIN, BAR / 2), text, fill=255, font=ImageFont.load_default(_LETTERS), anchor="lm")
    return np.asarray(image, np.uint16)


VideoFormat = Literal["gif", "mp4"]

_MOST_IN_A_PALETTE: Final = 255
_QUALITY: Final = "18"
"""H.264's rate factor without visible loss."""

_COLORS: Final = [
    *("-vf", "scale=out_color_matrix=bt709:out_range=tv"),
    *("-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"),
]
"""The colour space that players assume by default, for the conversion and for the file's header."""


def png(pixels: NDArray[Any]) -> bytes:
    """Encodes (H, W) uint16 or (H, W, 3) uint8 as a PNG."""
    from PIL import Image

    return _encode_png(Image.fromarray(np.ascontiguousarray(pixels)))


def png_of_ids(ids: NDArray[Any]) -> bytes:
    """Encodes ids (H, W) as a PNG, with a palette whose indices are the ids, or in colours if an id exceeds 255."""
    from PIL import Image

    if ids.max(initial=0) > _MOST_IN_A_PALETTE:
        return png(colors(ids))
    image = Image.fromarray(ids.astype(np.uint8))
    image.putpalette(colors(np.arange(_MOST_IN_A_PALETTE + 1)).tobytes())
    return _encode_png(image)


def encode_video(kind: VideoFormat, frames: Iterable[NDArray[np.uint8]], rate: float, count: int) -> bytes:
    """Encodes a video that plays `rate` frames per second.

    Args:
        kind: file format.
        frames: (H, W, 3) each, of one size; read one at a time, without keeping them.
        rate: [1/s].
        count: number of frames.

    Raises:
        OSError: the encoder cannot be run, or fails.
    """
    return gif(frames, rate, count) if kind == "gif" else mp4(frames, rate)


def gif(frames: Iterable[NDArray[np.uint8]], rate: float, count: int) -> bytes:
    """Encodes a GIF that loops, with 256 colours per frame. Equal successive frames become one longer frame."""
    from PIL import Image

    def small(frame: NDArray[np.uint8]) -> Image.Image:
        return Image.fromarray(frame).quantize(256, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)

    # A GIF counts hundredths of a second, so rounding errors are carried over to the next frame.
    ends = [round(100 * number / rate) for number in range(count + 1)]
    lasts = [10 * (end - start) for start, end in pairwise(ends)]
    rest = map(small, frames)
    first, file = next(rest), BytesIO()
    first.save(file, "GIF", save_all=True, append_images=rest, duration=lasts, loop=0)
    return file.getvalue()


def mp4(frames: Iterable[NDArray[np.uint8]], rate: float) -> bytes:
    """Encodes an MP4 (H.264, 4:2:0) for every player. An odd width or height is padded by repeating its last pixel.

    Raises:
        OSError: the encoder cannot be run, or fails.
    """
    rest = iter(frames)
    first = _pad_to_even(next(rest))
    with tempfile.TemporaryFile() as file:
        with _encoder(first.shape[1], first.shape[0], rate, file.fileno()) as put:
            for frame in chain([first], map(_pad_to_even, rest)):
                put(frame)
        return file.read()


@contextmanager
def _encoder(width: int, height: int, rate: float, video: int) -> Generator[Callable[[NDArray[np.uint8]], object]]:
    """Runs ffmpeg and yields a function that takes frames. The film is complete afterwards, unless ffmpeg failed.

    `film` is the descriptor of an unnamed file, so that a killed process leaves no file.
    """
    ffmpeg: Any = import_module("imageio_ffmpeg")
    frame_rate = Fraction(rate).limit_denominator(1000)
    given = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(frame_rate), "-i", "-"]
    made = ["-c:v", "libx264", "-crf", _QUALITY, "-pix_fmt", "yuv420p", *_COLORS, "-movflags", "+faststart"]
    try:
        program = ffmpeg.get_ffmpeg_exe()
    except RuntimeError as error:
        raise OSError(str(error)) from error
    command = [program, "-v", "error", "-y", *given, *made, "-f", "mp4", f"/dev/fd/{video}"]
    with (
        tempfile.TemporaryFile() as said,
        child(command, stdin=PIPE, stdout=DEVNULL, stderr=said, pass_fds=[video]) as process,
    ):
        assert process.stdin is not None
        try:
            with suppress(BrokenPipeError):  # it has ended, and its error says why
                yield process.stdin.write
                process.stdin.close()
            if process.wait() != 0 or os.fstat(video).st_size == 0:
                said.seek(0)
                words = said.read().decode(errors="replace").strip()
                raise OSError(f"ffmpeg failed: {words or f'its process ended with status {process.returncode}'}")
        finally:
            process.kill()  # before buffered frames are written to it
            with suppress(BrokenPipeError):
                process.stdin.close()


def _pad_to_even(frame: NDArray[np.uint8]) -> NDArray[np.uint8]:
    height, width, _ = frame.shape
    return np.ascontiguousarray(np.pad(frame, ((0, height % 2), (0, width % 2), (0, 0)), "edge"))


def _encode_png(image: Images.Image) -> bytes:
    file = BytesIO()
    image.save(file, "PNG", optimize=True)
    return file.getvalue()


NO_ENCODER: Final = "an MP4 video needs imageio-ffmpeg, which is not installed here"


def has_encoder() -> bool:
    """Returns whether the package that writes MP4 is installed."""
    return find_spec("imageio_ffmpeg") is not None
