"""Whether a document is to be expanded at all."""

from __future__ import annotations

from typing import Any

from scenecc.spec.plain import is_mapping, is_sequence

_AT_THE_TOP = ("params", "draws", "include")
_OF_ENTITIES = frozenset(("use", "if", "repeat", "name"))
_COPIES = frozenset(("if", "repeat", "name"))
_KEYS = {"entities": _OF_ENTITIES, "constraints": _COPIES, "lights": _COPIES, "cameras": _COPIES}
_OF_SHAPES = ("shapes", "collisions", "visuals")


def needs_expansion(data: dict[str, Any], text: str | None) -> bool:
    """Whether a document uses parameters, draws, includes, repetition, conditions, prefabs or expressions.

    Costs next to nothing where there is a text: what is to be expanded must be spelled out in it.

    Args:
        data: of the document.
        text: that it was read from; None for a dict.
    """
    if any(key in data for key in _AT_THE_TOP):
        return True
    entities = data.get("entities")
    for section, keys in _KEYS.items():
        nodes = data.get(section)
        if is_mapping(nodes):
            for node in nodes.values():
                if is_mapping(node) and not keys.isdisjoint(node):
                    return True
    # A backslash may stand for any character.
    if text is None or "\\" in text:
        return _has_expression(data) or _repeats(entities)
    # The word alone is no repetition: textures have it too.
    return "${" in text or ("repeat" in text and _repeats(entities))


def _has_expression(node: Any) -> bool:
    if isinstance(node, str):
        return "${" in node
    if is_mapping(node):
        return any(map(_has_expression, node.values()))
    return is_sequence(node) and any(map(_has_expression, node))


def _repeats(entities: Any) -> bool:
    """Whether any of the bodies repeats a shape."""
    return is_mapping(entities) and any(_repeats_a_shape(body) for body in entities.values() if is_mapping(body))


def _repeats_a_shape(body: dict[str, Any]) -> bool:
    for key in _OF_SHAPES:
        shapes = body.get(key)
        if is_sequence(shapes) and any(is_mapping(shape) and "repeat" in shape for shape in shapes):
            return True
    if is_mapping(root := body.get("root")):
        return _repeats_a_shape(root)
    # Variants, or the links that hang on one.
    parts = body.get("variants", body.get("children"))
    return is_sequence(parts) and any(is_mapping(one) and _repeats_a_shape(one) for one in parts)
