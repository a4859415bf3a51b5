"""Ids of entities from the colours of a segmentation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def ids_of(pixels: NDArray[np.uint8]) -> NDArray[np.int32]:
    """The ids (…) whose `colors` these (…, 3) are."""
    found = np.zeros(pixels.shape[:-1], np.int32)
    for place in range(8):
        for channel in range(3):
            bit = (pixels[..., channel].astype(np.int32) >> (7 - place)) & 1
            found |= bit << (3 * place + channel)
    return found
