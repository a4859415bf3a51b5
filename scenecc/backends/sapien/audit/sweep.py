"""Properties of many objects, read one property at a time: much faster than one object at a time."""

from __future__ import annotations

from dataclasses import dataclass, field
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.audit.difference import CODE, Difference, same, same_local_pose, shown
from scenecc.backends.sapien.engine import sapien

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from scenecc.backends.sapien.turn import AnyTurn
    from scenecc.diagnostics import Origin

Expected = dict[str, Any]
"""Properties by name, floats already rounded to float32 (see `single`). What most objects share is one dictionary."""


class Place(NamedTuple):
    """A body: its entity, its number there, the node that asked for what is looked at, and which link it is."""

    turn: AnyTurn
    number: int
    origin: Origin | None
    link: str | None = None


@dataclass(frozen=True, slots=True)
class _Group:
    """Objects that must agree with one dictionary."""

    expected: Expected
    engines: list[Any] = field(default_factory=list[Any])
    places: list[Place] = field(default_factory=list[Place])


@dataclass(frozen=True, slots=True)
class _Column:
    """Objects and what one property of each must be."""

    engines: list[Any] = field(default_factory=list[Any])
    expected: list[Any] = field(default_factory=list[Any])
    places: list[Place] = field(default_factory=list[Place])


class Sweep:
    """Collects objects with what they must hold, then reads them all."""

    def __init__(self) -> None:
        self._groups: dict[int, _Group] = {}
        self._columns: dict[str, _Column] = {}
        self._found: list[tuple[Place, Difference]] = []
        self._without: dict[tuple[int, tuple[str, ...]], Expected] = {}

    def expect(self, expected: Expected, engine: object, place: Place) -> None:
        """`engine` must have these properties. The dictionary is told by identity and must not change."""
        group = self._groups.get(id(expected))
        if group is None:
            group = self._groups[id(expected)] = _Group(expected)
        group.engines.append(engine)
        group.places.append(place)

    def expect_but(self, expected: Expected, own: Expected, engine: object, place: Place) -> None:
        """As `expect`, with values of the object's own for some of the properties, not rounded yet."""
        if own:
            key = (id(expected), tuple(own))
            if key not in self._without:
                self._without[key] = {name: value for name, value in expected.items() if name not in own}
            expected = self._without[key]
            for name, value in own.items():
                self.hold(name, value, engine, place)
        self.expect(expected, engine, place)

    def hold(self, name: str, expected: object, engine: object, place: Place) -> None:
        """One property of `engine`, of the same type wherever it has this name: numbers of the plan are not rounded.

        `name` may say whose property it is: "component.name" is the `name` of a component.
        """
        column = self._columns.get(name)
        if column is None:
            column = self._columns[name] = _Column()
        column.engines.append(engine)
        column.expected.append(expected)
        column.places.append(place)

    def tell(self, place: Place, what: str, expected: object, found: object, code: str = CODE) -> None:
        """A difference that was seen otherwise."""
        self._found.append((place, Difference(what, expected, found, place.origin, code)))

    def differences(self) -> Iterator[tuple[Place, Difference]]:
        """Everything that differs."""
        yield from self._found
        for group in self._groups.values():
            for name, value in group.expected.items():
                found = list(map(attrgetter(name), group.engines))
                for number in _wrong(value, found):
                    place = group.places[number]
                    yield place, Difference(name, shown(value), shown(found[number]), place.origin)
        for what, column in self._columns.items():
            name = what.rpartition(".")[2]
            found = list(map(attrgetter(name), column.engines))
            for number in _unequal(column.expected, found):
                place = column.places[number]
                yield place, Difference(what, shown(column.expected[number]), shown(found[number]), place.origin)


def _wrong(expected: Any, found: Sequence[Any]) -> list[int]:
    """Which of the values read differ from one value, its floats rounded to float32."""
    if isinstance(found[0], np.ndarray):
        return np.flatnonzero((np.array(found) != expected).reshape(len(found), -1).any(axis=1)).tolist()
    if isinstance(found[0], sapien.Pose):
        states = [pose.__getstate__() for pose in found]
        if states.count(expected) == len(states):
            return []
        return [i for i, pose in enumerate(found) if not same_local_pose(np.array(expected), pose)]
    if list(found).count(expected) == len(found):
        return []
    return [i for i, value in enumerate(found) if not same(expected, value)]


def _unequal(expected: list[Any], found: list[Any]) -> list[int]:
    """Which of the values read differ from that of their own, rounded here, all at once."""
    if isinstance(found[0], sapien.Pose):
        poses = zip(expected, found, strict=True)
        return [i for i, (value, pose) in enumerate(poses) if not same_local_pose(np.array(value, np.float64), pose)]
    if isinstance(found[0], (float, list, np.ndarray)):
        wanted = np.array(expected)
        with np.errstate(over="ignore"):
            wrong = (wanted.astype(np.float32) if wanted.dtype.kind == "f" else wanted) != np.array(found)
        return np.flatnonzero(wrong.reshape(len(found), -1).any(axis=1)).tolist()
    if expected == found:
        return []
    return [i for i, (value, other) in enumerate(zip(expected, found, strict=True)) if not same(value, other)]
