"""All values of a node whose sources are few: it is evaluated once for each combination of what they can give.

What two parts of a node read in common is then the same in both, which bounds of the parts cannot know.
"""

from __future__ import annotations

import math
from dataclasses import fields
from itertools import product
from typing import TYPE_CHECKING, Any

from scenecc.values.failure import DrawError
from scenecc.values.nodes import NODES, Chosen, Computed, Cycled, Drawn, Key, Node, RandomRotated, Rows, Shared, Stacked
from scenecc.values.order import BUILT_IN

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from numpy.typing import NDArray

FEW = 64
"""How many combinations are looked at."""

LONGEST = 16
"""How many shared draws are looked into, or else each member of a long chain of them would look into all others."""

Draw = tuple[Key, int]
"""What one draw is known by: its key and word."""


def alternatives(
    node: Node, draws: Mapping[str, Node], given: Mapping[str, NDArray[Any]], num_scenes: int | None
) -> list[Any] | None:
    """All that a node can give; None where that is not known to be few, or there is none in some combination."""
    sources = _Sources(draws, given, num_scenes)
    if not sources.add(node):
        return None
    scenes = range(sources.period) if sources.scenes is None else sorted(sources.scenes)
    if not 0 < len(scenes) * math.prod(sources.drawn.values()) <= FEW:
        return None
    import numpy as np  # noqa: PLC0415 - most supports need no array

    from scenecc.values.assigned import Assigned  # noqa: PLC0415 - likewise

    combinations = list(product(scenes, *(range(count) for count in sources.drawn.values())))
    columns = np.array(combinations, dtype=np.int64).T
    assigned = dict(zip(sources.drawn, columns[1:], strict=True))
    try:
        return Assigned(columns[0], num_scenes or 1, draws, given, assigned).evaluate(node).tolist()
    except DrawError:
        return None


class _Sources:
    """What decides a node's value.

    Attributes:
        drawn: the draws, with how many values each can give.
        period: after how many scenes the cycles begin anew.
        scenes: the only scenes in which it has a value, where these are listed.
    """

    def __init__(self, draws: Mapping[str, Node], given: Mapping[str, NDArray[Any]], num_scenes: int | None) -> None:
        self.drawn: dict[Draw, int] = {}
        self.period = 1
        self.scenes: set[int] | None = None
        self._draws = draws
        self._given = given
        self._num_scenes = num_scenes
        self._seen: set[str] = set()
        self._todo: list[Any] = []

    def add(self, item: Any) -> bool:
        """Adds the sources of an item; whether they may be few."""
        self._todo.append(item)
        while self._todo:
            item = self._todo.pop()
            add = _TABLE.get(item.__class__)
            if add is not None and not add(self, item):
                return False
        return True

    def add_all(self, items: tuple[Any, ...]) -> bool:
        self._todo += items
        return len(items) <= FEW

    def parts(self, node: Any) -> bool:
        return self.add_all(tuple(getattr(node, name) for name in _FIELDS[node.__class__]))

    def chosen(self, node: Chosen) -> bool:
        self.drawn[node.key, node.word] = len(node.items)
        return (node.weights is None or all(node.weights)) and self.add_all(node.items)

    def drawn_integers(self, node: Drawn) -> bool:
        low, high = node.low, node.high
        if node.kind != "integers" or node.shape or not (type(low) is int and type(high) is int):
            return False
        self.drawn[node.key, node.word] = high - low + 1
        return 0 <= high - low < FEW

    def cycled(self, node: Cycled) -> bool:
        self.period = math.lcm(self.period, len(node.items))
        return self.period <= FEW and self.add_all(node.items)

    def rows(self, node: Rows) -> bool:
        self._restrict(node.scene_idxs)
        return self.add_all(node.items)

    def shared(self, node: Shared) -> bool:
        if node.name in self._seen:
            return True
        self._seen.add(node.name)
        if node.name in self._given:
            self._restrict(range(len(self._given[node.name])))
        else:
            self._todo.append(self._draws[node.name])
        return len(self._seen) <= LONGEST

    def computed(self, node: Computed) -> bool:
        names, reads = node.template.names, dict(node.reads)
        if "num_scenes" in names and self._num_scenes is None:
            return False
        if "scene" in names:
            if self._num_scenes is None or self._num_scenes > FEW:
                return False
            self._restrict(range(self._num_scenes))
        return self.add_all(tuple(Shared(reads.get(name, name)) for name in sorted(names - BUILT_IN)))

    def _restrict(self, scenes: Iterable[int]) -> None:
        self.scenes = set(scenes) if self.scenes is None else self.scenes & set(scenes)


_FIELDS = {kind: tuple(field.name for field in fields(kind)) for kind in NODES}

_TABLE: dict[type[Any], Callable[[_Sources, Any], bool]] = {
    **dict.fromkeys(NODES, _Sources.parts),
    Chosen: _Sources.chosen,
    Drawn: _Sources.drawn_integers,
    RandomRotated: lambda _sources, _node: False,
    Stacked: lambda sources, node: sources.add_all(node.items),
    Cycled: _Sources.cycled,
    Rows: _Sources.rows,
    Shared: _Sources.shared,
    Computed: _Sources.computed,
}
"""How each node adds its sources; most are simply made of their parts."""
