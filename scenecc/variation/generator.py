"""The random numbers behind every draw; `docs/draws.md` is the same in words.

The words of a field in a scene follow from the seed, the field's key and the scene's index alone, by the counter-based
generator Philox 4×64-10 (J. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", 2011).
"""

from __future__ import annotations

import cmath
import hashlib
import json
import math
from itertools import accumulate, repeat
from typing import TYPE_CHECKING, cast

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.variation.nodes import Key


_BLOCK = 4
"""How many words one value of the counter gives."""


def philox_key(seed: int, key: Key) -> tuple[int, int]:
    """The two 64-bit words of the generator's key: SHA-256 of `[seed,"section","name","path"]`, its first 16 bytes."""
    text = json.dumps([seed, key.section, key.name, key.path], ensure_ascii=True, separators=(",", ":"))
    digest = hashlib.sha256(text.encode("ascii")).digest()
    return int.from_bytes(digest[:8], "little"), int.from_bytes(digest[8:16], "little")


def words(
    seed: int | tuple[int, ...], key: Key, scenes: NDArray[np.int64], first: int, count: int, lane: int = 0
) -> NDArray[np.uint64]:
    """The raw words `first` to `first + count` of a field in some scenes, (B, count).

    Args:
        seed: any integer, or one for each of the scenes.
        key: the field's.
        scenes: indices of the scenes (B,), in any order.
        first: the first word; component j of a vector has word j.
        count: how many.
        lane: 0, or 1 for the second word of each component where a component needs two.
    """
    if scenes.size == 0:
        return np.empty((0, count), dtype=np.uint64)
    first_block, last_block = first // _BLOCK, (first + count - 1) // _BLOCK
    start = first - first_block * _BLOCK
    if not isinstance(seed, int):
        return _many_seeds(seed, key, scenes, range(first_block, last_block + 1), lane)[:, start : start + count]
    lowest = int(scenes.min())
    rows = int(scenes.max()) - lowest + 1
    key_words = np.array(philox_key(seed, key), dtype=np.uint64)
    blocks: list[NDArray[np.uint64]] = []
    for block in range(first_block, last_block + 1):
        # The generator counts up before it gives its first words: scene i has the counter (i + 1, block, lane, 0).
        counter = np.array((lowest, block, lane, 0), dtype=np.uint64)
        stream = np.random.Philox(key=key_words, counter=counter).random_raw(rows * _BLOCK)
        blocks.append(np.asarray(stream, dtype=np.uint64).reshape(rows, _BLOCK))
    joined = blocks[0] if len(blocks) == 1 else np.concatenate(blocks, axis=1)
    joined = joined[:, start : start + count]
    return joined if rows == len(scenes) and _are_consecutive(scenes) else joined[scenes - lowest]


def _many_seeds(
    seeds: tuple[int, ...], key: Key, scenes: NDArray[np.int64], blocks: Sequence[int], lane: int
) -> NDArray[np.uint64]:
    """The words of some blocks (B, 4 · blocks), where each scene has a seed of its own."""
    key_of = {seed: philox_key(seed, key) for seed in set(seeds)}
    keys = np.array([key_of[seed] for seed in seeds], dtype=np.uint64)
    counters = np.zeros((len(seeds), 4), dtype=np.uint64)
    counters[:, 0], counters[:, 2] = scenes + 1, lane
    found: list[NDArray[np.uint64]] = []
    for block in blocks:
        counters[:, 1] = block
        found.append(philox_block(keys, counters))
    return np.concatenate(found, axis=1)


def units(raw: NDArray[np.uint64]) -> NDArray[np.float64]:
    """Numbers in [0, 1) from the upper 53 bits of words."""
    return (raw >> np.uint64(11)).astype(np.float64) * 2.0**-53


def rotation(u: NDArray[np.float64]) -> NDArray[np.float64]:
    """Quaternions (B, 4) even over all rotations, of numbers (B, 3): K. Shoemake, "Uniform random rotations" (1992)."""
    a, b = np.sqrt(1.0 - u[:, 0]), np.sqrt(u[:, 0])
    s, t = _unit_complex(2.0 * math.pi * u[:, 1]), _unit_complex(2.0 * math.pi * u[:, 2])
    return np.stack((b * t.real, a * s.imag, a * s.real, b * t.imag), axis=1)


def _unit_complex(angles: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Cosine and sine of each angle, as real and imaginary part: the C library's, both by one call from Python."""
    return np.fromiter(map(cmath.rect, repeat(1.0), angles.tolist()), dtype=np.complex128, count=angles.size)


def choice(u: NDArray[np.float64], count: int, weights: Sequence[float] | None) -> NDArray[np.int64]:
    """Indices below `count`, each as likely as its weight says."""
    if weights is None:
        return np.minimum(np.floor(u * count).astype(np.int64), count - 1)
    reached = np.array(list(accumulate(float(weight) for weight in weights)), dtype=np.float64)
    # What has no weight is never reached; rounding must not carry a draw past the last that has one.
    last = max(index for index, weight in enumerate(weights) if weight > 0)
    found = cast("NDArray[np.intp]", np.searchsorted(reached, u * reached[-1], side="right"))
    return np.minimum(found, last).astype(np.int64)


def _are_consecutive(scenes: NDArray[np.int64]) -> bool:
    return bool((scenes[1:] - scenes[:-1] == 1).all())


_ROUNDS = 10

_MULTIPLIERS = (np.uint64(0xD2E7470EE14C6C93), np.uint64(0xCA5A826395121157))

_WEYL = (np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBB67AE8584CAA73B))

_LOW, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)


def philox_block(keys: NDArray[np.uint64], counters: NDArray[np.uint64]) -> NDArray[np.uint64]:
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
