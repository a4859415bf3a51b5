"""Bounds of expressions from the bounds of their names: interval arithmetic, and sets if there are few values.

A branch of a condition is analysed with what the condition says of its parts.
"""

from __future__ import annotations

import ast
import math
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.variation import operations
from scenecc.variation.bounds import (
    ANYTHING,
    MAX_KNOWN_VALUES,
    ExpressionBounds,
    are_exact,
    bounds_of_values,
    example_values,
    interval_of,
    items_of,
    join_bounds,
    truth_values,
)
from scenecc.variation.expression import CONSTANTS, Expression, bound_name
from scenecc.variation.operations import (
    BINARY,
    COMPARISONS,
    FUNCTIONS,
    MAX_ARGUMENTS,
    ExpressionError,
    comparison_outcomes,
    product_interval,
    sum_interval,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.variation.forms import Template
    from scenecc.variation.operations import Interval

    Operation = Callable[[tuple[Any, ...]], Any]


@frozen
class ExpressionFault:
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


def template_bounds(
    template: Template, names: Mapping[str, ExpressionBounds], faults: list[ExpressionFault] | None = None
) -> ExpressionBounds:
    """What a template can give, from what its free names can; `faults` takes why it may have no value."""
    names = {**names, **_constant_bounds(template)}
    walks = [
        part if isinstance(part, str) else _BoundsWalk(part, names, [] if faults is None else faults)
        for part in template.expressions()
    ]
    parts = [bounds_of_values((part,)) if isinstance(part, str) else part.node(part.expression.tree) for part in walks]
    if len(parts) == 1 and not isinstance(walks[0], str):
        return parts[0]
    for walk, part in zip(walks, parts, strict=True):
        if not isinstance(walk, str):
            walk.check_kinds([part], lambda values: operations.scalar_text(values[0], _ANYWHERE), walk.expression.tree)
    if any(part.values is None for part in parts):
        return ANYTHING
    return _combine_values(parts, lambda values: "".join(operations.scalar_text(v, _ANYWHERE) for v in values))


def difference_interval(a: Template, b: Template, names: Mapping[str, ExpressionBounds]) -> Interval | None:
    """The bounds of a - b, as a sum of terms; None where that is not made of numbers.

    Args:
        a: a scalar's text.
        b: another one's.
        names: what their free names can be.
    """
    if {**dict(a.constants), **dict(b.constants)} != {**dict(b.constants), **dict(a.constants)}:
        return None
    parts = [*a.expressions(), *b.expressions()]
    if len(parts) != 2 or isinstance(parts[0], str) or isinstance(parts[1], str):
        return None
    terms: _Terms = {}
    _add_terms(parts[0].tree, 1.0, terms)
    _add_terms(parts[1].tree, -1.0, terms)
    walk = _BoundsWalk(parts[0], {**names, **_constant_bounds(a), **_constant_bounds(b)}, [])
    total: Interval = (0.0, 0.0)
    for factor, term in terms.values():
        found = interval_of(walk.node(term))
        if found is None:
            return None
        total = sum_interval(total, product_interval((factor, factor), found))
    return total


def _constant_bounds(template: Template) -> dict[str, ExpressionBounds]:
    return {name: bounds_of_values((value,)) for name, value in template.constants}


_ANYWHERE = (0, 0)


class _BoundsWalk:
    """Bounds the parts of one expression.

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
        names: Mapping[str, ExpressionBounds],
        faults: list[ExpressionFault],
        *,
        certain: bool = True,
        known_parts: KnownParts | None = None,
    ) -> None:
        self.expression = expression
        self._names = names
        self._faults = faults
        self._certain = certain
        self._parts: KnownParts = known_parts or {}

    def node(self, node: ast.expr) -> ExpressionBounds:
        found = self._parts.get(part_key(node)) if self._parts else None
        return found or _NODES[type(node)](self, node)

    def constant(self, node: ast.Constant) -> ExpressionBounds:
        return bounds_of_values((node.value,))

    def name(self, node: ast.Name) -> ExpressionBounds:
        return bounds_of_values((CONSTANTS[node.id],)) if node.id in CONSTANTS else self._names.get(node.id, ANYTHING)

    def listed(self, node: ast.List) -> ExpressionBounds:
        items = [self.node(item) for item in node.elts]
        if (
            all(item.values is not None for item in items)
            and math.prod(len(item.values or ()) for item in items) <= MAX_KNOWN_VALUES
        ):
            return _combine_values(items, list)
        return ExpressionBounds(items=tuple(items), exact=are_exact(items))

    def binary(self, node: ast.BinOp) -> ExpressionBounds:
        """By the rules of intervals, where the values are too many to be combined; lists are joined."""
        name, parts = type(node.op).__name__, [self.node(node.left), self.node(node.right)]
        if name == "Mult" and part_key(node.left) == part_key(node.right):
            return self._squared(parts[0], node)
        operator = BINARY[name]
        found = self._combined(parts, lambda values: operator.apply(values[0], values[1], _ANYWHERE), node)
        if found.values is not None:
            return found
        a, b = map(interval_of, parts)
        if a is not None and b is not None:
            of_integers = operator.interval_of_integers if all(part.is_whole for part in parts) else None
            if operator.divides and parts[1].may_be_zero():
                self._fault("division by zero", node, certain=b == (0, 0))
            elif name == "Pow":
                self._power(a, b, parts[0], node)
            low, high = (of_integers or operator.interval)(a, b)
            reaches_ends = operator.reaches_ends and not (operator.divides and b[0] <= 0 <= b[1])
            exact = reaches_ends and are_exact(parts)
            return ExpressionBounds(low=low, high=high, exact=exact, whole=of_integers is not None)
        first, second = map(items_of, parts)
        if name == "Add" and first is not None and second is not None:
            return ExpressionBounds(items=(*first, *second), exact=are_exact(parts))
        if name == "Mult" and (repeated := _repeated_list(first, parts[1]) or _repeated_list(second, parts[0])):
            return repeated
        return self._by_kind(parts, lambda values: operator.apply(values[0], values[1], _ANYWHERE), node)

    def _squared(self, part: ExpressionBounds, node: ast.BinOp) -> ExpressionBounds:
        """A part times itself, which is never below 0."""
        found = self._combined([part], lambda values: operations.multiply(values[0], values[0], _ANYWHERE), node)
        bounds = interval_of(part)
        if found.values is not None or bounds is None:
            return found
        low, high = operations.squared_interval(bounds)
        return ExpressionBounds(low=low, high=high, exact=part.exact, whole=part.is_whole)

    def _power(self, a: Interval, b: Interval, base: ExpressionBounds, node: ast.BinOp) -> None:
        if base.may_be_zero() and b[0] < 0:
            self._fault("0 cannot have a negative exponent", node, certain=a == (0, 0) and b[1] < 0)
        elif a[0] < 0 and not (b[0] == b[1] and b[0] == math.floor(b[0])):
            self._fault("a negative number cannot have a fractional exponent", node, certain=a[1] < 0 and b[0] == b[1])

    def unary(self, node: ast.UnaryOp) -> ExpressionBounds:
        """A sign turns the bounds round; `not` takes the truths that there can be."""
        part = self.node(node.operand)
        if isinstance(node.op, ast.Not):
            return bounds_of_values(not truth for truth in self._truths(part, node.operand))
        bounds = interval_of(part) if part.values is None else None
        if bounds is not None:
            low, high = bounds if isinstance(node.op, ast.UAdd) else (-bounds[1], -bounds[0])
            return ExpressionBounds(low=low, high=high, exact=part.exact, whole=part.whole, nonzero=part.nonzero)
        apply = operations.SIGNS[type(node.op).__name__]
        return self._combined_or_kind([part], lambda values: apply(values[0], _ANYWHERE), node)

    def logical(self, node: ast.BoolOp) -> ExpressionBounds:
        """An operand is looked at as it is where those before it have not decided, and not at all where they have."""
        parts: list[ExpressionBounds] = []
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
        return join_bounds(parts)

    def compared(self, node: ast.Compare) -> ExpressionBounds:
        parts = [self.node(node.left), *map(self.node, node.comparators)]
        truths: set[bool] = {True}
        for op, a, b in zip(node.ops, parts, parts[1:], strict=False):
            step = self._comparison(type(op).__name__, a, b, node)
            truths = {truth and now for truth in truths for now in step}
        return bounds_of_values(truths, exact=False)

    def conditional(self, node: ast.IfExp) -> ExpressionBounds:
        truths = self._truths(self.node(node.test), node.test)
        branches = [(node.body, True), (node.orelse, False)]
        return join_bounds(
            [self._where(node.test, truths, holds=t).node(branch) for branch, t in branches if t in truths]
        )

    def _where(self, test: ast.expr, truths: set[bool], *, holds: bool) -> _BoundsWalk:
        """The walk of what is evaluated only where a condition holds, or where it does not."""
        if truths == {holds}:
            return self
        parts = {**self._parts, **refine_branch(test, holds=holds, bounds_in=self._quietly)}
        return _BoundsWalk(self.expression, self._names, self._faults, certain=False, known_parts=parts)

    def _quietly(self, node: ast.expr) -> ExpressionBounds:
        return _BoundsWalk(self.expression, self._names, [], known_parts=self._parts).node(node)

    def indexed(self, node: ast.Subscript) -> ExpressionBounds:
        """The items that the index can reach; a fault where it can miss the list, certain where it always does."""
        parts = [self.node(node.value), self.node(node.slice)]
        items, bounds = items_of(parts[0]), interval_of(parts[1])
        if items is None or bounds is None or not parts[1].is_whole or all(part.values is not None for part in parts):
            return self._combined_or_kind(parts, lambda found: operations.item_at(found[0], found[1], _ANYWHERE), node)
        every = range(-len(items), len(items))
        indices = parts[1].values or [i for i in every if bounds[0] <= i <= bounds[1]]
        reached = [items[i] for i in indices if i in every]
        if bounds[0] not in every or bounds[1] not in every:
            self._fault(f"an index is out of range: the list has {len(items)} items", node, certain=not reached)
        return join_bounds(reached) if reached else ANYTHING

    def call(self, node: ast.Call) -> ExpressionBounds:
        """By the rules of intervals, where the values are too many to be combined."""
        assert isinstance(node.func, ast.Name)
        if node.func.id not in FUNCTIONS:
            return self._names.get(bound_name(node), ANYTHING)
        name, parts = node.func.id, [self.node(argument) for argument in node.args]
        function = FUNCTIONS[name]
        found = self._combined(parts, lambda values: function.apply(list(values), _ANYWHERE), node)
        if found.values is not None:
            return found
        if name == "len" and parts[0].items is not None:
            return bounds_of_values((len(parts[0].items),))
        if function.most == MAX_ARGUMENTS and len(parts) == 1 and parts[0].items is not None:
            parts = list(parts[0].items)
        bounds = [bound for bound in map(interval_of, parts) if bound is not None]
        if len(bounds) < len(parts) or function.interval is None:
            return self._by_kind(parts, lambda values: function.apply(list(values), _ANYWHERE), node)
        if (fault := function.fault(*bounds)) is not None:
            self._fault(fault[0], node, certain=fault[1])
        low, high = function.interval(*bounds)
        return ExpressionBounds(low=low, high=high, whole=function.is_whole([part.is_whole for part in parts]))

    def _combined(self, parts: list[ExpressionBounds], apply: Operation, node: ast.expr) -> ExpressionBounds:
        failed: list[ExpressionError] = []
        found = _combine_values(parts, apply, failed)
        if failed:
            self._fault(failed[0].message, node, certain=found.values is None)
        return found

    def _by_kind(self, parts: list[ExpressionBounds], apply: Operation, node: ast.expr) -> ExpressionBounds:
        """What comes of parts of which some have too many values: only whether their kinds fit is looked at."""
        if any(part.values is None for part in parts):
            self.check_kinds(parts, apply, node)
        return ANYTHING

    def check_kinds(self, parts: list[ExpressionBounds], apply: Operation, node: ast.expr) -> None:
        """A fault where something cannot be done with values of these kinds."""
        self._combined([bounds_of_values(example_values(part)) for part in parts], apply, node)

    def _truths(self, part: ExpressionBounds, node: ast.expr) -> set[bool]:
        """What a condition can be."""
        self.check_kinds([part], lambda values: operations.truth(values[0], _ANYWHERE), node)
        return truth_values(part)

    def _combined_or_kind(self, parts: list[ExpressionBounds], apply: Operation, node: ast.expr) -> ExpressionBounds:
        found = self._combined(parts, apply, node)
        return self._by_kind(parts, apply, node) if found is ANYTHING else found

    def _comparison(self, name: str, a: ExpressionBounds, b: ExpressionBounds, node: ast.expr) -> set[bool]:
        """The outcomes that are possible."""
        apply = COMPARISONS[name].apply
        found = self._combined([a, b], lambda values: apply(values[0], values[1], _ANYWHERE), node)
        if found.values is not None:
            return set(found.values)
        first, second = interval_of(a), interval_of(b)
        if first is not None and second is not None:
            return comparison_outcomes(name, first, second)
        self._by_kind([a, b], lambda values: apply(values[0], values[1], _ANYWHERE), node)
        return {True, False}

    def _fault(self, message: str, node: ast.expr, *, certain: bool) -> None:
        self._faults.append(ExpressionFault(message, *self.expression.span(node), certain=certain and self._certain))


_NODES: dict[type[ast.expr], Callable[[_BoundsWalk, Any], ExpressionBounds]] = {
    ast.Constant: _BoundsWalk.constant,
    ast.Name: _BoundsWalk.name,
    ast.List: _BoundsWalk.listed,
    ast.BinOp: _BoundsWalk.binary,
    ast.UnaryOp: _BoundsWalk.unary,
    ast.BoolOp: _BoundsWalk.logical,
    ast.Compare: _BoundsWalk.compared,
    ast.IfExp: _BoundsWalk.conditional,
    ast.Subscript: _BoundsWalk.indexed,
    ast.Call: _BoundsWalk.call,
}


def _repeated_list(items: tuple[ExpressionBounds, ...] | None, times: ExpressionBounds) -> ExpressionBounds | None:
    """A list that is repeated so often; None where it is none, or how often is not known."""
    values = times.values or ()
    if (
        items is None
        or len(values) != 1
        or type(values[0]) is not int
        or not 0 < values[0] * len(items) <= MAX_KNOWN_VALUES
    ):
        return None
    return ExpressionBounds(items=items * values[0])


def _combine_values(
    parts: list[ExpressionBounds], apply: Operation, failed: list[ExpressionError] | None = None
) -> ExpressionBounds:
    """What comes of every combination of known values; what has no value is left out, and goes to `failed`."""
    if (
        math.prod(MAX_KNOWN_VALUES + 1 if part.values is None else len(part.values) for part in parts)
        > MAX_KNOWN_VALUES
    ):
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
    return bounds_of_values(found, exact=are_exact(parts))


KnownParts = dict[str, ExpressionBounds]
"""What is known of parts of an expression, by how they are written: the same text has the same value."""

_MAX_EXACT_INTEGER = 2.0**53
"""Up to here every integer is a float, so that there is none between two floats."""


def part_key(node: ast.expr) -> str:
    """A part of an expression as a key."""
    return ast.dump(node)


def refine_branch(test: ast.expr, *, holds: bool, bounds_in: Callable[[ast.expr], ExpressionBounds]) -> KnownParts:
    """What is known of the parts of a condition where it holds, or where it does not.

    Args:
        test: the condition.
        holds: whether it does.
        bounds_in: gives the bounds of a part of it.
    """
    match test:
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return refine_branch(operand, holds=not holds, bounds_in=bounds_in)
        case ast.BoolOp(op=op, values=values):
            if isinstance(op, ast.And) is not holds:
                return {}
            found: KnownParts = {}
            for value in values:
                found |= refine_branch(value, holds=holds, bounds_in=_with_parts(found, bounds_in))
            return found
        case ast.Compare(left=left, ops=ops, comparators=others):
            if len(ops) > 1 and not holds:
                return {}
            found = {}
            for a, op, b in zip([left, *others], ops, others, strict=False):
                name = type(op).__name__ if holds else COMPARISONS[type(op).__name__].negated
                first, second = found.get(part_key(a)) or bounds_in(a), bounds_in(b)
                found[part_key(a)] = _refine_comparison(first, name, second)
                found[part_key(b)] = _refine_comparison(second, COMPARISONS[name].flipped, first)
            return found
        case _:
            return {part_key(test): _refine_truth(bounds_in(test), holds=holds)}


def _with_parts(
    found: KnownParts, bounds_in: Callable[[ast.expr], ExpressionBounds]
) -> Callable[[ast.expr], ExpressionBounds]:
    """Bounds a part, of which something may be known already."""
    return lambda node: found.get(part_key(node)) or bounds_in(node)


def _refine_truth(part: ExpressionBounds, *, holds: bool) -> ExpressionBounds:
    if part.values is not None:
        kept = tuple(value for value in part.values if bool(value) is holds)
        return replace(part, values=kept, exact=False) if kept else part
    if interval_of(part) is None:
        return part
    return replace(part, nonzero=True) if holds else ExpressionBounds(values=(0.0, 0))


def _refine_comparison(part: ExpressionBounds, name: str, other: ExpressionBounds) -> ExpressionBounds:
    """What is left of a number of which a comparison holds."""
    limits = interval_of(other)
    if limits is None:
        return part
    if part.values is not None:
        if interval_of(part) is None:
            return part
        kept = tuple(value for value in part.values if True in comparison_outcomes(name, (value, value), limits))
        return replace(part, values=kept, exact=False) if kept else part
    if part.items is not None:
        return part
    # What can be compared with a number is one.
    low = -math.inf if part.low is None else part.low
    high = math.inf if part.high is None else part.high
    if name in {"Lt", "LtE", "Eq"}:
        high = min(high, _below(limits[1], whole=part.whole) if name == "Lt" else limits[1])
    if name in {"Gt", "GtE", "Eq"}:
        low = max(low, -_below(-limits[0], whole=part.whole) if name == "Gt" else limits[0])
    nonzero = part.nonzero or (name == "NotEq" and limits == (0, 0)) or (name == "Eq" and not other.may_be_zero())
    if low > high:
        return part
    return ExpressionBounds(low=low, high=high, whole=part.whole, nonzero=nonzero)


def _below(limit: float, *, whole: bool) -> float:
    """The greatest number below a limit, or something above it."""
    if not abs(limit) < _MAX_EXACT_INTEGER:
        return limit
    return math.ceil(limit) - 1 if whole else math.nextafter(limit, -math.inf)


_SUBTRACTING = (ast.Sub, ast.USub)

_Terms = dict[str, tuple[float, ast.expr]]
"""A sum: by how a term is written, its factor and the term."""


def _add_terms(tree: ast.expr, factor: float, terms: _Terms) -> None:
    match tree:
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub(), right=right):
            _add_terms(left, factor, terms)
            _add_terms(right, -factor if isinstance(tree.op, _SUBTRACTING) else factor, terms)
        case ast.UnaryOp(op=ast.UAdd() | ast.USub(), operand=operand):
            _add_terms(operand, -factor if isinstance(tree.op, _SUBTRACTING) else factor, terms)
        case (
            ast.BinOp(left=ast.Constant(value=float() | int() as number), op=ast.Mult(), right=other)
            | ast.BinOp(left=other, op=ast.Mult(), right=ast.Constant(value=float() | int() as number))
        ):
            _add_terms(other, factor * number, terms)
        case ast.BinOp(left=other, op=ast.Div(), right=ast.Constant(value=float() | int() as number)) if number:
            _add_terms(other, factor / number, terms)
        case _:
            key = part_key(tree)
            terms[key] = (terms[key][0] + factor if key in terms else factor, tree)
