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

SHAPE_LISTS = frozenset(("shapes", "collisions", "visuals"))
"""Keys of the lists whose items may be repeated."""

PER_OBJECT = 8
"""How many values count as an object."""

FORM = 4
"""How many values a form counts for beside those that it holds."""

ROBOTS = frozenset(("root", "urdf", "mjcf"))
ROBOT = 8
"""For how many objects a robot counts beside its shapes."""

CHARACTERS = 64
"""How many characters of a text that was made count as an object."""

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
            if not VARIATION_FORMS.isdisjoint(item):
                count += FORM
        elif is_sequence(item):
            waiting += item
        else:
            count += 1 + (len(item) // _PER_VALUE if isinstance(item, str) and "${" in item else 0)
    return count + len(waiting)


def weight(node: Any) -> int:
    """For how many objects something counts that has a name: for each of its shapes, and more where it is long."""
    if not is_mapping(node):
        return max(1, count_values(node) // PER_OBJECT)
    robot = ROBOT if not ROBOTS.isdisjoint(node) else 0
    return max(1, count_values(node) // PER_OBJECT, _shapes(node)) + robot


def beyond(made: Any) -> int:
    """For how many objects a text or list counts that an expression gave, beside the object that it is part of."""
    return len(made) // CHARACTERS if made.__class__ is str else count_values(made) // PER_OBJECT


def _shapes(node: dict[str, Any]) -> int:
    """How many shapes an entity has as written, in all of its variants or links."""
    count = sum(len(node[key]) for key in SHAPE_LISTS if is_sequence(node.get(key)))
    if is_mapping(root := node.get("root")):
        count += _shapes(root)
    parts = node.get("variants", node.get("children"))
    return count + sum(map(_shapes, filter(is_mapping, parts))) if is_sequence(parts) else count


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
