"""Properties of many objects, read one property at a time: much faster than one object at a time."""

from __future__ import annotations

from dataclasses import dataclass, field
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.audit.difference import Difference, same, same_local_pose, shown
from scenecc.backends.sapien.engine import sapien

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from scenecc.backends.sapien.turn import Turn
    from scenecc.diagnostics import Origin

Expected = dict[str, Any]
"""Properties by name, floats already rounded to float32 (see `given`). What most objects share is one dictionary."""


class Place(NamedTuple):
    """A body: its entity, its number there, and the node that asked for what is looked at."""

    turn: Turn
    number: int
    origin: Origin | None


@dataclass(frozen=True, slots=True)
class _Group:
    expected: Expected
    engines: list[Any] = field(default_factory=list[Any])
    places: list[Place] = field(default_factory=list[Place])


class Sweep:
    """Collects objects by the dictionary that they must agree with, then reads them all."""

    def __init__(self) -> None:
        self._groups: dict[int, _Group] = {}
        self._found: list[tuple[Place, Difference]] = []

    def expect(self, expected: Expected, engine: object, place: Place) -> None:
        """`engine` must have these properties. The dictionary is told by identity and must not change."""
        group = self._groups.get(id(expected))
        if group is None:
            group = self._groups[id(expected)] = _Group(expected)
        group.engines.append(engine)
        group.places.append(place)

    def tell(self, place: Place, what: str, expected: object, found: object) -> None:
        """A difference that was seen otherwise."""
        self._found.append((place, Difference(what, expected, found, place.origin)))

    def differences(self) -> Iterator[tuple[Place, Difference]]:
        """Everything that differs."""
        yield from self._found
        for group in self._groups.values():
            for name, value in group.expected.items():
                found = list(map(attrgetter(name), group.engines))
                for number in _wrong(value, found):
                    place = group.places[number]
                    yield place, Difference(name, shown(value), shown(found[number]), place.origin)


def given(data: Any) -> Any:
    """A row of the plan as the engine gives it back: float32 arrays, lists, or plain Python rounded to float32."""
    if data.dtype.kind != "f":
        return data.tolist()
    rounded = data.astype(np.float32)
    return rounded if rounded.ndim else rounded.item()


def _wrong(expected: Any, found: Sequence[Any]) -> list[int]:
    """Which of the values read differ."""
    if isinstance(found[0], np.ndarray):
        return np.flatnonzero((np.array(found) != expected).any(axis=1)).tolist()
    if isinstance(found[0], sapien.Pose):
        states = [pose.__getstate__() for pose in found]
        if states.count(expected) == len(states):
            return []
        return [i for i, pose in enumerate(found) if not same_local_pose(np.array(expected), pose)]
    if list(found).count(expected) == len(found):
        return []
    return [i for i, value in enumerate(found) if not same(expected, value)]
