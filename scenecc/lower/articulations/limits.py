"""Positions held against the limits of joints, and targets of drives that are beyond them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.articulations.draft import DraftJoint
    from scenecc.lower.leaves import Leaves
    from scenecc.plan import Value

OUTSIDE = 1e-6
"""How far outside of a limit a position may be written, for the limits are rounded [m or rad]."""

Found = tuple[int, float, float, float]
"""The row of a position that is outside, the position, and the limits there."""


def widest(limits: Value | None) -> tuple[float, float]:
    """The lowest and the highest that limits can be."""
    numbers = () if limits is None else limits.numbers()
    return min(numbers[0::2], default=-math.inf), max(numbers[1::2], default=math.inf)


def first_outside(limits: Value, positions: Sequence[float]) -> Found | None:
    """The first position that is outside of limits that are known.

    Args:
        limits: (·, 2).
        positions: one for all scenes, or one a scene.
    """
    numbers = limits.numbers()
    pairs = [(numbers[i], numbers[i + 1]) for i in range(0, len(numbers), 2)]
    for row in range(max(len(pairs), len(positions))):
        low, high = pairs[row if len(pairs) > 1 else 0]
        at = positions[row if len(positions) > 1 else 0]
        if not low - OUTSIDE <= at <= high + OUTSIDE:
            return row, at, low, high
    return None


class Targets:
    """Warns of targets of drives that are beyond the limits of their joints, each place once.

    Args:
        leaves: of the articulation.
        sink: takes the warnings.
        beyond_limits: whether they are meant.
    """

    def __init__(self, leaves: Leaves, sink: Sink, *, beyond_limits: bool) -> None:
        self._leaves = leaves
        self._sink = sink
        self._beyond_limits = beyond_limits
        self._told: set[int] = set()

    def judge(self, joint: DraftJoint, target: Value, place: Origin) -> None:
        """Warns of the first scene in which a target is, or may be, beyond the limits.

        Of what is drawn the bounds are judged, by the widest limits; what has no bounds, a `normal`, is not.

        Args:
            joint: with what is said of it.
            target: (·,) as written.
            place: where it is written.
        """
        if self._beyond_limits or joint.limits is None or id(target) in self._told:
            return
        found = _beyond(joint.limits, target)
        if found is None:
            return
        self._told.add(id(target))
        (row, at, low, high), certain = found
        several = certain and max(len(joint.limits.numbers()) // 2, len(target.numbers())) > 1
        scene = f" in scene {self._leaves.scenes[row]}" if several else ""
        pulls = "pulls" if certain else "may pull"
        message = f"the drive of `{cut(joint.name)}` {pulls} to {at:g}{scene}, beyond its limits [{low:g}, {high:g}]"
        hint = (
            "positions are radians, or metres of a prismatic joint; to press against a limit, say `beyond_limits: true`"
        )
        self._sink.report("SC523", message, place, hint=hint)


def _beyond(limits: Value, target: Value) -> tuple[Found, bool] | None:
    """A target beyond its limits, and whether it is for certain so."""
    if limits.known and target.known:
        found = first_outside(limits, target.numbers())
        return None if found is None else (found, True)
    low, high = widest(limits)
    numbers = [number for number in target.numbers() if math.isfinite(number)]
    at = next((number for number in numbers if not low - OUTSIDE <= number <= high + OUTSIDE), None)
    return None if at is None else ((0, at, low, high), False)
