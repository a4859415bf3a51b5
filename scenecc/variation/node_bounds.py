"""Possible values of nodes, without drawing: alternatives if their sources are few, otherwise bounds."""

from __future__ import annotations

import math
from contextlib import suppress
from itertools import product
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.variation import nodes
from scenecc.variation.bounds import (
    UNKNOWN,
    ExpressionBounds,
    ValueBounds,
    affine_clamp_bounds,
    bounds_of_values,
    component_bounds,
    stack_bounds,
    to_expression_bounds,
    to_value_bounds,
    union_bounds,
)
from scenecc.variation.conversions import CONVERSIONS
from scenecc.variation.expression_bounds import ExpressionFault, template_bounds
from scenecc.variation.nodes import (
    NODE_FIELDS,
    NODE_TYPES,
    NODES,
    SIGNATURES,
    Key,
    Node,
    draws_read_by,
    evaluation_order,
    shaped_fields,
)
from scenecc.variation.operations import NAME_LOOKUP_COST, NUMBERS, DrawError, OperationCounter, has_shape

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.variation.evaluation import CombinationBatch
    from scenecc.variation.forms import Template

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


_DIRECT = frozenset(
    (nodes.Const, nodes.Rows, nodes.Cycled, nodes.Chosen, nodes.Drawn, nodes.RandomRotated, nodes.Shared)
)
"""Nodes whose bounds are those of their items."""


def find_bounds(
    node: Node,
    draws: Mapping[str, Node],
    *,
    given: Mapping[str, NDArray[Any]] | None = None,
    num_scenes: int | None = None,
) -> ValueBounds:
    """Everything that a node can give.

    Args:
        node: whatever reads draws.
        draws: the shared draws by name.
        given: values (N, …) that take the place of draws.
        num_scenes: how many scenes there are, where that is known.
    """
    return BoundsAnalysis(draws, given or {}, num_scenes).bounds(node)


class BoundsAnalysis:
    """Finds bounds, those of shared draws once."""

    def __init__(
        self,
        draws: Mapping[str, Node],
        given: Mapping[str, NDArray[Any]],
        num_scenes: int | None,
        work: OperationCounter | None = None,
    ) -> None:
        self.draws = draws
        self.given = given
        self.num_scenes = num_scenes
        self.work = work
        self._shared: dict[str, ValueBounds] = {}
        self._reached: dict[str, ExpressionBounds] = {}
        self._outcomes: dict[tuple[Node, int], tuple[list[Any] | None, tuple[int, ...]]] = {}
        self._computed: dict[tuple[Any, ...], tuple[Template, ValueBounds]] = {}

    def bounds(self, node: Node) -> ValueBounds:
        """Everything that a node can give."""
        if not isinstance(node, nodes.Computed):
            return self._found(node)
        # Many fields have one expression, which is one object: as many as read a shared draw. It is kept with its id.
        key = (id(node.template), node.shape, node.reads)
        known = self._computed.get(key)
        if known is None:
            known = self._computed[key] = node.template, self._found(node)
        return known[1]

    def _found(self, node: Node) -> ValueBounds:
        if node.__class__ not in _DIRECT:
            with suppress(DrawError):
                rows = enumerate_outcomes(node, self, work=self.work)
                if rows is not None:
                    return ValueBounds.of(rows)
        return NODE_BOUNDS[node.__class__](self, node)

    def outcomes(self, node: Node, scenes: tuple[int, ...]) -> list[Any] | None:
        """What a node gives in some scenes, in every combination of what it reads; None where these are too many.

        Raises:
            DrawError: it has no value in one of them.
        """
        key = node, id(scenes)
        if key not in self._outcomes:
            rows = enumerate_outcomes(node, self, scenes=scenes, most=MAX_OUTCOMES, work=self.work)
            if self.work is not None:
                self.work.take(NAME_LOOKUP_COST * len(rows or ()), node)
            # The scenes are kept, so that their id stays their own.
            self._outcomes[key] = rows, scenes
        return self._outcomes[key][0]

    def item(self, item: Any) -> ValueBounds:
        """As `bounds`, of a plain value too."""
        return self.bounds(item) if item.__class__ in NODE_TYPES else ValueBounds.of((item,))

    def shared(self, name: str) -> ValueBounds:
        """The bounds of a shared draw."""
        if not self._is_known(name):
            for other in evaluation_order(name, self.draws, self._is_known):
                self._shared[other] = self.bounds(self.draws[other])
        return self._shared[name]

    def reached(self, name: str) -> ExpressionBounds:
        """The same, as expressions read it: once, for there may be very many alternatives and expressions."""
        found = self._reached.get(name)
        if found is None:
            node = self.draws.get(name)
            if isinstance(node, nodes.Shuffled) and name not in self.given:
                # Any of the items may stand anywhere; of texts the bounds of a value know nothing.
                found = ExpressionBounds(items=(bounds_of_values(node.items),) * len(node.items), exact=True)
            else:
                found = to_expression_bounds(self.shared(name), whole=_gives_integers(node))
            self._reached[name] = found
        return found

    def dependence(self, node: Node) -> Dependence:
        """What a node's value is computed from."""
        return Dependence(node, self)

    def _is_known(self, name: str) -> bool:
        if name not in self._shared and name in self.given:
            self._shared[name] = ValueBounds.of_rows(self.given[name])
        return name in self._shared

    def any_of(self, items: tuple[Any, ...]) -> ValueBounds:
        """Of items of which each scene has one."""
        if any(item.__class__ in NODE_TYPES for item in items):
            return union_bounds(map(self.item, items))
        return ValueBounds.of(items)


