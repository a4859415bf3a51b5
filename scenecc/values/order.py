"""Which shared draws a draw reads, in the order in which they can be made: a chain of them may be long."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

from scenecc.values.nodes import NODE_TYPES, NODES, Computed, Shared

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.values.nodes import Node

BUILT_IN = frozenset(("scene", "num_scenes"))
"""Names that every expression can read, and that are no draws."""

_MANY = NODE_TYPES | {tuple}
_FIELDS = {kind: tuple(field.name for field in fields(kind)) for kind in NODES}


def read_by(node: Node) -> list[str]:
    """The shared draws that a node reads, in any scene; not those that these read."""
    found: dict[str, None] = {}
    todo: list[Any] = [node]
    while todo:
        item = todo.pop()
        kind = item.__class__
        if kind is Shared:
            found[item.name] = None
        elif kind is Computed:
            reads = dict(item.reads)
            found.update(dict.fromkeys(reads.get(name, name) for name in sorted(item.template.names - BUILT_IN)))
        elif kind is tuple:
            todo += [part for part in item if part.__class__ in _MANY]
        elif kind in _FIELDS:
            parts = [getattr(item, name) for name in _FIELDS[kind]]
            todo += [part for part in parts if part.__class__ in _MANY]
    return list(found)


def needed(name: str, draws: Mapping[str, Node], is_made: Callable[[str], bool]) -> list[str]:
    """A shared draw and all that have to be made before it, each after those that it reads.

    Args:
        name: of it.
        draws: the shared draws by name.
        is_made: whether nothing is to be done for one.
    """
    ordered: dict[str, None] = {}
    opened: set[str] = set()
    todo = [name]
    while todo:
        last = todo[-1]
        if last not in opened:
            opened.add(last)
            todo += [other for other in read_by(draws[last]) if other not in opened and not is_made(other)]
        else:
            todo.pop()
            ordered[last] = None
    return list(ordered)
