"""Initial joint positions and velocities of an articulation, from `qpos` and `qvel`, within the limits."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut
from scenecc.lower.articulations.links import first_outside, widest
from scenecc.lower.articulations.overrides import names_hint
from scenecc.lower.field_types import FieldType, field_type, report_unused_key
from scenecc.lower.forms import VARYING, FieldPlace, FormStep, VariationLowerer, field_place
from scenecc.lower.poses import suspect_degrees, warn_large_angle
from scenecc.lower.variation import MimicRelation, ResettableValue
from scenecc.plan import derived, literal
from scenecc.plan.properties import FLOAT32_MAX, Bounds
from scenecc.variation import forms
from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.nodes import NODES, AffineClamp, Const, Rows

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.articulations.drafts import DraftJoint, DraftMimic
    from scenecc.lower.fields import FieldLowerer
    from scenecc.plan import Value

_POSITION = field_type("Joint.qpos")
_VELOCITY = field_type("Joint.qvel")

_APART = 0.01
"""Distance of a mimic joint from the position that its source gives it, from which it is reported [rad, 0.1 m]."""


class InitialStateLowerer:
    """Finds the initial positions and velocities.

    Args:
        joints: moving joints in SAPIEN's order, with their overrides.
        fields: of the entity.
        origin: of the entity.
        sink: receives the diagnostics.
        beyond_limits: whether values may exceed the limits, so that drawn ones are not clamped.
    """

    def __init__(
        self,
        joints: Sequence[DraftJoint],
        fields: FieldLowerer,
        origin: Origin,
        sink: Sink,
        *,
        beyond_limits: bool = False,
    ) -> None:
        self._joints = joints
        self._fields = fields
        self._origin = origin
        self._sink = sink
        self._beyond_limits = beyond_limits
        self._quiet = False
        self._numbers = {joint.name: number for number, joint in enumerate(joints) if joint.name}

    def velocities(self, given: Mapping[int, JointValue]) -> list[Value | None]:
        """The velocity of each joint; all None if no velocity is given."""
        if not given:
            return [None] * len(self._joints)
        zero = literal(0.0)
        return [self._velocity(given[i]) if i in given else zero for i in range(len(self._joints))]

    def positions(self, given: Mapping[int, JointValue], *, all_of_them: bool, quiet: bool) -> list[Value | None]:
        """The position of each joint; all None if no position is given and all start at 0, unless `all_of_them`.

        Args:
            given: given positions, by joint number.
            all_of_them: whether to return a position for every joint in any case.
            quiet: whether an error in the values was reported, so that missing ones are not.
        """
        self._quiet = quiet
        found: dict[int, Value] = {}
        moved = False
        for i in self._order(given):
            if i in given:
                found[i] = self._position(self._joints[i], given[i])
                self._warn_probable_degrees(self._joints[i], found[i], given[i].origin)
                continue
            found[i], elsewhere = self._left_out(self._joints[i], found, told=bool(given))
            moved |= elsewhere
        for i, one in given.items():
            self._warn_apart(self._joints[i], found, i, one.origin)
        if not given and not moved and not all_of_them:
            return [None] * len(self._joints)
        return [found[i] for i in range(len(self._joints))]

    def _order(self, given: Mapping[int, JointValue]) -> list[int]:
        """The joints, each after the one that it follows. Another rule reports cycles."""
        order: dict[int, None] = {}
        for i in range(len(self._joints)):
            chain = [i]
            while (source := self._source(chain[-1], given)) is not None and source not in chain:
                chain.append(source)
            order.update(dict.fromkeys(reversed(chain)))
        return list(order)

    def _source(self, i: int, given: Mapping[int, JointValue]) -> int | None:
        mimic = self._joints[i].mimic
        return None if mimic is None or i in given else self._numbers.get(mimic.source)

    def _velocity(self, given: JointValue) -> Value:
        if given.item.__class__ not in NODES:
            return literal(float(given.item))
        assert given.variation is not None
        item = joint_value_node(given)
        return self._fields.finish(item, given.variation, _VELOCITY, given.origin, reset=True)

    def _position(self, joint: DraftJoint, given: JointValue) -> Value:
        if given.item.__class__ not in NODES:
            at = float(given.item)
            self._report_outside_limits(joint, [at], given.origin)
            return literal(at)
        assert given.variation is not None
        variation = given.variation
        if self._beyond_limits:
            return self._fields.finish(joint_value_node(given), variation, _POSITION, given.origin, reset=True)
        if variation.is_random:
            return self._clamp_to_limits(joint, given, variation)
        item = joint_value_node(given)
        kind = FieldType(within=Bounds(*widest(joint.limits)))
        value = self._fields.finish(item, variation, kind, given.origin, reset=True)
        if value.known and not variation.broken:
            self._report_outside_limits(joint, value.data.tolist(), given.origin)
        return value

    def _clamp_to_limits(self, joint: DraftJoint, given: JointValue, variation: VariationLowerer) -> Value:
        """A drawn position clamped to the limits, also at each reset."""
        fields, limits = self._fields, joint.limits
        plain = limits is None or limits.is_constant
        low, high = _constant_limits(limits) if plain else (-FLOAT32_MAX, FLOAT32_MAX)
        item = AffineClamp(given.item, given.index, low, high)
        value = fields.finish(item, variation, _POSITION, given.origin, reset=True)
        if plain or limits is None or value.known:
            return value
        clamped = derived(_clip, [value, limits], fields.scenes)
        fields.sampling.resets[id(clamped)] = ResettableValue(clamped, item, variation, fields.scenes, limits)
        return clamped

    def _left_out(self, joint: DraftJoint, found: Mapping[int, Value], *, told: bool) -> tuple[Value, bool]:
        """The default initial position of a joint, and whether it is not 0.

        `told`: whether positions of other joints are given.
        """
        mimic = joint.mimic
        source = None if mimic is None else self._numbers.get(mimic.source)
        if mimic is not None and source is not None and source in found:
            followed = self._follow_source(mimic, joint.limits, found[source])
            return followed, followed.numbers() != (0.0,)
        if joint.qpos is not None:
            low, high = widest(joint.limits)
            start = min(max(joint.qpos, low), high)
            return literal(start), start != 0.0
        limits = joint.limits
        low, high = widest(joint.limits)
        # Another rule reports reversed limits.
        if limits is not None and low <= high and not low <= 0 <= high and not self._quiet:
            nearest = high if high < 0 else low
            message = f"`{cut(joint.name)}` starts at its limit {nearest:g}, because 0 is outside the limits"
            place = self._origin.child("qpos") if told else self._origin
            hint = f"give it a position: `qpos: {{{joint.name}: …}}`"
            # One report per entity, since there is one thing to fix. The other joints are counted.
            with self._sink.merge_repeats():
                self._sink.report("SC518", message, place, at="key", hint=hint)
        if limits is None:
            return literal(0.0), False
        if limits.is_constant:
            at = min(max(0.0, limits.numbers()[0]), limits.numbers()[1])
            return literal(at), at != 0.0
        return self._nearest(limits), True

    def _nearest(self, limits: Value) -> Value:
        """The position nearest to 0 within limits that vary by scene."""
        value = derived(_clip, [literal(0.0), limits], self._fields.scenes)
        resets = self._fields.sampling.resets
        if id(limits) in resets:
            variation = VariationLowerer(self._fields, self._origin)
            node = AffineClamp(Const(0.0), -1, -FLOAT32_MAX, FLOAT32_MAX)
            resets[id(value)] = ResettableValue(value, node, variation, self._fields.scenes, limits)
        return value

    def _follow_source(self, mimic: DraftMimic, limits: Value | None, source: Value) -> Value:
        """The initial position of a joint that follows another one, within its limits."""
        parts = [part for part in (source, mimic.multiplier, mimic.offset, limits) if part is not None]
        if all(part.is_constant for part in parts):
            (at,), (multiplier,), (offset,) = source.numbers(), mimic.multiplier.numbers(), mimic.offset.numbers()
            low, high = _constant_limits(limits)
            return literal(max(min(multiplier * at + offset, high), low))
        import numpy as np  # noqa: PLC0415 - loaded where something varies

        def follow(at: NDArray[Any], factor: NDArray[Any], offset: NDArray[Any], *held: NDArray[Any]) -> NDArray[Any]:
            moved = factor * at + offset
            return np.maximum(np.minimum(moved, held[0][:, 1]), held[0][:, 0]) if held else moved

        value = derived(follow, parts, self._fields.scenes)
        if value.known:
            return value
        resets = self._fields.sampling.resets
        reset = resets.get(id(source))
        if reset is None and limits is not None and id(limits) in resets:
            scenes = self._fields.scenes
            start = Rows(scenes, tuple(np.broadcast_to(source.data, len(scenes)).tolist()))
            reset = ResettableValue(source, start, VariationLowerer(self._fields, self._origin), self._fields.scenes)
        if reset is not None:
            follows = MimicRelation(reset, mimic.multiplier, mimic.offset)
            resets[id(value)] = ResettableValue(
                value, reset.node, reset.variation, self._fields.scenes, limits, follows
            )
        return value

    def _warn_apart(self, joint: DraftJoint, found: Mapping[int, Value], number: int, place: Origin) -> None:
        """Warns of a given position that differs from the one that follows from the joint's source."""
        mimic = joint.mimic
        source = None if mimic is None else found.get(self._numbers.get(mimic.source, -1))
        if mimic is None or source is None or self._beyond_limits:
            return
        limits = joint.limits
        values = (source, mimic.multiplier, mimic.offset, found[number], *(() if limits is None else (limits,)))
        if not all(one.is_constant for one in values):
            return
        (at,), (follows,) = found[number].numbers(), self._follow_source(mimic, limits, source).numbers()
        if abs(at - follows) > (_APART / 10 if joint.type == "prismatic" else _APART):
            message = (
                f"`{cut(joint.name)}` starts at {at:g}, but its source `{cut(mimic.source)}` has it at {follows:g}"
            )
            hint = f"write {follows:g}, or only the source by name: `qpos: {{{mimic.source}: …}}`"
            with self._sink.merge_repeats():
                self._sink.report("SC566", message, place, hint=hint)

    def _warn_probable_degrees(self, joint: DraftJoint, position: Value, place: Origin) -> None:
        """Warns of a position that is probably in degrees, if the joint has no limits."""
        if self._beyond_limits or not joint.type.startswith("revolute"):
            return
        numbers = position.numbers()
        if any(map(math.isfinite, widest(joint.limits))) or not (
            angle := min(map(suspect_degrees, numbers), default=0.0)
        ):
            return
        hint = "positions are radians: `${radians(90)}` is 90 degrees; if this is intended, write `beyond_limits: true`"
        warn_large_angle(angle, place, self._sink, hint=hint)

    def _report_outside_limits(self, joint: DraftJoint, positions: Sequence[float], place: Origin) -> None:
        """Reports the first position outside of its limits."""
        limits = joint.limits
        if self._beyond_limits or limits is None or not limits.known:
            # Drawn limits are checked with the rows.
            return
        found = first_outside(limits, positions)
        if found is None:
            return
        row, at, low, high = found
        if low > high:
            return  # reported for the limits
        several = max(len(limits.numbers()) // 2, len(positions)) > 1
        scene = f" in scene {self._fields.scenes[row]}" if several else ""
        message = f"`{cut(joint.name)}` starts at {at:g}{scene}, outside its limits [{low:g}, {high:g}]"
        hint = "positions are radians, or metres for a prismatic joint"
        self._sink.report("SC517", message, place, hint=hint)


def _constant_limits(limits: Value | None) -> tuple[float, float]:
    """Limits that are the same in every scene, as numbers for a recipe."""
    low, high = (-math.inf, math.inf) if limits is None else limits.numbers()
    return max(low, -FLOAT32_MAX), min(high, FLOAT32_MAX)


def _clip(positions: NDArray[Any], limits: NDArray[Any]) -> NDArray[Any]:
    """Clamps positions (B,) to limits (B, 2)."""
    return positions.clip(limits[:, 0], limits[:, 1])


def joint_value_node(given: JointValue) -> Any:
    """The written value of a joint as one number or node."""
    return given.item if given.index < 0 else AffineClamp(given.item, given.index, -FLOAT32_MAX, FLOAT32_MAX)


_NUMBERS = frozenset((float, int))
_ONE = FieldType()


@dataclass(frozen=True, slots=True)
class JointValue:
    """The written value of one joint.

    Attributes:
        item: a number, or a node.
        index: in the list that the node gives; -1: it gives one number.
        variation: of the node; None for a number.
        origin: where it is written.
    """

    item: Any
    index: int
    variation: VariationLowerer | None
    origin: Origin


@dataclass(frozen=True, slots=True)
class JointNumbers:
    """Splits the written values of an articulation by joint.

    Attributes:
        names: of the moving joints, in SAPIEN's order.
        others: joint names of the entity's other structures and of other robots in its file.
        origin: of the articulation.
        fields: of the articulation.
        sink: receives the diagnostics.
    """

    names: Sequence[str]
    others: Collection[str]
    origin: Origin
    fields: FieldLowerer
    sink: Sink

    def of(self, written: Any, key: str) -> dict[int, JointValue]:
        """The written values by joint number, without those with errors.

        Args:
            written: a list, a mapping, a form or an expression of a list; None: nothing.
            key: of the values.
        """
        if written is None:
            return {}
        origin = self.origin.child(key)
        if written.__class__ is dict:
            return self._by_name(written, origin)
        if self._misfit(written, key, origin):
            return {}
        if not self.names:
            report_unused_key(key, "here: no joint moves", self.origin, self.sink)
            return {}
        place = field_place(origin)
        if written.__class__ is forms.Vector or written.__class__ not in VARYING:
            items = written.items if written.__class__ is forms.Vector else written
            return {
                number: self._read_value(item, FieldPlace(origin.child(number), place.path, number))
                for number, item in enumerate(items)
            }
        count = len(self.names)
        variation = VariationLowerer(self.fields, origin)
        kind = FieldType((count,), fallback=(0.0,) * count)

        def leaf(one: Any, around: FieldPlace, step: FormStep) -> Any:
            # In the format of a node, so that a plan is unchanged after a round trip through JSON.
            return (
                tuple(one)
                if one.__class__ is list
                else variation.item(one, kind, around.inside(step) if step else around)
            )

        node = variation.select(written, place, leaf)
        return {number: JointValue(node, number, shared_by_joint(variation, number), origin) for number in range(count)}

    def _read_value(self, item: Any, place: FieldPlace) -> JointValue:
        if item.__class__ not in VARYING:
            return JointValue(item, -1, None, place.origin)
        variation = VariationLowerer(self.fields, place.origin)
        return JointValue(variation.item(item, _ONE, place), -1, variation, place.origin)

    def _by_name(self, written: dict[str, Any], origin: Origin) -> dict[int, JointValue]:
        numbers = {name: number for number, name in enumerate(self.names) if name}
        found: dict[int, JointValue] = {}
        for name, item in written.items():
            place = field_place(origin.child(name))
            if name in numbers:
                found[numbers[name]] = self._read_value(item, place)
            elif name not in self.others:
                hint = names_hint(self.names, name)
                if "*" in name:
                    hint = f"patterns are not read here, so name each joint; {hint}"
                self.sink.report(
                    "SC325", f"there is no moving joint `{cut(name)}` here", place.origin, at="key", hint=hint
                )
        return found

    def _misfit(self, written: Any, key: str, origin: Origin) -> bool:
        """Whether a list has the wrong length, or is a mapping where only a list is allowed; reports it."""
        for found, place in _lists(written):
            if found.__class__ is dict:
                message = f"alternatives of `{key}` must be lists, not mappings by name"
                hint = f"write the form for each joint: `{key}: {{JOINT: {{choice: [0, 1]}}}}`"
                self.sink.report("SC321", message, origin.child(*place), hint=hint)
                return True
            if len(found) != len(self.names):
                self._report_wrong_count(len(found), origin.child(*place))
                return True
        return False

    def _report_wrong_count(self, count: int, place: Origin) -> None:
        joints = len(self.names)
        are = "joint moves" if joints == 1 else "joints move"
        values = "1 number" if count == 1 else f"{count} numbers"
        names = ", ".join(f"`{cut(name)}`" for name in self.names[:_SHOWN_NAMES])
        hint = f"in this order: {names}" + (" …" if joints > _SHOWN_NAMES else "") if joints else None
        self.sink.report("SC325", f"{values}, where {joints} {are}", place, hint=hint)


_SHOWN_NAMES = 20


def shared_by_joint(variation: VariationLowerer, number: int) -> VariationLowerer:
    """The variation for joint `number`. Only the first joint's is checked, since they share it."""
    if number == 0:
        return variation
    other = copy(variation)
    other.risky = False
    return other


def _lists(written: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, tuple[Any, ...]]]:
    """The lists of numbers and the mappings in a written value, each with its path."""
    match written:
        case forms.PerScene() | forms.SceneMap() | forms.Cycle() | forms.Choice() | forms.Once():
            pairs: list[tuple[tuple[Any, ...], Any]] = list(forms.alternatives(written))
        case forms.DrawForm(kind, operands):
            pairs = list(zip(DISTRIBUTIONS[kind].steps(len(operands)), operands, strict=True))
        case forms.Vector(items) | forms.Shuffle(items):
            yield items, at
            return
        case _:
            if written.__class__ in {list, tuple, dict}:
                yield written, at
            return
    for step, one in pairs:
        yield from _lists(one, (*at, *step))
