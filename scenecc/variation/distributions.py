"""The forms that draw numbers, one class each: how they are written, judged, bounded and drawn.

A new distribution is one class and one entry of `DISTRIBUTIONS`. The reader of scene files, the JSON Schema, the ranges
of parameters, the plan's JSON, the bounds of values and the generator all work from these.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Interval = tuple[float, float]

Role = Literal["value", "mean", "deviation"]
"""What an operand is: a number that the field may hold, any number, or one that is not negative."""

WIDEST_INTEGERS = 2**53
"""How many integers one draw may be among: those that are exact as numbers with a fraction."""


@frozen
class Condition:
    """What has to hold of the operands: one is at least another, or at least 0.

    Attributes:
        message: what is wrong otherwise.
        greater: the number of the operand.
        less: of the other one; None: 0.
        strict: whether both may not be equal.
        because: why, where a file breaks it.
    """

    message: str
    greater: int
    less: int | None = None
    strict: bool = False
    because: str = ""


class Distribution:
    """One form that draws numbers, each component of a vector by itself.

    Attributes:
        key: of the form.
        operands: the names of the numbers in its list.
        roles: what each of them is.
        members: their names in a plan's JSON.
        companion: the key beside the form that holds two edges, which follow the operands.
        description: of the list, for the JSON Schema.
        companion_description: of the companion.
        listed: all operands in words.
        conditions: what has to hold of the operands; of those that are there.
        within_operands: whether what is drawn lies between the first operand and the last.
        whole: whether integers are drawn.
    """

    key: ClassVar[str]
    operands: ClassVar[tuple[str, ...]] = ("low", "high")
    roles: ClassVar[tuple[Role, ...]] = ("value", "value")
    members: ClassVar[tuple[str, ...]] = ("low", "high")
    companion: ClassVar[str | None] = None
    description: ClassVar[str]
    companion_description: ClassVar[str] = ""
    listed: ClassVar[str] = "both bounds"
    conditions: ClassVar[tuple[Condition, ...]] = (Condition("the lower bound is above the upper one", 1, 0),)
    within_operands: ClassVar[bool] = True
    whole: ClassVar[bool] = False

    def steps(self, count: int) -> list[tuple[str, int]]:
        """The keys that lead to each of so many operands from the mapping that holds the form."""
        own = len(self.operands)
        return [(self.key, i) if i < own else (str(self.companion), i - own) for i in range(count)]

    def holding(self, count: int) -> list[Condition]:
        """The conditions that concern the first so many operands."""
        return [one for one in self.conditions if max(one.greater, one.less or 0) < count]

    def bounds(self, operands: Sequence[Interval]) -> Interval:
        """The least and the greatest number that can be drawn, by the bounds of each operand."""
        return operands[0][0], operands[len(self.operands) - 1][1]

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Numbers (B, n).

        Args:
            units: gives numbers (B, n) in [0, 1) of a lane of words; each lane is independent of the others.
            operands: each (B, n).
        """
        raise NotImplementedError


class Uniform(Distribution):
    """`uniform: [low, high]`."""

    key = "uniform"
    description = "[low, high]: numbers or vectors; each component is drawn by itself."

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Numbers (B, n)."""
        low, high = operands
        return (low + (high - low) * units(0)).clip(low, high)


class Integers(Distribution):
    """`integers: [low, high]`, both ends included."""

    key = "integers"
    description = "[low, high]: whole numbers, both ends included."
    whole = True

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Integers (B, n)."""
        import numpy as np

        low, high = (bound.astype(np.int64) for bound in operands)
        count = (high - low + 1).astype(np.float64)
        return np.minimum(low + np.floor(units(0) * count).astype(np.int64), high)


class LogUniform(Distribution):
    """`log_uniform: [low, high]`: the logarithm is uniform."""

    key = "log_uniform"
    description = "[low, high]: the logarithm is uniform."
    conditions = (
        *Distribution.conditions,
        Condition("the lower bound is not positive", 0, strict=True, because=" for its logarithm to be drawn"),
        Condition("the upper bound is not positive", 1, strict=True, because=" for its logarithm to be drawn"),
    )

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Numbers (B, n)."""
        from scenecc.geometry.rotation_arrays import map_elements

        low, high = operands
        first, last = map_elements(math.log, low), map_elements(math.log, high)
        return map_elements(math.exp, first + (last - first) * units(0)).clip(low, high)


class Normal(Distribution):
    """`normal: [mean, std]`; what lies outside of `clip: [low, high]` is put on its edge."""

    key = "normal"
    operands = ("mean", "std")
    roles = ("mean", "deviation")
    companion = "clip"
    description = "[mean, std]: needs `clip` where the value has a range."
    companion_description = "[low, high]: what a normal draw stays within."
    listed = "mean, std and clip"
    conditions = (
        Condition("the standard deviation is negative", 1),
        Condition("the lower edge of `clip` is above the upper one", 3, 2),
    )
    within_operands = False

    def bounds(self, operands: Sequence[Interval]) -> Interval:
        """Without a deviation the mean; a mean outside of `clip` is put on its edge."""
        (least, most), (_, deviation), *clip = operands
        low, high = (least, most) if deviation == 0 else (-math.inf, math.inf)
        if clip:
            bottom, top = clip
            low, high = min(max(low, bottom[0]), top[1]), max(min(high, top[1]), bottom[0])
        return low, high

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Numbers (B, n), by the cosine half of Box and Muller's transform (1958)."""
        import numpy as np

        from scenecc.geometry.rotation_arrays import map_elements

        mean, deviation, *clip = operands
        first, second = units(0), units(1)
        normal = np.sqrt(-2.0 * map_elements(math.log, 1.0 - first)) * map_elements(math.cos, 2.0 * math.pi * second)
        values = mean + deviation * normal
        return values.clip(*clip) if clip else values


DISTRIBUTIONS: Final[dict[str, Distribution]] = {cls.key: cls() for cls in (Uniform, Integers, LogUniform, Normal)}
"""Every form that draws numbers, by its key."""
