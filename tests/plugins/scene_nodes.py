"""What stands where in a scene document, for the rules of the strategies: entities, links, shapes, and who is where."""

from __future__ import annotations

import math
from collections.abc import Iterator
from random import Random
from typing import Any

Node = dict[str, Any]

SHAPE_LISTS = ("shapes", "collisions", "visuals")
KINDS = ("urdf", "mjcf", "root")
COPIES = ("repeat", "if", "name")
FALLBACK: Node = {"type": "sphere", "radius": 0.5}
"""A shape that any body may have."""


def nodes(node: Any) -> Iterator[Node]:
    """Every mapping of a document."""
    if isinstance(node, dict):
        yield node
    for item in node.values() if isinstance(node, dict) else node if isinstance(node, list) else ():
        yield from nodes(item)


def bodies(document: Node) -> list[Node]:
    """The entities that are one body."""
    return [entity for entity in document.get("entities", {}).values() if not any(key in entity for key in KINDS)]


def articulations(document: Node) -> list[Node]:
    """The entities that are articulations."""
    return [entity for entity in document.get("entities", {}).values() if any(key in entity for key in KINDS)]


def units(document: Node) -> list[Node]:
    """The articulations and the parts that are attached to them, each part before what it is attached to."""
    return [unit for entity in articulations(document) for unit in _units(entity)]


def _units(node: Node) -> Iterator[Node]:
    for part in node.get("attach", {}).values():
        yield from _units(part)
    yield node


def links(entity: Node) -> list[tuple[Node, Node | None]]:
    """The links of a tree, each with the one that it hangs on, before those that hang on it; none of a file."""
    found: list[tuple[Node, Node | None]] = []
    waiting: list[tuple[Node, Node | None]] = [(entity["root"], None)] if "root" in entity else []
    while waiting:
        link, parent = waiting.pop()
        found.append((link, parent))
        waiting += [(child, link) for child in reversed(link.get("children", []))]
    return found


def shapes(body: Node, *lists: str) -> list[Node]:
    """The shapes of a body or a link in some of its lists."""
    return [shape for name in lists for shape in body.get(name, [])]


def colliding(body: Node) -> list[Node]:
    return shapes(body, "shapes", "collisions")


def scenes_of(node: Node, document: Node) -> frozenset[int]:
    """The scenes that something selects."""
    every = range(document.get("num_scenes", 1))
    written = node.get("scene_idxs", ":")
    found: set[int] = set()
    for item in [written] if isinstance(written, str) else written:
        if isinstance(item, int):
            found.add(item)
        else:
            found.update(every[slice(*(int(part) if part else None for part in item.split(":")))])
    return frozenset(found)


def is_copied(node: Node) -> bool:
    """Whether there are none, or several, of what is written: nothing else names it."""
    return any(key in node for key in COPIES)


def drop(node: Node, *keys: str) -> None:
    for key in keys:
        node.pop(key, None)


def keep_one(node: Node, random: Random, *groups: tuple[str, ...]) -> None:
    """Of some groups of keys that exclude one another, what is there of one."""
    present = [group for group in groups if any(key in node for key in group)]
    kept = random.choice(present) if present else ()
    for group in groups:
        if group is not kept:
            drop(node, *(key for key in group if key not in kept))


def ascending(pair: list[float], random: Random) -> list[float]:
    """Limits the right way round, of which one may be missing."""
    low, high = sorted(pair)
    return random.choice([[low, high], [low, high], [low, math.inf], [-math.inf, high]])
