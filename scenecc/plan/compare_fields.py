"""What differs between two objects of plans, field by field, by the kinds of their fields."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scenecc.plan.fields import Kind, Many, Node, OneOf, Quantity, slots, type_name
from scenecc.plan.words import cut, rows_words

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan.compare_tables import Side, Tables
    from scenecc.plan.value import Value
    from scenecc.values.nodes import Node as RecipeNode


@dataclass(frozen=True, slots=True)
class FieldDifference:
    """One field in which two objects differ, as in `Difference`."""

    kind: Literal["added", "removed", "changed"]
    path: str
    a: str | None
    b: str | None
    scene_count: int | None = None


class Fields:
    """Compares two objects.

    Args:
        tables: of their plans.
        scene_count: how many scenes the first is in; 1 for what is in none.
        rows: of each, those of the scenes that both are in; None: all rows of both.
    """

    def __init__(
        self, tables: Tables, scene_count: int = 1, rows: tuple[NDArray[np.intp], NDArray[np.intp]] | None = None
    ) -> None:
        self._tables = tables
        self._rows = rows
        self._count = scene_count if rows is None else len(rows[0])

    def compare_node(self, x: Any, y: Any, path: str, but: tuple[str, ...] = ()) -> Iterator[FieldDifference]:
        """Two dataclasses of one type; `but`: fields that are left out."""
        for slot in slots(x.__class__):
            if slot.name not in but:
                where = f"{path}.{slot.name}" if path else slot.name
                yield from self._compare(slot.kind, getattr(x, slot.name), getattr(y, slot.name), where)

    def _compare(self, kind: Kind, x: Any, y: Any, path: str) -> Iterator[FieldDifference]:
        if x is y:
            return
        if x is None or y is None:
            yield FieldDifference("changed", path, self._words(kind, x, 0), self._words(kind, y, 1))
        elif isinstance(kind, Quantity):
            yield from self._values(kind, x, y, path)
        elif isinstance(kind, Many):
            yield from self._lists(kind.item, x, y, path)
        elif isinstance(kind, Node | OneOf) and x.__class__ is y.__class__:
            yield from self.compare_node(x, y, path)
        elif x != y:
            yield FieldDifference("changed", path, self._words(kind, x, 0), self._words(kind, y, 1))

    def _lists(self, kind: Kind, x: tuple[Any, ...], y: tuple[Any, ...], path: str) -> Iterator[FieldDifference]:
        """By place; where one has more, what it has more is what stands where the rest is no longer the same."""
        short = min(len(x), len(y))
        head = short if len(x) == len(y) else self._alike(kind, x, y, short)
        tail = 0 if len(x) == len(y) else self._alike(kind, x[::-1], y[::-1], short - head)
        for index in range(short - tail):
            yield from self._compare(kind, x[index], y[index], f"{path}[{index}]")
        for index in range(short - tail, len(x) - tail):
            yield FieldDifference("removed", f"{path}[{index}]", self._words(kind, x[index], 0), None)
        for index in range(short - tail, len(y) - tail):
            yield FieldDifference("added", f"{path}[{index}]", None, self._words(kind, y[index], 1))
        for back in range(tail, 0, -1):
            yield from self._compare(kind, x[-back], y[-back], f"{path}[{len(x) - back}]")

    def _alike(self, kind: Kind, x: tuple[Any, ...], y: tuple[Any, ...], most: int) -> int:
        """How many are the same from the beginning on."""
        for index in range(most):
            if next(self._compare(kind, x[index], y[index], ""), None) is not None:
                return index
        return most

    def _values(self, kind: Quantity, x: Value, y: Value, path: str) -> Iterator[FieldDifference]:
        if kind.table is None and self._rows is None and x == y:
            return
        a, b = self._taken(kind, x, 0), self._taken(kind, y, 1)
        differing = _differing(a, b)
        if kind.table not in {None, "files"}:
            # Rows of one material may stand for other scenes.
            if differing.any() or self._rows is not None:
                yield from self._materials(kind, a, b, path)
        elif differing.any():
            count = self._count if len(differing) == 1 else int(differing.sum())
            name = self._name(kind)
            yield FieldDifference("changed", path, rows_words(a, name), rows_words(b, name), count)
        elif repr(x.recipe) != repr(y.recipe):
            first, second = (None if one.recipe is None else recipe_words(one.recipe) for one in (x, y))
            yield FieldDifference("changed", f"{path}.recipe", first, second)

    def _materials(
        self, kind: Quantity, a: NDArray[np.int64], b: NDArray[np.int64], path: str
    ) -> Iterator[FieldDifference]:
        """By what the materials hold in each scene."""
        assert kind.table is not None
        table = self._tables.materials[kind.table]
        first = [_held(table[index], row) for row, index in self._by_row(a, 0)]
        second = [_held(table[index], row) for row, index in self._by_row(b, 1)]
        for field in {name: None for held in (*first, *second) for name in held}:
            pairs = [(x.get(field), y.get(field)) for x, y in zip(first, second, strict=True)]
            count = sum(repr(x) != repr(y) for x, y in pairs)
            if count:
                a_words, b_words = (self._held_words(field, [pair[side] for pair in pairs]) for side in (0, 1))
                yield FieldDifference("changed", f"{path}.{field}", a_words, b_words, count)

    def _by_row(self, indices: NDArray[np.int64], side: Side) -> list[tuple[int, int]]:
        rows = range(self._count) if self._rows is None else self._rows[side].tolist()
        return list(zip(rows, np.broadcast_to(indices, self._count).tolist(), strict=True))

    def _held_words(self, field: str, items: list[Any]) -> str | None:
        distinct: dict[str, Any] = {repr(item): item for item in items}
        if distinct.keys() == {"None"}:
            return None
        return cut(" | ".join(self._held_word(field, item) for item in distinct.values()))

    def _held_word(self, field: str, item: Any) -> str:
        if item is None:
            return "left out"
        if field.endswith(".file"):
            number: int = item
            return self._tables.names[number]
        return json.dumps(item)

    def _taken(self, kind: Quantity, value: Value, side: Side) -> NDArray[Any]:
        """The rows that count, with one number for equal entries of the tables."""
        data = value.data
        if self._rows is not None and len(data) != 1:
            data = data[self._rows[side]]
        return data if kind.table is None else self._tables.numbered(data, kind.table, side)

    def _name(self, kind: Quantity) -> Any:
        return self._tables.names.__getitem__ if kind.table == "files" else None

    def _words(self, kind: Kind, item: Any, side: Side) -> str | None:
        if item is None:
            return None
        if isinstance(kind, Quantity):
            return self._value_words(kind, item, side)
        if isinstance(kind, OneOf):
            return type_name(item.__class__)
        if isinstance(kind, Many):
            return str(len(item))
        if isinstance(kind, Node):
            given = ((slot, getattr(item, slot.name)) for slot in slots(item.__class__))
            words = [f"{slot.name} {self._words(slot.kind, x, side)}" for slot, x in given if x is not None]
            return cut(", ".join(words))
        return cut(json.dumps(item))

    def _value_words(self, kind: Quantity, value: Value, side: Side) -> str:
        rows = self._taken(kind, value, side)
        if kind.table is None or kind.table == "files":
            return rows_words(rows, self._name(kind))
        row, index = self._by_row(rows, side)[0]
        held = _held(self._tables.materials[kind.table][index], row)
        return cut(", ".join(f"{name} {self._held_words(name, [item])}" for name, item in held.items()))


def recipe_words(node: RecipeNode) -> str:
    """A recipe on a line."""
    from scenecc.plan.recipe_json import recipe_data  # noqa: PLC0415 - most plans have no recipes

    return cut(json.dumps(recipe_data(node), ensure_ascii=False))


def _differing(a: NDArray[Any], b: NDArray[Any]) -> NDArray[np.bool_]:
    """Which rows are not the same to the bit; one item where both have one row."""
    if a.dtype != b.dtype or a.shape[1:] != b.shape[1:]:
        return np.ones(max(len(a), len(b)), np.bool_)
    count = max(len(a), len(b)) if len(a) and len(b) else 0
    first, second = (
        np.ascontiguousarray(np.broadcast_to(one, (count, *one.shape[1:]))).reshape(count, -1).view(np.uint8)
        for one in (a, b)
    )
    return (first != second).any(axis=1)


def _held(material: Any, row: int) -> dict[str, Any]:
    """What a material holds in a row, by the path of the field."""
    held: dict[str, Any] = {}
    for slot in slots(material.__class__):
        item = getattr(material, slot.name)
        if item is None:
            continue
        if isinstance(slot.kind, Quantity):
            held[slot.name] = item.row(row).tolist()
        else:
            held[f"{slot.name}.file"] = int(item.file.row(row))
            held |= {f"{slot.name}.{key}": value for key, value in item.sampling().items()}
    return held
