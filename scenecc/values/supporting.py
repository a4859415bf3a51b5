"""The support of each kind of node: its alternatives where its sources are few, otherwise its bounds."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.values.enumerating import FEW, MANY, alternatives, outcomes
from scenecc.values.intervals import Fault, reach
from scenecc.values.nodes import (
    NODE_TYPES,
    Chosen,
    Composed,
    Computed,
    Const,
    Cycled,
    Drawn,
    FromAxisAngle,
    FromMatrix,
    FromRpy,
    Looking,
    Node,
    Normalized,
    Posed,
    Radians,
    RandomRotated,
    Rows,
    Shared,
    Stacked,
)
from scenecc.values.order import needed
from scenecc.values.reach import Reach, known, reach_of, support_of
from scenecc.values.support import UNKNOWN, Support, union

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from scenecc.values.template import Template

_TURN = Support(None, (-1.0,) * 4, (1.0,) * 4, exact=False)
"""A quaternion that is not looked into."""

_DIRECT = frozenset((Const, Rows, Cycled, Chosen, Drawn, RandomRotated, Shared))
"""Nodes whose support is that of their items."""

_NUMBERS = frozenset((float, int))


MOST_COMBINATIONS = 1_000_000
"""How many combinations are looked at for all expressions of a document whose names have to be known."""


class Reader:
    """Finds supports, those of shared draws once."""

    def __init__(self, draws: Mapping[str, Node], given: Mapping[str, NDArray[Any]], num_scenes: int | None) -> None:
        self.draws = draws
        self.given = given
        self.num_scenes = num_scenes
        self._shared: dict[str, Support] = {}
        self._reached: dict[str, Reach] = {}
        self._outcomes: dict[tuple[Node, int], tuple[list[Any] | None, tuple[int, ...]]] = {}
        self._left = MOST_COMBINATIONS
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
            rows = alternatives(node, self.draws, self.given, self.num_scenes)
            if rows is not None:
                return Support.of(rows)
        return _TABLE[node.__class__](self, node)

    def outcomes(self, node: Node, scenes: tuple[int, ...]) -> list[Any] | None:
        """What a node gives in some scenes, in every combination of what it reads; None where these are too many.

        Raises:
            DrawError: it has no value in one of them.
        """
        key = node, id(scenes)
        if key not in self._outcomes:
            # Of the scenes alone every one is looked at, however little is left.
            most = max(min(MANY, self._left), FEW + 1)
            self._left -= most
            rows = outcomes(node, self.draws, self.given, self.num_scenes, scenes=scenes, most=most)
            self._left += most - min(len(rows or ()), most)
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


def _chosen(reader: Reader, node: Chosen) -> Support:
    weights = node.weights or (1.0,) * len(node.items)
    return reader.any_of(tuple(item for item, weight in zip(node.items, weights, strict=True) if weight > 0))


def _drawn(reader: Reader, node: Drawn) -> Support:
    if node.kind in _BETWEEN:
        # Of most draws both bounds are plain: this is what the rest makes of them, sooner.
        low, high = _plain_bound(node.low, node.shape), _plain_bound(node.high, node.shape)
        if low is not None and high is not None and low != high:
            return Support(None, low, high, exact=True)
    first, second = _vector(reader.item(node.low), node.shape), _vector(reader.item(node.high), node.shape)
    if first.low is None or second.low is None:
        return UNKNOWN
    exact = first.exact and second.exact
    if node.kind == "normal":
        return _normal(reader, node, first, second)
    if node.kind == "integers" and not node.shape and exact and second.high - first.low < FEW:
        low, high = _whole(first.low), _whole(second.high)
        if low is not None and high is not None and low <= high:
            return Support.of(range(low, high + 1))
    if first.low == second.high:
        return Support.of((first.low,), exact=exact)
    return Support(None, first.low, second.high, exact)


def _normal(reader: Reader, node: Drawn, mean: Support, std: Support) -> Support:
    exact = mean.exact and std.exact
    low = _each(lambda m, s: m if s == 0 else -math.inf, mean.low, std.high)
    high = _each(lambda m, s: m if s == 0 else math.inf, mean.high, std.high)
    if node.clip is not None:
        bottom, top = (_vector(reader.item(bound), node.shape) for bound in node.clip)
        if bottom.low is None or top.low is None:
            return UNKNOWN
        low, high = _each(max, low, bottom.low), _each(min, high, top.high)
        # A mean that is outside with no deviation is put on the edge.
        low, high = _each(min, low, top.high), _each(max, high, bottom.low)
        exact = exact and bottom.exact and top.exact
    return Support(None, low, high, exact)


def _stacked(reader: Reader, node: Stacked) -> Support:
    return _beside(list(map(reader.item, node.items)))


def _beside(parts: list[Support]) -> Support:
    if any(part.low is None for part in parts):
        return UNKNOWN
    low, high = tuple(part.low for part in parts), tuple(part.high for part in parts)
    return Support(None, low, high, all(part.exact for part in parts))


def _computed(reader: Reader, node: Computed) -> Support:
    return support_of(reach(node.template, _names(reader, node)))


def reach_and_faults(reader: Reader, node: Computed) -> tuple[Reach, list[Fault]]:
    """What an expression can give by the bounds of what it reads, and why it may have no value."""
    faults: list[Fault] = []
    return reach(node.template, _names(reader, node), faults), faults


def _names(reader: Reader, node: Computed) -> dict[str, Reach]:
    """What the names in an expression can be."""
    reads = dict(node.reads)
    names: dict[str, Reach] = {}
    for name in node.template.names:
        if name == "scene":
            most = math.inf if reader.num_scenes is None else reader.num_scenes - 1
            names[name] = Reach(low=0, high=most, exact=reader.num_scenes is not None, whole=True)
        elif name == "num_scenes":
            names[name] = (
                Reach(low=1, high=math.inf, whole=True) if reader.num_scenes is None else known((reader.num_scenes,))
            )
        else:
            names[name] = reader.reached(reads.get(name, name))
    return names


def _is_whole(node: Node | None) -> bool:
    """Whether what a draw gives are integers in any case."""
    return isinstance(node, Drawn) and node.kind == "integers"


def _turned(_reader: Reader, _node: Node) -> Support:
    return _TURN


def _posed(reader: Reader, node: Posed) -> Support:
    p, q = _shaped(reader.item(node.p), (3,)), _shaped(reader.item(node.q), (4,))
    if p.low is None or q.low is None:
        return UNKNOWN
    return Support(None, (*p.low, *q.low), (*p.high, *q.high), p.exact and q.exact)


def _radians(reader: Reader, node: Radians) -> Support:
    found = reader.item(node.degrees)
    if found.low is None:
        return UNKNOWN
    low, high = (_each(lambda d, _: math.radians(d), bound, bound) for bound in (found.low, found.high))
    return Support(None, low, high, found.exact)


def _from_matrix(reader: Reader, node: FromMatrix) -> Support:
    found = _shaped(reader.item(node.matrix), (4, 4))
    if found.low is None:
        return UNKNOWN
    low, high = (tuple(row[3] for row in bound[:3]) for bound in (found.low, found.high))
    return Support(None, (*low, *_TURN.low), (*high, *_TURN.high), exact=False)


def _composed(reader: Reader, node: Composed) -> Support:
    outer, inner = _shaped(reader.item(node.outer), (7,)), _shaped(reader.item(node.inner), (7,))
    if outer.low is None or inner.low is None:
        return UNKNOWN
    if outer.low[3:] == outer.high[3:] == (1.0, 0.0, 0.0, 0.0):
        low = tuple(a + b for a, b in zip(outer.low[:3], inner.low[:3], strict=True))
        high = tuple(a + b for a, b in zip(outer.high[:3], inner.high[:3], strict=True))
        turn = (inner.low[3:], inner.high[3:])
        return Support(None, (*low, *turn[0]), (*high, *turn[1]), exact=outer.exact and inner.exact)
    # However it is turned, it is within its own distance of where the outer one is.
    far = math.hypot(*(max(abs(a), abs(b)) for a, b in zip(inner.low[:3], inner.high[:3], strict=True)))
    low, high = tuple(a - far for a in outer.low[:3]), tuple(a + far for a in outer.high[:3])
    return Support(None, (*low, *_TURN.low), (*high, *_TURN.high), exact=False)


_BETWEEN = frozenset(("uniform", "log_uniform"))


def _plain_bound(item: Any, shape: tuple[int, ...]) -> Any:
    """A bound that does not vary, for every component; None for any other."""
    if item.__class__ in _NUMBERS:
        return (item,) * shape[0] if shape else item
    fits = item.__class__ is tuple and shape == (len(item),) and _NUMBERS.issuperset(map(type, item))
    return item if fits else None


def _vector(found: Support, shape: tuple[int, ...]) -> Support:
    """A bound of one number as that of every component."""
    if not shape or found.low is None or found.low.__class__ is tuple:
        return _shaped(found, shape)
    return Support(None, (found.low,) * shape[0], (found.high,) * shape[0], found.exact)


def _shaped(found: Support, shape: tuple[int, ...]) -> Support:
    """The same, where it is of that shape. An expression may give anything, which is reported as it is drawn."""
    return found if found.low is None or _has_shape(found.low, shape) else UNKNOWN


def _has_shape(bound: Any, shape: tuple[int, ...]) -> bool:
    if not shape or bound.__class__ is not tuple:
        return not shape and bound.__class__ is not tuple
    return len(bound) == shape[0] and all(_has_shape(item, shape[1:]) for item in bound)


def _each(function: Callable[[Any, Any], Any], a: Any, b: Any) -> Any:
    if a.__class__ is tuple:
        return tuple(_each(function, x, y) for x, y in zip(a, b, strict=True))
    return function(a, b)


def _whole(number: float) -> int | None:
    return int(number) if math.isfinite(number) and number == int(number) else None


_TABLE: dict[type[Any], Callable[[Reader, Any], Support]] = {
    Const: lambda reader, node: reader.item(node.data),
    Rows: lambda reader, node: reader.any_of(node.items),
    Cycled: lambda reader, node: reader.any_of(node.items),
    Chosen: _chosen,
    Drawn: _drawn,
    RandomRotated: lambda _reader, _node: Support(None, (-1.0,) * 4, (1.0,) * 4, exact=True),
    Stacked: _stacked,
    Computed: _computed,
    Shared: lambda reader, node: reader.shared(node.name),
    Posed: _posed,
    Normalized: _turned,
    FromRpy: _turned,
    FromAxisAngle: _turned,
    FromMatrix: _from_matrix,
    Looking: _turned,
    Radians: _radians,
    Composed: _composed,
}
