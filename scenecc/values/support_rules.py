"""The support of each kind of node, from those of what it reads."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.values.enumerating import FEW
from scenecc.values.intervals import Fault, reach
from scenecc.values.nodes import (
    Chosen,
    Composed,
    Computed,
    Const,
    Cycled,
    Drawn,
    FromAxisAngle,
    FromMatrix,
    FromRpy,
    Held,
    Looking,
    Node,
    Normalized,
    Pointing,
    Posed,
    Radians,
    RandomRotated,
    Rows,
    Shared,
    Stacked,
)
from scenecc.values.reach import Reach, known, support_of
from scenecc.values.support import UNKNOWN, Support, component, held_support

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.values.supporting import Reader

_TURN = Support(None, (-1.0,) * 4, (1.0,) * 4, exact=False)
"""A quaternion that is not looked into."""

_NUMBERS = frozenset((float, int))


def _chosen(reader: Reader, node: Chosen) -> Support:
    weights = node.weights or (1.0,) * len(node.items)
    return reader.any_of(tuple(item for item, weight in zip(node.items, weights, strict=True) if weight > 0))


def _drawn(reader: Reader, node: Drawn) -> Support:
    if node.kind in _BETWEEN:
        # Of most draws both bounds are plain: this is what the rest makes of them, sooner.
        low, high = _plain_bound(node.low, node.shape), _plain_bound(node.high, node.shape)
        if low is not None and high is not None and low != high:
            return Support(None, low, high, exact=True)
    first, second = spread(reader.item(node.low), node.shape), spread(reader.item(node.high), node.shape)
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
        bottom, top = (spread(reader.item(bound), node.shape) for bound in node.clip)
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
    return support_of(reach(node.template, names_of(reader, node)))


def reach_and_faults(reader: Reader, node: Computed) -> tuple[Reach, list[Fault]]:
    """What an expression can give by the bounds of what it reads, and why it may have no value."""
    faults: list[Fault] = []
    return reach(node.template, names_of(reader, node), faults), faults


def names_of(reader: Reader, node: Computed) -> dict[str, Reach]:
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


def _held(reader: Reader, node: Held) -> Support:
    of, factor, offset, low, high = map(reader.item, (node.of, node.factor, node.offset, node.low, node.high))
    return held_support(of if node.index < 0 else component(of, node.index), factor, offset, low, high)


_BETWEEN = frozenset(("uniform", "log_uniform"))


def _plain_bound(item: Any, shape: tuple[int, ...]) -> Any:
    """A bound that does not vary, for every component; None for any other."""
    if item.__class__ in _NUMBERS:
        return (item,) * shape[0] if shape else item
    fits = item.__class__ is tuple and shape == (len(item),) and _NUMBERS.issuperset(map(type, item))
    return item if fits else None


def spread(found: Support, shape: tuple[int, ...]) -> Support:
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


TABLE: dict[type[Any], Callable[[Reader, Any], Support]] = {
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
    Pointing: _turned,
    Radians: _radians,
    Held: _held,
    Composed: _composed,
}
"""How each kind of node finds its support."""
