"""Pictures of a camera as arrays, in units that do not depend on its shader pack."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

MILLIMETRES = 1000.0
"""What SAPIEN's shader pack `minimal` counts positions in."""


def color(camera: Any) -> NDArray[Any]:
    """(H, W, 4) float32, as on a screen (not linear), 0 to 1 and above where it is brighter; alpha last."""
    return camera.get_picture("Color")


def position(camera: Any) -> NDArray[Any]:
    """(H, W, 3) float32 [m] in the camera's frame as SAPIEN's pictures have it: x right, y up, z backwards.

    0 where there is nothing.
    """
    names = camera.get_picture_names()
    if "PositionSegmentation" in names:
        return camera.get_picture("PositionSegmentation")[..., :3].astype(np.float32) / np.float32(MILLIMETRES)
    found: NDArray[Any] = camera.get_picture("Position")[..., :3]
    if "HdrColor" in names:
        # Ray tracing gives what is far away a place too.
        found = np.where(segmentation(camera) == 0, np.float32(0), found)
    return found


def depth(camera: Any) -> NDArray[Any]:
    """(H, W, 1) float32 [m] along the axis of the camera, positive; 0 where there is nothing."""
    # As subtraction: nothing is 0.0, not -0.0.
    return np.float32(0) - position(camera)[..., 2:3]


def segmentation(camera: Any) -> NDArray[Any]:
    """(H, W, 1) int32, `per_scene_id` of the entity that is seen; 0 where there is nothing."""
    if "PositionSegmentation" in camera.get_picture_names():
        return camera.get_picture("PositionSegmentation")[..., 3:4].astype(np.int32)
    return camera.get_picture("Segmentation")[..., 1:2].astype(np.int32)


def normal(camera: Any) -> NDArray[Any]:
    """(H, W, 3) float32, where surfaces face, of length 1, in the frame of `position`; 0 where there is nothing.

    Raises:
        ValueError: the camera's shader pack has no such picture.
    """
    if "Normal" not in (names := camera.get_picture_names()):
        raise ValueError(f"no picture 'normal' with this shader; there are {', '.join((*PICTURES, *sorted(names)))}")
    return np.where(segmentation(camera) == 0, np.float32(0), camera.get_picture("Normal")[..., :3])


PICTURES: Final[dict[str, Callable[[Any], NDArray[Any]]]] = {
    "color": color,
    "depth": depth,
    "segmentation": segmentation,
    "position": position,
}
"""What every camera takes, beside SAPIEN's own names of pictures."""

_READERS: Final[dict[str, Callable[[Any], NDArray[Any]]]] = {**PICTURES, "normal": normal}


def picture(camera: Any, what: str) -> NDArray[Any]:
    """A picture that was taken, (H, W, C).

    Raises:
        ValueError: there is none of the name.
    """
    read = _READERS.get(what)
    if read is not None:
        return read(camera)
    names = camera.get_picture_names()
    if what not in names:
        raise ValueError(f"no picture {what!r}; there are {', '.join((*PICTURES, *sorted(names)))}")
    found: NDArray[Any] = camera.get_picture(what)
    return found if found.ndim == 3 else found[..., None]
