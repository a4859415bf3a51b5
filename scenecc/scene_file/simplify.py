"""Shortens documents without changing what they build: `repeat` for runs of equal items, and named materials."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any, Final

from scenecc.names import UniqueNames
from scenecc.scene_file import Node, is_list_node, is_mapping_node
from scenecc.scene_file.shared_keys import SHAPE_LISTS

_LEAST_COPIES: Final = 3
"""Minimum number of items for a `repeat`."""

_AXES: Final = ("x", "y", "z")

_Path = tuple[str | int, ...]
"""Keys and indices that lead to a value."""


def simplify(document: Mapping[str, Any]) -> Node:
    """Returns an equivalent, shorter document: materials used more than once get names, and runs of equal shapes and
    bodies become one with `repeat`.

    Args:
        document: a scene document; it is not changed.
    """
    found: Node = json.loads(json.dumps(document))
    _name_materials(found)
    for shapes in _shape_lists(found.get("entities", {})):
        shapes[:] = _fold_repeats(shapes)
    if "entities" in found:
        found["entities"] = _repeated_entities(found["entities"], _referred_to(found))
    return found


def _shape_lists(node: Any) -> Iterator[list[Node]]:
    if is_list_node(node):
        for item in node:
            yield from _shape_lists(item)
    elif is_mapping_node(node):
        for key, value in node.items():
            if key in SHAPE_LISTS and is_list_node(value):
                yield value
            else:
                yield from _shape_lists(value)


# ---- materials


def _name_materials(document: Node) -> None:
    """Names materials that occur more than once."""
    places: dict[str, list[tuple[Node, str]]] = {}
    for owner, holder in _materials(document.get("entities", {}), ""):
        places.setdefault(json.dumps(holder["material"], sort_keys=True), []).append((holder, owner))
    named: Node = document.get("materials", {})
    for holders in places.values():
        if len(holders) == 1:
            continue
        material = holders[0][0]["material"]
        name = _material_name(material, holders[0][1], named)
        named[name] = material
        for holder, _ in holders:
            holder["material"] = name
    if named:
        document["materials"] = named


def _materials(node: Any, owner: str) -> Iterator[tuple[str, Node]]:
    if is_list_node(node):
        for item in node:
            yield from _materials(item, owner)
    elif is_mapping_node(node):
        if is_mapping_node(node.get("material")) and not node["material"].keys() - {"physical", "visual"}:
            yield owner, node
        for key, value in node.items():
            if key != "material":
                yield from _materials(value, owner or key)


def _material_name(material: Node, owner: str, taken: Node) -> str:
    """Returns a name from the friction, or from the first entity with the material."""
    physical = material.get("physical", {})
    friction = physical.get("static_friction")
    if friction is not None and "visual" not in material:
        return UniqueNames(*taken).new(f"friction_{friction:g}")
    return UniqueNames(*taken).new(f"{owner.rsplit('/', maxsplit=1)[-1]}_surface")


# ---- repetition


def _fold_repeats(items: list[Node]) -> list[Node]:
    """Replaces runs of equal shapes by one with `repeat`."""
    found: list[Node] = []
    start = 0
    while start < len(items):
        end, node = _longest_run(items, start)
        found.append(items[start] if node is None else node)
        start = end
    return found


def _longest_run(items: Sequence[Node], start: int) -> tuple[int, Node | None]:
    end = _run_end(items, start, lambda _, __: True)
    return (end, _copies(items[start:end])) if end - start >= _LEAST_COPIES else (start + 1, None)


def _run_end(items: Sequence[Node], start: int, allows: Callable[[int, _Path], bool]) -> int:
    """Returns the end of the longest run that `_copies` can write: equal keys, and at most one value that differs.

    Args:
        items: all items.
        start: index of the first item of the run.
        allows: whether the run may contain an item, by its index and the path that differs in the run; (): no path.
    """
    first = items[start]
    if "repeat" in first:
        return start + 1
    path: _Path = ()
    for end in range(start + 1, len(items)):
        other = items[end]
        differing = {path, *_differing_paths(first, other, ())} - {()}
        if other.keys() != first.keys() or len(differing) > 1:
            return end
        path = differing.pop() if differing else path
        if path and (_holds_form(_value_at(first, path)) or _holds_form(_value_at(other, path))):
            return end
        if not allows(end, path):
            return end
    return len(items)


def _copies(items: Sequence[Node]) -> Node:
    """Returns one item with `repeat` for those of a run."""
    path = next((path for other in items[1:] for path in _differing_paths(items[0], other, ())), None)
    if path is None:
        return {"repeat": {"i": {"count": len(items)}}, **items[0]}
    variables, value = _loop(path, [_value_at(item, path) for item in items])
    return {"repeat": variables, **_with_value(items[0], path, value)}


def _loop(path: _Path, values: list[Any]) -> tuple[Node, Any]:
    """Returns the loop variables for values, and the expression that reads them."""
    key = str(next(part for part in reversed(path) if isinstance(part, str)))
    if all(is_list_node(value) and len(value) == len(values[0]) for value in values):
        moving = [axis for axis in range(len(values[0])) if any(value[axis] != values[0][axis] for value in values)]
        ranges = [list(dict.fromkeys(value[axis] for value in values)) for axis in moving]
        names = [_AXES[axis] if len(values[0]) == len(_AXES) else f"{key}_{axis}" for axis in moving]
        if [tuple(value[axis] for axis in moving) for value in values] == list(product(*ranges)):
            reader = [f"${{{names[moving.index(a)]}}}" if a in moving else number for a, number in enumerate(values[0])]
            return dict(zip(names, ranges, strict=True)), reader
    key = {"pose": "p", "q": "turn"}.get(key, key)
    return {key: values}, f"${{{key}}}"


def _differing_paths(first: Any, second: Any, path: _Path) -> Iterator[_Path]:
    """Yields the paths of differing values; a list of numbers is one value."""
    if is_mapping_node(first) and is_mapping_node(second) and first.keys() == second.keys():
        for key in first:
            yield from _differing_paths(first[key], second[key], (*path, key))
    elif (
        is_list_node(first)
        and is_list_node(second)
        and len(first) == len(second)
        and any(isinstance(item, dict | list) for item in first)
    ):
        for index, pair in enumerate(zip(first, second, strict=True)):
            yield from _differing_paths(*pair, (*path, index))
    elif first != second:
        yield path


def _value_at(node: Any, path: _Path) -> Any:
    for part in path:
        node = node[part]
    return node


def _with_value(node: Any, path: _Path, value: Any) -> Any:
    if not path:
        return value
    if is_mapping_node(node):
        return {key: _with_value(inner, path[1:], value) if key == path[0] else inner for key, inner in node.items()}
    return [_with_value(inner, path[1:], value) if index == path[0] else inner for index, inner in enumerate(node)]


def _holds_form(value: Any) -> bool:
    """Whether a loop variable cannot hold a value: mappings may be forms, and texts expressions."""
    if is_list_node(value):
        return any(map(_holds_form, value))
    return is_mapping_node(value) or (isinstance(value, str) and "${" in value)


_FIXED_KEYS: Final = frozenset(
    ("type", "body_type", "use", "anchor", "relative_to", "mount", "hidden", "scene_idxs", "variants")
)
"""Keys whose values cannot be expressions, or should not be."""


def _repeated_entities(entities: Node, referred: frozenset[str]) -> Node:
    names, found, start = list(entities), dict[str, Any](), 0
    nodes = list(entities.values())
    while start < len(names):
        end, node, name = _entity_run(names, nodes, start, referred)
        if node is None or name in found or (name in entities and name not in names[start:end]):
            found[names[start]] = nodes[start]
            start += 1
            continue
        found[name] = node
        start = end
    return found


def _entity_run(
    names: list[str], nodes: list[Node], start: int, referred: frozenset[str]
) -> tuple[int, Node | None, str]:
    stem, _, first = names[start].rpartition("_")
    numbered = start
    if stem and first == "0":
        numbers = range(start, len(names))
        numbered = next((index for index in numbers if names[index] != f"{stem}_{index - start}"), len(names))

    def allows(index: int, path: _Path) -> bool:
        """Returns whether a run contains an entity: its name follows, or it differs from the first in its name only."""
        return names[index] not in referred and (not path or (index < numbered and path[0] not in _FIXED_KEYS))

    end = start if names[start] in referred else _run_end(nodes, start, allows)
    if end - start < _LEAST_COPIES:
        return start + 1, None, names[start]
    node = _copies(nodes[start:end])
    if end <= numbered:
        return end, node, stem
    return end, {"name": "${name}", **node, "repeat": {"name": names[start:end]}}, f"{names[start]}_and_others"


def _referred_to(document: Node) -> frozenset[str]:
    """Returns names of entities that other parts of the document refer to."""
    found: set[str] = set()

    def visit(node: Any) -> None:
        """Collects the names in a node and below it."""
        if is_list_node(node):
            for item in node:
                visit(item)
        elif is_mapping_node(node):
            for key, value in node.items():
                if key in ("relative_to", "mount", "parent", "child") and isinstance(value, str):
                    found.add(value.split("/")[0])
                else:
                    visit(value)

    visit(document)
    return frozenset(found)
