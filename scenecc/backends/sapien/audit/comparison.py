"""Compares properties of many objects with expected values, one property at a time, and reports the differences."""

from __future__ import annotations

from dataclasses import dataclass, field
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.engine import sapien
from scenecc.diagnostics.diagnostic import Location, Origin

if TYPE_CHECKING:
    from collections.abc import Hashable, Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.preparation import PreparedEntity
    from scenecc.diagnostics import Sink

AUDIT_CODE = "SC802"

ROTATION_TOLERANCE = 5e-7
"""PhysX normalises the quaternion of a shape's pose and of a centre of mass: a few units in the last place."""


@dataclass(frozen=True, slots=True)
class EngineDifference:
    """One property of one body that is not what the plan says.

    Attributes:
        what: the property, by the engine's name.
        expected, found: as they are shown to people.
        origin: the node that asked; None: the entity's own.
        code: of the diagnostic.
    """

    what: str
    expected: object
    found: object
    origin: Origin | None = None
    code: str = AUDIT_CODE

    @property
    def words(self) -> str:
        """What the engine holds, for people."""
        return f"{self.what} = {self.found}, and the plan asks for {self.expected}"


class DifferenceGroups:
    """Differences, grouped: one diagnostic a group, however many scenes have it."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._groups: dict[Hashable, tuple[str, str, Origin | None, str, list[int]]] = {}

    def add(
        self, who: str, words: str, index: int, place: Origin | None, *, key: Hashable = None, code: str = AUDIT_CODE
    ) -> None:
        """Adds a difference.

        Args:
            who: has it, in words.
            words: what the engine holds, as seen in the first of the scenes.
            index: of the scene.
            place: the node that asked.
            key: tells differences of one thing apart; None: the words do.
            code: of the diagnostic.
        """
        self._groups.setdefault((who, key or words), (who, words, place, code, []))[-1].append(index)

    def report(self) -> bool:
        """Reports every group. Returns True if there are none."""
        for who, words, place, code, found in self._groups.values():
            scene_idxs = sorted(set(found))
            more = f" (and in {len(scene_idxs) - 1} more)" if len(scene_idxs) > 1 else ""
            message = f"{who} in scene {scene_idxs[0]}{more}: the engine holds {words}"
            self._sink.report(code, message, place or Location(None))
        return not self._groups


def is_same(expected: Any, found: object) -> bool:
    """Equal as the engine stores it: floats as float32, all others exactly."""
    if isinstance(found, (str, int)) or found is None:
        return bool(expected == found)
    if isinstance(found, float):
        return expected == found or bool(np.float32(expected) == np.float32(found))
    a, b = to_engine_array(expected), to_engine_array(found)
    return a.shape == b.shape and (a.tobytes() == b.tobytes() or bool((a == b).all()))


def is_same_local_pose(expected: NDArray[np.float64], found: sapien.Pose) -> bool:
    """Whether a pose that PhysX has normalised is the expected one (7,)."""
    actual = to_engine_array(found)
    if expected.astype(np.float32).tobytes() == actual.tobytes():
        return True
    if (expected[:3].astype(np.float32) != actual[:3]).any():
        return False
    unit = expected[3:] / np.linalg.norm(expected[3:])
    return bool(np.abs(unit - actual[3:]).max() <= ROTATION_TOLERANCE)


def to_engine_array(value: object) -> NDArray[Any]:
    """Numbers of the plan or of the engine as an array: float32, integers or booleans."""
    if isinstance(value, sapien.Pose):
        return np.array(pose_numbers(value), dtype=np.float32)
    array: NDArray[Any] = np.asarray(value)
    with np.errstate(over="ignore"):
        return array.astype(np.float32, copy=False) if array.dtype.kind == "f" else array


def pose_numbers(pose: sapien.Pose) -> tuple[float, ...]:
    """p, then q: the quickest way to all seven numbers."""
    engine_pose: Any = pose
    return engine_pose.__getstate__()


def format_value(value: object) -> str:
    """A value as it is written in a diagnostic."""
    if isinstance(value, str) or value is None:
        return repr(value)
    array = to_engine_array(value)
    if array.size > 8:
        return f"{array.shape} numbers"
    # numpy's own words for a float32 are the shortest that tell it from its neighbours.
    return "[" + ", ".join(map(str, array.ravel())) + "]" if array.ndim else str(array[()])


ExpectedProperties = dict[str, Any]
"""Properties by name, floats already rounded to float32 (see `single`). What most objects share is one dictionary."""


class BodyLocation(NamedTuple):
    """A body: its entity, its number there, the node that asked for what is looked at, and which link it is."""

    prepared: PreparedEntity
    number: int
    origin: Origin | None
    link: str | None = None


@dataclass(frozen=True, slots=True)
class _SharedExpectation:
    """Objects that share one dictionary of expected values."""

    expected: ExpectedProperties
    engines: list[Any] = field(default_factory=list[Any])
    places: list[BodyLocation] = field(default_factory=list[BodyLocation])


@dataclass(frozen=True, slots=True)
class _PropertyExpectation:
    """Objects and what one property of each must be."""

    engines: list[Any] = field(default_factory=list[Any])
    expected: list[Any] = field(default_factory=list[Any])
    places: list[BodyLocation] = field(default_factory=list[BodyLocation])


class BatchComparison:
    """Collects objects with what they must hold, then reads them all."""

    def __init__(self) -> None:
        self._groups: dict[int, _SharedExpectation] = {}
        self._columns: dict[str, _PropertyExpectation] = {}
        self._found: list[tuple[BodyLocation, EngineDifference]] = []
        self._without: dict[tuple[int, tuple[str, ...]], ExpectedProperties] = {}

    def expect(self, expected: ExpectedProperties, engine: object, place: BodyLocation) -> None:
        """`engine` must have these properties. The dictionary is told by identity and must not change."""
        group = self._groups.get(id(expected))
        if group is None:
            group = self._groups[id(expected)] = _SharedExpectation(expected)
        group.engines.append(engine)
        group.places.append(place)

    def expect_but(
        self, expected: ExpectedProperties, own: ExpectedProperties, engine: object, place: BodyLocation
    ) -> None:
        """As `expect`, with values of the object's own for some of the properties, not rounded yet."""
        if own:
            key = (id(expected), tuple(own))
            if key not in self._without:
                self._without[key] = {name: value for name, value in expected.items() if name not in own}
            expected = self._without[key]
            for name, value in own.items():
                self.hold(name, value, engine, place)
        self.expect(expected, engine, place)

    def hold(self, name: str, expected: object, engine: object, place: BodyLocation) -> None:
        """One property of `engine`, of the same type wherever it has this name: numbers of the plan are not rounded.

        `name` may say whose property it is: "component.name" is the `name` of a component.
        """
        column = self._columns.get(name)
        if column is None:
            column = self._columns[name] = _PropertyExpectation()
        column.engines.append(engine)
        column.expected.append(expected)
        column.places.append(place)

    def tell(self, place: BodyLocation, what: str, expected: object, found: object, code: str = AUDIT_CODE) -> None:
        """Adds a difference that the caller has found."""
        self._found.append((place, EngineDifference(what, expected, found, place.origin, code)))

    def differences(self) -> Iterator[tuple[BodyLocation, EngineDifference]]:
        """All differences; reads the objects that were collected."""
        yield from self._found
        for group in self._groups.values():
            for name, value in group.expected.items():
                found = list(map(attrgetter(name), group.engines))
                for number in _rows_unlike_shared(value, found):
                    place = group.places[number]
                    yield place, EngineDifference(name, format_value(value), format_value(found[number]), place.origin)
        for what, column in self._columns.items():
            name = what.rpartition(".")[2]
            found = list(map(attrgetter(name), column.engines))
            for number in _rows_unlike_own(column.expected, found):
                place = column.places[number]
                yield (
                    place,
                    EngineDifference(
                        what, format_value(column.expected[number]), format_value(found[number]), place.origin
                    ),
                )


