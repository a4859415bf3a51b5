"""The packages that files of pictures need, which come with the extra `pictures`."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Final

INSTALL: Final = "pip install 'scenecc[pictures]'"

_PILLOW: Final = {"PIL": "pillow"}
_FFMPEG: Final = {"imageio_ffmpeg": "imageio-ffmpeg"}


def missing(*, mp4: bool) -> list[str]:
    """The names of packages that are needed and not installed. `mp4`: whether a film is to be written so."""
    needed = _PILLOW | _FFMPEG if mp4 else _PILLOW
    return [name for module, name in needed.items() if find_spec(module) is None]
