"""What plain data hold: how many objects, whether any of it varies or has failed, and whether it needs expansion."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Origin
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.nodes import EXPRESSION_START, is_mapping, is_sequence
from scenecc.variation.forms import FORM_KEYS
from scenecc.variation.template import Template

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Path, Sink
    from scenecc.source import Document, Limits


SHAPE_LISTS = frozenset(("shapes", "collisions", "visuals"))
"""Keys of the lists whose items may be repeated."""

VALUES_PER_OBJECT = 8
"""How many values count as an object."""

VALUES_PER_FORM = 4
"""How many values a form counts for beside those that it holds."""

ROBOT_KEYS = frozenset(("root", "urdf", "mjcf"))
OBJECTS_PER_ROBOT = 8
"""For how many objects a robot counts beside its shapes."""

CHARACTERS_PER_OBJECT = 64
"""How many characters of a text that was made count as an object."""

_CHARACTERS_PER_VALUE = 8
"""How many characters of an expression count as one more value: each may be an operation."""


class FailedValue(str):
    """Stands for a scalar whose value was reported, or reads something that was; nothing more is said about it."""

    __slots__ = ()


def count_values(node: Any, most: int | None = None) -> int:
    """How many values a node holds, repeated items counted once, and long expressions as several.

    No more than `most` are counted: lists of lists that were made by expressions may hold far more than can be.
    """
    waiting, count = [node], 0
    while waiting and (most is None or count + len(waiting) <= most):
        item = waiting.pop()
        if is_mapping(item):
            waiting += item.values()
            if not FORM_KEYS.isdisjoint(item):
                count += VALUES_PER_FORM
        elif is_sequence(item):
            waiting += item
        else:
            count += 1 + (len(item) // _CHARACTERS_PER_VALUE if isinstance(item, str) and "${" in item else 0)
    return count + len(waiting)


def count_objects(node: Any) -> int:
    """For how many objects something counts that has a name: for each of its shapes, and more where it is long."""
    if not is_mapping(node):
        return max(1, count_values(node) // VALUES_PER_OBJECT)
    robot = OBJECTS_PER_ROBOT if not ROBOT_KEYS.isdisjoint(node) else 0
    return max(1, count_values(node) // VALUES_PER_OBJECT, _count_shapes(node)) + robot


def count_added_objects(made: Any) -> int:
    """For how many objects a text or list counts that an expression gave, beside the object that it is part of."""
    return len(made) // CHARACTERS_PER_OBJECT if made.__class__ is str else count_values(made) // VALUES_PER_OBJECT


def _count_shapes(node: dict[str, Any]) -> int:
    """How many shapes an entity has as written, in all of its variants or links."""
    count = sum(len(node[key]) for key in SHAPE_LISTS if is_sequence(node.get(key)))
    if is_mapping(root := node.get("root")):
        count += _count_shapes(root)
    parts = node.get("variants", node.get("children"))
    return count + sum(map(_count_shapes, filter(is_mapping, parts))) if is_sequence(parts) else count


def iterate_texts(node: Any) -> Iterator[str]:
    """The texts in a node, in any order."""
    todo = [node]
    while todo:
        item = todo.pop()
        if isinstance(item, str):
            yield item
        elif is_mapping(item):
            todo += item.values()
        elif is_sequence(item):
            todo += item


def is_varying(value: Any) -> bool:
    """Whether a value that was made still differs from scene to scene: it holds a template or a form."""
    if isinstance(value, Template):
        return True
    if is_mapping(value):
        return not FORM_KEYS.isdisjoint(value) or any(map(is_varying, value.values()))
    return is_sequence(value) and any(map(is_varying, value))


def has_failed(value: Any) -> bool:
    """Whether something in a value that was made has none."""
    if is_mapping(value):
        return any(map(has_failed, value.values()))
    return any(map(has_failed, value)) if is_sequence(value) else isinstance(value, FailedValue)


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


_MIN_OBJECT_CHARACTERS = 10
"""How long the text of an object is at least [characters]."""


def is_within_object_limit(document: Document, limits: Limits, sink: Sink) -> bool:
    """Whether a text holds no more objects than there may be; otherwise that is reported."""
    text = document.text or ""
    if len(text) < _MIN_OBJECT_CHARACTERS * limits.objects or _max_objects(text, document.data) <= limits.objects:
        return True
    sections = (node for key, node in document.data.items() if not key.startswith(NOTE_PREFIX))
    count = sum(
        sum(map(count_objects, node.values())) if is_mapping(node) else count_objects(node) for node in sections
    )
    if count <= limits.objects:
        return True
    message = f"{count} objects, or as much as these hold, are more than the limit of {limits.objects}"
    hint = "raise it with --limit objects=N or limits={'objects': N}"
    sink.report("SC604", message, Origin(document.name), hint=hint)
    return False


def _max_objects(text: str, data: dict[str, Any]) -> float:
    """No fewer objects than a text holds, found by its letters alone: walking its data takes a tenth of all checks."""
    if "\\" in text:  # a key may be written in escapes
        return inf
    values = sum(map(text.count, (",", "\n", "[", "{", "- ")))
    forms, robots, shapes = (sum(map(text.count, keys)) for keys in (FORM_KEYS, ROBOT_KEYS, ("type",)))
    named = sum(len(node) for node in data.values() if is_mapping(node))
    expressions = len(text) / CHARACTERS_PER_OBJECT if "${" in text else 0
    return (
        named
        + shapes
        + OBJECTS_PER_ROBOT * robots
        + (values + VALUES_PER_FORM * forms) / VALUES_PER_OBJECT
        + expressions
    )


_TOP_LEVEL_KEYS = ("params", "draws", "include")
_ENTITY_KEYS = frozenset(("use", "if", "repeat", "name"))
_COPY_KEYS = frozenset(("if", "repeat", "name"))
_EXPANDED_KEYS = {"entities": _ENTITY_KEYS, "constraints": _COPY_KEYS, "lights": _COPY_KEYS, "cameras": _COPY_KEYS}


def needs_expansion(data: dict[str, Any], text: str | None) -> bool:
    """Whether a document uses parameters, draws, includes, repetition, conditions, prefabs or expressions.

    Costs next to nothing where there is a text: what is to be expanded must be spelled out in it.

    Args:
        data: of the document.
        text: that it was read from; None for a dict.
    """
    if any(key in data for key in _TOP_LEVEL_KEYS):
        return True
    entities = data.get("entities")
    for section, keys in _EXPANDED_KEYS.items():
        nodes = data.get(section)
        if is_mapping(nodes):
            for node in nodes.values():
                if is_mapping(node) and not keys.isdisjoint(node):
                    return True
    # A backslash may stand for any character.
    if text is None or "\\" in text:
        return any(EXPRESSION_START in one for one in iterate_texts(data)) or _repeats(entities)
    # The word alone is no repetition: textures have it too.
    return "${" in text or ("repeat" in text and _repeats(entities))


def _repeats(entities: Any) -> bool:
    """Whether any of the bodies repeats a shape."""
    return is_mapping(entities) and any(_repeats_a_shape(body) for body in entities.values() if is_mapping(body))


def _repeats_a_shape(body: dict[str, Any]) -> bool:
    for key in SHAPE_LISTS:
        shapes = body.get(key)
        if is_sequence(shapes) and any(is_mapping(shape) and "repeat" in shape for shape in shapes):
            return True
    if is_mapping(root := body.get("root")):
        return _repeats_a_shape(root)
    # Variants, or the links that hang on one.
    parts = body.get("variants", body.get("children"))
    return is_sequence(parts) and any(is_mapping(one) and _repeats_a_shape(one) for one in parts)
