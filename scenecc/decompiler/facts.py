"""What is read of a live scene: a tree of frozen, comparable, picklable data that holds no object of the engine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias, cast

import numpy as np


@dataclass(frozen=True)
class Numbers:
    """One number or an array of numbers, to the bit.

    -0.0 was made 0.0 when it was read: the two are one number, and whether a zero has a sign is an accident of how
    a pose was composed. A NaN equals a NaN of the same bits.

    Attributes:
        dtype: numpy's name of the type (`<f4`).
        shape: of the array; `()` for a number.
        data: the array's bytes in C order.
    """

    dtype: str
    shape: tuple[int, ...]
    data: bytes

    def array(self) -> np.ndarray:
        """The numbers again; not writable."""
        return np.frombuffer(self.data, dtype=self.dtype).reshape(self.shape)

    def __str__(self) -> str:
        # repr of a float32 has as many digits as tell it from its neighbours.
        values = self.array()
        if values.size > 16:
            return f"{'×'.join(map(str, self.shape))} numbers"
        return str([str(x) for x in values.ravel()]).replace("'", "") if self.shape else str(values[()])


Plain: TypeAlias = "Numbers | str | bool | int | tuple[Plain, ...] | None"


@dataclass(frozen=True)
class Facts:
    """An object and what it consists of.

    Attributes:
        kind: the engine's class (`PhysxCollisionShapeBox`), or what the node stands for (`scene`, `articulation`).
        name: the object's own name, "" if it has none.
        values: its properties by the engine's names, in the order of the tables.
        parts: the objects in it, in the engine's order.
    """

    kind: str
    name: str
    values: tuple[tuple[str, Plain], ...]
    parts: tuple[Facts, ...] = ()

    def value(self, name: str) -> Plain:
        """The property of a name.

        Raises:
            KeyError: there is none.
        """
        return dict(self.values)[name]

    def of_kind(self, kind: str) -> list[Facts]:
        """The objects of a kind in the tree, this one among them, depth first."""
        found = [self] if self.kind == kind else []
        return found + [inner for part in self.parts for inner in part.of_kind(kind)]


NAMES = frozenset({"links", "joints", "active_joints", "parent", "articulation"})
"""Properties that hold names of other objects."""


def renamed(facts: Facts, rename: Callable[[str], str]) -> Facts:
    """The same tree with other names, also where one object names another; shapes keep theirs."""

    def called(name: str, value: Plain) -> Plain:
        if name not in NAMES or value is None:
            return value
        return rename(value) if isinstance(value, str) else tuple(called(name, item) for item in _items(value))

    return replace(
        facts,
        name=facts.name if facts.kind.startswith("RenderShape") else rename(facts.name),
        values=tuple((name, called(name, value)) for name, value in facts.values),
        parts=tuple(renamed(part, rename) for part in facts.parts),
    )


def _items(value: Plain) -> tuple[Plain, ...]:
    assert isinstance(value, tuple)
    return value


def plain(value: Any) -> Plain:
    """A value of the engine as comparable data.

    Raises:
        TypeError: it is of a type that no table should name.
    """
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if type(value).__name__ == "Pose":
        value = np.concatenate([value.p, value.q])
    if isinstance(value, (float, np.ndarray, np.generic)):
        array: Any = np.ascontiguousarray(cast("Any", value))
        array = array.reshape(np.shape(cast("Any", value)))
        array = array + np.zeros((), array.dtype) if array.dtype.kind == "f" else array
        return Numbers(array.dtype.str, array.shape, array.tobytes())
    if isinstance(value, (list, tuple)):
        return tuple(plain(item) for item in cast("list[Any]", value))
    raise TypeError(f"{type(value)} is no plain value")
