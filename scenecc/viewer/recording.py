"""Pictures and videos of a browser's view of a page."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.errors import SceneError
from scenecc.extras import install_hint
from scenecc.render.images import NO_ENCODER, has_encoder, mp4

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    import viser
    from numpy.typing import NDArray

RATE: Final = 30
"""Frames per second of a video."""

_TIMEOUT: Final = 60
"""Time limit for a picture [s]: a browser without a GPU takes seconds."""

_MOST: Final = 2048
"""Maximum width and height of a picture [px]."""


class ShotError(Exception):
    """A browser returns no picture: it has disconnected, or takes too long."""


def shot(browser: viser.ClientHandle) -> NDArray[np.uint8]:
    """(H, W, 3) picture of a browser's view, without panels.

    Raises:
        ShotError: the browser returns no picture.
    """
    try:
        camera: Any = browser.camera
        scale = min(1.0, _MOST / max(camera.image_height, camera.image_width, 1))
        height, width = (max(int(side * scale), 1) for side in (camera.image_height, camera.image_width))
        found = browser.get_render(height, width, transport_format="jpeg", timeout=_TIMEOUT)
    except (AssertionError, RuntimeError, TimeoutError) as error:
        raise ShotError(str(error)) from error
    return np.ascontiguousarray(found[..., :3])


def record_video(browser: viser.ClientHandle, advance: Callable[[], bool]) -> bytes:
    """Returns an MP4 of a browser's view, with `RATE` frames per second.

    Args:
        browser: the browser.
        advance: called after each picture; returns false after the last.

    Raises:
        SceneError: the encoder is not installed or fails, or the browser returns no picture.
    """
    if not has_encoder():
        raise _error("SC816", NO_ENCODER, install_hint("pictures"))

    def frames() -> Iterator[NDArray[np.uint8]]:
        yield (first := shot(browser))
        while advance():
            # The window may be resized meanwhile.
            yield _fit_picture(shot(browser), first)

    try:
        return mp4(frames(), RATE)
    except ShotError as error:
        raise _error("SC816", f"the browser returned no picture: {error}") from error
    except OSError as error:
        raise _error("SC816", str(error)) from error


def _fit_picture(frame: NDArray[np.uint8], first: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Returns a picture cropped or padded to the size of another."""
    made = np.full_like(first, 255)
    height, width = (min(a, b) for a, b in zip(first.shape[:2], frame.shape[:2], strict=True))
    made[:height, :width] = frame[:height, :width]
    return made


def _error(code: str, message: str, hint: str | None = None) -> SceneError:
    sink = Sink()
    sink.report(code, message, Location(None), hint=hint)
    return SceneError(sink.diagnostics())