@frozen
class Dependence:
    """What the value of an expression is computed from.

    Attributes:
        node: computes it.
        analysis: knows the shared draws of its document.
    """

    node: Node
    analysis: BoundsAnalysis

    def shared_draws(self) -> set[str]:
        """The shared draws that it reads, also through others."""
        draws = self.analysis.draws
        read = draws_read_by(self.node)
        return {name for first in read for name in evaluation_order(first, draws, lambda _name: False)}


_MAX_DRAWS_COMBINED = 3
"""Of more draws that two values read in common only two combinations are looked at."""


def joint_extremes(a: Dependence, b: Dependence) -> Iterator[tuple[Any, Any]]:
    """The greatest of one value with the least of another, for extremes of the draws that both read: nothing is drawn.

    Raises:
        DrawError: one of them may have no value.
    """
    analysis = a.analysis
    draws = analysis.draws
    common = sorted(a.shared_draws() & b.shared_draws())
    ends = {name: analysis.shared(name) for name in common if isinstance(draws[name], nodes.Drawn)}
    pairs = [(found.low, found.high) for found in ends.values()]
    for corner in product(*pairs) if len(pairs) <= _MAX_DRAWS_COMBINED else zip(*pairs, strict=True):
        constants = {**draws, **dict(zip(ends, map(nodes.Const, corner), strict=True))}
        fixed = BoundsAnalysis(constants, analysis.given, analysis.num_scenes, analysis.work)
        batch = combination_batch((a.node, b.node), fixed, scenes=None, most=MAX_OUTCOMES, work=analysis.work)
        if batch is None:
            yield fixed.bounds(a.node).high, fixed.bounds(b.node).low
        else:
            yield from zip(batch.evaluate(a.node).tolist(), batch.evaluate(b.node).tolist(), strict=True)


def _gives_integers(node: Node | None) -> bool:
    """Whether what a draw gives are integers in any case."""
    return isinstance(node, nodes.Drawn) and node.distribution.whole


def bounds_and_faults(analysis: BoundsAnalysis, node: nodes.Computed) -> tuple[ExpressionBounds, list[ExpressionFault]]:
    """What an expression can give by the bounds of what it reads, and why it may have no value."""
    faults: list[ExpressionFault] = []
    return template_bounds(node.template, name_bounds(analysis, node), faults), faults


