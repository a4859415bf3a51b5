"""Single precision, in which the engine computes: its range, and rounding to it."""

from __future__ import annotations

import math
import struct

FLOAT32_MAX = 3.4028234663852886e38

FLOAT32_MIN = 1.1754943508222875e-38
"""The largest and the smallest normal number: beyond them a length becomes infinite or zero in the engine."""


def round_to_float32(number: float) -> float:
    """Rounded to single precision; infinite beyond its range."""
    try:
        return struct.unpack("f", struct.pack("f", number))[0]
    except OverflowError:
        return math.copysign(math.inf, number)
