"""What expressions can give, from what their names can: interval arithmetic, and sets where few values are known."""

from __future__ import annotations

import ast
import math
from contextlib import suppress
from itertools import product
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.values import interval_rules, operations
from scenecc.values.expression import CONSTANTS, Expression
from scenecc.values.failure import ExpressionError
from scenecc.values.support import UNKNOWN, Support

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from scenecc.values.template import Template

FEW = 64
"""How many values, or combinations of values, are followed one by one."""

_ANYWHERE = (0, 0)


@frozen
class Reach:
    """What an expression can give: one of few values, a number within bounds, a list of such, or anything.

    Attributes:
        values: all of them; None where they are too many or not known.
        low, high: of a number that is not one of few; None of anything else.
        items: of a list that is not one of few; None of anything else.
        exact: whether every value, or every bound, can occur.
    """

    values: tuple[Any, ...] | None = None
    low: float | None = None
    high: float | None = None
    items: tuple[Reach, ...] | None = None
    exact: bool = False


ANYTHING = Reach()


def known(values: Iterable[Any], *, exact: bool = True) -> Reach:
    """One of some values; what bounds them where they are many."""
    distinct = list({(value.__class__, repr(value)): value for value in values}.values())
    if not distinct:
        return ANYTHING
    if len(distinct) <= FEW:
        return Reach(values=tuple(distinct), exact=exact)
    if all(map(operations.is_number, distinct)):
        return Reach(low=min(distinct), high=max(distinct), exact=exact)
    return ANYTHING


def reach(template: Template, names: Mapping[str, Reach]) -> Reach:
    """What a template can give, from what its free names can."""
    names = {**names, **{name: known((value,)) for name, value in template.constants}}
    parts = [
        known((part,)) if isinstance(part, str) else _Walk(part, names).node(part.tree)
        for part in template.expressions()
    ]
    if len(parts) == 1 and not isinstance(template.expressions()[0], str):
        return parts[0]
    if any(part.values is None for part in parts):
        return ANYTHING
    return _combined(parts, lambda values: "".join(operations.shown(v, _ANYWHERE) for v in values), exact=_exact(parts))


def reach_of(found: Support) -> Reach:
    """The reach of a name whose support is known."""
    if found.alternatives is not None:
        reached = known(found.alternatives, exact=found.exact)
        if reached is not ANYTHING:
            return reached
    return _between(found.low, found.high, found.exact)


def support_of(found: Reach) -> Support:
    """The support of what has a reach."""
    if found.values is not None:
        return Support.of(found.values, exact=found.exact)
    if found.items is not None:
        parts = [support_of(item) for item in found.items]
        if any(part.low is None for part in parts):
            return UNKNOWN
        return Support(None, tuple(p.low for p in parts), tuple(p.high for p in parts), all(p.exact for p in parts))
    return UNKNOWN if found.low is None else Support(None, found.low, found.high, found.exact)


def join(parts: list[Reach]) -> Reach:
    """Any of several."""
    if len(parts) == 1:
        return parts[0]
    if all(part.values is not None for part in parts):
        return known((value for part in parts for value in part.values or ()), exact=False)
    bounds = [_bounds(part) for part in parts]
    if all(bound is not None for bound in bounds):
        return Reach(low=min(b[0] for b in bounds if b), high=max(b[1] for b in bounds if b))
    lists = [_items(part) for part in parts]
    if all(items is not None for items in lists) and len({len(items or ()) for items in lists}) == 1:
        return Reach(items=tuple(join(list(column)) for column in zip(*(items or () for items in lists), strict=True)))
    return ANYTHING


