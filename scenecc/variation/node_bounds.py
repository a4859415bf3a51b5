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
from scenecc.variation.enumeration import MAX_COMBINATIONS, MAX_OUTCOMES, combination_batch, enumerate_outcomes
from scenecc.variation.expression_bounds import ExpressionFault, template_bounds
from scenecc.variation.nodes import NODE_TYPES, SIGNATURES, Node, draws_read_by, evaluation_order, shaped_fields
from scenecc.variation.operations import NAME_LOOKUP_COST, NUMBERS, DrawError, has_shape

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from numpy.typing import NDArray

    from scenecc.variation.forms import Template
    from scenecc.variation.operations import OperationCounter


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
        held = {**draws, **dict(zip(ends, map(nodes.Const, corner), strict=True))}
        fixed = BoundsAnalysis(held, analysis.given, analysis.num_scenes, analysis.work)
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
