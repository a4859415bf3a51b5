"""What expressions can give, from what their names can: interval arithmetic, and sets where few values are known."""

from __future__ import annotations

import ast
import math
from itertools import product
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.values import interval_rules, operations
from scenecc.values.expression import CONSTANTS, Expression
from scenecc.values.failure import ExpressionError
from scenecc.values.functions import FUNCTIONS
from scenecc.values.narrowing import Narrowed, narrowed, written
from scenecc.values.reach import ANYTHING, FEW, Reach, are_exact, bounds_of, examples, items_of, join, known, truths_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.values.template import Template

_ANYWHERE = (0, 0)
_INTEGERS = frozenset(("Add", "Sub", "Mult", "FloorDiv", "Mod"))
"""Operators that give an integer where both operands are."""

_ROUNDING = frozenset(("floor", "ceil", "round"))
_OF_LISTS = frozenset(("min", "max"))
_KEEPING = frozenset(("abs", "min", "max"))
"""Functions that give an integer where all arguments are."""


@frozen
class Fault:
    """Why an expression may have no value.

    Attributes:
        message: what is wrong, as a diagnostic says it.
        start, end: of the part of the scalar's text that is meant.
        certain: whether it has none whatever is drawn.
    """

    message: str
    start: int
    end: int
    certain: bool


def reach(template: Template, names: Mapping[str, Reach], faults: list[Fault] | None = None) -> Reach:
    """What a template can give, from what its free names can; `faults` takes why it may have no value."""
    names = {**names, **{name: known((value,)) for name, value in template.constants}}
    walks = [
        part if isinstance(part, str) else _Walk(part, names, [] if faults is None else faults)
        for part in template.expressions()
    ]
    parts = [known((part,)) if isinstance(part, str) else part.node(part.expression.tree) for part in walks]
    if len(parts) == 1 and not isinstance(walks[0], str):
        return parts[0]
    for walk, part in zip(walks, parts, strict=True):
        if not isinstance(walk, str):
            walk.check_kinds([part], lambda values: operations.shown(values[0], _ANYWHERE), walk.expression.tree)
    if any(part.values is None for part in parts):
        return ANYTHING
    return _combined(parts, lambda values: "".join(operations.shown(v, _ANYWHERE) for v in values))


def reach_in(
    expression: Expression, names: Mapping[str, Reach], constants: Mapping[str, Any]
) -> Callable[[ast.expr], Reach]:
    """What finds the reach of a part of an expression."""
    return _Walk(expression, {**names, **{name: known((value,)) for name, value in constants.items()}}, []).node


