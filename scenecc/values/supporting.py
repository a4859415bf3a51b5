"""Finding the supports of nodes: their alternatives where their sources are few, otherwise their bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.values.enumerating import MANY, alternatives, outcomes
from scenecc.values.nodes import NODE_TYPES, Chosen, Computed, Const, Cycled, Drawn, Node, RandomRotated, Rows, Shared
from scenecc.values.order import needed
from scenecc.values.reach import Reach, reach_of
from scenecc.values.support import Support, union
from scenecc.values.support_rules import TABLE
from scenecc.values.work import NAME

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from scenecc.values.template import Template
    from scenecc.values.work import Work

_DIRECT = frozenset((Const, Rows, Cycled, Chosen, Drawn, RandomRotated, Shared))
"""Nodes whose support is that of their items."""


def support(
    node: Node,
    draws: Mapping[str, Node],
    *,
    given: Mapping[str, NDArray[Any]] | None = None,
    num_scenes: int | None = None,
) -> Support:
    """Everything that a node can give.

    Args:
        node: whatever reads draws.
        draws: the shared draws by name.
        given: values (N, …) that take the place of draws.
        num_scenes: how many scenes there are, where that is known.
    """
    return Reader(draws, given or {}, num_scenes).support(node)


class Reader:
    """Finds supports, those of shared draws once."""

    def __init__(
        self,
        draws: Mapping[str, Node],
        given: Mapping[str, NDArray[Any]],
        num_scenes: int | None,
        work: Work | None = None,
    ) -> None:
        self.draws = draws
        self.given = given
        self.num_scenes = num_scenes
        self.work = work
        self._shared: dict[str, Support] = {}
        self._reached: dict[str, Reach] = {}
        self._outcomes: dict[tuple[Node, int], tuple[list[Any] | None, tuple[int, ...]]] = {}
        self._computed: dict[tuple[Any, ...], tuple[Template, Support]] = {}

    def support(self, node: Node) -> Support:
        """Everything that a node can give."""
        if not isinstance(node, Computed):
            return self._found(node)
        # Many fields have one expression, which is one object: as many as read a shared draw. It is kept with its id.
        key = (id(node.template), node.shape, node.reads)
        known = self._computed.get(key)
        if known is None:
            known = self._computed[key] = node.template, self._found(node)
        return known[1]

    def _found(self, node: Node) -> Support:
        if node.__class__ not in _DIRECT:
            rows = alternatives(node, self.draws, self.given, self.num_scenes, self.work)
            if rows is not None:
                return Support.of(rows)
        return TABLE[node.__class__](self, node)

    def outcomes(self, node: Node, scenes: tuple[int, ...]) -> list[Any] | None:
        """What a node gives in some scenes, in every combination of what it reads; None where these are too many.

        Raises:
            DrawError: it has no value in one of them.
        """
        key = node, id(scenes)
        if key not in self._outcomes:
            rows = outcomes(node, self.draws, self.given, self.num_scenes, scenes=scenes, most=MANY, work=self.work)
            if self.work is not None:
                self.work.take(NAME * len(rows or ()), node)
            # The scenes are kept, so that their id stays their own.
            self._outcomes[key] = rows, scenes
        return self._outcomes[key][0]

    def item(self, item: Any) -> Support:
        """As `support`, of a plain value too."""
        return self.support(item) if item.__class__ in NODE_TYPES else Support.of((item,))

    def shared(self, name: str) -> Support:
        """The support of a shared draw."""
        if not self._is_known(name):
            for other in needed(name, self.draws, self._is_known):
                self._shared[other] = self.support(self.draws[other])
        return self._shared[name]

    def reached(self, name: str) -> Reach:
        """The same, as expressions read it: once, for there may be very many alternatives and expressions."""
        found = self._reached.get(name)
        if found is None:
            found = reach_of(self.shared(name), whole=_is_whole(self.draws.get(name)))
            self._reached[name] = found
        return found

    def _is_known(self, name: str) -> bool:
        if name not in self._shared and name in self.given:
            self._shared[name] = Support.of_rows(self.given[name])
        return name in self._shared

    def any_of(self, items: tuple[Any, ...]) -> Support:
        """Of items of which each scene has one."""
        if any(item.__class__ in NODE_TYPES for item in items):
            return union(map(self.item, items))
        return Support.of(items)


def _is_whole(node: Node | None) -> bool:
    """Whether what a draw gives are integers in any case."""
    return isinstance(node, Drawn) and node.kind == "integers"
