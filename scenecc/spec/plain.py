"""Plain data, as the reader gives it: what a node is, in words that a type checker understands."""

from __future__ import annotations

from typing import Any, TypeGuard

EXPRESSION = "${"
"""What a text holds that has an expression in it."""


def is_mapping(node: Any) -> TypeGuard[dict[str, Any]]:
    """Whether a node is a mapping; the reader lets no key through that is not a string."""
    return isinstance(node, dict)


def is_sequence(node: Any) -> TypeGuard[list[Any] | tuple[Any, ...]]:
    """Whether a node is a list. (Pydantic reports some as the tuple that it made of one.)"""
    return isinstance(node, list | tuple)
