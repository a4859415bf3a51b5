"""What differs between two objects of plans, field by field, by the kinds of their fields."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scenecc.plan.articulation import Link, Mimic
from scenecc.plan.compare_order import moved
from scenecc.plan.compare_words import cut, held_words, own_words, reset_words, rows_words
from scenecc.plan.constraint import AxisDrive, AxisLimit
from scenecc.plan.fields import Kind, Many, Node, OneOf, Quantity, slots, type_name
from scenecc.plan.labels import field_place, item_place, name_place
from scenecc.plan.scene import structure_word

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan.compare_resets import Resets
    from scenecc.plan.compare_tables import Side, Tables
    from scenecc.plan.value import Value


@dataclass(frozen=True, slots=True)
class FieldDifference:
    """One field in which two objects differ, as in `Difference`."""

    kind: Literal["added", "removed", "moved", "changed"]
    path: str
    a: str | None
    b: str | None
    scene_count: int | None = None


@dataclass(frozen=True, slots=True)
class Both:
    """What two objects have in common.

    Attributes:
        tables, resets: of their plans.
        scenes: indices of the scenes that both are in; (1,) for what is in none.
        rows: of each, those of these scenes; None: all rows of both.
    """

    tables: Tables
    resets: Resets
    scenes: NDArray[np.int64]
    rows: tuple[NDArray[np.intp], NDArray[np.intp]] | None = None


_KEYS: dict[type, str] = {Link: "name", Mimic: "joint", AxisLimit: "axis", AxisDrive: "axis"}
"""By which of their fields items of lists are found."""


class Fields:
    """Compares two objects."""

    def __init__(self, both: Both) -> None:
        self._tables = both.tables
        self._resets = both.resets
        self._scenes = both.scenes
        self._rows = both.rows
        self._count = len(both.scenes)

    def compare_node(self, x: Any, y: Any, place: str, but: tuple[str, ...] = ()) -> Iterator[FieldDifference]:
        """Two dataclasses of one type, which a file has at `place`; `but`: fields that are left out."""
        for slot in slots(x.__class__):
            if slot.name not in but:
                where = field_place(place, slot.name, x.__class__)
                yield from self._compare(slot.kind, getattr(x, slot.name), getattr(y, slot.name), where)

    def _compare(self, kind: Kind, x: Any, y: Any, path: str) -> Iterator[FieldDifference]:
        if x is y and (x is None or (self._resets.same_draws and self._tables.same)):
            return
        if x is None or y is None:
            yield FieldDifference("changed", path, self._words(kind, x, 0, path), self._words(kind, y, 1, path))
        elif isinstance(kind, Quantity):
            yield from self._values(kind, x, y, path)
        elif isinstance(kind, Many) and isinstance(kind.item, Node) and kind.item.cls in _KEYS:
            yield from self._named(kind.item.cls, x, y, path)
        elif isinstance(kind, Many):
            yield from self._lists(kind.item, x, y, path)
        elif isinstance(kind, Node | OneOf) and x.__class__ is y.__class__:
            yield from self.compare_node(x, y, path)
        elif isinstance(kind, OneOf):
            yield FieldDifference("changed", f"{path}.type" if path else "type", _type(kind, x), _type(kind, y))
        elif x != y:
            yield FieldDifference("changed", path, self._words(kind, x, 0, path), self._words(kind, y, 1, path))

    def _named(self, cls: type, x: tuple[Any, ...], y: tuple[Any, ...], path: str) -> Iterator[FieldDifference]:
        """By their names, or by what else tells them apart."""
        key = _KEYS[cls]
        first, second = ({getattr(item, key): (place, item) for place, item in enumerate(items)} for items in (x, y))
        elsewhere = moved([second[name][0] for name in first if name in second])
        for name, (place, item) in first.items():
            where = path + name_place(name)
            if name not in second:
                yield FieldDifference("removed", where, self._item_words(item, x, 0), None)
                continue
            other_place, other = second[name]
            if other_place in elsewhere:
                yield FieldDifference("moved", where, f"number {place + 1}", f"number {other_place + 1}")
            if cls is Link and (parents := (_parent(item, x), _parent(other, y)))[0] != parents[1]:
                yield FieldDifference("changed", f"{where}.parent", *parents)
            yield from self.compare_node(item, other, where, but=(key, "parent"))
        for name, (_, item) in second.items():
            if name not in first:
                yield FieldDifference("added", path + name_place(name), None, self._item_words(item, y, 1))

    def _item_words(self, item: Any, items: tuple[Any, ...], side: Side) -> str | None:
        if not isinstance(item, Link):
            return self._words(Node(item.__class__), item, side)
        return "the root" if item.joint is None else f"{item.joint.type} on {_parent(item, items)}"

    def _lists(self, kind: Kind, x: tuple[Any, ...], y: tuple[Any, ...], path: str) -> Iterator[FieldDifference]:
        """By place; where one has more, what it has more is what stands where the rest is no longer the same."""
        short, count = min(len(x), len(y)), max(len(x), len(y))
        head = short if len(x) == len(y) else self._alike(kind, x, y, short)
        tail = 0 if len(x) == len(y) else self._alike(kind, x[::-1], y[::-1], short - head)
        for index in range(short - tail):
            yield from self._compare(kind, x[index], y[index], item_place(path, index, x[index], count=count))
        for index in range(short - tail, len(x) - tail):
            place = item_place(path, index, x[index], count=count)
            yield FieldDifference("removed", place, self._words(kind, x[index], 0), None)
        for index in range(short - tail, len(y) - tail):
            place = item_place(path, index, y[index], count=count)
            yield FieldDifference("added", place, None, self._words(kind, y[index], 1))
        for back in range(tail, 0, -1):
            place = item_place(path, len(x) - back, x[-back], count=count)
            yield from self._compare(kind, x[-back], y[-back], place)

    def _alike(self, kind: Kind, x: tuple[Any, ...], y: tuple[Any, ...], most: int) -> int:
        """How many are the same from the beginning on."""
        for index in range(most):
            if next(self._compare(kind, x[index], y[index], ""), None) is not None:
                return index
        return most

    def _values(self, kind: Quantity, x: Value, y: Value, path: str) -> Iterator[FieldDifference]:
        if kind.table is None and self._rows is None and self._resets.same_draws and x == y:
            return
        a, b = self._taken(kind, x, 0), self._taken(kind, y, 1)
        if kind.table not in {None, "files"}:
            # Rows of one material may stand for other scenes.
            if _differing(a, b).any() or self._rows is not None:
                yield from self._materials(kind, a, b, path)
        elif kind.pose and a.shape[1:] == b.shape[1:] == kind.shape:
            for name, part in (("p", slice(0, 3)), ("q", slice(3, 7))):
                yield from self._part((x, y), (a[:, part], b[:, part]), f"{path}.{name}", part)
        else:
            yield from self._part((x, y), (a, b), path, None, self._name(kind))

    def _part(
        self,
        values: tuple[Value, Value],
        rows: tuple[NDArray[Any], NDArray[Any]],
        path: str,
        part: slice | None,
        name: Any = None,
    ) -> Iterator[FieldDifference]:
        """Two values or the same part of both, as built and after a reset."""
        differing = _differing(*rows)
        if differing.any():
            at = np.flatnonzero(np.broadcast_to(differing, self._count))
            taken = [np.broadcast_to(one, (self._count, *one.shape[1:]))[at] for one in rows]
            a, b = rows_words(path, taken[0], taken[1], self._scenes[at], name)
            yield FieldDifference("changed", path, a, b, len(at))
            return
        count = self._resets.differing(self._scenes, values, rows, part)
        if count:
            a, b = reset_words(values, self._resets.plans, part)
            yield FieldDifference("changed", path, a, b, count)

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
                others = [pair for pair in pairs if repr(pair[0]) != repr(pair[1])]
                names = self._tables.names
                a_words, b_words = held_words(field, [x for x, _ in others], [y for _, y in others], names)
                yield FieldDifference("changed", f"{path}.{field.removesuffix('.file')}", a_words, b_words, count)

    def _by_row(self, indices: NDArray[np.int64], side: Side) -> list[tuple[int, int]]:
        rows = range(self._count) if self._rows is None else self._rows[side].tolist()
        return list(zip(rows, np.broadcast_to(indices, self._count).tolist(), strict=True))

    def _taken(self, kind: Quantity, value: Value, side: Side) -> NDArray[Any]:
        """The rows that count, with one number for equal entries of the tables."""
        data = value.data
        if self._rows is not None and len(data) != 1:
            data = data[self._rows[side]]
        return data if kind.table is None else self._tables.numbered(data, kind.table, side)

    def _name(self, kind: Quantity) -> Any:
        return self._tables.names.__getitem__ if kind.table == "files" else None

    def _words(self, kind: Kind, item: Any, side: Side, path: str = "") -> str | None:
        if item is None:
            return None
        if isinstance(kind, Quantity):
            return self._value_words(kind, item, side, path)
        if isinstance(kind, OneOf) and item.__class__ is not kind.untyped:
            return type_name(item.__class__)
        if isinstance(kind, Many):
            return str(len(item))
        if isinstance(kind, Node | OneOf):
            given = ((slot, getattr(item, slot.name)) for slot in slots(item.__class__))
            words = [
                f"{'type' if slot.name == 'geometry' else slot.name} {self._words(slot.kind, x, side)}"
                for slot, x in given
                if x is not None
            ]
            return cut(", ".join(words))
        return cut(json.dumps(item))

    def _value_words(self, kind: Quantity, value: Value, side: Side, path: str) -> str:
        rows = self._taken(kind, value, side)
        if kind.table is None or kind.table == "files":
            return own_words(path, rows, self._name(kind))
        row, index = self._by_row(rows, side)[0]
        held = _held(self._tables.materials[kind.table][index], row)
        names = self._tables.names
        return cut(", ".join(f"{name} {held_words(name, [item], [item], names)[0]}" for name, item in held.items()))


def _type(kind: OneOf, item: Any) -> str:
    return structure_word(item) if item.__class__ is kind.untyped else type_name(item.__class__)


def _parent(link: Link, links: tuple[Link, ...]) -> str | None:
    if link.parent is None:
        return None
    return links[link.parent].name if link.parent < len(links) else f"number {link.parent}"


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
