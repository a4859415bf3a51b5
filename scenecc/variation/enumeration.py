"""All values of a node whose sources are few: it is evaluated once for each combination of what they can give.

What two parts of a node read in common is then the same in both, which bounds of the parts cannot know.
"""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any

from scenecc.variation import nodes
from scenecc.variation.nodes import NODE_FIELDS, NODES, Key, Node

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from scenecc.variation.evaluation import CombinationBatch
    from scenecc.variation.node_bounds import BoundsAnalysis
    from scenecc.variation.operations import OperationCounter

MAX_COMBINATIONS = 64
"""How many combinations are looked at."""

MAX_OUTCOMES = 10_000
"""How many are where all have to be known: the names that an expression gives. Of what reads no draw but `scene`,
every scene is looked at."""

MAX_DRAWS_READ = 16
"""How many shared draws are looked into, or else each member of a long chain of them would look into all others."""

_MAX_ORDERED = 7
"""How many values have orders that may be few: 5040 are below `MAX_OUTCOMES`."""

DrawWord = tuple[Key, int]
"""What one draw is known by: its key and word."""


def enumerate_outcomes(
    node: Node,
    analysis: BoundsAnalysis,
    *,
    scenes: tuple[int, ...] | None = None,
    most: int = MAX_COMBINATIONS,
    work: OperationCounter | None = None,
) -> list[Any] | None:
    """What a node gives in each combination of what it reads; None where these are more than `most`, or not known.

    Args:
        node: whatever reads draws.
        analysis: knows the shared draws, those that are given, and how many scenes there are.
        scenes: the only scenes that count; None: all.
        most: how many combinations are looked at.
        work: counts what is computed; None: nothing does.

    Raises:
        DrawError: it has no value in one of them; what is drawn there need not be what the scene draws.
    """
    batch = combination_batch((node,), analysis, scenes=scenes, most=most, work=work)
    return None if batch is None else batch.evaluate(node).tolist()


def combination_batch(
    items: tuple[Any, ...],
    analysis: BoundsAnalysis,
    *,
    scenes: tuple[int, ...] | None,
    most: int,
    work: OperationCounter | None,
) -> CombinationBatch | None:
    """A row for each combination of what several items read; arguments and limits are those of `enumerate_outcomes`."""
    sources = _Sources(analysis, scenes, most)
    combined = sources.combined() if all(map(sources.add, items)) else None
    if combined is None:
        return None
    import numpy as np  # noqa: PLC0415 - most bounds need no array

    from scenecc.variation.evaluation import CombinationBatch  # noqa: PLC0415 - likewise

    columns = np.array(list(product(combined, *sources.drawn.values())), dtype=np.int64).T
    assigned = dict(zip(sources.drawn, columns[1:], strict=True))
    return CombinationBatch(columns[0], analysis.num_scenes or 1, analysis.draws, analysis.given, assigned, work)


_MAX_NODES = 500
"""How many nodes are looked through: a chain of poses has them all again at each of its members."""


