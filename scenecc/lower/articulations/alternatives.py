"""What decides how an articulation is put together: its file, how that is read, and whether its root is fixed.

Each may differ from scene to scene. Before anything is drawn it is told which of them can be had together, and each
combination becomes a structure of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product, zip_longest
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import show
from scenecc.lower.field_types import FieldType
from scenecc.lower.references import possible_values
from scenecc.lower.variation import VARYING, FieldPlace, FormStep, VariationLowerer, field_place
from scenecc.plan import Value, per_scene, varying
from scenecc.plan.properties import FLOAT32_MAX, FLOAT32_MIN
from scenecc.variation.nodes import Stacked

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Origin
    from scenecc.lower.fields import FieldLowerer
    from scenecc.variation.nodes import Node

_TEXT_TYPE = FieldType(convert=str, fallback="")
_KEY_TYPES = {
    "urdf": _TEXT_TYPE,
    "mjcf": _TEXT_TYPE,
    "scale": FieldType(fallback=1.0, within=(FLOAT32_MIN, FLOAT32_MAX)),
    "srdf": _TEXT_TYPE,
    "package_dir": _TEXT_TYPE,
    "fix_root_link": FieldType(dtype="bool", fallback=False),
}
"""The keys, in the order that tells alternatives apart."""

_TYPE_WORDS = {"float64": "a number", "bool": "true or false"}
_INDEX_TYPE = FieldType(dtype="int64", fallback=0, free=True)  # expressions give what it is picked by, and not itself

Combination = tuple[Any, ...]
"""A value of each key that is written, in their order."""


@dataclass(frozen=True, slots=True)
class Alternative:
    """One way to put an articulation together.

    Attributes:
        values: by key; what was left out is missing.
        places: where each of these is written.
    """

    values: dict[str, Any]
    places: dict[str, Origin]


@dataclass(frozen=True, slots=True)
class Alternatives:
    """All ways, of which each scene has one.

    Attributes:
        each: one or more.
        pick: (·,) index into them; None: there is one only.
    """

    each: tuple[Alternative, ...]
    pick: Value | None = None


def read_alternatives(entity: Any, origin: Origin, leaves: FieldLowerer) -> Alternatives | None:
    """What may be had together of what an articulation is put together from; None where that was reported.

    What no scene has is among it, to be judged all the same: with what stands beside it that no scene has either.

    Args:
        entity: as written.
        origin: of it.
        leaves: of it.
    """
    written = {key: given for key in _KEY_TYPES if (given := getattr(entity, key, None)) is not None}
    if VARYING.isdisjoint(given.__class__ for given in written.values()):
        return Alternatives((Alternative(written, {key: origin.child(key) for key in written}),))
    reading = VariationLowerer(leaves, origin)
    columns = [_KeyAlternatives(key, given, origin.child(key), reading) for key, given in written.items()]
    leaves.fix(reading)
    told = [column.enumerate(leaves) for column in columns]
    if reading.broken or not all(told):
        return None
    return _Combinations(columns, reading, leaves).all()


class _KeyAlternatives:
    """One key.

    Attributes:
        node: its value in each scene: a node, or a plain value.
        places: where each value that it can have is written, in their order.
    """

    def __init__(self, key: str, given: Any, origin: Origin, reading: VariationLowerer) -> None:
        self.key = key
        self.origin = origin
        self.varies = given.__class__ in VARYING
        self.places: dict[Any, Origin] = {}
        self._kind = _KEY_TYPES[key]
        self._sources: list[tuple[Node, Origin]] = []

        def leaf(one: Any, around: FieldPlace, step: FormStep) -> Any:
            inside = around.inside(step) if step else around
            if one.__class__ not in VARYING:
                self.places.setdefault(self.value(one), inside.origin)
                return one
            node = reading.item(one, self._kind, inside)
            if not reading.broken:
                self._sources.append((node, inside.origin))
            return node

        self.node = reading.select(given, field_place(origin), leaf)

    def value(self, given: Any) -> Any:
        """What a scene has, as values are told apart; None where it is none of the key's."""
        if self._kind is _TEXT_TYPE:
            return given if given.__class__ is str else None
        if self._kind.dtype == "bool":
            return given if given.__class__ is bool else None
        return float(given) if given.__class__ in {int, float} else None

    def enumerate(self, leaves: FieldLowerer) -> bool:
        """Whether all that it can be is known, and may be; otherwise that is reported."""
        text = self._kind is _TEXT_TYPE
        untold = f"it cannot be told which {'names' if text else 'values'} this gives"
        instead = "or write them in a `choice`" + (
            "" if text else ": what is put together is judged before it is drawn"
        )
        for node, place in self._sources:
            every = possible_values(node, place, leaves, untold, instead)
            if every is None:
                return False
            for given in every:
                value = self.value(given)
                if value is None or not self._may_be(value):
                    self._misfit(given, value, place, leaves)
                    return False
                self.places.setdefault(value, place)
        return True

    def _may_be(self, value: Any) -> bool:
        return self._kind.within is None or self._kind.bounds().allow(value)

    def _misfit(self, given: Any, value: Any, place: Origin, leaves: FieldLowerer) -> None:
        if value is not None:
            message = f"this expression gives {show(given)}, and it must be {self._kind.bounds().wanted(value)}"
            leaves.sink.report("SC513", message, place)
            return
        wanted = "a name" if self._kind is _TEXT_TYPE else _TYPE_WORDS[self._kind.dtype]
        code = "SC317" if self._kind is _TEXT_TYPE else "SC515"
        leaves.sink.report(code, f"this expression gives {show(given)}, and {wanted} is wanted", place)