def _rows_unlike_shared(expected: Any, found: Sequence[Any]) -> list[int]:
    """Which of the values read differ from one value, its floats rounded to float32."""
    if isinstance(found[0], np.ndarray):
        return np.flatnonzero((np.array(found) != expected).reshape(len(found), -1).any(axis=1)).tolist()
    if isinstance(found[0], sapien.Pose):
        states = [pose.__getstate__() for pose in found]
        if states.count(expected) == len(states):
            return []
        return [i for i, pose in enumerate(found) if not is_same_local_pose(np.array(expected), pose)]
    if list(found).count(expected) == len(found):
        return []
    return [i for i, value in enumerate(found) if not is_same(expected, value)]


def _rows_unlike_own(expected: list[Any], found: list[Any]) -> list[int]:
    """Which of the values read differ from that of their own, rounded here, all at once."""
    if isinstance(found[0], sapien.Pose):
        poses = zip(expected, found, strict=True)
        return [i for i, (value, pose) in enumerate(poses) if not is_same_local_pose(np.array(value, np.float64), pose)]
    if isinstance(found[0], (float, list, np.ndarray)):
        wanted = np.array(expected)
        with np.errstate(over="ignore"):
            wrong = (wanted.astype(np.float32) if wanted.dtype.kind == "f" else wanted) != np.array(found)
        return np.flatnonzero(wrong.reshape(len(found), -1).any(axis=1)).tolist()
    if expected == found:
        return []
    return [i for i, (value, other) in enumerate(zip(expected, found, strict=True)) if not is_same(value, other)]
