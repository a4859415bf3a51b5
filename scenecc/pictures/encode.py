"""What a camera measures, as the pixels of a file. Arrays in are those of `CameraBatch.capture`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

What = Literal["color", "depth", "segmentation", "normal"]

WHATS: Final[tuple[What, ...]] = ("color", "depth", "segmentation", "normal")

_MILLIMETRES: Final = 1000.0
_FARTHEST: Final = 65535


def encoded(what: What, pixels: NDArray[Any]) -> NDArray[Any]:
    """The pixels of a PNG: (H, W) uint16 of a depth [mm], otherwise (H, W, 3) uint8.

    Args:
        what: what the picture shows.
        pixels: (H, W, C) as a camera gives them.
    """
    return millimetres(pixels) if what == "depth" else shown(what, pixels)


def shown(what: What, pixels: NDArray[Any]) -> NDArray[np.uint8]:
    """The pixels of a film (H, W, 3): as `encoded`, a depth in shades of grey."""
    if what == "color":
        # Cut off, not rounded: as in SAPIEN's examples and in ManiSkill.
        return (np.clip(pixels[..., :3], 0, 1) * 255).astype(np.uint8)
    if what == "depth":
        return _grey(pixels[..., 0])
    if what == "segmentation":
        return colors(pixels[..., 0])
    return _normal(pixels)


def millimetres(depth: NDArray[Any]) -> NDArray[np.uint16]:
    """A depth (H, W, 1) [m] as (H, W) [mm]: 0 where there is nothing, 65535 from 65.535 m on."""
    return np.clip(np.rint(depth[..., 0] * _MILLIMETRES), 0, _FARTHEST).astype(np.uint16)


def colors(ids: NDArray[Any]) -> NDArray[np.uint8]:
    """The colour (…, 3) of each id: that of PASCAL VOC, and so another one for every id below 2²⁴. 0 is black.

    The bits of an id are dealt to red, green and blue in turn, the lowest first, and into each from the highest down.
    """
    bits = np.asarray(ids, np.uint32)
    found = np.zeros((*bits.shape, 3), np.uint8)
    for place in range(8):
        for channel in range(3):
            bit = (bits >> np.uint32(3 * place + channel)) & np.uint32(1)
            found[..., channel] |= (bit << np.uint32(7 - place)).astype(np.uint8)
    return found


def ids_of(pixels: NDArray[np.uint8]) -> NDArray[np.int32]:
    """The ids (…) whose `colors` these (…, 3) are."""
    found = np.zeros(pixels.shape[:-1], np.int32)
    for place in range(8):
        for channel in range(3):
            bit = (pixels[..., channel].astype(np.int32) >> (7 - place)) & 1
            found |= bit << (3 * place + channel)
    return found


def _grey(depth: NDArray[Any]) -> NDArray[np.uint8]:
    """White at the lens, half as bright a metre away, a third at two, and so on; black where there is nothing."""
    grey = np.where(depth > 0, np.rint(255 / (1 + np.maximum(depth, 0))), 0).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)


def _normal(pixels: NDArray[Any]) -> NDArray[np.uint8]:
    """-1 to 1 of each axis as 0 to 255; black where there is nothing."""
    nothing = ~pixels.any(axis=2, keepdims=True)
    return np.where(nothing, 0, np.rint((np.clip(pixels, -1, 1) + 1) * 127.5)).astype(np.uint8)
