"""Bounds of a node's values: exact for plain forms, from 256 samples for expressions."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from scenecc.variation import nodes
from scenecc.variation.bounds import (
    UNKNOWN,
    ValueBounds,
    combined_bounds,
    component_bounds,
    union_bounds,
)
from scenecc.variation.conversions import CONVERSIONS
from scenecc.variation.nodes import NODE_FIELDS, NODE_TYPES, SIGNATURES, Node, evaluation_order, shaped_fields
from scenecc.variation.operations import NUMBERS, DrawError, OperationCounter, has_shape

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from scenecc.variation.samples import SampleBatch

MAX_INTEGERS = 64
"""Most integers of one draw that are listed as alternatives."""


class BoundsAnalysis:
    """Finds the bounds of nodes in some scenes. Bounds of shared draws are cached.

    Args:
        draws: the shared draws by name.
        num_scenes: of the document.
        scenes: indices of the scenes; None: all.
        work: counts the operations of sampling.
    """

    def __init__(
        self,
        draws: Mapping[str, Node],
        num_scenes: int,
        scenes: tuple[int, ...] | None = None,
        work: OperationCounter | None = None,
    ) -> None:
        self.scenes = tuple(range(num_scenes)) if scenes is None else scenes
        self._draws = draws
        self._num_scenes = num_scenes
        self._work = work
        self._shared: dict[str, ValueBounds] = {}

    def bounds(self, node: Node) -> ValueBounds:
        """The bounds of a node's values."""
        return NODE_BOUNDS[node.__class__](self, node)

    @cached_property
    def samples(self) -> SampleBatch:
        """The samples of an object in the scenes."""
        from scenecc.variation.samples import SampleBatch  # noqa: PLC0415 - it loads numpy

        return SampleBatch(self.scenes, self._num_scenes, self._draws, self._work)

    def sampled(self, node: Node) -> ValueBounds:
        """The bounds of a node's samples; unknown if a sample has no value."""
        try:
            return ValueBounds.of_samples(self.samples.evaluate(node))
        except DrawError:
            return UNKNOWN

    def item(self, item: Any) -> ValueBounds:
        """Same as `bounds`, also for a plain value."""
        return self.bounds(item) if item.__class__ in NODE_TYPES else ValueBounds.of((item,))

    def shared(self, name: str) -> ValueBounds:
        """The bounds of a shared draw."""
        if not self._is_known(name):
            for other in evaluation_order(name, self._draws, self._is_known):
                self._shared[other] = self.bounds(self._draws[other])
        return self._shared[name]

    def _is_known(self, name: str) -> bool:
        return name in self._shared

    def any_of(self, items: tuple[Any, ...]) -> ValueBounds:
        """Bounds over items, one of which each scene has."""
        if any(item.__class__ in NODE_TYPES for item in items):
            return union_bounds(map(self.item, items))
        return ValueBounds.of(items)


_ANY_ROTATION = ValueBounds(None, (-1.0,) * 4, (1.0,) * 4, exact=True)


def _bound_draw(analysis: BoundsAnalysis, node: nodes.Drawn) -> ValueBounds:
    drawn = node.distribution
    if drawn.between is not None and not drawn.whole:
        # Shortcut for the common case of two plain bounds.
        low, high = (_plain_bound(node.operands[i], node.shape) for i in drawn.between)
        if low is not None and high is not None and low != high:
            return ValueBounds(None, low, high, exact=True)
    found = [_broadcast_bounds(analysis.item(item), node.shape) for item in node.operands]
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
    if drawn.whole and not node.shape and exact and high - low < MAX_INTEGERS:
        first, last = _whole(low), _whole(high)
        if first is not None and last is not None and first <= last:
            return ValueBounds.of(range(first, last + 1))
    if drawn.between is not None and low == high:
        return ValueBounds.of((low,), exact=exact)
    return ValueBounds(None, low, high, exact)


def _bound_shuffle(_: BoundsAnalysis, node: nodes.Shuffled) -> ValueBounds:
    if not all(item.__class__ in NUMBERS for item in node.items):
        return UNKNOWN
    low, high = ((pick(node.items),) * len(node.items) for pick in (min, max))
    return ValueBounds(None, (*low, *node.rest), (*high, *node.rest), exact=True)


def _bound_stack(analysis: BoundsAnalysis, node: nodes.Stacked) -> ValueBounds:
    first, *others = node.items
    if others and all(item is first for item in others):
        # One bound serves every component.
        found, count = analysis.item(first), len(node.items)
        return combined_bounds([found], lambda parts: parts * count)
    if not _are_independent(node.items):
        return analysis.sampled(node)
    return combined_bounds(list(map(analysis.item, node.items)), tuple)


def _are_independent(items: Sequence[Any]) -> bool:
    """Whether the values of items are independent: at most one reads the scene or a shared draw."""
    return sum(map(_reads_context, items)) < 2


def _reads_context(item: Any) -> bool:
    if item.__class__ is tuple:
        return any(map(_reads_context, item))
    if item.__class__ in _CONTEXT_NODES:
        return True
    return any(_reads_context(getattr(item, name)) for name in NODE_FIELDS.get(item.__class__, ()))


_CONTEXT_NODES = frozenset((nodes.Rows, nodes.Cycled, nodes.Computed, nodes.Shared, nodes.Placed))


def _bound_pose(analysis: BoundsAnalysis, node: nodes.Posed) -> ValueBounds:
    if not _are_independent((node.p, node.q)):
        return analysis.sampled(node)
    return combined_bounds(_parts(analysis, node), lambda parts: (*parts[0], *parts[1]))


