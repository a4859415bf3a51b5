"""Philox 4×64-10 for many keys at once; numpy's own has one key a generator.

J. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", 2011, with the constants of its table 2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_ROUNDS = 10
_MULTIPLIERS = (np.uint64(0xD2E7470EE14C6C93), np.uint64(0xCA5A826395121157))
_WEYL = (np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBB67AE8584CAA73B))
_LOW, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)


def block(keys: NDArray[np.uint64], counters: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """The words (B, 4) that each key (B, 2) gives for its counter (B, 4), which is not counted up before."""
    a, b, c, d = (counters[:, i].copy() for i in range(4))
    k0, k1 = keys[:, 0].copy(), keys[:, 1].copy()
    with np.errstate(over="ignore"):
        for _ in range(_ROUNDS):
            high0, low0 = _product(_MULTIPLIERS[0], a)
            high1, low1 = _product(_MULTIPLIERS[1], c)
            a, b, c, d = high1 ^ b ^ k0, low1, high0 ^ d ^ k1, low0
            k0, k1 = k0 + _WEYL[0], k1 + _WEYL[1]
    return np.stack([a, b, c, d], axis=1)


def _product(x: np.uint64, y: NDArray[np.uint64]) -> tuple[NDArray[np.uint64], NDArray[np.uint64]]:
    """The upper and the lower 64 bits of a product."""
    x0, x1, y0, y1 = x & _LOW, x >> _HALF, y & _LOW, y >> _HALF
    low = x0 * y0
    middle = x1 * y0 + (low >> _HALF)
    other = x0 * y1 + (middle & _LOW)
    return x1 * y1 + (middle >> _HALF) + (other >> _HALF), x * y
