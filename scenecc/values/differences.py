"""How far two expressions are apart, where they may read the same: bounds of each alone cannot know that."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from scenecc.values.interval_rules import binary
from scenecc.values.intervals import reach_in
from scenecc.values.narrowing import written
from scenecc.values.reach import Reach, bounds_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.values.interval_rules import Interval
    from scenecc.values.template import Template

_NEGATIVE = (ast.Sub, ast.USub)

Terms = dict[str, tuple[float, ast.expr]]
"""A sum: by how a term is written, its factor and the term."""


def difference(a: Template, b: Template, names: Mapping[str, Reach]) -> Interval | None:
    """The bounds of a - b, as a sum of terms; None where that is not made of numbers.

    Args:
        a: a scalar's text.
        b: another one's.
        names: what their free names can be.
    """
    constants = {**dict(a.constants), **dict(b.constants)}
    if constants != {**dict(b.constants), **dict(a.constants)}:
        return None
    parts = [*a.expressions(), *b.expressions()]
    if len(parts) != 2 or isinstance(parts[0], str) or isinstance(parts[1], str):
        return None
    terms: Terms = {}
    _add(parts[0].tree, 1.0, terms)
    _add(parts[1].tree, -1.0, terms)
    find = reach_in(parts[0], names, constants)
    total: Interval = (0.0, 0.0)
    for factor, term in terms.values():
        found = bounds_of(find(term))
        if found is None:
            return None
        total = binary("Add", total, binary("Mult", (factor, factor), found, whole=False), whole=False)
    return total


def _add(tree: ast.expr, factor: float, terms: Terms) -> None:
    match tree:
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub(), right=right):
            _add(left, factor, terms)
            _add(right, -factor if isinstance(tree.op, _NEGATIVE) else factor, terms)
        case ast.UnaryOp(op=ast.UAdd() | ast.USub(), operand=operand):
            _add(operand, -factor if isinstance(tree.op, _NEGATIVE) else factor, terms)
        case (
            ast.BinOp(left=ast.Constant(value=float() | int() as number), op=ast.Mult(), right=other)
            | ast.BinOp(left=other, op=ast.Mult(), right=ast.Constant(value=float() | int() as number))
        ):
            _add(other, factor * number, terms)
        case ast.BinOp(left=other, op=ast.Div(), right=ast.Constant(value=float() | int() as number)) if number:
            _add(other, factor / number, terms)
        case _:
            key = written(tree)
            terms[key] = (terms[key][0] + factor if key in terms else factor, tree)
