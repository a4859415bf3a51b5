"""Angles in radians that are so large that degrees were probably meant."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.variation.forms import MISSING, Choice, Cycle, Integers, LogUniform, PerScene, SceneMap, Uniform, Vector

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Path, Sink

_MOST = 4 * math.pi * (1 + 1e-6)
"""Two turns: beyond, few angles are meant, and within, few are told from degrees [rad]."""


def doubt(written: Any, key: str, owner: Origin, at: Path, sink: Sink, *, more: str = "") -> None:
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
    largest = far(written)
    if largest:
        report(largest, owner.child(*at), sink, hint=f"angles are radians; `{key}_deg` takes degrees{more}")


def report(angle: float, place: Origin, sink: Sink, *, hint: str) -> None:
    """Warns of an angle [rad]."""
    sink.report("SC526", f"{angle:g} radians are {angle / math.tau:.3g} turns", place, hint=hint)


def far(written: Any) -> float:
    """The largest angle that is beyond two turns in every scene; 0: none is.

    Of alternatives and bounds it is the smallest that counts.
    """
    sizes = _least(written)
    return max((size for size in (sizes if sizes.__class__ is tuple else (sizes,)) if size > _MOST), default=0.0)


def _least(written: Any) -> Any:
    """How large a number is at least, or each of several; 0 where that is not known, or there is no limit."""
    if written.__class__ in {tuple, list}:
        return tuple(map(_least, written))
    parts: tuple[Any, ...]
    match written:
        case int() | float():
            return abs(written) if math.isfinite(written) else 0.0
        case Vector(items):
            return tuple(map(_least, items))
        case PerScene(items) | Cycle(items) | Choice(items):
            parts = items
        case SceneMap(items, default):
            parts = tuple(one for _, one in items) + (() if default is MISSING else (default,))
        case Uniform(low, high) | Integers(low, high) | LogUniform(low, high):
            parts = (low, high)
        case _:
            return 0.0
    found = [_least(part) for part in parts]
    if all(one.__class__ is tuple for one in found):
        return tuple(min(ones) for ones in zip(*found, strict=False))
    return 0.0 if any(one.__class__ is tuple for one in found) else min(found, default=0.0)
