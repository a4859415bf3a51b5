"""What varying values depend on, and how a reset redraws them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.plan.properties import FLOAT32_MAX
from scenecc.variation.nodes import AffineClamp, Node, Rows

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from numpy.typing import NDArray

    from scenecc.plan import Value


@dataclass(slots=True, eq=False)
class Variation:
    """What a value depends on.

    Attributes:
        drawn: whether it has draws of its own.
        computed: whether it has expressions.
        seeded: whether it contains drawn rows that a reset keeps.
        cycled: whether it has alternatives that no scene may use.
        risky: whether it may have no value or an out-of-range value in some scene.
        broken: whether an error was reported, so that it holds a placeholder.
        reads: shared draws that it reads by expressions or through `once`.
    """

    drawn: bool = False
    computed: bool = False
    seeded: bool = False
    cycled: bool = False
    risky: bool = False
    broken: bool = False
    reads: set[str] = field(default_factory=set[str])

    def join(self, other: Variation) -> None:
        """Merges the variation of another field that this value is computed from."""
        self.drawn |= other.drawn
        self.computed |= other.computed
        self.seeded |= other.seeded
        self.cycled |= other.cycled
        self.risky |= other.risky
        self.broken |= other.broken
        self.reads |= other.reads


@frozen
class MimicRelation:
    """The joint that a joint follows: its position is multiplier · source + offset. Both are fixed after the build."""

    source: ResettableValue
    multiplier: Value
    offset: Value


@frozen
class ResettableValue:
    """A velocity, a position of a joint or a target that may be redrawn.

    Attributes:
        scenes: scenes of its rows.
        limits: (·, 2) as built, to which the drawn value is clamped; None: no clamp.
        follows: the position that it is computed from; None: the node draws it.
    """

    value: Value
    node: Node
    variation: Variation
    scenes: tuple[int, ...]
    limits: Value | None = None
    follows: MimicRelation | None = None


def reset_node(reset: ResettableValue, limit_items: Callable[[Value, tuple[int, ...]], Iterable[Any]]) -> Node:
    """The recipe of a value, clamped to its limits.

    Args:
        reset: the value.
        limit_items: gives the lower and the upper limit in some scenes as items of a recipe.
    """
    node, scenes, follows = reset.node, reset.scenes, reset.follows
    if follows is not None:
        factor, offset = (_constant_item(value.data, scenes) for value in (follows.multiplier, follows.offset))
        node = AffineClamp(reset_node(follows.source, limit_items), -1, -FLOAT32_MAX, FLOAT32_MAX, factor, offset)
    if reset.limits is not None and isinstance(node, AffineClamp):
        low, high = limit_items(reset.limits, scenes)
        node = replace(node, low=low, high=high)
    return node


def built_limit_items(limits: Value, scenes: tuple[int, ...]) -> Iterator[Any]:
    """Limits that are fixed after the build, as items of a recipe."""
    return (_constant_item(side.clip(-FLOAT32_MAX, FLOAT32_MAX), scenes) for side in limits.data.T)


def drawn_limit_items(node: Node) -> Iterator[Any]:
    """Limits that a reset redraws, as items of a recipe."""
    return (AffineClamp(node, index, -FLOAT32_MAX, FLOAT32_MAX) for index in range(2))


def _constant_item(rows: NDArray[Any], scenes: tuple[int, ...]) -> Any:
    """Numbers (1,) or (B,) that a reset does not change, as an item of a recipe."""
    return Rows(scenes, tuple(rows.tolist())) if len(rows) > 1 else rows.item()
