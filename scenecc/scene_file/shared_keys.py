"""Joins collisions with equal visuals, and writes keys that several entries share once, above them."""

from __future__ import annotations

from collections.abc import Hashable
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.scene_file import Node

SHAPE_LISTS: Final = ("shapes", "collisions", "visuals")
"""Lists of a body or link: shapes that collide and are seen, that only collide, and that are only seen."""

_SEEN_AS: Final = {"convex_mesh": "mesh", "convex_parts": "mesh", "triangle_mesh": "mesh"}

_FORM: Final = (
    *("half_size", "radius", "half_length", "file", "scale", "size", "heights"),
    *("pose", "axis", "normal", "offset"),
)

_OWNERS: Final = {
    "material": SHAPE_LISTS,
    "color": ("shapes", "visuals"),
    "density": ("shapes", "collisions"),
    "collision_bits": ("shapes", "collisions"),
}
"""Key of a body or link → the lists of shapes that have it."""


def form_of(shape: Node) -> tuple[Any, ...]:
    """Returns type, sizes and place of a shape, which are hashable, and equal for a collision and its visual."""
    seen = _SEEN_AS.get(shape["type"], shape["type"])
    # The size of a plane is only seen.
    values = (None if (seen, key) == ("plane", "half_size") else shape.get(key) for key in _FORM)
    return seen, *(value if isinstance(value, Hashable) else repr(value) for value in values)


def merge_shapes(collision: Node, visual: Node) -> Node:
    """Returns a collision and a visual of the same form as one shape."""
    material = {**collision.get("material", {}), **visual.get("material", {})}
    merged = {**visual, **collision}
    return {**merged, "material": material} if material else merged


def move_up(node: Node, owners: Sequence[Node], key: str, least: int = 1) -> None:
    """Moves a key from entries to the node above them, if all of at least `least` entries have the same value."""
    value = owners[0].get(key) if len(owners) >= least else None
    if value is not None and all(owner.get(key) == value for owner in owners):
        node[key] = value
        for owner in owners:
            del owner[key]


def move_shape_keys_up(node: Node, *, is_link: bool, least: int = 1) -> None:
    """Moves keys that all shapes of a body or link share to it.

    Args:
        node: with lists of shapes.
        is_link: of an articulation, which has no key `color`.
        least: how many shapes must share `color` or `density`.
    """
    for key, lists in _OWNERS.items():
        if key != "color" or not is_link:
            owners = [shape for name in lists for shape in node.get(name, ())]
            move_up(node, owners, key, least if key in {"color", "density"} else 1)
