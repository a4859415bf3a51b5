"""The distributions, one class each: syntax, validation, bounds and sampling.

A new distribution is one class and one entry of `DISTRIBUTIONS`. The scene reader, the JSON Schema, the parameter
ranges, the plan's JSON, the bounds of values and the generator all use these.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotation_arrays import Floats

    Interval = tuple[float, float]

Role = Literal["value", "mean", "deviation", "positive", "shape"]
"""Role of an operand: a field value, any number, a number >= 0, one > 0, or a shape parameter in `SHAPE_BOUNDS`."""

SHAPE_BOUNDS = (1e-3, 1e6)
"""Range of a beta distribution's parameters. Beyond it, float32 values are all at the ends or all equal."""

WIDEST_INTEGERS = 2**53
"""Most integers that one draw selects from: those that are exact in float64."""


@frozen
class OperandRule:
    """A rule for the operands: one is at least another, or at least or at most a limit.

    Attributes:
        message: if the rule is violated.
        greater: index of the greater operand; None: the limit.
        less: index of the other operand; None: the limit.
        limit: if only one operand is compared.
        strict: whether equality violates the rule.
        because: the reason, if a file violates it.
    """

    message: str
    greater: int | None
    less: int | None = None
    limit: float = 0.0
    strict: bool = False
    because: str = ""


class Distribution:
    """A form that draws numbers, independently for each component of a vector.

    Attributes:
        key: of the form.
        operands: the names of the numbers in its list.
        roles: role of each operand.
        members: their names in a plan's JSON.
        companion: key beside the form with two bounds, which follow the operands.
        needs_companion: whether the form requires it.
        description: of the list, for the JSON Schema.
        companion_description: of the companion.
        listed: all operands in words.
        conditions: rules for the operands that are present.
        between: indices of the operands that bound all drawn values; None: unbounded.
        whole: whether integers are drawn.
        cost: time of one draw, in draws of uniform numbers.
    """

    key: ClassVar[str]
    operands: ClassVar[tuple[str, ...]] = ("low", "high")
    roles: ClassVar[tuple[Role, ...]] = ("value", "value")
    members: ClassVar[tuple[str, ...]] = ("low", "high")
    companion: ClassVar[str | None] = None
    needs_companion: ClassVar[bool] = False
    description: ClassVar[str]
    companion_description: ClassVar[str] = ""
    listed: ClassVar[str] = "both bounds"
    conditions: ClassVar[tuple[OperandRule, ...]] = (OperandRule("the lower bound is above the upper one", 1, 0),)
    between: ClassVar[tuple[int, int] | None] = (0, 1)
    whole: ClassVar[bool] = False
    cost: ClassVar[int] = 1

    def steps(self, count: int) -> list[tuple[str, int]]:
        """The keys that lead from the form's mapping to each of `count` operands."""
        own = len(self.operands)
        return [(self.key, i) if i < own else (str(self.companion), i - own) for i in range(count)]

    def holding(self, count: int) -> list[OperandRule]:
        """The conditions for the first `count` operands."""
        return [one for one in self.conditions if max(one.greater or 0, one.less or 0) < count]

    def bounds(self, operands: Sequence[Interval]) -> Interval:
        """The bounds of the drawn number, from the bounds of each operand."""
        assert self.between is not None
        low, high = self.between
        return operands[low][0], operands[high][1]

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Draws numbers (B, n).

        Args:
            units: gives numbers (B, n) in [0, 1) from a lane of words; lanes are independent.
            operands: each (B, n).
        """
        raise NotImplementedError


class Uniform(Distribution):
    """`uniform: [low, high]`."""

    key = "uniform"
    description = "[low, high]: numbers or vectors; each component is drawn independently."

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Draws numbers (B, n)."""
        low, high = operands
        return (low + (high - low) * units(0)).clip(low, high)


class Integers(Distribution):
    """`integers: [low, high]`, both ends included."""

    key = "integers"
    description = "[low, high]: whole numbers, both ends included."
    whole = True

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Draws integers (B, n)."""
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
        OperandRule("the lower bound is not positive", 0, strict=True, because=" for its logarithm to be drawn"),
        OperandRule("the upper bound is not positive", 1, strict=True, because=" for its logarithm to be drawn"),
    )

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Draws numbers (B, n)."""
        from scenecc.geometry.rotation_arrays import map_elements

        low, high = operands
        first, last = map_elements(math.log, low), map_elements(math.log, high)
        return map_elements(math.exp, first + (last - first) * units(0)).clip(low, high)


