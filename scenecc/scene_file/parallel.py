"""Merges documents of single scenes into one document of parallel scenes, with forms for differing values."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

from scenecc.scene_file import Node, is_list_node, is_mapping_node

_STRUCTURE: Final = frozenset(
    re.findall(
        r"\w+",
        """
    type body_type axis decomposition decomposition_params sdf locked_axes collision_bits name front_face hidden
    beyond_limits mode width height mount srdf sapien_bits
    """,
    )
)
"""Keys that must have the same value in all scenes."""

_OF_ENTITY: Final = frozenset(("pose", "hidden"))
"""Keys of a body that are written beside `variants`."""


class UnlikeScenes(ValueError):
    """Raised if one document cannot represent the scenes; the message says why."""


def merge_scenes(documents: Sequence[Mapping[str, Any]]) -> Node:
    """Merges documents of one scene each.

    Args:
        documents: with the same `physics`.

    Raises:
        UnlikeScenes: they differ in what all parallel scenes must share.
    """
    count = len(documents)
    if count == 1:
        return dict(documents[0])
    merged: Node = {"scenecc": 1, "num_scenes": count}
    for section in ("physics",):
        values = [document.get(section) for document in documents]
        if any(value != values[0] for value in values):
            raise UnlikeScenes(f"the scenes differ in `{section}`")
        merged |= {} if values[0] is None else {section: values[0]}
    surroundings = [document.get("environment", {}) for document in documents]
    if any(surroundings):
        common = _merge_nodes(surroundings, count)
        if common is None:
            raise UnlikeScenes("the scenes differ in `environment`")
        merged["environment"] = common
    for section in ("entities", "constraints", "lights", "cameras"):
        nodes = _section([document.get(section, {}) for document in documents], count, section)
        merged |= {section: nodes} if nodes or section == "entities" else {}
    return merged


_DEFAULTS: Final = (("pose", [0.0, 0.0, 0.0]), ("enabled", True))
"""Keys that may be missing in some scenes, and their defaults."""


def _section(sections: list[Node], count: int, section: str) -> Node:
    merged: Node = {}
    for name in _names_in_order(sections):
        present = [index for index, nodes in enumerate(sections) if name in nodes]
        nodes = [sections[index][name] for index in present]
        for key, default in _DEFAULTS:
            if any(key in node for node in nodes):
                nodes = [node if key in node else {**node, key: default} for node in nodes]
        # A cycle counts all scenes, not only those with the object.
        node = _merge_nodes(nodes, count if len(present) == count else 0)
        if node is None and section == "entities" and not any(each.keys() & {"urdf", "mjcf", "root"} for each in nodes):
            node = _variants(nodes)
        if node is None:
            raise UnlikeScenes(f"`{name}` is built differently in different scenes")
        merged[name] = node if len(present) == count else {"scene_idxs": _indices(present), **node}
    return merged


def _names_in_order(sections: list[Node]) -> list[str]:
    """Returns all names, in an order that agrees with every scene as far as possible."""
    ordered: list[str] = []
    for section in sections:
        place = 0
        for name in section:
            if name in ordered:
                place = ordered.index(name) + 1
            else:
                ordered.insert(place, name)
                place += 1
    return ordered


def _indices(present: list[int]) -> Any:
    if present == list(range(present[0], present[-1] + 1)) and len(present) > 2:
        return f"{present[0]}:{present[-1] + 1}"
    return present


def _merge_nodes(nodes: list[Any], count: int) -> Any:
    """Merges the nodes of all scenes; None if their structure differs."""
    first = nodes[0]
    if all(node == first for node in nodes):
        return first
    if all(map(is_mapping_node, nodes)):
        return _merged_mappings(nodes, count)
    if all(map(is_list_node, nodes)) and any(map(is_mapping_node, first)):
        if any(len(node) != len(first) for node in nodes):
            return None
        items = [_merge_nodes(list(column), count) for column in zip(*nodes, strict=True)]
        return None if None in items else items
    alike = all(isinstance(node, type(first)) or _are_numbers(node, first) for node in nodes)
    return _form(nodes, count) if alike else None


def _merged_mappings(nodes: list[Node], count: int) -> Node | None:
    first = nodes[0]
    if any(node.keys() != first.keys() for node in nodes):
        return None
    found: Node = {}
    for key in first:
        values = [node[key] for node in nodes]
        differ = any(value != values[0] for value in values)
        if key == "pose" and differ:
            found[key] = _form(values, count)
        else:
            found[key] = None if key in _STRUCTURE and differ else _merge_nodes(values, count)
    return None if None in found.values() else found


def _are_numbers(first: Any, second: Any) -> bool:
    return all(isinstance(each, int | float) and not isinstance(each, bool) for each in (first, second))


def _form(values: list[Any], count: int) -> Any:
    if all(value == values[0] for value in values):
        return values[0]
    for period in range(2, count // 2 + 1):
        if all(value == values[index % period] for index, value in enumerate(values)):
            return {"cycle": values[:period]}
    return {"per_scene": values}


def _variants(nodes: list[Node]) -> Node | None:
    """Merges bodies with different structure into `variants`."""
    outside = [{key: value for key, value in node.items() if key in _OF_ENTITY} for node in nodes]
    common = _merge_nodes(outside, len(nodes))
    if common is None:
        return None
    inside = [{key: value for key, value in node.items() if key not in _OF_ENTITY} for node in nodes]
    distinct: list[Node] = []
    for node in inside:
        if node not in distinct:
            distinct.append(node)
    pick = _form([distinct.index(node) for node in inside], len(nodes))
    return {"variants": distinct, "pick": pick, **common}
