"""What may stand in place of a value in a scene file: the forms of variation, as they are written.

Items, bounds and components are plain values, or forms or templates themselves.
"""

from __future__ import annotations

from enum import Enum
from typing import Any, Final

from scenecc.diagnostics.frozen import frozen
from scenecc.variation.template import Template


class Missing(Enum):
    """The type of `MISSING`."""

    MISSING = "missing"


MISSING: Final = Missing.MISSING
"""No default."""


@frozen
class PerScene:
    """`per_scene: [a, b]`: one value for each scene that the entity is in, by ascending index."""

    items: tuple[Any, ...]


@frozen
class SceneMap:
    """`per_scene: {0: a, 3: b, default: c}`: (scene index, value), in the order written, each index once."""

    items: tuple[tuple[int, Any], ...]
    default: Any = MISSING


@frozen
class Cycle:
    """`cycle: [a, b]`: by scene index modulo the length."""

    items: tuple[Any, ...]


@frozen
class Choice:
    """`choice: [a, b], weights: [1, 2]`: one of them, drawn; all alike likely without weights."""

    items: tuple[Any, ...]
    weights: tuple[float, ...] | None = None


@frozen
class Uniform:
    """`uniform: [low, high]`: drawn, each component of a vector by itself."""

    low: Any
    high: Any


@frozen
class Integers:
    """`integers: [low, high]`: drawn, both ends included."""

    low: Any
    high: Any


@frozen
class LogUniform:
    """`log_uniform: [low, high]`: drawn, the logarithm being uniform; both bounds positive."""

    low: Any
    high: Any


@frozen
class Normal:
    """`normal: [mean, std], clip: [low, high]`: drawn; what lies outside `clip` is put on its edge."""

    mean: Any
    std: Any
    clip: tuple[Any, Any] | None = None


@frozen
class RandomRotation:
    """`q: uniform`: drawn, even over all rotations."""


@frozen
class Vector:
    """A list some of whose components vary."""

    items: tuple[Any, ...]


LIST_FORMS: Final[dict[str, type[Any]]] = {"per_scene": PerScene, "cycle": Cycle, "choice": Choice}
"""Keys of the forms that list the values of which each scene has one. (`per_scene` may be a map, too: `SceneMap`.)"""

DISTRIBUTIONS: Final[dict[str, type[Any]]] = {
    "uniform": Uniform,
    "integers": Integers,
    "log_uniform": LogUniform,
    "normal": Normal,
}
"""Keys of the forms that draw numbers; the nodes that draw them have these for their kinds."""

Form = PerScene | SceneMap | Cycle | Choice | Uniform | Integers | LogUniform | Normal | RandomRotation | Vector
Varying = Form | Template