class Normal(Distribution):
    """`normal: [mean, std]`; numbers outside of `clip: [low, high]` are clamped."""

    key = "normal"
    operands = ("mean", "std")
    roles = ("mean", "deviation")
    companion = "clip"
    description = "[mean, std]: needs `clip` where the value has a range."
    companion_description = "[low, high]: limits of a normal draw."
    listed = "mean, std and clip"
    conditions = (
        OperandRule("the standard deviation is negative", 1),
        OperandRule("the lower edge of `clip` is above the upper one", 3, 2),
    )
    between = None

    def bounds(self, operands: Sequence[Interval]) -> Interval:
        """The mean if the deviation is 0, clamped to `clip`; otherwise the bounds of `clip`."""
        (least, most), (_, deviation), *clip = operands
        low, high = (least, most) if deviation == 0 else (-math.inf, math.inf)
        if clip:
            bottom, top = clip
            low, high = min(max(low, bottom[0]), top[1]), max(min(high, top[1]), bottom[0])
        return low, high

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Draws numbers (B, n) by the cosine half of the Box-Muller transform (1958)."""
        import numpy as np

        from scenecc.geometry.rotation_arrays import map_elements

        mean, deviation, *clip = operands
        first, second = units(0), units(1)
        normal = np.sqrt(-2.0 * map_elements(math.log, 1.0 - first)) * map_elements(math.cos, 2.0 * math.pi * second)
        values = mean + deviation * normal
        return values.clip(*clip) if clip else values


class Triangular(Distribution):
    """`triangular: [low, mode, high]`: the density rises linearly to the mode and falls linearly from it."""

    key = "triangular"
    operands = ("low", "mode", "high")
    roles = ("value", "value", "value")
    members = ("low", "mode", "high")
    description = "[low, mode, high]: most often near the mode."
    listed = "low, mode and high"
    conditions = (
        OperandRule("the lower bound is above the mode", 1, 0),
        OperandRule("the mode is above the upper bound", 2, 1),
    )
    between = (0, 2)

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Draws numbers (B, n) by the inverse of the distribution function."""
        import numpy as np

        low, mode, high = operands
        u, width = units(0), high - low
        # Separate square roots: the product of two tiny numbers is 0.
        rising = low + np.sqrt(u * width) * np.sqrt(mode - low)
        falling = high - np.sqrt((1.0 - u) * width) * np.sqrt(high - mode)
        return np.where(u * width < mode - low, rising, falling).clip(low, high)


class _Ranged(Distribution):
    """A distribution limited to `range: [low, high]`."""

    companion = "range"
    needs_companion = True
    companion_description = "[low, high]: range of a `beta` or `truncated_normal` draw."
    between = (2, 3)

    edges_crossed: ClassVar[OperandRule] = OperandRule("the lower edge of `range` is above the upper one", 3, 2)


