"""Where the joints of an articulation start, within their limits."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut
from scenecc.lower.articulations.limits import first_outside, widest
from scenecc.lower.kinds import Kind, number
from scenecc.lower.pending import Follows, Reset
from scenecc.lower.turns import far, report
from scenecc.plan import literal, per_scene, varying
from scenecc.spec.scalars import LARGEST
from scenecc.variation.bounds import ValueBounds, component_bounds, held_bounds
from scenecc.variation.nodes import NODES, Held

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.articulations.draft import DraftJoint, DraftMimic
    from scenecc.lower.articulations.numbers import Given
    from scenecc.lower.forms import Reading
    from scenecc.lower.leaves import Leaves
    from scenecc.plan import Value

_POSITION = number("qpos")
_VELOCITY = number("qvel")


class Starts:
    """Finds the positions and velocities at the start.

    Args:
        joints: those that move, in SAPIEN's order, with what is said of them.
        leaves: of the entity.
        origin: of it.
        sink: takes the diagnostics.
        beyond_limits: whether what is written may be outside of the limits, and what is drawn is not held within.
    """

    def __init__(
        self, joints: Sequence[DraftJoint], leaves: Leaves, origin: Origin, sink: Sink, *, beyond_limits: bool = False
    ) -> None:
        self._joints = joints
        self._leaves = leaves
        self._origin = origin
        self._sink = sink
        self._beyond_limits = beyond_limits
        self._quiet = False
        self._numbers = {joint.name: number for number, joint in enumerate(joints) if joint.name}

    def velocities(self, given: Mapping[int, Given]) -> list[Value | None]:
        """The velocity of each joint; None of all where nothing is written."""
        if not given:
            return [None] * len(self._joints)
        zero = literal(0.0)
        return [self._velocity(given[i]) if i in given else zero for i in range(len(self._joints))]

    def positions(self, given: Mapping[int, Given], *, all_of_them: bool, quiet: bool) -> list[Value | None]:
        """The position of each joint; None of all where nothing is written and all start at 0, unless `all_of_them`.

        Args:
            given: what is written, by the joint's number.
            all_of_them: whether each has one in any case.
            quiet: what is written was reported, so that nothing is said of what is left out.
        """
        self._quiet = quiet
        found: dict[int, Value] = {}
        moved = False
        for i in self._order(given):
            if i in given:
                found[i] = self._position(self._joints[i], given[i])
                self._doubt(self._joints[i], found[i], given[i].origin)
                continue
            found[i], elsewhere = self._left_out(self._joints[i], found, told=bool(given))
            moved |= elsewhere
        if not given and not moved and not all_of_them:
            return [None] * len(self._joints)
        return [found[i] for i in range(len(self._joints))]

    def _order(self, given: Mapping[int, Given]) -> list[int]:
        """The joints, each after the one that it follows; circles are another rule's."""
        order: dict[int, None] = {}
        for i in range(len(self._joints)):
            chain = [i]
            while (source := self._source(chain[-1], given)) is not None and source not in chain:
                chain.append(source)
            order.update(dict.fromkeys(reversed(chain)))
        return list(order)

    def _source(self, i: int, given: Mapping[int, Given]) -> int | None:
        mimic = self._joints[i].mimic
        return None if mimic is None or i in given else self._numbers.get(mimic.source)

    def _velocity(self, given: Given) -> Value:
        if given.item.__class__ not in NODES:
            return literal(float(given.item))
        assert given.reading is not None
        item = given_node(given)
        return self._leaves.finish(item, given.reading, _VELOCITY, given.origin, reset=True)

    def _position(self, joint: DraftJoint, given: Given) -> Value:
        if given.item.__class__ not in NODES:
            at = float(given.item)
            self._judge(joint, [at], given.origin)
            return literal(at)
        assert given.reading is not None
        reading, drawing = given.reading, self._leaves.drawing
        if self._beyond_limits:
            return self._leaves.finish(given_node(given), reading, _POSITION, given.origin, reset=True)
        if reading.drawn or any(name in drawing.random for name in reading.reads):
            return self._held(joint, given, reading)
        item = given_node(given)
        kind = Kind(quantity="qpos", within=widest(joint.limits))
        value = self._leaves.finish(item, reading, kind, given.origin, reset=True)
        if value.known and not reading.broken:
            self._judge(joint, value.data.tolist(), given.origin)
        elif not value.known:
            self._leaves.pend(value, kind, given.origin, reading)
        return value

    def _held(self, joint: DraftJoint, given: Given, reading: Reading) -> Value:
        """A position that is drawn, held within the limits, as each later one is."""
        leaves, limits = self._leaves, joint.limits
        plain = limits is None or limits.is_constant
        low, high = _ends(limits) if plain else (-LARGEST, LARGEST)
        item = Held(given.item, given.index, low, high)
        value = leaves.finish(item, reading, _POSITION, given.origin, reset=True)
        if plain or limits is None or value.known:
            return value
        import numpy as np  # noqa: PLC0415 - loaded where something varies

        rows = len(leaves.scenes)

        def draw() -> NDArray[Any]:
            # Either has one row where its rows are equal.
            return np.broadcast_to(np.clip(value.data, limits.data[:, 0], limits.data[:, 1]), rows)

        held = varying(draw, bounds=_within(value.bounds, limits), rows=rows)
        leaves.drawing.resets[id(held)] = Reset(held, item, reading, leaves, limits)
        return held

    def _left_out(self, joint: DraftJoint, found: Mapping[int, Value], *, told: bool) -> tuple[Value, bool]:
        """Where a joint starts of which nothing is said, and whether that is elsewhere than at 0.

        `told`: whether anything is said of others.
        """
        mimic = joint.mimic
        source = None if mimic is None else self._numbers.get(mimic.source)
        if mimic is not None and source is not None and source in found:
            followed = self._following(mimic, joint.limits, found[source])
            return followed, followed.numbers() != (0.0,)
        limits = joint.limits
        low, high = widest(joint.limits)
        # Limits the wrong way round are another rule's.
        if limits is not None and low <= high and not low <= 0 <= high and not self._quiet:
            nearest = high if high < 0 else low
            message = f"`{cut(joint.name)}` starts at its limit {nearest:g}, for it cannot start at 0"
            place = self._origin.child("qpos") if told else self._origin
            hint = f"give it a position: `qpos: {{{joint.name}: …}}`"
            # One entity, and one thing to mend: the other joints are counted.
            with self._sink.alike():
                self._sink.report("SC518", message, place, at="key", hint=hint)
        if limits is None:
            return literal(0.0), False
        if limits.is_constant:
            at = min(max(0.0, limits.numbers()[0]), limits.numbers()[1])
            return literal(at), at != 0.0
        return self._nearest(limits), True

    def _nearest(self, limits: Value) -> Value:
        """As near to 0 as limits allow that differ from scene to scene."""
        import numpy as np  # noqa: PLC0415 - loaded where something varies

        rows = len(self._leaves.scenes)

        def draw() -> NDArray[Any]:
            # The limits have one row where they are equal in all scenes.
            return np.broadcast_to(np.clip(0.0, limits.data[:, 0], limits.data[:, 1]), rows)

        if limits.known:
            return per_scene(draw())
        return varying(draw, bounds=_within(ValueBounds.of((0.0,)), limits), rows=rows)

    def _following(self, mimic: DraftMimic, limits: Value | None, source: Value) -> Value:
        """Where a joint starts that follows another one, within its limits.

        Args:
            mimic: how it follows.
            limits: its own.
            source: where the other one starts.
        """
        parts = [part for part in (source, mimic.multiplier, mimic.offset, limits) if part is not None]
        if all(part.is_constant for part in parts):
            (at,), (multiplier,), (offset,) = source.numbers(), mimic.multiplier.numbers(), mimic.offset.numbers()
            low, high = _ends(limits)
            return literal(max(min(multiplier * at + offset, high), low))
        import numpy as np  # noqa: PLC0415 - loaded where something varies

        rows = len(self._leaves.scenes)

        def draw() -> NDArray[Any]:
            moved = mimic.multiplier.data * source.data + mimic.offset.data
            held = moved if limits is None else np.maximum(np.minimum(moved, limits.data[:, 1]), limits.data[:, 0])
            return np.broadcast_to(held, rows)

        if all(part.known for part in parts):
            return per_scene(draw())
        support = held_bounds(source.bounds, mimic.multiplier.bounds, mimic.offset.bounds, *_bounds(limits))
        value = varying(draw, bounds=support, rows=rows)
        resets = self._leaves.drawing.resets
        reset = resets.get(id(source))
        if reset is not None:
            follows = Follows(reset, mimic.multiplier, mimic.offset)
            resets[id(value)] = Reset(value, reset.node, reset.reading, self._leaves, limits, follows)
        return value

    def _doubt(self, joint: DraftJoint, position: Value, place: Origin) -> None:
        """Warns of a position that is probably in degrees, where no limits tell."""
        if self._beyond_limits or not joint.type.startswith("revolute"):
            return
        numbers = position.numbers()
        if any(map(math.isfinite, widest(joint.limits))) or not (angle := min(map(far, numbers), default=0.0)):
            return
        hint = "positions are radians: `${radians(90)}` is 90 degrees; if it is meant, say `beyond_limits: true`"
        report(angle, place, self._sink, hint=hint)

    def _judge(self, joint: DraftJoint, positions: Sequence[float], place: Origin) -> None:
        """Reports the first position that is outside of its limits."""
        limits = joint.limits
        if self._beyond_limits or limits is None or not limits.known:
            # Whether it is outside of limits that are drawn is told by their rows.
            return
        found = first_outside(limits, positions)
        if found is None:
            return
        row, at, low, high = found
        several = max(len(limits.numbers()) // 2, len(positions)) > 1
        scene = f" in scene {self._leaves.scenes[row]}" if several else ""
        message = f"`{cut(joint.name)}` starts at {at:g}{scene}, outside of its limits [{low:g}, {high:g}]"
        hint = "positions are radians, or metres of a prismatic joint"
        self._sink.report("SC517", message, place, hint=hint)


def _ends(limits: Value | None) -> tuple[float, float]:
    """Limits that are the same in every scene, as numbers that a recipe may hold."""
    low, high = (-math.inf, math.inf) if limits is None else limits.numbers()
    return max(low, -LARGEST), min(high, LARGEST)


def _bounds(limits: Value | None) -> tuple[ValueBounds, ValueBounds]:
    """What the lowest and the highest position can be."""
    if limits is None:
        return ValueBounds.of((-math.inf,)), ValueBounds.of((math.inf,))
    return component_bounds(limits.bounds, 0), component_bounds(limits.bounds, 1)


def _within(support: ValueBounds, limits: Value) -> ValueBounds:
    """What is left of a support once it is held within limits."""
    if support.low is None or not isinstance(support.low, int | float):
        return replace(support, exact=False)
    numbers = limits.numbers()
    low, high = min(numbers[0::2], default=-math.inf), max(numbers[1::2], default=math.inf)
    return ValueBounds(None, max(support.low, low), min(support.high, high), exact=False)


def given_node(given: Given) -> Any:
    """What is written for a joint as one number."""
    return given.item if given.index < 0 else Held(given.item, given.index, -LARGEST, LARGEST)
