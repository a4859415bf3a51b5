"""Differences between two plans, field by field, with the keys of the language."""

from __future__ import annotations

import json
from bisect import bisect_left
from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from scenecc.diagnostics.messages import index_ranges
from scenecc.plan.articulation import Link
from scenecc.plan.constraint import Constraint
from scenecc.plan.display import (
    ITEM_KEYS,
    field_path,
    format_material_pair,
    format_reset_pair,
    format_row_pair,
    format_rows,
    item_path,
    name_suffix,
    truncate,
)
from scenecc.plan.expect import Condition, Expectation, describe_expectation
from scenecc.plan.placement import Placement
from scenecc.plan.properties import Quantity, TableName
from scenecc.plan.rendering import Camera, Environment, Light
from scenecc.plan.scene import Entity, ScenePlan, structure_type
from scenecc.plan.schema import FieldKind, ListKind, ObjectKind, ScalarKind, UnionKind, plan_fields, type_name
from scenecc.plan.value import Value
from scenecc.plan.walk import walk_fields
from scenecc.variation.evaluation import Batch, to_field_rows
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan.body import AssetFile, VisualMaterial

Side = Literal[0, 1]

_HASH_DIGITS = 12
"""Digits of a hash that people are shown."""


class MergedTables:
    """Numbers for the entries of two plans' tables: equal entries have one.

    Attributes:
        same: whether the tables are the same, entry by entry.
        names: of each file, by its number.
        materials: by table, with the numbers of their files in place of the indices.
    """

    def __init__(self, a: ScenePlan, b: ScenePlan) -> None:
        self.same = all(
            getattr(a, name) == getattr(b, name) for name in ("files", "physical_materials", "visual_materials")
        )
        self.names: list[str] = []
        self._numbers: dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]] = {"files": self._files(a.files, b.files)}
        tables: dict[str, tuple[Sequence[Hashable], Sequence[Hashable]]] = {
            "physical_materials": (a.physical_materials, b.physical_materials),
            "visual_materials": (
                [self._named(material, 0) for material in a.visual_materials],
                [self._named(material, 1) for material in b.visual_materials],
            ),
        }
        self.materials: dict[str, list[Any]] = {}
        for name, (first, second) in tables.items():
            self._numbers[name] = self._joined(name, first, second)

    def numbered(self, indices: NDArray[np.int64], table: TableName, side: Side) -> NDArray[np.int64]:
        """Indices of one of the plans as numbers of both."""
        return self._numbers[table][side][indices]

    def _files(self, a: Sequence[AssetFile], b: Sequence[AssetFile]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        known: dict[object, int] = {}
        told: list[AssetFile] = []
        numbers: tuple[list[int], list[int]] = ([], [])
        for side, files in enumerate((a, b)):
            for file in files:
                content = (file.sha256, file.data, tuple(one.sha256 for one in file.names))
                number = known.get((file.uri, content), known.get((file.path, content), len(self.names)))
                if number == len(self.names):
                    self.names.append(file.uri)
                    told.append(file)
                known.setdefault((file.uri, content), number)
                known.setdefault((file.path, content), number)
                numbers[side].append(number)
        count = Counter(self.names)
        self.names[:] = [file.uri if count[file.uri] == 1 else _uri_with_hashes(file) for file in told]
        return np.array(numbers[0], np.int64), np.array(numbers[1], np.int64)

    def _named(self, material: VisualMaterial, side: Side) -> VisualMaterial:
        """The material with the numbers of its files in place of their indices."""
        textures: dict[str, Any] = {
            name: replace(texture, file=Value(self.numbered(texture.file.data, "files", side)))
            for name, texture in material.textures().items()
        }
        return replace(material, **textures)

    def _joined(
        self, table: str, a: Sequence[Hashable], b: Sequence[Hashable]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        known: dict[Hashable, int] = {}
        first, second = ([known.setdefault(row, len(known)) for row in rows] for rows in (a, b))
        self.materials[table] = list(known)
        return np.array(first, np.int64), np.array(second, np.int64)


def _uri_with_hashes(file: AssetFile) -> str:
    """A file's uri, and what it and those that it names hold, in short."""
    hashes = [
        (file.sha256 or "unknown")[:_HASH_DIGITS],
        *(f"{one.uri} {one.sha256[:_HASH_DIGITS]}" for one in file.names),
    ]
    return f"{file.uri} (SHA-256 {', '.join(hashes)})"


MIN_SEEDS: Final = 4

MIN_DRAWS: Final = 256
"""So many seeds at least, and so many draws of each value over all scenes: one that is seldom another shows."""

_FIRST_SEED: Final = 0x5CE9E


class ResetComparison:
    """Evaluates the recipes of two plans with the same seeds.

    Attributes:
        plans: the two.
        same_draws: whether their shared draws are written alike.
    """

    def __init__(self, a: ScenePlan, b: ScenePlan) -> None:
        self.same_draws = repr(a.draws) == repr(b.draws) and a.num_scenes == b.num_scenes
        self.plans = (a, b)
        self._batches: dict[tuple[Side, bytes], Batch] = {}

    def differing(
        self,
        scenes: NDArray[np.int64],
        values: tuple[Value, Value],
        rows: tuple[NDArray[Any], NDArray[Any]],
        part: slice | None = None,
    ) -> int:
        """In how many scenes some seed gives the two something else.

        Args:
            scenes: indices of those that both have (B,).
            values: of the two plans.
            rows: their data there, or a part of it (B, …) or (1, …), for what a reset leaves as it is.
            part: of each row that a recipe gives; None: all of it.
        """
        x, y = values
        if x.recipe is None and y.recipe is None:
            return 0
        if self.same_draws and repr(x.recipe) == repr(y.recipe):
            return 0
        first, second = self._given(0, scenes, x, rows[0], part), self._given(1, scenes, y, rows[1], part)
        if isinstance(first, str) or isinstance(second, str):
            # What has no value with one of the seeds is the same only as what fails alike.
            return 0 if isinstance(first, str) and first == second else len(scenes)
        return int((first != second).any(axis=(0, 2)).sum())

    def _given(
        self, side: Side, scenes: NDArray[np.int64], value: Value, rows: NDArray[Any], part: slice | None
    ) -> NDArray[np.uint8] | str:
        """What the seeds give, to the bit: (seeds, B, bytes); or why one of them gives nothing."""
        seeds = max(MIN_SEEDS, -(-MIN_DRAWS // len(scenes)))
        if value.recipe is None:
            data = np.broadcast_to(rows, (seeds, len(scenes), *rows.shape[1:]))
        else:
            try:
                data = to_field_rows(self._batch(side, scenes, seeds).evaluate(value.recipe))
            except DrawError as error:
                return str(error)
            data = data if part is None else data[:, part]
        numbers = np.ascontiguousarray(data, dtype=np.float64)
        return numbers.reshape(seeds, len(scenes), -1).view(np.uint8)

    def _batch(self, side: Side, scenes: NDArray[np.int64], seeds: int) -> Batch:
        key = (side, scenes.tobytes())
        if key not in self._batches:
            plan = self.plans[side]
            each = np.repeat(np.arange(_FIRST_SEED, _FIRST_SEED + seeds), len(scenes)).tolist()
            self._batches[key] = Batch(np.tile(scenes, seeds), tuple(each), plan.num_scenes, dict(plan.draws), {})
        return self._batches[key]


@dataclass(frozen=True, slots=True)
class ComparisonContext:
    """What two objects have in common.

    Attributes:
        tables, resets: of their plans.
        scenes: indices of the scenes that both are in; (1,) for what is in none.
        rows: of each, those of these scenes; None: all rows of both.
    """

    tables: MergedTables
    resets: ResetComparison
    scenes: NDArray[np.int64]
    rows: tuple[NDArray[np.intp], NDArray[np.intp]] | None = None


def find_moved(places: Sequence[int]) -> set[int]:
    """The fewest that must move for the rest to ascend."""
    ends: list[int] = []
    before: list[int | None] = []
    tails: list[int] = []
    for number, place in enumerate(places):
        at = bisect_left(ends, place)
        before.append(tails[at - 1] if at else None)
        ends[at : at + 1] = [place]
        tails[at : at + 1] = [number]
    stay: set[int] = set()
    number = tails[-1] if tails else None
    while number is not None:
        stay.add(places[number])
        number = before[number]
    return set(places) - stay


@dataclass(frozen=True, slots=True)
class FieldDifference:
    """One field in which two objects differ, as in `Difference`."""

    kind: Literal["added", "removed", "moved", "changed"]
    path: str
    a: str | None
    b: str | None
    scene_count: int | None = None


class FieldComparison:
    """Compares two objects."""

    def __init__(self, both: ComparisonContext) -> None:
        self._tables = both.tables
        self._resets = both.resets
        self._scenes = both.scenes
        self._rows = both.rows
        self._count = len(both.scenes)

    def compare_node(self, x: Any, y: Any, place: str, but: tuple[str, ...] = ()) -> Iterator[FieldDifference]:
        """Two dataclasses of one type, which a file has at `place`; `but`: fields that are left out."""
        for slot in plan_fields(x.__class__):
            if slot.name not in but:
                where = field_path(place, slot.name, x.__class__)
                yield from self._compare(slot.kind, getattr(x, slot.name), getattr(y, slot.name), where)

    def _compare(self, kind: FieldKind, x: Any, y: Any, path: str) -> Iterator[FieldDifference]:
        if x is y and (x is None or (self._resets.same_draws and self._tables.same)):
            return
        if x is None or y is None:
            yield FieldDifference("changed", path, self._words(kind, x, 0, path), self._words(kind, y, 1, path))
        elif isinstance(kind, Quantity):
            yield from self._values(kind, x, y, path)
        elif isinstance(kind, ListKind) and isinstance(kind.item, ObjectKind) and kind.item.cls in ITEM_KEYS:
            yield from self._named(kind.item.cls, x, y, path)
        elif isinstance(kind, ListKind) and isinstance(kind.item, ListKind):
            yield from _rows_of_numbers(x, y, path)
        elif isinstance(kind, ListKind):
            yield from self._lists(kind.item, x, y, path)
        elif isinstance(kind, ObjectKind | UnionKind) and x.__class__ is y.__class__:
            yield from self.compare_node(x, y, path)
        elif isinstance(kind, UnionKind):
            yield FieldDifference(
                "changed", f"{path}.type" if path else "type", _union_type_name(kind, x), _union_type_name(kind, y)
            )
        elif x != y:
            yield FieldDifference("changed", path, self._words(kind, x, 0, path), self._words(kind, y, 1, path))

    def _named(self, cls: type, x: tuple[Any, ...], y: tuple[Any, ...], path: str) -> Iterator[FieldDifference]:
        """By their names, or by another key that is unique."""
        key = ITEM_KEYS[cls]
        first, second = ({getattr(item, key): (place, item) for place, item in enumerate(items)} for items in (x, y))
        elsewhere = find_moved([second[name][0] for name in first if name in second])
        for name, (place, item) in first.items():
            where = path + name_suffix(name)
            if name not in second:
                yield FieldDifference("removed", where, self._item_words(item, x, 0), None)
                continue
            other_place, other = second[name]
            if other_place in elsewhere:
                yield FieldDifference("moved", where, f"number {place + 1}", f"number {other_place + 1}")
            if cls is Link and (parents := (_parent_name(item, x), _parent_name(other, y)))[0] != parents[1]:
                yield FieldDifference("changed", f"{where}.parent", *parents)
            yield from self.compare_node(item, other, where, but=(key, "parent"))
        for name, (_, item) in second.items():
            if name not in first:
                yield FieldDifference("added", path + name_suffix(name), None, self._item_words(item, y, 1))

    def _item_words(self, item: Any, items: tuple[Any, ...], side: Side) -> str | None:
        if not isinstance(item, Link):
            return self._words(ObjectKind(item.__class__), item, side)
        return "the root" if item.joint is None else f"{item.joint.type} on {_parent_name(item, items)}"

    def _lists(self, kind: FieldKind, x: tuple[Any, ...], y: tuple[Any, ...], path: str) -> Iterator[FieldDifference]:
        """By place; where one has more, what it has more is what stands where the rest is no longer the same."""
        short, count = min(len(x), len(y)), max(len(x), len(y))
        head = short if len(x) == len(y) else self._alike(kind, x, y, short)
        tail = 0 if len(x) == len(y) else self._alike(kind, x[::-1], y[::-1], short - head)
        for index in range(short - tail):
            yield from self._compare(kind, x[index], y[index], item_path(path, index, x[index], count=count))
        for index in range(short - tail, len(x) - tail):
            place = item_path(path, index, x[index], count=count)
            yield FieldDifference("removed", place, self._words(kind, x[index], 0), None)
        for index in range(short - tail, len(y) - tail):
            place = item_path(path, index, y[index], count=count)
            yield FieldDifference("added", place, None, self._words(kind, y[index], 1))
        for back in range(tail, 0, -1):
            place = item_path(path, len(x) - back, x[-back], count=count)
            yield from self._compare(kind, x[-back], y[-back], place)

    def _alike(self, kind: FieldKind, x: tuple[Any, ...], y: tuple[Any, ...], most: int) -> int:
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
            if _differing_rows(a, b).any() or self._rows is not None:
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
        differing = _differing_rows(*rows)
        if differing.any():
            at = np.flatnonzero(np.broadcast_to(differing, self._count))
            taken = [np.broadcast_to(one, (self._count, *one.shape[1:]))[at] for one in rows]
            a, b = format_row_pair(path, taken[0], taken[1], self._scenes[at], name)
            yield FieldDifference("changed", path, a, b, len(at))
            return
        count = self._resets.differing(self._scenes, values, rows, part)
        if count:
            a, b = format_reset_pair(values, self._resets.plans, part)
            yield FieldDifference("changed", path, a, b, count)

    def _materials(
        self, kind: Quantity, a: NDArray[np.int64], b: NDArray[np.int64], path: str
    ) -> Iterator[FieldDifference]:
        """By what the materials hold in each scene."""
        assert kind.table is not None
        table = self._tables.materials[kind.table]
        first = [_material_values(table[index], row) for row, index in self._by_row(a, 0)]
        second = [_material_values(table[index], row) for row, index in self._by_row(b, 1)]
        for field in {name: None for values in (*first, *second) for name in values}:
            pairs = [(x.get(field), y.get(field)) for x, y in zip(first, second, strict=True)]
            count = sum(repr(x) != repr(y) for x, y in pairs)
            if count:
                others = [pair for pair in pairs if repr(pair[0]) != repr(pair[1])]
                names = self._tables.names
                a_words, b_words = format_material_pair(field, [x for x, _ in others], [y for _, y in others], names)
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

    def _words(self, kind: FieldKind, item: Any, side: Side, path: str = "") -> str | None:
        if item is None:
            return None
        if isinstance(kind, Quantity):
            return self._value_words(kind, item, side, path)
        if isinstance(kind, UnionKind) and item.__class__ is not kind.untyped:
            return type_name(item.__class__)
        if isinstance(kind, ListKind):
            return str(len(item))
        if isinstance(kind, ObjectKind | UnionKind):
            given = ((slot, getattr(item, slot.name)) for slot in plan_fields(item.__class__))
            words = [
                f"{'type' if slot.name == 'geometry' else slot.name} {self._words(slot.kind, x, side)}"
                for slot, x in given
                if x is not None
            ]
            return truncate(", ".join(words))
        return truncate(json.dumps(item))

    def _value_words(self, kind: Quantity, value: Value, side: Side, path: str) -> str:
        rows = self._taken(kind, value, side)
        if kind.table is None or kind.table == "files":
            return format_rows(path, rows, self._name(kind))
        row, index = self._by_row(rows, side)[0]
        values = _material_values(self._tables.materials[kind.table][index], row)
        names = self._tables.names
        return truncate(
            ", ".join(f"{name} {format_material_pair(name, [item], [item], names)[0]}" for name, item in values.items())
        )


def _union_type_name(kind: UnionKind, item: Any) -> str:
    return structure_type(item) if item.__class__ is kind.untyped else type_name(item.__class__)


def _parent_name(link: Link, links: tuple[Link, ...]) -> str | None:
    if link.parent is None:
        return None
    return links[link.parent].name if link.parent < len(links) else f"number {link.parent}"


def _differing_rows(a: NDArray[Any], b: NDArray[Any]) -> NDArray[np.bool_]:
    """Which rows are not the same to the bit; one item where both have one row."""
    if a.dtype != b.dtype or a.shape[1:] != b.shape[1:]:
        return np.ones(max(len(a), len(b)), np.bool_)
    count = max(len(a), len(b)) if len(a) and len(b) else 0
    first, second = (
        np.ascontiguousarray(np.broadcast_to(one, (count, *one.shape[1:]))).reshape(count, -1).view(np.uint8)
        for one in (a, b)
    )
    return (first != second).any(axis=1)


def _material_values(material: Any, row: int) -> dict[str, Any]:
    """What a material holds in a row, by the path of the field."""
    return {
        path: item.row(row).tolist() if isinstance(kind, Quantity) else item
        for path, kind, item in walk_fields(material)
    }


def _rows_of_numbers(
    x: tuple[tuple[float, ...], ...], y: tuple[tuple[float, ...], ...], path: str
) -> Iterator[FieldDifference]:
    """Heights of terrain, as one difference."""
    if x == y:
        return
    first, second = np.array(x), np.array(y)
    if first.shape != second.shape:
        a, b = (f"{len(rows)} × {len(rows[0])} numbers" for rows in (x, y))
    else:
        count = int((first != second).sum())
        b = f"{count} of {first.size} numbers differ, by at most {np.abs(first - second).max():.3g}"
        a = f"{len(x)} × {len(x[0])} numbers"
    yield FieldDifference("changed", path, a, b)


Section = Literal[
    "plan", "physics", "entities", "constraints", "environment", "lights", "cameras", "placements", "expect"
]

_Object = Entity | Constraint | Light | Camera | Placement


@dataclass(frozen=True, slots=True)
class Difference:
    """One thing in which two plans differ.

    Attributes:
        kind: "added" and "removed" are objects, links or shapes that only the second or only the first plan has;
            "moved" are objects and links that are built in another order; "changed" is all else.
        section: where the object is; "plan" for what concerns the whole.
        name: of the object; "" in "plan", "physics" and "environment".
        path: of the field in the object, as in the scene file where the shape is known to be from one, such as
            `shapes[1].radius`, and by the names of links: `links.hand.joint.limits`; "" for the object.
        a, b: what the first and the second plan have there, in a few words, in the scenes that differ; None where
            they have nothing. What says "at reset" is the same as built.
        scene_count: number of scenes in which the field differs, of those that contain both objects; None if it is not
            compared by scene.
    """

    kind: Literal["added", "removed", "moved", "changed"]
    section: Section
    name: str
    path: str
    a: str | None
    b: str | None
    scene_count: int | None = None


def diff_plans(a: ScenePlan, b: ScenePlan) -> list[Difference]:
    """Everything in which two plans differ in what they build and reset, and in `name`, `description` and `seed`.

    Two recipes are the same if they give the same, to the bit, in every scene with each of some seeds
    (see the comparison of resets), whatever they are made of; shared draws count by what reads them.

    The order of the tables of files and materials and what nothing refers to in them are no difference. Files are one
    if their uris or their places are. Rows of values are compared scene by scene, in the scenes that both have;
    entities that share no scene differ in their scenes alone.
    """
    found: list[Difference] = []
    for slot in plan_fields(ScenePlan):
        x, y = getattr(a, slot.name), getattr(b, slot.name)
        if isinstance(slot.kind, ScalarKind) and x != y:
            found.append(Difference("changed", "plan", "", slot.name, str(x), str(y)))
    tables, resets = MergedTables(a, b), ResetComparison(a, b)
    physics = FieldComparison(ComparisonContext(tables, resets, np.zeros(1, np.int64))).compare_node(
        a.physics, b.physics, ""
    )
    found += [_to_difference(one, "physics", "") for one in physics]
    found += _compare_sections("entities", a, b, tables, resets)
    found += _compare_sections("constraints", a, b, tables, resets)
    found += _compare_environments(a, b, tables, resets)
    found += _compare_sections("lights", a, b, tables, resets)
    found += _compare_sections("cameras", a, b, tables, resets)
    found += _compare_sections("placements", a, b, tables, resets)
    found += _compare_expectations(a, b)
    return found


def _compare_expectations(a: ScenePlan, b: ScenePlan) -> Iterator[Difference]:
    first, second = ({one.name: one for one in plan.expectations} for plan in (a, b))
    for name in dict.fromkeys((*first, *second)):
        one, other = first.get(name), second.get(name)
        if one != other:
            kind = "added" if one is None else "removed" if other is None else "changed"
            x, y = (None if each is None else _describe_expectation(each) for each in (one, other))
            yield Difference(kind, "expect", name, "", x, y)


def _describe_expectation(one: Expectation) -> str:
    scenes = f", in scenes {index_ranges(one.scene_idxs)}" if isinstance(one, Condition) else ""
    return describe_expectation(one) + scenes


def _to_difference(one: FieldDifference, section: Section, name: str) -> Difference:
    return Difference(one.kind, section, name, one.path, one.a, one.b, one.scene_count)


def _compare_environments(
    a: ScenePlan, b: ScenePlan, tables: MergedTables, resets: ResetComparison
) -> Iterator[Difference]:
    first, second = (plan.environment if plan.environment is not None else Environment() for plan in (a, b))
    count = min(a.num_scenes, b.num_scenes)
    # It has a row a scene of the batch.
    rows = None if a.num_scenes == b.num_scenes else (np.arange(count), np.arange(count))
    for one in FieldComparison(ComparisonContext(tables, resets, np.arange(count), rows)).compare_node(
        first, second, ""
    ):
        yield _to_difference(one, "environment", "")


def _compare_sections(
    section: Section, a: ScenePlan, b: ScenePlan, tables: MergedTables, resets: ResetComparison
) -> Iterator[Difference]:
    first: dict[str, tuple[int, _Object]] = {one.name: (place, one) for place, one in enumerate(getattr(a, section))}
    second: dict[str, tuple[int, _Object]] = {one.name: (place, one) for place, one in enumerate(getattr(b, section))}
    common = [name for name in first if name in second]
    elsewhere = find_moved([second[name][0] for name in common])
    for name, (place, one) in first.items():
        if name not in second:
            yield Difference("removed", section, name, "", _describe_object(one, a), None)
            continue
        other_place, other = second[name]
        if other_place in elsewhere:
            yield Difference("moved", section, name, "", f"number {place + 1}", f"number {other_place + 1}")
        if tables.same and resets.same_draws and one == other:
            continue
        yield from _compare_objects(section, one, other, tables, resets)
    for name, (_, one) in second.items():
        if name not in first:
            yield Difference("added", section, name, "", None, _describe_object(one, b))


def _compare_objects(
    section: Section, a: _Object, b: _Object, tables: MergedTables, resets: ResetComparison
) -> Iterator[Difference]:
    rows = None
    num_scenes = tuple(plan.num_scenes for plan in resets.plans)
    scenes = np.array(a.scene_idxs, np.int64)
    if a.scene_idxs != b.scene_idxs:
        rows = _common_rows(a.scene_idxs, b.scene_idxs)
        if (len(a.scene_idxs), len(b.scene_idxs)) != num_scenes:
            first, second = _describe_scenes(a.scene_idxs, num_scenes[0]), _describe_scenes(b.scene_idxs, num_scenes[1])
            yield Difference("changed", section, a.name, "scene_idxs", first, second)
        if not len(rows[0]):
            return
        scenes = scenes[rows[0]]
    found = FieldComparison(ComparisonContext(tables, resets, scenes, rows)).compare_node(
        a, b, "", but=("name", "scene_idxs")
    )
    # A shape both collides and is seen, and is one in the file.
    told = {(one.path, one.kind if one.kind != "changed" else (one.a, one.b)): one for one in reversed([*found])}
    for one in reversed(told.values()):
        yield _to_difference(one, section, a.name)


def _describe_object(one: _Object, plan: ScenePlan) -> str:
    match one:
        case Entity():
            word = "|".join(dict.fromkeys(map(structure_type, one.structures)))
        case Constraint():
            word = type_name(one.joint.__class__)
        case Light():
            word = type_name(one.light.__class__)
        case Camera():
            word = f"{one.width} × {one.height} px"
        case Placement():
            word = f"{one.kind} {one.target}"
    return f"{word} in {_describe_scenes(one.scene_idxs, plan.num_scenes)}"


def _describe_scenes(scene_idxs: tuple[int, ...], num_scenes: int) -> str:
    if len(scene_idxs) == num_scenes:
        return "every scene"
    if len(scene_idxs) > 1 and scene_idxs[-1] - scene_idxs[0] == len(scene_idxs) - 1:
        return f"scenes {scene_idxs[0]} to {scene_idxs[-1]}"
    shown = ", ".join(map(str, scene_idxs[:8]))
    if len(scene_idxs) > 8:
        return f"scenes {shown}, …"
    return f"scene {shown}" if len(scene_idxs) == 1 else f"scenes {shown}"


def _common_rows(a: tuple[int, ...], b: tuple[int, ...]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows of the scenes that are in both."""
    _, first, second = np.intersect1d(a, b, assume_unique=True, return_indices=True)
    return first, second