class Beta(_Ranged):
    """`beta: [a, b], range: [low, high]`: a beta distribution with shape parameters a and b, scaled to the range."""

    key = "beta"
    operands = ("a", "b")
    roles = ("shape", "shape")
    members = ("a", "b")
    description = "[a, b]: a beta distribution with these shape parameters over `range`."
    listed = "a, b and range"
    cost = 16
    conditions = (
        *(
            condition
            for i, name in enumerate(("a", "b"))
            for condition in (
                OperandRule(f"`{name}` is below {SHAPE_BOUNDS[0]:g}", i, limit=SHAPE_BOUNDS[0]),
                OperandRule(f"`{name}` is above {SHAPE_BOUNDS[1]:g}", None, i, limit=SHAPE_BOUNDS[1]),
            )
        ),
        _Ranged.edges_crossed,
    )

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Draws numbers (B, n) by the rejection method of R. Cheng, "Generating beta variates with nonintegral shape
        parameters" (1978), algorithm BA. Attempt t uses the lanes 2t and 2t + 1.
        """
        import numpy as np

        a, b, low, high = operands
        drawn = np.empty(a.shape)
        open_ = np.ones(a.shape, dtype=bool)
        attempt = 0
        while open_.any():
            first, second = units(2 * attempt), units(2 * attempt + 1)
            tries = zip(*(each[open_].tolist() for each in (a, b, first, second)), strict=True)
            drawn[open_] = [_cheng_attempt(*one) for one in tries]
            open_ = np.isnan(drawn)
            attempt += 1
        return (low + (high - low) * drawn).clip(low, high)


def _cheng_attempt(a: float, b: float, first: float, second: float) -> float:
    """One attempt to draw from a beta distribution over [0, 1]; NaN if rejected."""
    first, second = 1.0 - first, 1.0 - second  # above 0
    if first == 1.0:
        return math.nan
    total, least = a + b, min(a, b)
    scale = 1.0 / least if least <= 1.0 else math.sqrt((total - 2.0) / (2.0 * a * b - total))
    v = scale * math.log(first / (1.0 - first))
    # The logarithms of W = a exp(v) and of b + W: W itself may overflow.
    log_w, log_b = math.log(a) + v, math.log(b)
    log_sum = max(log_w, log_b) + math.log1p(math.exp(-abs(log_w - log_b)))
    taken = total * (math.log(total) - log_sum) + (a + 1.0 / scale) * v - math.log(4.0)
    return math.exp(log_w - log_sum) if taken >= math.log(first * first * second) else math.nan


class TruncatedNormal(_Ranged):
    """`truncated_normal: [mean, std], range: [low, high]`: a normal distribution, truncated to the range."""

    key = "truncated_normal"
    operands = ("mean", "std")
    roles = ("mean", "positive")
    members = ("mean", "std")
    description = "[mean, std]: a normal distribution truncated to `range`, without clamping."
    listed = "mean, std and range"
    cost = 5
    conditions = (OperandRule("the standard deviation is not positive", 1, strict=True), _Ranged.edges_crossed)

    def sample(self, units: Callable[[int], Floats], operands: Sequence[Floats]) -> NDArray[Any]:
        """Draws numbers (B, n) by the inverse of the distribution function."""
        from statistics import NormalDist

        import numpy as np

        inverse = NormalDist().inv_cdf
        columns = [each.ravel().tolist() for each in (*operands, units(0))]
        found = [_within_normal(m, s, a, b, u, inverse) for m, s, a, b, u in zip(*columns, strict=True)]
        mean, _, low, high = operands
        return np.array(found, dtype=np.float64).reshape(mean.shape).clip(low, high)


_FAR = 37.0
"""Standard deviations beyond which the tail probability of a normal distribution is below the normal floats."""

_NARROW = 1e-4
"""Width in standard deviations within which the log density is linear to one part in 10⁹."""


def _within_normal(
    mean: float, deviation: float, low: float, high: float, u: float, inverse: Callable[[float], float]
) -> float:
    """The number between two bounds at the quantile `u` of the probability between them.

    Far from the mean, where the probability underflows, and between close bounds, the density is approximated as
    exponential, with an error of one part in `_FAR`² and in 10⁹. `inverse`: that of the standard normal distribution
    function.
    """
    if low == high:
        return low
    # Any of these may be infinite.
    first, last, width = (low - mean) / deviation, (high - mean) / deviation, (high - low) / deviation
    if first > _FAR:
        return low + (high - low) * _exponential_share(first * width, u)
    if last < -_FAR:
        return high - (high - low) * _exponential_share(-last * width, 1.0 - u)
    if width < _NARROW:
        return low + (high - low) * _exponential_share(width * (first + last) / 2, u)
    side = -1.0 if first > 0 else 1.0  # numbers are exact in the lower tail
    if side < 0:
        first, last, u = -last, -first, 1.0 - u
    bottom, top = (0.5 * math.erfc(-bound / math.sqrt(2.0)) for bound in (first, last))
    share = bottom + u * (top - bottom)
    found = inverse(share) if 0.0 < share < 1.0 else (first if share <= 0.0 else last)
    return mean + deviation * side * found


def _exponential_share(rate: float, u: float) -> float:
    """The quantile `u` of an exponential density of this rate over [0, 1]."""
    if abs(rate) < 1e-9:
        return u
    return -math.log1p(min(u, 1.0 - 2.0**-53) * math.expm1(-rate)) / rate


DISTRIBUTIONS: Final[dict[str, Distribution]] = {
    cls.key: cls() for cls in (Uniform, Integers, LogUniform, Normal, Triangular, Beta, TruncatedNormal)
}
"""Every form that draws numbers, by its key."""
