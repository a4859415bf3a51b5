"""One number for each joint that moves: `qpos` and `qvel` as written, taken apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut
from scenecc.lower.articulations.maps import listed
from scenecc.lower.forms import VARYING, Place, Reading, Step, place_of
from scenecc.lower.kinds import Kind
from scenecc.spec.base import NOTE_PREFIX
from scenecc.variation import forms

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.leaves import Leaves

_NUMBERS = frozenset((float, int))
_ONE = Kind()


@dataclass(frozen=True, slots=True)
class Given:
    """What is written for one joint.

    Attributes:
        item: a number, or a node.
        index: which of the numbers that the node gives; -1: it gives one.
        reading: of the node; None of a number.
        origin: where it is written.
    """

    item: Any
    index: int
    reading: Reading | None
    origin: Origin


class JointNumbers:
    """Takes apart what is written for the joints of an articulation.

    Args:
        names: of the joints that move, in SAPIEN's order.
        others: names that joints of the entity's other structures have, and of its file's other robots.
        origin: of the articulation.
        leaves: of it.
        sink: takes the diagnostics.
    """

    def __init__(
        self, names: Sequence[str], others: Collection[str], origin: Origin, leaves: Leaves, sink: Sink
    ) -> None:
        self._names = names
        self._others = others
        self._origin = origin
        self._leaves = leaves
        self._sink = sink

    def of(self, written: Any, key: str) -> dict[int, Given]:
        """What is written, by the joint's number; what was reported is missing.

        Args:
            written: a list, a mapping, a form or an expression of a list; None: nothing.
            key: under which.
        """
        if written is None:
            return {}
        origin = self._origin.child(key)
        if written.__class__ is dict:
            return self._by_name(written, origin)
        if self._misfit(written, key, origin):
            return {}
        if not self._names:
            message = f"`{key}` does nothing here: no joint moves"
            self._sink.report("SC115", message, origin, at="key", hint=f"leave `{key}` out")
            return {}
        place = place_of(origin)
        if written.__class__ is forms.Vector or written.__class__ not in VARYING:
            items = written.items if written.__class__ is forms.Vector else written
            return {
                number: self._one(item, Place(origin.child(number), place.path, number))
                for number, item in enumerate(items)
            }
        count = len(self._names)
        reading = Reading(self._leaves, origin)
        kind = Kind((count,), fallback=(0.0,) * count)

        def leaf(one: Any, around: Place, step: Step) -> Any:
            # As a node holds them, so that a plan comes back from its JSON as it was.
            return (
                tuple(one)
                if one.__class__ is list
                else reading.item(one, kind, around.inside(step) if step else around)
            )

        node = reading.select(written, place, leaf)
        return {number: Given(node, number, after(reading, number), origin) for number in range(count)}

    def _one(self, item: Any, place: Place) -> Given:
        if item.__class__ not in VARYING:
            return Given(item, -1, None, place.origin)
        reading = Reading(self._leaves, place.origin)
        return Given(reading.item(item, _ONE, place), -1, reading, place.origin)

    def _by_name(self, written: dict[str, Any], origin: Origin) -> dict[int, Given]:
        numbers = {name: number for number, name in enumerate(self._names) if name}
        found: dict[int, Given] = {}
        for name, item in written.items():
            if name.startswith(NOTE_PREFIX):
                continue
            place = place_of(origin.child(name))
            if name in numbers:
                found[numbers[name]] = self._one(item, place)
            elif name not in self._others:
                hint = listed(self._names, name)
                self._sink.report("SC325", f"no joint `{cut(name)}` moves here", place.origin, at="key", hint=hint)
        return found

    def _misfit(self, written: Any, key: str, origin: Origin) -> bool:
        """Whether some list has another length, or names stand where only a list can, which is reported."""
        for found, place in _lists(written):
            if found.__class__ is dict:
                message = f"alternatives of `{key}` are lists: names cannot stand for one"
                hint = f"write the form for each joint: `{key}: {{JOINT: {{choice: [0, 1]}}}}`"
                self._sink.report("SC321", message, origin.child(*place), hint=hint)
                return True
            if len(found) != len(self._names):
                self._miscounted(len(found), origin.child(*place))
                return True
        return False

    def _miscounted(self, count: int, place: Origin) -> None:
        joints = len(self._names)
        are = "joint moves" if joints == 1 else "joints move"
        values = "1 number" if count == 1 else f"{count} numbers"
        names = ", ".join(f"`{cut(name)}`" for name in self._names[:_SHOWN])
        hint = f"in this order: {names}" + (" …" if joints > _SHOWN else "") if joints else None
        self._sink.report("SC325", f"{values}, where {joints} {are}", place, hint=hint)


_SHOWN = 20


def after(reading: Reading, number: int) -> Reading:
    """What was read, for the joint of some number: what the first one judges is not judged again."""
    if number == 0:
        return reading
    other = object.__new__(Reading)
    other.__dict__.update(reading.__dict__)
    other.risky = False
    return other


def _lists(written: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, tuple[Any, ...]]]:
    """The lists of numbers, and the mappings, in what is written, and where each of them is."""
    match written:
        case forms.PerScene(items):
            pairs = [(one, ("per_scene", i)) for i, one in enumerate(items)]
        case forms.SceneMap(items, default):
            pairs = [(one, ("per_scene", str(scene))) for scene, one in items]
            pairs += [] if default is forms.MISSING else [(default, ("per_scene", "default"))]
        case forms.Cycle(items):
            pairs = [(one, ("cycle", i)) for i, one in enumerate(items)]
        case forms.Choice(items):
            pairs = [(one, ("choice", i)) for i, one in enumerate(items)]
        case forms.Normal():
            ends = (written.mean, written.std, *(written.clip or ()))
            steps = (("normal", 0), ("normal", 1), ("clip", 0), ("clip", 1))
            pairs = list(zip(ends, steps, strict=False))
        case forms.Uniform() | forms.Integers() | forms.LogUniform():
            word = _word(written)
            pairs = [(written.low, (word, 0)), (written.high, (word, 1))]
        case forms.Vector(items):
            yield items, at
            return
        case _:
            if written.__class__ in {list, tuple, dict}:
                yield written, at
            return
    for one, step in pairs:
        yield from _lists(one, (*at, *step))


def _word(form: Any) -> str:
    """The key of a form that draws."""
    return next(key for key, kind in forms.DISTRIBUTIONS.items() if kind is form.__class__)
