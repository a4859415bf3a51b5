"""Pictures of a page as a browser shows it, one by one or as a film."""

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
"""Pictures of a film a second."""

_TIMEOUT: Final = 60
"""How long a browser may take for a picture [s]: one without a GPU takes seconds."""

_MOST: Final = 2048
"""Of the sides of a picture [px]."""


class ShotError(Exception):
    """A browser gives no picture: it is gone, or takes too long."""


def shot(browser: viser.ClientHandle) -> NDArray[np.uint8]:
    """(H, W, 3), what a browser shows, without panels.

    Raises:
        ShotError: it gives none.
    """
    try:
        camera: Any = browser.camera
        scale = min(1.0, _MOST / max(camera.image_height, camera.image_width, 1))
        height, width = (max(int(side * scale), 1) for side in (camera.image_height, camera.image_width))
        found = browser.get_render(height, width, transport_format="jpeg", timeout=_TIMEOUT)
    except (AssertionError, RuntimeError, TimeoutError) as error:
        raise ShotError(str(error)) from error
    return np.ascontiguousarray(found[..., :3])


def record_film(browser: viser.ClientHandle, advance: Callable[[], bool]) -> bytes:
    """An MP4 of what a browser shows, `RATE` pictures a second.

    Args:
        browser: that shows it.
        advance: called after each picture; false: it was the last.

    Raises:
        SceneError: the encoder is not installed or fails, or the browser gives no picture.
    """
    if not has_encoder():
        raise _error("SC816", NO_ENCODER, install_hint("pictures"))

    def frames() -> Iterator[NDArray[np.uint8]]:
        yield (first := shot(browser))
        while advance():
            # A window may change its size meanwhile.
            yield _fit_picture(shot(browser), first)

    try:
        return mp4(frames(), RATE)
    except ShotError as error:
        raise _error("SC816", f"the browser gives no picture: {error}") from error
    except OSError as error:
        raise _error("SC816", str(error)) from error


def _fit_picture(frame: NDArray[np.uint8], first: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A picture cut or filled up to the size of another."""
    made = np.full_like(first, 255)
    height, width = (min(a, b) for a, b in zip(first.shape[:2], frame.shape[:2], strict=True))
    made[:height, :width] = frame[:height, :width]
    return made


def _error(code: str, message: str, hint: str | None = None) -> SceneError:
    sink = Sink()
    sink.report(code, message, Location(None), hint=hint)
    return SceneError(sink.diagnostics())
