"""Constraints that do not hold at the start: PhysX pulls their bodies together as hard as it can."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from scenecc.plan.constraint import Connection, Distance, Drive, Weld
from scenecc.simulation.findings import Finding, length_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import Constraint

TORN: Final = 0.001
"""[m] Bodies may start this far from where a constraint holds them."""

TORN_TURN: Final = math.radians(1)
"""[rad] Likewise of turns."""

_AXES: Final = ("x", "y", "z")


def torn_constraints(batch: SceneBatch) -> Iterator[Finding]:
    """Constraints whose limits the start does not keep, of a batch that was not stepped."""
    for constraint in batch.plan.constraints:
        if constraint.name not in batch.constraints:
            continue
        built = batch.constraints[constraint.name]
        row_of = {index: row for row, index in enumerate(constraint.scene_idxs)}
        for index, component in zip(built.scene_idxs, built.objs, strict=True):
            if not component.is_enabled:
                continue
            errors = list(_errors(constraint, row_of[index], component))
            if errors:
                excess, text = max(errors)
                yield Finding(
                    "SC853", (f"constraints/{constraint.name}",), index, excess,
                    f"the constraint `{constraint.name}` is torn at the start: {text}",
                )  # fmt: skip


def _errors(constraint: Constraint, row: int, component: Any) -> Iterator[tuple[float, str]]:
    """By how many times the tolerance something is out of its limits, and what it is."""
    joint = constraint.joint
    pose = component.relative_pose
    if isinstance(joint, Connection):
        yield from _beyond(component.distance, 0.0, 0.0, TORN, "its frames are {} apart")
    elif isinstance(joint, Distance) and joint.stiffness is None:
        low, high = map(float, joint.limits.row(row))
        yield from _beyond(component.distance, low, high, TORN, f"its frames are {{}} beyond {low:g}…{high:g} m apart")
    elif isinstance(joint, Weld):
        distance = math.hypot(*map(float, pose.p))
        yield from _beyond(distance, 0.0, 0.0, TORN, "its frames are {} apart")
        turn = 2 * math.acos(min(1.0, abs(float(pose.q[0]))))
        yield from _beyond(turn, 0.0, 0.0, TORN_TURN, "its frames are turned by {} against each other")
    elif isinstance(joint, Drive):
        twist = 2 * math.atan2(float(pose.q[1]), float(pose.q[0]))
        twist = math.remainder(twist, 2 * math.pi)
        for limit in joint.limits:
            if limit.stiffness is not None:
                continue
            low, high = map(float, limit.limits.row(row))
            if limit.axis == "twist":
                yield from _beyond(twist, low, high, TORN_TURN, "its twist is {} beyond its limits")
            else:
                where = float(pose.p[_AXES.index(limit.axis)])
                yield from _beyond(where, low, high, TORN, f"along {limit.axis} it is {{}} beyond its limits")


def _beyond(value: float, low: float, high: float, tolerance: float, text: str) -> Iterator[tuple[float, str]]:
    excess = max(low - value, value - high)
    if excess > tolerance:
        shown = f"{math.degrees(excess):.3g}°" if tolerance == TORN_TURN else length_text(excess)
        yield excess / tolerance, text.format(shown)