class _Sources:
    """What decides a node's value.

    Attributes:
        drawn: the draws, with the numbers of the values that each can give.
        period: after how many scenes the cycles begin anew.
        scenes: the only scenes in which it has a value, where these are listed.
    """

    def __init__(self, analysis: BoundsAnalysis, only: tuple[int, ...] | None, most: int) -> None:
        self.drawn: dict[DrawWord, Sequence[int]] = {}
        self.period = 1
        self.scenes: set[int] | None = None
        self._only = only
        self._most = most
        self._longest = most if most <= MAX_COMBINATIONS else max(most, analysis.num_scenes or 0)
        self._analysis = analysis
        self._seen: set[str] = set()
        self._todo: list[Any] = []

    def add(self, item: Any) -> bool:
        """Adds the sources of an item; whether they may be few."""
        self._todo.append(item)
        looked_at = 0
        while self._todo:
            item = self._todo.pop()
            add = _ADD_SOURCES.get(item.__class__)
            if add is None:
                continue
            looked_at += 1
            if looked_at > _MAX_NODES or not add(self, item):
                return False
        return True

    def combined(self) -> list[int] | None:
        """The scenes that are combined with what is drawn; None where there are none or too many."""
        if self.scenes is not None:
            scenes = sorted(self.scenes if self._only is None else self.scenes.intersection(self._only))
        elif self._only is None:
            scenes = list(range(self.period))
        else:
            # The first one for each place in the cycles.
            first: dict[int, int] = {}
            for scene in self._only:
                first.setdefault(scene % self.period, scene)
            scenes = list(first.values())
        count = len(scenes) * math.prod(map(len, self.drawn.values()))
        return scenes if 0 < count <= self._most or (count and self._is_by_scene()) else None

    def _is_by_scene(self) -> bool:
        """Whether the scene's index decides alone, so that there are no more combinations than scenes."""
        return not self.drawn and self._most > MAX_COMBINATIONS

    def add_all(self, items: tuple[Any, ...]) -> bool:
        self._todo += items
        return len(items) <= self._longest

    def parts(self, node: Any) -> bool:
        return self.add_all(tuple(getattr(node, name) for name in NODE_FIELDS[node.__class__]))

    def chosen(self, node: nodes.Chosen) -> bool:
        if len(node.items) > self._longest:
            return False
        self.drawn[node.key, node.word] = node.possible
        return self.add_all(node.items)

    def shuffled(self, node: nodes.Shuffled) -> bool:
        """Adds every order of a short list."""
        if len(node.items) > _MAX_ORDERED:
            return False
        self.drawn[node.key, node.word] = range(math.factorial(len(node.items)))
        return True

    def drawn_integers(self, node: nodes.Drawn) -> bool:
        if not node.distribution.whole or node.shape:
            return False
        low, high = node.operands
        if not (type(low) is int and type(high) is int):
            return False
        self.drawn[node.key, node.word] = range(high - low + 1)
        return 0 <= high - low < self._most

    def cycled(self, node: nodes.Cycled) -> bool:
        self.period = math.lcm(self.period, len(node.items))
        return self.period <= self._longest and self.add_all(node.items)

    def rows(self, node: nodes.Rows) -> bool:
        self._restrict(node.scene_idxs)
        return self.add_all(node.items)

    def shared(self, node: nodes.Shared) -> bool:
        """A draw that others read counts once. Whether the draws are still few enough to enumerate."""
        if node.name in self._seen:
            return True
        self._seen.add(node.name)
        given = self._analysis.given.get(node.name)
        if given is not None:
            self._restrict(range(len(given)))
        else:
            self._todo.append(self._analysis.draws[node.name])
        return len(self._seen) <= MAX_DRAWS_READ

    def computed(self, node: nodes.Computed) -> bool:
        """Adds what an expression reads: draws, and the scene's index where it names that."""
        names, num_scenes = node.template.names, self._analysis.num_scenes
        if "num_scenes" in names and num_scenes is None:
            return False
        if "scene" in names:
            scenes = self._only or range(num_scenes or 0)
            if num_scenes is None or len(scenes) > self._longest:
                return False
            self._restrict(scenes)
        return self.add_all(tuple(map(nodes.Shared, node.draws_by_name.values())))

    def _restrict(self, scenes: Iterable[int]) -> None:
        self.scenes = set(scenes) if self.scenes is None else self.scenes & set(scenes)


_ADD_SOURCES: dict[type[Any], Callable[[_Sources, Any], bool]] = {
    **dict.fromkeys(NODES, _Sources.parts),
    nodes.Chosen: _Sources.chosen,
    nodes.Shuffled: _Sources.shuffled,
    nodes.Drawn: _Sources.drawn_integers,
    nodes.RandomRotated: lambda _sources, _node: False,
    nodes.Placed: lambda _sources, _node: False,
    nodes.Stacked: lambda sources, node: sources.add_all(node.items),
    nodes.Cycled: _Sources.cycled,
    nodes.Rows: _Sources.rows,
    nodes.Shared: _Sources.shared,
    nodes.Computed: _Sources.computed,
}
"""How each node adds its sources; most are simply made of their parts."""
