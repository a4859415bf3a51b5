"""Limits of joints as the scene file writes them, in radians, metres or degrees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.lower.forms import Reading, place_of
from scenecc.lower.kinds import vector
from scenecc.lower.turns import doubt
from scenecc.plan import Value, literal
from scenecc.variation.nodes import NODES, Radians

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.leaves import Leaves

_LIMITS = vector(2, "limits")


def limits_of(keys: Any, origin: Origin, leaves: Leaves) -> Value | None:
    """Lowest and highest position, (·, 2) [m or rad]; None where neither key is given.

    Args:
        keys: what has `limits` and `limits_deg`.
        origin: of it.
        leaves: of the entity.
    """
    if keys.limits_deg is None:
        return leaves.given(keys.limits, _LIMITS, origin, "limits")
    place = place_of(origin.child("limits_deg"))
    reading = Reading(leaves, place.origin)
    item = reading.item(keys.limits_deg, _LIMITS, place)
    if item.__class__ in NODES:
        return leaves.finish(Radians(item), reading, _LIMITS, place.origin)
    return literal(tuple(map(math.radians, item)))


def limits_fit(keys: Any, type_: str, origin: Origin, sink: Sink) -> None:
    """Reports limits that are written twice, and those in degrees of a joint that slides."""
    if keys.limits_deg is None:
        return
    place = origin.child("limits_deg")
    if keys.limits is not None:
        message = "`limits` and `limits_deg` exclude each other"
        sink.report("SC111", message, place, at="key", related=[("the first", origin.child("limits"), "key")])
    elif type_ == "prismatic":
        message = "the positions of a prismatic joint are lengths, and `limits_deg` are angles"
        sink.report("SC111", message, place, at="key", hint="write `limits`, in metres")


def doubt_limits(keys: Any, type_: str, origin: Origin, sink: Sink) -> None:
    """Warns of limits of a joint that turns which are probably in degrees."""
    if type_ != "prismatic":
        doubt(keys.limits, "limits", origin, ("limits",), sink, more=", for several turns too")