def name_bounds(analysis: BoundsAnalysis, node: nodes.Computed) -> dict[str, ExpressionBounds]:
    """What the names in an expression can be."""
    count = analysis.num_scenes
    names = {name: analysis.reached(draw) for name, draw in node.draws_by_name.items()}
    if count is None:
        names["scene"] = ExpressionBounds(low=0, high=math.inf, whole=True)
        names["num_scenes"] = ExpressionBounds(low=1, high=math.inf, whole=True)
    else:
        names["scene"] = ExpressionBounds(low=0, high=count - 1, exact=True, whole=True)
        names["num_scenes"] = bounds_of_values((count,))
    return names


_ANY_QUATERNION = ValueBounds(None, (-1.0,) * 4, (1.0,) * 4, exact=False)
"""A quaternion that is not looked into."""


def _drawn(analysis: BoundsAnalysis, node: nodes.Drawn) -> ValueBounds:
    drawn = node.distribution
    if drawn.between is not None and not drawn.whole:
        # Of most draws both bounds are plain: this is what the rest makes of them, sooner.
        low, high = (_plain_bound(node.operands[i], node.shape) for i in drawn.between)
        if low is not None and high is not None and low != high:
            return ValueBounds(None, low, high, exact=True)
    found = [broadcast_bounds(analysis.item(item), node.shape) for item in node.operands]
    if any(one.low is None for one in found):
        return UNKNOWN
    exact = all(one.exact for one in found)
    low: Any
    high: Any
    if node.shape:
        sides = [zip(one.low, one.high, strict=True) for one in found]
        low, high = zip(*map(drawn.bounds, zip(*sides, strict=True)), strict=True)
    else:
        low, high = drawn.bounds([(one.low, one.high) for one in found])
    if drawn.whole and not node.shape and exact and high - low < MAX_COMBINATIONS:
        first, last = _whole(low), _whole(high)
        if first is not None and last is not None and first <= last:
            return ValueBounds.of(range(first, last + 1))
    if drawn.between is not None and low == high:
        return ValueBounds.of((low,), exact=exact)
    return ValueBounds(None, low, high, exact)


def _shuffled(_: BoundsAnalysis, node: nodes.Shuffled) -> ValueBounds:
    if not all(item.__class__ in NUMBERS for item in node.items):
        return UNKNOWN
    low, high = ((pick(node.items),) * len(node.items) for pick in (min, max))
    return ValueBounds(None, (*low, *node.rest), (*high, *node.rest), exact=True)


def _posed(analysis: BoundsAnalysis, node: nodes.Posed) -> ValueBounds:
    p, q = _parts(analysis, node)
    if p.low is None or q.low is None:
        return UNKNOWN
    return ValueBounds(None, (*p.low, *q.low), (*p.high, *q.high), p.exact and q.exact)


def _radians(analysis: BoundsAnalysis, node: nodes.Radians) -> ValueBounds:
    found = analysis.item(node.degrees)
    if found.low is None:
        return UNKNOWN
    return ValueBounds(None, _to_radians(found.low), _to_radians(found.high), found.exact)


def _to_radians(bound: Any) -> Any:
    return tuple(map(_to_radians, bound)) if bound.__class__ is tuple else math.radians(bound)


def _converted(analysis: BoundsAnalysis, node: nodes.Converted) -> ValueBounds:
    found, convert = analysis.item(node.of), CONVERSIONS[node.to].convert
    ends = () if found.low is None else (found.low, found.high)
    made = [convert(item) for item in (ends if found.alternatives is None else found.alternatives)]
    if not made or None in made:
        return UNKNOWN
    if found.alternatives is not None:
        return ValueBounds.of(made, exact=found.exact)
    return ValueBounds(None, *made, exact=found.exact)


def _from_matrix(analysis: BoundsAnalysis, node: nodes.FromMatrix) -> ValueBounds:
    (found,) = _parts(analysis, node)
    if found.low is None:
        return UNKNOWN
    low, high = (tuple(row[3] for row in bound[:3]) for bound in (found.low, found.high))
    return ValueBounds(None, (*low, *_ANY_QUATERNION.low), (*high, *_ANY_QUATERNION.high), exact=False)


