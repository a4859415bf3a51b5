"""What a scene file calls the fields of a plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.origin import dotted
from scenecc.plan.body import BodyStructure, CollisionShape, VisualShape

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin

NAMES: Final = {
    "disable_gravity": "gravity",
    "locked_motion_axes": "locked_axes",
    "collision_groups": "collision_bits",
}
"""Fields of a plan that a scene file calls otherwise."""


def shape_place(origin: Origin | None, otherwise: str) -> str:
    """A shape's place below its entity, as in the file that it was compiled from; `otherwise` where there is none."""
    path = () if origin is None else origin.path[2:]
    return dotted(path) if path and path[0] in {"shapes", "collisions", "visuals", "variants"} else otherwise


def field_place(above: str, name: str) -> str:
    """A field below what it stands in: a geometry's are its shape's."""
    if name in {"geometry", "structures"}:
        return above
    name = NAMES.get(name, name)
    return f"{above}.{name}" if above else name


def item_place(above: str, index: int, item: Any, *, count: int) -> str:
    """An item of a list below the list, `count` being how many there are: a single structure is the entity's own."""
    if isinstance(item, BodyStructure):
        return "" if count == 1 else f"variants[{index}]"
    place = f"{above}[{index}]"
    return shape_place(item.origin, place) if isinstance(item, CollisionShape | VisualShape) else place
