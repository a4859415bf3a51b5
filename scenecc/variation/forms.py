"""What may stand in place of a value in a scene file: the forms of variation, as they are written.

Items, bounds and components are plain values, or forms or templates themselves.
"""

from __future__ import annotations

from enum import Enum
from typing import Any, Final

from scenecc.diagnostics.frozen import frozen
from scenecc.variation.distributions import DISTRIBUTIONS
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
class DrawForm:
    """Numbers that a distribution draws: `uniform: [low, high]` and its like.

    Attributes:
        kind: the form's key, one of `DISTRIBUTIONS`.
        operands: the numbers of its list, and the edges of the key beside it, where that is there.
    """

    kind: str
    operands: tuple[Any, ...]


@frozen
class RandomRotation:
    """`q: uniform`: drawn, even over all rotations."""


@frozen
class Vector:
    """A list some of whose components vary."""

    items: tuple[Any, ...]


LIST_FORMS: Final[dict[str, type[Any]]] = {"per_scene": PerScene, "cycle": Cycle, "choice": Choice}
"""Keys of the forms that list the values of which each scene has one. (`per_scene` may be a map, too: `SceneMap`.)"""

FORM_KEYS: Final = frozenset((*LIST_FORMS, *DISTRIBUTIONS))
"""Keys of the mappings that give another value in each scene; others stand beside some of them."""

Form = PerScene | SceneMap | Cycle | Choice | DrawForm | RandomRotation | Vector
Varying = Form | Template