def _composed(analysis: BoundsAnalysis, node: nodes.Composed) -> ValueBounds:
    outer, inner = _parts(analysis, node)
    if outer.low is None or inner.low is None:
        return UNKNOWN
    if outer.low[3:] == outer.high[3:] == (1.0, 0.0, 0.0, 0.0):
        low = tuple(a + b for a, b in zip(outer.low[:3], inner.low[:3], strict=True))
        high = tuple(a + b for a, b in zip(outer.high[:3], inner.high[:3], strict=True))
        turn = (inner.low[3:], inner.high[3:])
        return ValueBounds(None, (*low, *turn[0]), (*high, *turn[1]), exact=outer.exact and inner.exact)
    # However it is turned, it is within its own distance of where the outer one is.
    far = math.hypot(*(max(abs(a), abs(b)) for a, b in zip(inner.low[:3], inner.high[:3], strict=True)))
    low, high = tuple(a - far for a in outer.low[:3]), tuple(a + far for a in outer.high[:3])
    return ValueBounds(None, (*low, *_ANY_QUATERNION.low), (*high, *_ANY_QUATERNION.high), exact=False)


def _affine_clamp(analysis: BoundsAnalysis, node: nodes.AffineClamp) -> ValueBounds:
    of, factor, offset, low, high = map(analysis.item, (node.of, node.factor, node.offset, node.low, node.high))
    return affine_clamp_bounds(of if node.index < 0 else component_bounds(of, node.index), factor, offset, low, high)


def _parts(analysis: BoundsAnalysis, node: Node) -> list[ValueBounds]:
    """The bounds of the fields of a node that has a signature."""
    return [_shaped(analysis.item(getattr(node, name)), shape) for name, shape in shaped_fields(node)]


def _plain_bound(item: Any, shape: tuple[int, ...]) -> Any:
    """A bound that does not vary, for every component; None for any other."""
    if item.__class__ in NUMBERS:
        return (item,) * shape[0] if shape else item
    fits = item.__class__ is tuple and shape == (len(item),) and NUMBERS.issuperset(map(type, item))
    return item if fits else None


def broadcast_bounds(found: ValueBounds, shape: tuple[int, ...]) -> ValueBounds:
    """A bound of one number as that of every component."""
    if not shape or found.low is None or found.low.__class__ is tuple:
        return _shaped(found, shape)
    return ValueBounds(None, (found.low,) * shape[0], (found.high,) * shape[0], found.exact)


def _shaped(found: ValueBounds, shape: tuple[int, ...]) -> ValueBounds:
    """The same, where it is of that shape. An expression may give anything, which is reported as it is drawn."""
    return found if found.low is None or has_shape(found.low, shape) else UNKNOWN


def _whole(number: float) -> int | None:
    return int(number) if math.isfinite(number) and number == int(number) else None


NODE_BOUNDS: dict[type[Any], Callable[[BoundsAnalysis, Any], ValueBounds]] = {
    **dict.fromkeys(
        (kind for kind, (_, gives) in SIGNATURES.items() if gives == (4,)), lambda _analysis, _node: _ANY_QUATERNION
    ),
    nodes.Const: lambda analysis, node: analysis.item(node.data),
    nodes.Rows: lambda analysis, node: analysis.any_of(node.items),
    nodes.Cycled: lambda analysis, node: analysis.any_of(node.items),
    nodes.Chosen: lambda analysis, node: analysis.any_of(tuple(node.items[number] for number in node.possible)),
    nodes.Shuffled: _shuffled,
    nodes.Drawn: _drawn,
    nodes.RandomRotated: lambda _analysis, _node: ValueBounds(None, (-1.0,) * 4, (1.0,) * 4, exact=True),
    nodes.Stacked: lambda analysis, node: stack_bounds(list(map(analysis.item, node.items))),
    nodes.Computed: lambda analysis, node: to_value_bounds(bounds_and_faults(analysis, node)[0]),
    nodes.Converted: _converted,
    nodes.Shared: lambda analysis, node: analysis.shared(node.name),
    nodes.Placed: lambda _analysis, _node: UNKNOWN,
    nodes.Posed: _posed,
    nodes.FromMatrix: _from_matrix,
    nodes.Radians: _radians,
    nodes.AffineClamp: _affine_clamp,
    nodes.Composed: _composed,
}
"""How each kind of node is bounded."""
