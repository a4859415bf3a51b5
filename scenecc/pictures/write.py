"""Pixels as the bytes of a file: PNG, GIF, MP4."""

from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager, suppress
from fractions import Fraction
from importlib import import_module
from io import BytesIO
from itertools import chain, pairwise
from subprocess import DEVNULL, PIPE
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from scenecc.interrupt import child
from scenecc.pictures.encode import colors

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable

    from numpy.typing import NDArray
    from PIL import Image as Images

Film = Literal["gif", "mp4"]

_MOST_IN_A_PALETTE: Final = 255
_QUALITY: Final = "18"
"""H.264's rate factor at which people see no loss."""

_COLORS: Final = [
    *("-vf", "scale=out_color_matrix=bt709:out_range=tv"),
    *("-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"),
]
"""What players take a film for that says nothing, said and done."""


def png(pixels: NDArray[Any]) -> bytes:
    """A PNG of (H, W) uint16 or (H, W, 3) uint8."""
    from PIL import Image

    return _saved(Image.fromarray(np.ascontiguousarray(pixels)))


def png_of_ids(ids: NDArray[Any]) -> bytes:
    """A PNG of ids (H, W): with a palette, so that a pixel's value is the id, or in colours where ids go beyond 255."""
    from PIL import Image

    if ids.max(initial=0) > _MOST_IN_A_PALETTE:
        return png(colors(ids))
    image = Image.fromarray(ids.astype(np.uint8))
    image.putpalette(colors(np.arange(_MOST_IN_A_PALETTE + 1)).tobytes())
    return _saved(image)


def film(kind: Film, frames: Iterable[NDArray[np.uint8]], rate: float, count: int) -> bytes:
    """A film that plays `rate` frames a second.

    Args:
        kind: which file.
        frames: (H, W, 3) each, of one size; taken one after another, and none is kept.
        rate: [1/s].
        count: how many there are.

    Raises:
        OSError: the encoder cannot be run, or fails.
    """
    return gif(frames, rate, count) if kind == "gif" else mp4(frames, rate)


def gif(frames: Iterable[NDArray[np.uint8]], rate: float, count: int) -> bytes:
    """A GIF that starts again when it ends, of 256 colours a frame. Equal frames in a row are one that lasts longer."""
    from PIL import Image

    def small(frame: NDArray[np.uint8]) -> Image.Image:
        return Image.fromarray(frame).quantize(256, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)

    # A GIF counts hundredths of a second: what one frame is too short, another is too long.
    ends = [round(100 * number / rate) for number in range(count + 1)]
    lasts = [10 * (end - start) for start, end in pairwise(ends)]
    rest = map(small, frames)
    first, file = next(rest), BytesIO()
    first.save(file, "GIF", save_all=True, append_images=rest, duration=lasts, loop=0)
    return file.getvalue()


def mp4(frames: Iterable[NDArray[np.uint8]], rate: float) -> bytes:
    """An MP4 (H.264, 4:2:0) that every player shows. A width or height that is odd grows by a pixel, its last again.

    Raises:
        OSError: the encoder cannot be run, or fails.
    """
    rest = iter(frames)
    first = _even(next(rest))
    with tempfile.TemporaryFile() as file:
        with _encoder(first.shape[1], first.shape[0], rate, file.fileno()) as put:
            for frame in chain([first], map(_even, rest)):
                put(frame)
        return file.read()


@contextmanager
def _encoder(width: int, height: int, rate: float, film: int) -> Generator[Callable[[NDArray[np.uint8]], object]]:
    """A running ffmpeg, which takes frames. It is gone when this ends, and has written the film if nothing failed.

    `film` is the descriptor of a file, whose name nobody needs: of a process that is killed, no file is left.
    """
    ffmpeg: Any = import_module("imageio_ffmpeg")
    frame_rate = Fraction(rate).limit_denominator(1000)
    given = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(frame_rate), "-i", "-"]
    made = ["-c:v", "libx264", "-crf", _QUALITY, "-pix_fmt", "yuv420p", *_COLORS, "-movflags", "+faststart"]
    try:
        program = ffmpeg.get_ffmpeg_exe()
    except RuntimeError as error:
        raise OSError(str(error)) from error
    command = [program, "-v", "error", "-y", *given, *made, "-f", "mp4", f"/dev/fd/{film}"]
    with (
        tempfile.TemporaryFile() as said,
        child(command, stdin=PIPE, stdout=DEVNULL, stderr=said, pass_fds=[film]) as process,
    ):
        assert process.stdin is not None
        try:
            with suppress(BrokenPipeError):  # it has ended, and said why
                yield process.stdin.write
                process.stdin.close()
            if process.wait() != 0 or os.fstat(film).st_size == 0:
                said.seek(0)
                words = said.read().decode(errors="replace").strip()
                raise OSError(f"ffmpeg failed: {words or f'it ended with status {process.returncode}'}")
        finally:
            process.kill()  # before what it has not read is written to it
            with suppress(BrokenPipeError):
                process.stdin.close()


def _even(frame: NDArray[np.uint8]) -> NDArray[np.uint8]:
    height, width, _ = frame.shape
    return np.ascontiguousarray(np.pad(frame, ((0, height % 2), (0, width % 2), (0, 0)), "edge"))


def _saved(image: Images.Image) -> bytes:
    file = BytesIO()
    image.save(file, "PNG", optimize=True)
    return file.getvalue()