class _Walk:
    """The reach of the nodes of one expression.

    Args:
        expression: at hand.
        names: what its names can be.
        faults: takes why it may have no value.
        certain: whether the nodes are evaluated in any case.
        known_parts: what a condition around the nodes says of parts of them.
    """

    def __init__(
        self,
        expression: Expression,
        names: Mapping[str, Reach],
        faults: list[Fault],
        *,
        certain: bool = True,
        known_parts: Narrowed | None = None,
    ) -> None:
        self.expression = expression
        self._names = names
        self._faults = faults
        self._certain = certain
        self._parts: Narrowed = known_parts or {}

    def node(self, node: ast.expr) -> Reach:
        found = self._parts.get(written(node)) if self._parts else None
        return found or _NODES[type(node)](self, node)

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
            return _combined(items, list)
        return Reach(items=tuple(items), exact=are_exact(items))

    def binary(self, node: ast.BinOp) -> Reach:
        """By the rules of intervals, where the values are too many to be combined; lists are joined."""
        name, parts = type(node.op).__name__, [self.node(node.left), self.node(node.right)]
        if name == "Mult" and written(node.left) == written(node.right):
            return self._squared(parts[0], node)
        apply = operations.BINARY[name]
        found = self._combined(parts, lambda values: apply(values[0], values[1], _ANYWHERE), node)
        if found.values is not None:
            return found
        a, b = map(bounds_of, parts)
        if a is not None and b is not None:
            whole = name in _INTEGERS and all(part.is_whole for part in parts)
            if name in interval_rules.BY_ZERO and parts[1].may_be_zero():
                self._fault("division by zero", node, certain=b == (0, 0))
            elif name == "Pow":
                self._power(a, b, parts[0], node)
            low, high = interval_rules.binary(name, a, b, whole=whole)
            exact = interval_rules.reached(name, b) and are_exact(parts)
            return Reach(low=low, high=high, exact=exact, whole=whole)
        first, second = map(items_of, parts)
        if name == "Add" and first is not None and second is not None:
            return Reach(items=(*first, *second), exact=are_exact(parts))
        if name == "Mult" and (repeated := _repeated(first, parts[1]) or _repeated(second, parts[0])):
            return repeated
        return self._by_kind(parts, lambda values: apply(values[0], values[1], _ANYWHERE), node)

    def _squared(self, part: Reach, node: ast.BinOp) -> Reach:
        """A part times itself, which is never below 0."""
        found = self._combined([part], lambda values: operations.multiply(values[0], values[0], _ANYWHERE), node)
        bounds = bounds_of(part)
        if found.values is not None or bounds is None:
            return found
        low, high = interval_rules.squared(bounds)
        return Reach(low=low, high=high, exact=part.exact, whole=part.is_whole)

    def _power(self, a: interval_rules.Interval, b: interval_rules.Interval, base: Reach, node: ast.BinOp) -> None:
        if base.may_be_zero() and b[0] < 0:
            self._fault("0 has no negative power", node, certain=a == (0, 0) and b[1] < 0)
        elif a[0] < 0 and not (b[0] == b[1] and b[0] == math.floor(b[0])):
            self._fault("a negative number has whole powers only", node, certain=a[1] < 0 and b[0] == b[1])

    def unary(self, node: ast.UnaryOp) -> Reach:
        """A sign turns the bounds round; `not` takes the truths that there can be."""
        part = self.node(node.operand)
        if isinstance(node.op, ast.Not):
            return known(not truth for truth in self._truths(part, node.operand))
        bounds = bounds_of(part) if part.values is None else None
        if bounds is not None:
            low, high = bounds if isinstance(node.op, ast.UAdd) else (-bounds[1], -bounds[0])
            return Reach(low=low, high=high, exact=part.exact, whole=part.whole, nonzero=part.nonzero)
        apply = operations.negative if isinstance(node.op, ast.USub) else operations.positive
        return self._combined_or_kind([part], lambda values: apply(values[0], _ANYWHERE), node)

    def logical(self, node: ast.BoolOp) -> Reach:
        """An operand is looked at as it is where those before it have not decided, and not at all where they have."""
        parts: list[Reach] = []
        until = isinstance(node.op, ast.Or)
        walk = self
        for value in node.values:
            part = walk.node(value)
            truths = walk._truths(part, value)
            if value is not node.values[-1]:
                walk = walk._where(value, truths, holds=not until)
                if until not in truths:
                    continue
            parts.append(part)
            if truths == {until}:
                break
        return join(parts)

    def compared(self, node: ast.Compare) -> Reach:
        parts = [self.node(node.left), *map(self.node, node.comparators)]
        truths: set[bool] = {True}
        for op, a, b in zip(node.ops, parts, parts[1:], strict=False):
            step = self._comparison(type(op).__name__, a, b, node)
            truths = {truth and now for truth in truths for now in step}
        return known(truths, exact=False)

    def conditional(self, node: ast.IfExp) -> Reach:
        truths = self._truths(self.node(node.test), node.test)
        branches = [(node.body, True), (node.orelse, False)]
        return join([self._where(node.test, truths, holds=t).node(branch) for branch, t in branches if t in truths])

    def _where(self, test: ast.expr, truths: set[bool], *, holds: bool) -> _Walk:
        """The walk of what is evaluated only where a condition holds, or where it does not."""
        if truths == {holds}:
            return self
        parts = {**self._parts, **narrowed(test, holds=holds, reach=self._quietly)}
        return _Walk(self.expression, self._names, self._faults, certain=False, known_parts=parts)

    def _quietly(self, node: ast.expr) -> Reach:
        return _Walk(self.expression, self._names, [], known_parts=self._parts).node(node)

    def indexed(self, node: ast.Subscript) -> Reach:
        """The items that the index can reach; a fault where it can miss the list, certain where it always does."""
        parts = [self.node(node.value), self.node(node.slice)]
        items, bounds = items_of(parts[0]), bounds_of(parts[1])
        if items is None or bounds is None or not parts[1].is_whole or all(part.values is not None for part in parts):
            return self._combined_or_kind(parts, lambda found: operations.item(found[0], found[1], _ANYWHERE), node)
        every = range(-len(items), len(items))
        indices = parts[1].values or [i for i in every if bounds[0] <= i <= bounds[1]]
        reached = [items[i] for i in indices if i in every]
        if bounds[0] not in every or bounds[1] not in every:
            self._fault(f"an index is out of range: the list has {len(items)} items", node, certain=not reached)
        return join(reached) if reached else ANYTHING

    def call(self, node: ast.Call) -> Reach:
        """By the rules of intervals, where the values are too many to be combined."""
        assert isinstance(node.func, ast.Name)
        name, parts = node.func.id, [self.node(argument) for argument in node.args]
        apply = FUNCTIONS[name][2]
        found = self._combined(parts, lambda values: apply(list(values), _ANYWHERE), node)
        if found.values is not None:
            return found
        if name == "len" and parts[0].items is not None:
            return known((len(parts[0].items),))
        if name in _OF_LISTS and len(parts) == 1 and parts[0].items is not None:
            parts = list(parts[0].items)
        bounds = [bound for bound in map(bounds_of, parts) if bound is not None]
        if len(bounds) < len(parts) or name == "len":
            return self._by_kind(parts, lambda values: apply(list(values), _ANYWHERE), node)
        if name == "sqrt" and bounds[0][0] < 0:
            self._fault("a negative number has no root", node, certain=bounds[0][1] < 0)
        low, high = interval_rules.FUNCTIONS[name](bounds)
        whole = (name in _ROUNDING and len(parts) == 1) or (name in _KEEPING and all(part.is_whole for part in parts))
        return Reach(low=low, high=high, whole=whole)

    def _combined(self, parts: list[Reach], apply: Callable[[tuple[Any, ...]], Any], node: ast.expr) -> Reach:
        failed: list[ExpressionError] = []
        found = _combined(parts, apply, failed)
        if failed:
            self._fault(failed[0].message, node, certain=found.values is None)
        return found

    def _by_kind(self, parts: list[Reach], apply: Callable[[tuple[Any, ...]], Any], node: ast.expr) -> Reach:
        """What comes of parts of which some have too many values: only whether their kinds fit is looked at."""
        if any(part.values is None for part in parts):
            self.check_kinds(parts, apply, node)
        return ANYTHING

    def check_kinds(self, parts: list[Reach], apply: Callable[[tuple[Any, ...]], Any], node: ast.expr) -> None:
        """A fault where something cannot be done with values of these kinds."""
        self._combined([known(examples(part)) for part in parts], apply, node)

    def _truths(self, part: Reach, node: ast.expr) -> set[bool]:
        """What a condition can be."""
        self.check_kinds([part], lambda values: operations.truth(values[0], _ANYWHERE), node)
        return truths_of(part)

    def _combined_or_kind(self, parts: list[Reach], apply: Callable[[tuple[Any, ...]], Any], node: ast.expr) -> Reach:
        found = self._combined(parts, apply, node)
        return self._by_kind(parts, apply, node) if found is ANYTHING else found

    def _comparison(self, name: str, a: Reach, b: Reach, node: ast.expr) -> set[bool]:
        """The outcomes that are possible."""
        apply = operations.COMPARISONS[name]
        found = self._combined([a, b], lambda values: apply(values[0], values[1], _ANYWHERE), node)
        if found.values is not None:
            return set(found.values)
        first, second = bounds_of(a), bounds_of(b)
        if first is not None and second is not None:
            return interval_rules.compared(name, first, second)
        self._by_kind([a, b], lambda values: apply(values[0], values[1], _ANYWHERE), node)
        return {True, False}

    def _fault(self, message: str, node: ast.expr, *, certain: bool) -> None:
        self._faults.append(Fault(message, *self.expression.span(node), certain=certain and self._certain))


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


def _repeated(items: tuple[Reach, ...] | None, times: Reach) -> Reach | None:
    """A list that is repeated so often; None where it is none, or how often is not known."""
    values = times.values or ()
    if items is None or len(values) != 1 or type(values[0]) is not int or not 0 < values[0] * len(items) <= FEW:
        return None
    return Reach(items=items * values[0])


def _combined(
    parts: list[Reach], apply: Callable[[tuple[Any, ...]], Any], failed: list[ExpressionError] | None = None
) -> Reach:
    """What comes of every combination of known values; what has no value is left out, and goes to `failed`."""
    if math.prod(FEW + 1 if part.values is None else len(part.values) for part in parts) > FEW:
        return ANYTHING
    found: list[Any] = []

    def one(values: tuple[Any, ...]) -> None:
        try:
            found.append(apply(values))
        except ExpressionError as error:
            if failed is not None:
                failed.append(error)

    for values in product(*(part.values or () for part in parts)):
        one(values)
    return known(found, exact=are_exact(parts))
