"""Quantities of a plan as expressions: written in place where scenes agree, as a list by scene where they differ."""

from __future__ import annotations

import math
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.emit.python.layout import Group, Node, Source, call, list_of, string

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Hashable, Sequence

    from numpy.typing import NDArray

    from scenecc.emit.python.names import Names
    from scenecc.plan import ArticulationStructure, BodyStructure, Entity, Value

IDENTITY = np.array([0, 0, 0, 1, 0, 0, 0], dtype=np.float64)


def number(item: float) -> str:
    """The shortest literal of the same float64 (a whole number of a few digits without its point), integer or flag.

    Infinity, which limits may be, has none.
    """
    if isinstance(item, float) and math.isinf(item):
        return f'float("{item}")'
    if isinstance(item, float) and item.is_integer() and abs(item) < 1e6 and str(item) != "-0.0":
        return str(int(item))
    return repr(item).replace("e+", "e")


def numbers(row: NDArray[Any]) -> Node:
    """A number, or a list of them to any depth."""
    return _numbers(row.tolist())


def pose(row: NDArray[np.float64]) -> Node:
    """A `sapien.Pose`; SAPIEN's own rotation is left out."""
    rotation = () if row[3:].tobytes() == IDENTITY[3:].tobytes() else (numbers(row[3:]),)
    return call("sapien.Pose", numbers(row[:3]), *rotation)


def _numbers(item: float | list[Any]) -> Node:
    if not isinstance(item, list):
        return number(item)
    return list_of([_numbers(one) for one in item])


def variants(entity: Entity) -> list[tuple[int, BodyStructure | ArticulationStructure, NDArray[np.intp]]]:
    """The structures that some scene has: index, structure, and the entity's rows that have it."""
    pick = np.broadcast_to(0 if entity.pick is None else entity.pick.data, len(entity.scene_idxs))
    found = ((index, structure, np.flatnonzero(pick == index)) for index, structure in enumerate(entity.structures))
    return [(index, structure, rows) for index, structure, rows in found if len(rows)]


@dataclass(slots=True)
class Columns:
    """Expressions for one entity in the scenes of one block.

    Attributes:
        ident: what names of lists start with.
        rows: the entity's rows (not scene indices) that the block builds.
        names: where names of lists come from.
        copies: how many entities in one these rows are of, one after the other.
    """

    ident: str
    rows: NDArray[np.intp]
    names: Names
    copies: int = 1
    _lists: dict[Group, str] = field(default_factory=dict[Group, str])
    _seen: set[str] = field(default_factory=set[str])
    _indices: set[str] = field(default_factory=set[str])
    _rendered: bool = False

    def value(self, value: Value, name: str, write: Callable[[Any], Node] = numbers) -> Node:
        """A quantity of the plan; `write` makes an expression of one row."""
        return self.of_block(value.data[self.rows] if value.varies else value.data, name, write)

    def of_block(self, data: NDArray[Any], name: str, write: Callable[[Any], Node] = numbers) -> Node:
        """As `value`, of one row for each of the block, or one in all."""
        return self._chosen([row.tobytes() for row in data], name, lambda row: write(data[row]))

    def words(self, items: Sequence[str], name: str) -> Node:
        """Strings, one a row of the block."""
        return self._chosen(items, name, lambda row: string(items[row]))

    def _chosen(self, keys: Sequence[Hashable], name: str, write: Callable[[int], Node]) -> Node:
        """What rows have in place where all agree, or else from a list by scene, by copy, or by both."""
        if len(set(keys)) == 1:
            return write(0)
        scenes = len(keys) // self.copies
        starts = range(0, len(keys), scenes)
        by_copy = [keys[start : start + scenes] for start in starts]
        if all(len(set(copy)) == 1 for copy in by_copy):
            return self._list(name, [write(start) for start in starts], "[k]")
        if all(copy == by_copy[0] for copy in by_copy):
            return self._list(name, [write(row) for row in range(scenes)], "[i]")
        rows = [list_of([write(start + row) for row in range(scenes)]) for start in starts]
        return self._list(name, rows, "[k][i]")

    def of_rows(self, value: Value) -> NDArray[Any]:
        """The plan's data, one row for each of the block."""
        return value.data[self.rows] if value.varies else np.repeat(value.data, len(self.rows), axis=0)

    @contextmanager
    def rendered(self) -> Generator[None]:
        """Lists that are made inside are needed only where there is a renderer."""
        self._rendered = True
        yield
        self._rendered = False

    def reads(self, index: str) -> bool:
        """Whether any quantity is by scene, `i`, or by copy, `k`."""
        return any(index in at for at in self._indices)

    def write(self, source: Source) -> None:
        """Assigns the lists, ahead of the loop over scenes."""
        for items, name in self._lists.items():
            if name not in self._seen:
                source.statement(items, assign=name)
        if self._seen:
            with source.block("if render:"):
                for items, name in self._lists.items():
                    if name in self._seen:
                        source.statement(items, assign=name)

    def _list(self, name: str, items: Sequence[Node], at: str) -> str:
        self._indices.add(at)
        items_node = list_of(items)
        # What collides and what is seen mostly have the same sizes: one list serves both.
        variable = self._lists.get(items_node)
        if variable is None:
            variable = self._lists[items_node] = self.names.take(f"{self.ident}_{name}")
            if self._rendered:
                self._seen.add(variable)
        elif not self._rendered:
            self._seen.discard(variable)
        return variable + at