class _Walk:
    """The reach of the nodes of one expression."""

    def __init__(self, expression: Expression, names: Mapping[str, Reach]) -> None:
        self._expression = expression
        self._names = names

    def node(self, node: ast.expr) -> Reach:
        return _NODES[type(node)](self, node)

    def constant(self, node: ast.Constant) -> Reach:
        return known((node.value,))

    def name(self, node: ast.Name) -> Reach:
        return known((CONSTANTS[node.id],)) if node.id in CONSTANTS else self._names.get(node.id, ANYTHING)

    def listed(self, node: ast.List) -> Reach:
        items = [self.node(item) for item in node.elts]
        if (
            all(item.values is not None for item in items)
            and math.prod(len(item.values or ()) for item in items) <= FEW
        ):
            return _combined(items, list, exact=_exact(items))
        return Reach(items=tuple(items), exact=_exact(items))

    def binary(self, node: ast.BinOp) -> Reach:
        name, parts = type(node.op).__name__, [self.node(node.left), self.node(node.right)]
        apply = operations.BINARY[name]
        found = _combined(parts, lambda values: apply(values[0], values[1], _ANYWHERE), exact=_exact(parts))
        if found.values is not None:
            return found
        a, b = map(_bounds, parts)
        if a is not None and b is not None:
            low, high = interval_rules.BINARY[name](a, b)
            return Reach(low=low, high=high, exact=interval_rules.reached(name, b) and _exact(parts))
        first, second = map(_items, parts)
        if name == "Add" and first is not None and second is not None:
            return Reach(items=(*first, *second), exact=_exact(parts))
        return ANYTHING

    def unary(self, node: ast.UnaryOp) -> Reach:
        part = self.node(node.operand)
        if isinstance(node.op, ast.Not):
            return known(not truth for truth in _truths(part))
        bounds = _bounds(part) if part.values is None else None
        if bounds is not None:
            low, high = bounds if isinstance(node.op, ast.UAdd) else (-bounds[1], -bounds[0])
            return Reach(low=low, high=high, exact=part.exact)
        apply = operations.negative if isinstance(node.op, ast.USub) else operations.positive
        return _combined([part], lambda values: apply(values[0], _ANYWHERE), exact=part.exact)

    def logical(self, node: ast.BoolOp) -> Reach:
        parts: list[Reach] = []
        until = isinstance(node.op, ast.Or)
        for value in node.values:
            part = self.node(value)
            truths = _truths(part)
            if value is not node.values[-1] and until not in truths:
                continue
            parts.append(part)
            if truths == {until}:
                break
        return join(parts)

    def compared(self, node: ast.Compare) -> Reach:
        parts = [self.node(node.left), *map(self.node, node.comparators)]
        truths: set[bool] = {True}
        for op, a, b in zip(node.ops, parts, parts[1:], strict=False):
            step = _comparison(type(op).__name__, a, b)
            truths = {truth and now for truth in truths for now in step}
        return known(truths, exact=False)

    def conditional(self, node: ast.IfExp) -> Reach:
        truths = _truths(self.node(node.test))
        chosen = [branch for branch, truth in ((node.body, True), (node.orelse, False)) if truth in truths]
        return join([self.node(branch) for branch in chosen])

    def indexed(self, node: ast.Subscript) -> Reach:
        values, index = self.node(node.value), self.node(node.slice)
        if values.items is None or index.values is None:
            parts = [values, index]
            return _combined(parts, lambda found: operations.item(found[0], found[1], _ANYWHERE), exact=_exact(parts))
        items = values.items
        reached = [items[i] for i in index.values if type(i) is int and -len(items) <= i < len(items)]
        return join(reached) if reached else ANYTHING

    def call(self, node: ast.Call) -> Reach:
        assert isinstance(node.func, ast.Name)
        name, parts = node.func.id, [self.node(argument) for argument in node.args]
        apply = operations.FUNCTIONS[name][2]
        found = _combined(parts, lambda values: apply(list(values), _ANYWHERE), exact=_exact(parts))
        if found.values is not None:
            return found
        if name == "len":
            return ANYTHING if parts[0].items is None else known((len(parts[0].items),))
        if len(parts) == 1 and parts[0].items is not None:
            parts = list(parts[0].items)
        bounds = [_bounds(part) for part in parts]
        if any(bound is None for bound in bounds):
            return ANYTHING
        low, high = interval_rules.FUNCTIONS[name]([bound for bound in bounds if bound is not None])
        return Reach(low=low, high=high)


_NODES: dict[type[ast.expr], Callable[[_Walk, Any], Reach]] = {
    ast.Constant: _Walk.constant,
    ast.Name: _Walk.name,
    ast.List: _Walk.listed,
    ast.BinOp: _Walk.binary,
    ast.UnaryOp: _Walk.unary,
    ast.BoolOp: _Walk.logical,
    ast.Compare: _Walk.compared,
    ast.IfExp: _Walk.conditional,
    ast.Subscript: _Walk.indexed,
    ast.Call: _Walk.call,
}


def _combined(parts: list[Reach], apply: Callable[[tuple[Any, ...]], Any], *, exact: bool) -> Reach:
    """What comes of every combination of known values; what has no value is left out."""
    if math.prod(FEW + 1 if part.values is None else len(part.values) for part in parts) > FEW:
        return ANYTHING
    found: list[Any] = []
    for values in product(*(part.values or () for part in parts)):
        with suppress(ExpressionError):
            found.append(apply(values))
    return known(found, exact=exact)


def _exact(parts: list[Reach]) -> bool:
    """Whether all combinations can occur: where one part varies at most, since two may read the same draw."""
    varying = [part for part in parts if part.values is None or len(part.values) > 1]
    return len(varying) <= 1 and all(part.exact for part in parts)


def _bounds(part: Reach) -> tuple[float, float] | None:
    if part.values is not None:
        if not all(map(operations.is_number, part.values)):
            return None
        return min(part.values), max(part.values)
    return None if part.low is None or part.high is None else (part.low, part.high)


def _items(part: Reach) -> tuple[Reach, ...] | None:
    """The reaches of a list's items."""
    if part.values is None:
        return part.items
    if not all(type(value) in operations.LISTS for value in part.values) or len({*map(len, part.values)}) != 1:
        return None
    return tuple(known(column, exact=part.exact) for column in zip(*part.values, strict=True))


def _truths(part: Reach) -> set[bool]:
    if part.values is not None:
        return {bool(value) for value in part.values}
    bounds = _bounds(part)
    if bounds is None:
        return {True, False}
    low, high = bounds
    return {True} if low > 0 or high < 0 else {False} if low == high == 0 else {True, False}


def _comparison(name: str, a: Reach, b: Reach) -> set[bool]:
    """The outcomes that are possible."""
    apply = operations.COMPARISONS[name]
    found = _combined([a, b], lambda values: apply(values[0], values[1], _ANYWHERE), exact=False)
    if found.values is not None:
        return set(found.values)
    first, second = _bounds(a), _bounds(b)
    return {True, False} if first is None or second is None else interval_rules.compared(name, first, second)


def _between(low: Any, high: Any, exact: bool) -> Reach:  # noqa: FBT001
    if low is None:
        return ANYTHING
    if low.__class__ is tuple:
        return Reach(items=tuple(_between(a, b, exact) for a, b in zip(low, high, strict=True)), exact=exact)
    return Reach(low=low, high=high, exact=exact)
