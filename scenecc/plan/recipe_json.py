"""Recipes as plain data: each node an object with its `type`, and its fields as the dataclass has them."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Any

from scenecc.plan.fields import type_name
from scenecc.variation.nodes import NODES, Drawn, Key
from scenecc.variation.template import Template

if TYPE_CHECKING:
    from scenecc.variation.nodes import Node


_DRAWN = frozenset(("kind", "operands"))
"""Fields of a draw that are written by its distribution."""


def recipe_data(node: Node) -> dict[str, Any]:
    """A node as JSON has it. What is None, or the default of its field, is left out."""
    if isinstance(node, Drawn):
        return {"type": type_name(Drawn), "kind": node.kind, **_operands(node), **_members(node)}
    return {"type": type_name(type(node)), **_members(node)}


def _operands(node: Drawn) -> dict[str, Any]:
    """The operands of a draw, by the names that its distribution gives them."""
    drawn = node.distribution
    named = {name: _data(item) for name, item in zip(drawn.members, node.operands, strict=False)}
    edges = _data(node.operands[len(drawn.members) :])
    return {**named, str(drawn.companion): edges} if edges else named


def _members(node: Any) -> dict[str, Any]:
    given = [(item, getattr(node, item.name)) for item in fields(node) if item.name not in _DRAWN]
    return {
        item.name: _data(value)
        for item, value in given
        if value is not None and (item.default is MISSING or not _is_same(value, item.default))
    }


def _is_same(value: Any, default: Any) -> bool:
    """To the bit: 0 and -0.0 are equal to 0.0, and others."""
    return type(value) is type(default) and repr(value) == repr(default)


def _data(item: Any) -> Any:
    if isinstance(item, NODES):
        return recipe_data(item)
    if isinstance(item, Key):
        return _members(item)
    if isinstance(item, Template):
        constants = {name: _data(value) for name, value in item.constants}
        return {"text": item.text, **({"constants": constants} if constants else {})}
    if isinstance(item, tuple | list):
        several: list[Any] = list(item)  # pyright: ignore[reportUnknownArgumentType]
        return [_data(one) for one in several]
    return item
