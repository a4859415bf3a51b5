"""Writes scene documents as readable files: YAML layout and simplification."""

from __future__ import annotations

from typing import Any, TypeGuard

Node = dict[str, Any]
"""A mapping of a scene document."""


def is_mapping_node(value: object) -> TypeGuard[Node]:
    """Whether a node is a mapping."""
    return isinstance(value, dict)


def is_list_node(value: object) -> TypeGuard[list[Any]]:
    """Whether a node is a list."""
    return isinstance(value, list)
