"""What a scene file calls the fields of a plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.origin import dotted
from scenecc.plan.articulation import ArticulationStructure
from scenecc.plan.body import BodyStructure, CollisionShape, VisualShape

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin

NAMES: Final = {
    "disable_gravity": "gravity",
    "locked_motion_axes": "locked_axes",
    "collision_groups": "collision_bits",
}
"""Fields of a plan that a scene file calls otherwise."""


_ITS_HOLDERS: Final = frozenset(
    {
        ("Link", "body"),
        ("Constraint", "joint"),
        ("AxisLimit", "limits"),
        ("Light", "light"),
        ("Camera", "lens"),
    }
)
"""Fields whose own fields a scene file has where they stand, by the dataclass that has them."""

_LISTS: Final = ("shapes", "collisions", "visuals")


def shape_place(origin: Origin | None, otherwise: str) -> str:
    """A shape's place below its entity, as in the file that it was compiled from; `otherwise` where there is none."""
    path = () if origin is None else origin.path[2:]
    return dotted(path) if path and path[0] in {*_LISTS, "variants"} else otherwise


def shape_in_link(above: str, origin: Origin | None, otherwise: str) -> str:
    """A shape's place below its link, likewise: a link of a file's own tree has shapes as a body has."""
    path = () if origin is None else origin.path
    last = max((place for place, key in enumerate(path) if place > 1 and key in _LISTS), default=None)
    return otherwise if last is None else f"{above.rpartition('.')[0]}.{dotted(path[last:])}"


def field_place(above: str, name: str, holder: type | None = None) -> str:
    """A field below what it stands in: a geometry's are its shape's, and a lens's are its camera's.

    Args:
        above: where the dataclass is that has it.
        name: of the field.
        holder: the type of that dataclass.
    """
    if name in {"geometry", "structures"} or (holder is not None and (holder.__name__, name) in _ITS_HOLDERS):
        return above
    name = NAMES.get(name, name)
    return f"{above}.{name}" if above else name


def name_place(name: str) -> str:
    """What follows a list whose items are found by name."""
    return dotted(("", name))[len('[""]') :]


def item_place(above: str, index: int, item: Any, *, count: int) -> str:
    """An item of a list below the list, `count` being how many there are: a single structure is the entity's own."""
    if isinstance(item, BodyStructure | ArticulationStructure):
        return "" if count == 1 else f"variants[{index}]"
    place = f"{above}[{index}]"
    if not isinstance(item, CollisionShape | VisualShape):
        return place
    return shape_in_link(above, item.origin, place) if "links." in above else shape_place(item.origin, place)
