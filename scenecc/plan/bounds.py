"""Ranges of the plan's numbers."""

from __future__ import annotations

from math import inf
from typing import NamedTuple


class Bounds(NamedTuple):
    """The numbers that are allowed, both ends included. `nonzero`: 0 is not."""

    low: float = -inf
    high: float = inf
    nonzero: bool = False

    def __str__(self) -> str:
        low = "" if self.low == -inf else f"at least {self.low:g}"
        high = "" if self.high == inf else f"at most {self.high:g}"
        return " and ".join(filter(None, (low, high, "not 0" if self.nonzero else "")))

    def allow(self, number: float) -> bool:
        """Whether a number is one of them."""
        return self.low <= number <= self.high and not (self.nonzero and number == 0)

    def wanted(self, number: float) -> str:
        """What a number that is none of them would have to be, as a person says it."""
        if number == 0 and self.nonzero:
            return "other than 0"
        if number <= 0 and self.low == SMALLEST:
            return "above 0"
        if number < self.low:
            return f"at least {self.low:g}"
        return f"at most {self.high:g}"


LARGEST = 3.4028234663852886e38
SMALLEST = 1.1754943508222875e-38
"""The range of single precision, in which the engine computes; the language has the same."""

FARTHEST = 1e4
"""How far a shape or the centre of mass of a body that moves is from it [m]: beyond, the engine moves the body by
millimetres when it goes from the one to the other, and its inertia is noise."""

ANY = Bounds(-LARGEST, LARGEST)
POSITIVE = Bounds(SMALLEST, LARGEST)
AT_LEAST_0 = Bounds(0, LARGEST)
UNIT = Bounds(0, 1)
COUNT = Bounds(0, 2**31 - 1)
POSITION_ITERATIONS = Bounds(1, 255)
VELOCITY_ITERATIONS = Bounds(0, 255)
