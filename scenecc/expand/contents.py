"""What is inside of a value: how much, whether any of it varies or has failed, where its lists by scene are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.expand.run import Failed
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.features import VARIATION_FORMS
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.values.template import Template

if TYPE_CHECKING:
    from scenecc.diagnostics import Path

_PER_VALUE = 8
"""How many characters of an expression count as one more value: each may be an operation."""


def count_values(node: Any, most: int | None = None) -> int:
    """How many values a node holds, repeated items counted once, and long expressions as several.

    No more than `most` are counted: lists of lists that were made by expressions may hold far more than can be.
    """
    waiting, count = [node], 0
    while waiting and (most is None or count + len(waiting) <= most):
        item = waiting.pop()
        if is_mapping(item):
            waiting += item.values()
        elif is_sequence(item):
            waiting += item
        else:
            count += 1 + (len(item) // _PER_VALUE if isinstance(item, str) and "${" in item else 0)
    return count + len(waiting)


def is_varying(value: Any) -> bool:
    """Whether a value that was made still differs from scene to scene: it holds a template or a form."""
    if isinstance(value, Template):
        return True
    if is_mapping(value):
        return not VARIATION_FORMS.isdisjoint(value) or any(map(is_varying, value.values()))
    return is_sequence(value) and any(map(is_varying, value))


def has_failed(value: Any) -> bool:
    """Whether something in a value that was made has none."""
    if is_mapping(value):
        return any(map(has_failed, value.values()))
    return any(map(has_failed, value)) if is_sequence(value) else isinstance(value, Failed)


def find_per_scene_lists(node: Any, path: Path) -> list[Path]:
    """Where a node holds `per_scene` lists."""
    found: list[Path] = []
    if is_mapping(node):
        for key, item in node.items():
            if key == "per_scene" and is_sequence(item):
                found.append((*path, key))
            elif not key.startswith(NOTE_PREFIX):
                found += find_per_scene_lists(item, (*path, key))
    elif is_sequence(node):
        for index, item in enumerate(node):
            found += find_per_scene_lists(item, (*path, index))
    return found