def _bound_radians(analysis: BoundsAnalysis, node: nodes.Radians) -> ValueBounds:
    return combined_bounds([analysis.item(node.degrees)], lambda parts: _to_radians(parts[0]))


def _to_radians(bound: Any) -> Any:
    return tuple(map(_to_radians, bound)) if bound.__class__ is tuple else math.radians(bound)


def _bound_conversion(analysis: BoundsAnalysis, node: nodes.Converted) -> ValueBounds:
    found, convert = analysis.item(node.of), CONVERSIONS[node.to].convert
    ends = () if found.low is None else (found.low, found.high)
    made = [convert(item) for item in (ends if found.alternatives is None else found.alternatives)]
    if not made or None in made:
        return UNKNOWN
    if found.alternatives is not None:
        return ValueBounds.of(made, exact=found.exact)
    return ValueBounds(None, *made, exact=found.exact)


def _bound_composition(analysis: BoundsAnalysis, node: nodes.Composed) -> ValueBounds:
    outer, inner = _parts(analysis, node)
    if not _are_independent((node.outer, node.inner)):
        return analysis.sampled(node)
    if outer.low is None or inner.low is None or not outer.low[3:] == outer.high[3:] == (1.0, 0.0, 0.0, 0.0):
        return analysis.sampled(node)
    return combined_bounds((outer, inner), _translate)


def _translate(poses: tuple[Any, ...]) -> Any:
    """Composes two poses, the outer one without rotation."""
    outer, inner = poses
    return (*(a + b for a, b in zip(outer[:3], inner[:3], strict=True)), *inner[3:])


def _bound_expression(analysis: BoundsAnalysis, node: nodes.Computed) -> ValueBounds:
    name = node.template.text.removeprefix("${").removesuffix("}").strip()
    draw = node.draws_by_name.get(name)
    if draw is None:
        return analysis.sampled(node)
    # The bounds of a named draw are known. They are not exact, since other values may read the same draw.
    found = analysis.shared(draw)
    return replace(found if node.shape is None else _check_shape(found, node.shape), exact=False)


def _bound_affine_clamp(analysis: BoundsAnalysis, node: nodes.AffineClamp) -> ValueBounds:
    of = analysis.item(node.of)
    parts = [
        of if node.index < 0 else component_bounds(of, node.index),
        *map(analysis.item, (node.factor, node.offset, node.low, node.high)),
    ]
    if any(part.low.__class__ not in NUMBERS or part.high.__class__ not in NUMBERS for part in parts):
        return UNKNOWN
    if parts[1].low == parts[1].high >= 0:
        return combined_bounds(parts, _clamp)
    return analysis.sampled(node)


def _clamp(parts: tuple[float, ...]) -> float:
    of, factor, offset, low, high = parts
    return max(min(factor * of + offset, high), low)


def _parts(analysis: BoundsAnalysis, node: Node) -> list[ValueBounds]:
    """The bounds of the fields of a node with a signature."""
    return [_check_shape(analysis.item(getattr(node, name)), shape) for name, shape in shaped_fields(node)]


def _plain_bound(item: Any, shape: tuple[int, ...]) -> Any:
    """A constant bound, for every component; otherwise None."""
    if item.__class__ in NUMBERS:
        return (item,) * shape[0] if shape else item
    fits = item.__class__ is tuple and shape == (len(item),) and NUMBERS.issuperset(map(type, item))
    return item if fits else None


def _broadcast_bounds(found: ValueBounds, shape: tuple[int, ...]) -> ValueBounds:
    """Repeats the bound of one number for every component."""
    if not shape or found.low is None or found.low.__class__ is tuple:
        return _check_shape(found, shape)
    return ValueBounds(None, (found.low,) * shape[0], (found.high,) * shape[0], found.exact)


def _check_shape(found: ValueBounds, shape: tuple[int, ...]) -> ValueBounds:
    """The bounds if they have that shape, otherwise unknown. A wrong shape of an expression is reported at the draw."""
    return found if found.low is None or has_shape(found.low, shape) else UNKNOWN


def _whole(number: float) -> int | None:
    return int(number) if math.isfinite(number) and number == int(number) else None


NODE_BOUNDS: dict[type[Any], Callable[[BoundsAnalysis, Any], ValueBounds]] = {
    **dict.fromkeys(SIGNATURES, BoundsAnalysis.sampled),
    nodes.Const: lambda analysis, node: analysis.item(node.data),
    nodes.Rows: lambda analysis, node: analysis.any_of(node.items),
    nodes.Cycled: lambda analysis, node: analysis.any_of(node.items),
    nodes.Chosen: lambda analysis, node: analysis.any_of(tuple(node.items[number] for number in node.possible)),
    nodes.Shuffled: _bound_shuffle,
    nodes.Drawn: _bound_draw,
    nodes.RandomRotated: lambda _analysis, _node: _ANY_ROTATION,
    nodes.Stacked: _bound_stack,
    nodes.Computed: _bound_expression,
    nodes.Converted: _bound_conversion,
    nodes.Shared: lambda analysis, node: analysis.shared(node.name),
    nodes.Placed: lambda _analysis, _node: UNKNOWN,
    nodes.Posed: _bound_pose,
    nodes.Radians: _bound_radians,
    nodes.AffineClamp: _bound_affine_clamp,
    nodes.Composed: _bound_composition,
}
"""Computes the bounds of each kind of node."""
