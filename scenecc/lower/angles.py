"""Angles and limits of joints, in radians or degrees, and a warning of radians that look like degrees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.lower.field_types import FieldType, number, vector
from scenecc.lower.key_reports import report_exclusive_keys
from scenecc.lower.variation import VariationLowerer, field_place
from scenecc.plan import Value, literal
from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.forms import Choice, Cycle, DrawForm, PerScene, SceneMap, Vector, alternatives
from scenecc.variation.nodes import NODE_TYPES, Radians

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Path, Sink
    from scenecc.lower.fields import FieldLowerer


_TWO_TURNS = 4 * math.pi * (1 + 1e-6)
"""Two turns: beyond, few angles are meant, and within, few are told from degrees [rad]."""


def warn_probable_degrees(written: Any, key: str, owner: Origin, at: Path, sink: Sink, *, more: str = "") -> None:
    """Warns of angles [rad] that are beyond two turns whatever is drawn.

    Nothing is said of expressions that read draws, and of what has no bounds.

    Args:
        written: a number or several, or forms of such.
        key: under which, which has a twin in degrees.
        owner: of the node that has the key.
        at: where it is there.
        sink: takes the warning.
        more: what else the hint says.
    """
    largest = suspect_degrees(written)
    if largest:
        warn_large_angle(largest, owner.child(*at), sink, hint=f"angles are radians; `{key}_deg` takes degrees{more}")


def warn_large_angle(angle: float, place: Origin, sink: Sink, *, hint: str) -> None:
    """Warns of an angle [rad]."""
    sink.report("SC526", f"{angle:g} radians are {angle / math.tau:.3g} turns", place, hint=hint)


def suspect_degrees(written: Any) -> float:
    """The largest angle that is beyond two turns in every scene; 0: none is.

    Of alternatives and bounds it is the smallest that counts.
    """
    sizes = _least_magnitude(written)
    return max((size for size in (sizes if sizes.__class__ is tuple else (sizes,)) if size > _TWO_TURNS), default=0.0)


def _least_magnitude(written: Any) -> Any:
    """How large a number is at least, or each of several; 0 where that is not known, or there is no limit."""
    if written.__class__ in {tuple, list}:
        return tuple(map(_least_magnitude, written))
    parts: tuple[Any, ...]
    match written:
        case int() | float():
            return abs(written) if math.isfinite(written) else 0.0
        case Vector(items):
            return tuple(map(_least_magnitude, items))
        case PerScene() | SceneMap() | Cycle() | Choice():
            parts = tuple(one for _, one in alternatives(written))
        case DrawForm(kind, operands) if (between := DISTRIBUTIONS[kind].between) and between[1] < len(operands):
            parts = (operands[between[0]], operands[between[1]])
        case _:
            return 0.0
    found = [_least_magnitude(part) for part in parts]
    if all(one.__class__ is tuple for one in found):
        return tuple(min(ones) for ones in zip(*found, strict=False))
    return 0.0 if any(one.__class__ is tuple for one in found) else min(found, default=0.0)


_DEGREES = FieldType(within=(0.0, 180.0))


def lower_angle(keys: Any, name: str, owner: Origin, leaves: FieldLowerer) -> Value | None:
    """An angle [rad]; None where neither key is given. Both are an error, which is reported.

    Args:
        keys: the model.
        name: of the key in radians.
        owner: of the node that has the keys.
        leaves: of the object.
    """
    radians, degrees = getattr(keys, name), getattr(keys, f"{name}_deg")
    if radians is not None and degrees is not None:
        message = f"`{name}` and `{name}_deg` are the same angle"
        report_exclusive_keys(name, f"{name}_deg", owner, leaves.sink, message=message, related="the other")
    if radians is not None:
        return leaves.value(radians, number(name), owner, name)
    if degrees is None:
        return None
    return _lower_degrees(degrees, _DEGREES, number(name), owner.child(f"{name}_deg"), leaves)


def _lower_degrees(written: Any, degrees: FieldType, radians: FieldType, origin: Origin, leaves: FieldLowerer) -> Value:
    """An angle, or several, that are written in degrees [rad].

    Args:
        written: under the key in degrees.
        degrees: what that key holds.
        radians: what the field holds.
        origin: of the key.
        leaves: of the object.
    """
    reading = VariationLowerer(leaves, origin)
    item = reading.item(written, degrees, field_place(origin))
    if item.__class__ in NODE_TYPES:
        return leaves.finish(Radians(item), reading, radians, origin)
    return literal(tuple(map(math.radians, item)) if radians.shape else math.radians(item))


_LIMITS = vector(2, "limits")


def lower_limits(keys: Any, origin: Origin, leaves: FieldLowerer) -> Value | None:
    """Lowest and highest position, (·, 2) [m or rad]; None where neither key is given.

    Args:
        keys: what has `limits` and `limits_deg`.
        origin: of it.
        leaves: of the entity.
    """
    if keys.limits_deg is None:
        return leaves.given(keys.limits, _LIMITS, origin, "limits")
    return _lower_degrees(keys.limits_deg, _LIMITS, _LIMITS, origin.child("limits_deg"), leaves)


def check_limits_keys(keys: Any, type_: str, origin: Origin, sink: Sink) -> None:
    """Reports limits that are written twice, and those in degrees of a joint that slides."""
    if keys.limits_deg is None:
        return
    if keys.limits is not None:
        report_exclusive_keys("limits", "limits_deg", origin, sink)
    elif type_ == "prismatic":
        message = "the positions of a prismatic joint are lengths, and `limits_deg` are angles"
        sink.report("SC111", message, origin.child("limits_deg"), at="key", hint="write `limits`, in metres")


def warn_limits_in_degrees(keys: Any, type_: str, origin: Origin, sink: Sink) -> None:
    """Warns of limits of a joint that turns which are probably in degrees."""
    if type_ != "prismatic":
        warn_probable_degrees(keys.limits, "limits", origin, ("limits",), sink, more=", for several turns too")