class _Combinations:
    """The keys of one articulation, some of which vary."""

    def __init__(self, columns: list[_KeyAlternatives], reading: VariationLowerer, leaves: FieldLowerer) -> None:
        self._columns = columns
        self._reading = reading
        self._leaves = leaves
        self._node = Stacked(tuple(column.node for column in columns))

    def all(self) -> Alternatives | None:
        """All combinations, in the order in which their values are written; None where that was reported."""
        from scenecc.variation.bounds import ValueBounds  # noqa: PLC0415 - loaded where something varies

        had = self._together()
        if had is None:
            return None
        order = [{value: i for i, value in enumerate(column.places)} for column in self._columns]
        every = sorted(
            {*had, *self._unused(had)}, key=lambda row: [at[one] for at, one in zip(order, row, strict=True)]
        )
        numbers = {row: i for i, row in enumerate(every)}
        each = tuple(self._alternative(row) for row in every)
        if len(each) == 1:
            return Alternatives(each)
        reading, leaves = self._reading, self._leaves
        if reading.known:
            known = per_scene(self._rows(numbers), "int64")
            if not reading.cycled or len(set(known.numbers())) == len(each):
                return Alternatives(each, known)
        found = range(len(each)) if reading.cycled else sorted(numbers[row] for row in set(had))
        support = ValueBounds.of(found, exact=not reading.computed)
        pick = varying(lambda: self._rows(numbers), bounds=support, rows=len(leaves.scenes))
        leaves.drawing.drawn |= not reading.known
        if reading.computed or reading.risky:
            leaves.pend(pick, _INDEX_TYPE, self._first(), reading)
        return Alternatives(each, pick)

    def _alternative(self, row: Combination) -> Alternative:
        pairs = list(zip(self._columns, row, strict=True))
        return Alternative(
            {column.key: value for column, value in pairs},
            {column.key: column.places[value] for column, value in pairs},
        )

    def _together(self) -> list[Combination] | None:
        """What some scene can have, whatever is drawn; None where these are too many, which was reported."""
        from scenecc.variation.enumeration import MAX_OUTCOMES  # noqa: PLC0415 - loaded where something varies
        from scenecc.variation.operations import DrawError  # noqa: PLC0415 - likewise

        try:
            rows = self._leaves.drawing.reader().outcomes(self._node, self._leaves.scenes)
        except DrawError:
            # What reads it need not have it: each scene is judged as it is drawn.
            rows = None
        if rows is not None:
            return list(dict.fromkeys(map(self._combination, rows)))
        count = math.prod(len(column.places) for column in self._columns)
        if count > MAX_OUTCOMES and sum(column.varies for column in self._columns) > 1:
            keys = ", ".join(f"`{column.key}`" for column in self._columns if column.varies)
            message = f"{keys} have {count} combinations, and of what is put together {MAX_OUTCOMES} are looked at"
            hint = "let them read a shared draw, so that fewer of them come together"
            self._leaves.sink.report("SC317", message, self._first(), hint=hint)
            return None
        return list(product(*(column.places for column in self._columns)))

    def _combination(self, row: Sequence[Any]) -> Combination:
        return tuple(column.value(given) for column, given in zip(self._columns, row, strict=True))

    def _unused(self, had: list[Combination]) -> list[Combination]:
        """Combinations of the values that no scene can have: the first of one key with the first of the others."""
        missing = [
            [value for value in column.places if value not in used]
            for column, used in zip(self._columns, map(set, zip(*had, strict=True)), strict=True)
        ]
        return [
            tuple(one if value is None else value for one, value in zip(had[0], row, strict=True))
            for row in zip_longest(*missing)
        ]

    def _rows(self, numbers: dict[Combination, int]) -> NDArray[Any]:
        """Which of them each scene has.

        Raises:
            DrawError: one that was not foreseen, for what it reads has no value in some scene.
        """
        import numpy as np  # noqa: PLC0415 - loaded where something varies

        from scenecc.variation.operations import DrawError  # noqa: PLC0415 - likewise

        found: list[int] = []
        for scene, row in zip(self._leaves.scenes, self._leaves.batch().evaluate(self._node).tolist(), strict=True):
            number = numbers.get(self._combination(row))
            if number is None:
                raise DrawError(
                    f"this gives {show(row)}, which was not among what it was found to give", scene, self._node
                )
            found.append(number)
        return np.array(found, dtype=np.int64)

    def _first(self) -> Origin:
        """Where the first key is written that varies."""
        return next(column.origin for column in self._columns if column.varies)
