"""Angles that a key gives in radians, or another of the same name and `_deg` in degrees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.lower.forms import VARYING, Reading, place_of
from scenecc.lower.kinds import Kind, number
from scenecc.plan import Value, literal
from scenecc.variation.nodes import NODE_TYPES, Radians

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.lower.leaves import Leaves

_DEGREES = Kind(within=(0.0, 180.0))


def angle(keys: Any, name: str, owner: Origin, leaves: Leaves) -> Value | None:
    """An angle [rad]; None where neither key is given. Both are an error, which is reported.

    Args:
        keys: the model.
        name: of the key in radians.
        owner: of the node that has the keys.
        leaves: of the object.
    """
    radians, degrees = getattr(keys, name), getattr(keys, f"{name}_deg")
    if radians is not None and degrees is not None:
        leaves.sink.report(
            "SC111",
            f"`{name}` and `{name}_deg` are the same angle",
            owner.child(f"{name}_deg"),
            at="key",
            related=[("the other", owner.child(name), "key")],
        )
    if radians is not None:
        return leaves.value(radians, number(name), owner, name)
    if degrees is None:
        return None
    if degrees.__class__ not in VARYING:
        return literal(math.radians(degrees))
    place = place_of(owner.child(f"{name}_deg"))
    reading = Reading(leaves, place.origin)
    item = reading.item(degrees, _DEGREES, place)
    made = Radians(item) if item.__class__ in NODE_TYPES else math.radians(item)
    return leaves.finish(made, reading, number(name), place.origin)
