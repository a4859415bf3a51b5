"""Walks the fields of a plan's objects, each with its path in the scene file."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, Final

from scenecc.plan.display import field_path, item_path
from scenecc.plan.schema import FieldKind, ListKind, ObjectKind, PlanField, UnionKind, plan_fields

if TYPE_CHECKING:
    from collections.abc import Iterator

_PARTS: Final = ("structures", "body", "inertial", "collisions", "visuals", "links", "mimics")
"""Fields that come after the other fields of their object, in this order."""


def walk_fields(node: Any, place: str = "") -> Iterator[tuple[str, FieldKind, Any]]:
    """Yields path, kind and value of each field of a plan object and of its nested objects.

    Skips fields that are None and the fields of materials, which are in tables of the plan.

    Args:
        node: a dataclass of the plan.
        place: its path below its entity, constraint, light or camera; "" for one of these.
    """
    for slot in _sort_fields(node.__class__):
        item, path = getattr(node, slot.name), field_path(place, slot.name, node.__class__)
        if item is None:
            continue
        if isinstance(slot.kind, ObjectKind | UnionKind):
            yield from walk_fields(item, path)
        elif isinstance(slot.kind, ListKind) and isinstance(slot.kind.item, ObjectKind | UnionKind):
            for index, one in enumerate(item):
                yield from walk_fields(one, item_path(path, index, one, count=len(item)))
        else:
            yield path, slot.kind, item


@cache
def _sort_fields(cls: type) -> tuple[PlanField, ...]:
    return tuple(sorted(plan_fields(cls), key=lambda slot: _PARTS.index(slot.name) + 1 if slot.name in _PARTS else 0))
