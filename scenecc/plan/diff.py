"""Compares two plans by path, with the keys of the language.

Each object becomes a tree of plain data whose keys are paths. The trees are compared key by key. References to tables
(files, materials) are replaced by the entries. Recipes are equal if their text is equal.
"""

from __future__ import annotations

import json
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np

from scenecc.diagnostics.messages import index_ranges
from scenecc.plan.articulation import ArticulationStructure, Joint, Link, friction_force
from scenecc.plan.body import BodyStructure
from scenecc.plan.constraint import Constraint
from scenecc.plan.display import (
    ITEM_KEYS,
    field_path,
    format_reset_pair,
    format_row_pair,
    item_path,
    to_tuples,
    truncate,
)
from scenecc.plan.expect import Condition, Expectation, describe_expectation
from scenecc.plan.placement import Placement
from scenecc.plan.properties import Quantity
from scenecc.plan.rendering import Camera, Environment, Light
from scenecc.plan.scene import Entity, ScenePlan, structure_type
from scenecc.plan.schema import ListKind, ObjectKind, ScalarKind, UnionKind, plan_fields, type_name
from scenecc.plan.walk import walk_fields
from scenecc.variation.nodes import NODES, Node, Posed, draws_read_by

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan.body import AssetFile
    from scenecc.plan.geometry import Heights
    from scenecc.plan.value import Value

Side = Literal[0, 1]

_HASH_DIGITS = 12
"""Digits of a hash that are displayed."""

_STRUCTURES: Final = (BodyStructure, ArticulationStructure)

_TABLES: Final = ("files", "physical_materials", "visual_materials")


class _Pair:
    """Two plans to compare.

    Attributes:
        plans: both plans.
        same_tables: whether their tables are equal, entry by entry.
        file_names: names of the files of each plan. Files with the same content, and the same URI or path, share a
            name.
        changed_draws: shared draws whose recipe differs, directly or through another draw.
    """

    def __init__(self, a: ScenePlan, b: ScenePlan) -> None:
        self.plans = (a, b)
        self.same_tables = all(getattr(a, name) == getattr(b, name) for name in _TABLES)
        self.file_names = _file_names(a.files, b.files)
        self.changed_draws = {name for name, _ in {*_draw_texts(a)} ^ {*_draw_texts(b)}}
        for plan in self.plans:
            for name, node in plan.draws:
                if not self.changed_draws.isdisjoint(draws_read_by(node)):
                    self.changed_draws.add(name)

    def same_recipe(self, x: Node | None, y: Node | None) -> bool:
        """Whether two recipes, and the shared draws that they read, have the same text."""
        if x is None or y is None:
            return x is y
        return repr(x) == repr(y) and self.changed_draws.isdisjoint(draws_read_by(x))


def _draw_texts(plan: ScenePlan) -> Iterator[tuple[str, str]]:
    return ((name, repr(node)) for name, node in plan.draws)


def _file_names(*tables: Sequence[AssetFile]) -> tuple[list[str], ...]:
    known: dict[object, AssetFile] = {}
    for file in (file for table in tables for file in table):
        content = (file.sha256, file.data, tuple(one.sha256 for one in file.names))
        first = known.get((file.uri, content), known.get((file.path, content), file))
        known.setdefault((file.uri, content), first)
        known.setdefault((file.path, content), first)
        known[id(file)] = first
    distinct = {id(known[id(file)]): known[id(file)].uri for table in tables for file in table}
    count = Counter(distinct.values())
    firsts = ([known[id(file)] for file in table] for table in tables)
    return tuple([one.uri if count[one.uri] == 1 else _uri_with_hashes(one) for one in table] for table in firsts)


def _uri_with_hashes(file: AssetFile) -> str:
    """A file's URI with short hashes of it and of the files that it references."""
    hashes = [
        (file.sha256 or "unknown")[:_HASH_DIGITS],
        *(f"{one.uri} {one.sha256[:_HASH_DIGITS]}" for one in file.names),
    ]
    return f"{file.uri} (SHA-256 {', '.join(hashes)})"


def find_moved(places: Sequence[int]) -> set[int]:
    """The smallest set of items that must move so that the rest ascends."""
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


class _Typed(NamedTuple):
    """An object of one of several dataclasses. `word`: its name in the language."""

    cls: type
    word: str
    tree: dict[str, Any]


class _Leaf(NamedTuple):
    """A value of the plan."""

    kind: Quantity
    value: Value


class _Grid(NamedTuple):
    """Heights of a terrain."""

    rows: Heights


class _Item(NamedTuple):
    """An item of a list.

    Attributes:
        key: its name, or its index in a list without names.
        path: its path in the object. Paths of the tree start there.
    """

    key: str | int
    path: str
    tree: dict[str, Any]


class _Column(NamedTuple):
    """A value in the compared scenes, one row or one per scene, and its recipes in the same layout."""

    rows: list[Any]
    recipes: list[Node | None]


_ABSENT: Final = _Column([None], [None])


@dataclass(frozen=True, slots=True)
class FieldDifference:
    """One field in which two objects differ, as in `Difference`."""

    kind: Literal["added", "removed", "moved", "changed"]
    path: str
    a: str | None
    b: str | None
    scene_count: int | None = None


class _Comparison:
    """Compares two objects.

    Args:
        pair: their plans.
        scenes: indices of the scenes that contain both.
        rows: rows of these scenes in each object; None: all rows.
    """

    def __init__(
        self, pair: _Pair, scenes: NDArray[np.int64], rows: tuple[NDArray[np.intp], NDArray[np.intp]] | None = None
    ) -> None:
        self._pair = pair
        self._scenes = scenes
        self._rows = rows

    def compare(self, x: Any, y: Any, but: tuple[str, ...] = ()) -> Iterator[FieldDifference]:
        """Yields the differences of two dataclasses of one type. `but`: fields to skip."""
        several = any(isinstance(one, Entity) and len(one.structures) > 1 for one in (x, y))
        first, second = (_object_tree(one, "", several=several, but=but) for one in (x, y))
        yield from self._trees(first, second, "")

    def _trees(self, x: dict[str, Any], y: dict[str, Any], base: str) -> Iterator[FieldDifference]:
        for path in dict.fromkeys((*x, *y)):
            yield from self._compare(_join(base, path), x.get(path), y.get(path), base)

    def _compare(self, path: str, x: Any, y: Any, base: str) -> Iterator[FieldDifference]:
        one: Any = y if x is None else x
        match one:
            case list():
                yield from self._lists(x or [], y or [])
            case _Typed() if x is not None and y is not None and x.cls is y.cls:
                yield from self._trees(x.tree, y.tree, base)
            case _Typed():
                yield FieldDifference("changed", path, x and x.word, y and y.word)
            case _Leaf():
                yield from self._values(path, x, y)
            case _Grid() if x is not None and y is not None:
                if x != y:
                    yield FieldDifference("changed", path, *_height_words(x, y))
            case _:
                if x != y:
                    yield FieldDifference("changed", path, _scalar_words(x), _scalar_words(y))

    def _lists(self, x: list[_Item], y: list[_Item]) -> Iterator[FieldDifference]:
        """Compares two lists by name, or by index. If lengths differ, the equal head and tail are skipped."""
        named = any(isinstance(item.key, str) for item in (*x, *y))
        if not named and len(x) != len(y):
            head = self._count_equal_items(x, y)
            tail = self._count_equal_items(x[head:][::-1], y[head:][::-1])
            x, y = x[head : len(x) - tail], y[head : len(y) - tail]
        first, second = ({item.key if named else n: item for n, item in enumerate(items)} for items in (x, y))
        places = {key: place for place, key in enumerate(second)}
        moved = find_moved([places[key] for key in first if key in second])
        for place, (key, item) in enumerate(first.items()):
            other = second.get(key)
            if other is None:
                yield FieldDifference("removed", item.path, self._summary(item, 0), None)
                continue
            if places[key] in moved:
                yield FieldDifference("moved", item.path, f"number {place + 1}", f"number {places[key] + 1}")
            yield from self._trees(item.tree, other.tree, item.path)
        for key, item in second.items():
            if key not in first:
                yield FieldDifference("added", item.path, None, self._summary(item, 1))

    def _count_equal_items(self, x: list[_Item], y: list[_Item]) -> int:
        """Number of equal items at the start."""
        pairs = enumerate(zip(x, y, strict=False))
        unequal = (n for n, (a, b) in pairs if any(self._trees(a.tree, b.tree, a.path)))
        return next(unequal, min(len(x), len(y)))

    def _values(self, path: str, x: _Leaf | None, y: _Leaf | None) -> Iterator[FieldDifference]:
        recipes = [one.value.recipe for one in (x, y) if one is not None]
        split = all(recipe is None or isinstance(recipe, Posed) for recipe in recipes)
        first = {} if x is None else self._columns(path, x, 0, split=split)
        second = {} if y is None else self._columns(path, y, 1, split=split)
        for name in dict.fromkeys((*first, *second)):
            a, b = first.get(name, _ABSENT), second.get(name, _ABSENT)
            rows = _find_differences(list(map(repr, a.rows)), list(map(repr, b.rows)), len(self._scenes))
            if rows:
                taken = [[one.rows[n] if len(one.rows) > 1 else one.rows[0] for n in rows] for one in (a, b)]
                words = format_row_pair(name, taken[0], taken[1], self._scenes[rows].tolist())
                yield FieldDifference("changed", name, *words, len(rows))
                continue
            drawn = _find_differences(a.recipes, b.recipes, len(self._scenes), self._pair.same_recipe)
            if drawn:
                n = drawn[0]
                drawn_by = [one.recipes[n] if len(one.recipes) > 1 else one.recipes[0] for one in (a, b)]
                words = format_reset_pair((drawn_by[0], drawn_by[1]), self._pair.plans)
                yield FieldDifference("changed", name, *words, len(drawn))

    def _columns(self, path: str, leaf: _Leaf, side: Side, *, split: bool = False) -> dict[str, _Column]:
        """The columns of a value by path: two for a pose, one per field for a material.

        `split`: give each part of a pose its part of the recipe instead of a column for the whole recipe.
        """
        kind, value = leaf
        data = value.data
        if self._rows is not None and len(data) != 1:
            data = data[self._rows[side]]
        rows = [to_tuples(row) for row in data.tolist()]
        if kind.table == "files":
            return {path: _Column([self._pair.file_names[side][index] for index in rows], [None])}
        if kind.table is not None:
            return self._material_columns(path, getattr(self._pair.plans[side], kind.table), rows, side)
        if kind.pose:
            p, q = (value.recipe.p, value.recipe.q) if split and isinstance(value.recipe, Posed) else (None, None)
            whole = {} if split else {path: _Column([None], [value.recipe])}
            return {
                f"{path}.p": _Column([row[:3] for row in rows], [p if isinstance(p, NODES) else None]),
                f"{path}.q": _Column([row[3:] for row in rows], [q if isinstance(q, NODES) else None]),
                **whole,
            }
        return {path: _Column(rows, [value.recipe])}

    def _material_columns(self, path: str, table: Sequence[Any], indices: list[int], side: Side) -> dict[str, _Column]:
        count = len(self._scenes)
        found: dict[int, dict[str, _Column]] = {}
        for index in dict.fromkeys(indices):
            found[index] = {}
            for name, kind, item in walk_fields(table[index], path):
                found[index] |= (
                    self._columns(name.removesuffix(".file"), _Leaf(kind, item), side)
                    if isinstance(kind, Quantity)
                    else {name: _Column([item], [None])}
                )
        if len(found) == 1:
            return found[indices[0]]
        columns: dict[str, _Column] = {}
        for name in dict.fromkeys(name for one in found.values() for name in one):
            each = [found[index].get(name, _ABSENT) for index in indices]
            rows = [
                one.rows[n] if len(one.rows) > 1 else one.rows[0] for n, one in zip(range(count), each, strict=True)
            ]
            columns[name] = _Column(rows, [one.recipes[0] for one in each])
        return columns

    def _summary(self, item: _Item, side: Side) -> str:
        """Short text for an item."""
        return truncate(", ".join(f"{path} {text}".strip() for path, text in self._words(item.tree, side)))

    def _words(self, tree: dict[str, Any], side: Side) -> Iterator[tuple[str, str | None]]:
        for path, one in tree.items():
            match one:
                case _Typed():
                    yield path, one.word
                    yield from self._words(one.tree, side)
                case _Grid():
                    yield path, f"{len(one.rows)} rows"
                case _Leaf():
                    for name, column in self._columns(path, one, side).items():
                        yield name, format_row_pair(name, column.rows, [None], [])[0]
                case list():
                    yield path, str(len(one))  # pyright: ignore[reportUnknownArgumentType]
                case _ if one not in ("", ()) and path != "body_type":
                    yield path, _scalar_words(one)
                case _:
                    pass


def _find_differences(a: list[Any], b: list[Any], count: int, same: Any = None) -> list[int]:
    """Positions of the scenes in which two columns differ."""
    if len(a) == len(b) == 1:
        return [] if (a[0] == b[0] if same is None else same(a[0], b[0])) else list(range(count))
    pairs = ((a[n if len(a) > 1 else 0], b[n if len(b) > 1 else 0]) for n in range(count))
    return [n for n, (x, y) in enumerate(pairs) if not (x == y if same is None else same(x, y))]


def _object_tree(
    node: Any, base: str, path: str = "", *, several: bool = False, but: tuple[str, ...] = ()
) -> dict[str, Any]:
    """The set fields of an object and of its inner objects, by path below `base`."""
    tree: dict[str, Any] = {}
    for slot in plan_fields(node.__class__):
        item, where, kind = getattr(node, slot.name), field_path(path, slot.name, node.__class__), slot.kind
        if item is None or slot.name in but:
            continue
        if isinstance(kind, ListKind) and isinstance(kind.item, ListKind):
            tree[where] = _Grid(item)
        elif slot.name == "structures" and not several:
            tree |= _make_typed_tree(item[0], base, where)
        elif isinstance(kind, ListKind) and isinstance(kind.item, ObjectKind | UnionKind):
            tree[where or "variants"] = _items(item, _join(base, where))
        elif isinstance(kind, UnionKind):
            tree |= _make_typed_tree(item, base, where)
        elif isinstance(kind, ObjectKind):
            inner = _object_tree(item, base, where)
            if isinstance(item, Joint) and friction_force(item) is not None:
                # A drive that brakes, with the key of the language.
                inner[f"{where}.friction_force"] = inner.pop(f"{where}.force_limit")
                del inner[f"{where}.damping"]
            tree |= inner
        else:
            tree[where] = _Leaf(kind, item) if isinstance(kind, Quantity) else item
    return tree


def _make_typed_tree(item: Any, base: str, path: str) -> dict[str, Any]:
    word = structure_type(item) if isinstance(item, _STRUCTURES) else type_name(item.__class__)
    return {_join(path, "type"): _Typed(item.__class__, word, _object_tree(item, base, path))}


def _items(items: tuple[Any, ...], path: str) -> list[_Item]:
    found: list[_Item] = []
    for index, item in enumerate(items):
        place = item_path(path, index, item, count=2)
        tree = _make_typed_tree(item, place, "") if isinstance(item, _STRUCTURES) else _object_tree(item, place)
        if isinstance(item, Link) and item.parent is not None:
            tree["parent"] = items[item.parent].name
        key = ITEM_KEYS.get(item.__class__)
        found.append(_Item(index if key is None else getattr(item, key), place, tree))
    return found


def _join(above: str, path: str) -> str:
    return f"{above}.{path}" if above and path else above or path


def _scalar_words(item: Any) -> str | None:
    return None if item is None else truncate(json.dumps(item))


def _height_words(*grids: _Grid) -> tuple[str, str]:
    """Short texts for one or two terrains."""
    x, y = (np.array(grid.rows, np.float64) for grid in grids)
    a, b = (f"{rows.shape[0]} × {rows.shape[1]} numbers" for rows in (x, y))
    if x.shape == y.shape:
        b = f"{int((x != y).sum())} of {x.size} numbers differ, by at most {np.abs(x - y).max():.3g}"
    return a, b


Section = Literal[
    "plan", "physics", "entities", "constraints", "environment", "lights", "cameras", "placements", "expect"
]

_Object = Entity | Constraint | Light | Camera | Placement


@dataclass(frozen=True, slots=True)
class Difference:
    """One difference between two plans.

    Attributes:
        kind: "added" or "removed" for objects, links or shapes that only the second or only the first plan has;
            "moved" for objects and links with another build order; otherwise "changed".
        section: section of the object; "plan" for the whole plan.
        name: of the object; "" in "plan", "physics" and "environment".
        path: path of the field in the object, as in the scene file if the shape's origin is known, such as
            `shapes[1].radius`; links by name: `links.hand.joint.limits`; "" for the object.
        a, b: short texts for the value in each plan, in the scenes that differ; None if there is no value. A text with
            "at reset" is equal as built.
        scene_count: number of scenes in which the field differs, among those that contain both objects; None if it is
            not compared by scene.
    """

    kind: Literal["added", "removed", "moved", "changed"]
    section: Section
    name: str
    path: str
    a: str | None
    b: str | None
    scene_count: int | None = None


def diff_plans(a: ScenePlan, b: ScenePlan) -> list[Difference]:
    """Lists all differences in what two plans build and reset, and in `name`, `description` and `seed`.

    Values are compared bit by bit in the scenes that contain both objects. Recipes are equal if they and the shared
    draws that they read have the same text. The order of the file and material tables and unused entries are ignored.
    Files differ if their content differs, or if both URI and path differ.
    """
    found: list[Difference] = []
    for slot in plan_fields(ScenePlan):
        x, y = getattr(a, slot.name), getattr(b, slot.name)
        if isinstance(slot.kind, ScalarKind) and x != y:
            found.append(Difference("changed", "plan", "", slot.name, str(x), str(y)))
    pair = _Pair(a, b)
    physics = _Comparison(pair, np.zeros(1, np.int64)).compare(a.physics, b.physics)
    found += [_to_difference(one, "physics", "") for one in physics]
    found += _compare_sections("entities", pair)
    found += _compare_sections("constraints", pair)
    found += _compare_environments(pair)
    for section in ("lights", "cameras", "placements"):
        found += _compare_sections(section, pair)
    found += _compare_expectations(a, b)
    if a.starts != b.starts:
        x, y = (f"{len(plan.starts)} ({sha256(repr(plan.starts).encode()).hexdigest()[:12]})" for plan in (a, b))
        found.append(Difference("changed", "plan", "", "starts", x, y))
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


def _compare_environments(pair: _Pair) -> Iterator[Difference]:
    first, second = (plan.environment or Environment() for plan in pair.plans)
    counts = [plan.num_scenes for plan in pair.plans]
    common = np.arange(min(counts))
    # An environment has one row per scene of the batch.
    rows = None if counts[0] == counts[1] else (common, common)
    for one in _Comparison(pair, common, rows).compare(first, second):
        yield _to_difference(one, "environment", "")


def _compare_sections(section: Section, pair: _Pair) -> Iterator[Difference]:
    first, second = (
        {one.name: (place, one) for place, one in enumerate(getattr(plan, section))} for plan in pair.plans
    )
    moved = find_moved([second[name][0] for name in first if name in second])
    for name, (place, one) in first.items():
        if name not in second:
            yield Difference("removed", section, name, "", _describe_object(one, pair.plans[0]), None)
            continue
        other_place, other = second[name]
        if other_place in moved:
            yield Difference("moved", section, name, "", f"number {place + 1}", f"number {other_place + 1}")
        if not (pair.same_tables and not pair.changed_draws and one == other):
            yield from _compare_objects(section, one, other, pair)
    for name, (_, one) in second.items():
        if name not in first:
            yield Difference("added", section, name, "", None, _describe_object(one, pair.plans[1]))


def _compare_objects(section: Section, a: _Object, b: _Object, pair: _Pair) -> Iterator[Difference]:
    rows = None
    counts = [plan.num_scenes for plan in pair.plans]
    scenes = np.array(a.scene_idxs, np.int64)
    if a.scene_idxs != b.scene_idxs:
        rows = _match_rows(a.scene_idxs, b.scene_idxs)
        if [len(a.scene_idxs), len(b.scene_idxs)] != counts:
            first, second = _describe_scenes(a.scene_idxs, counts[0]), _describe_scenes(b.scene_idxs, counts[1])
            yield Difference("changed", section, a.name, "scene_idxs", first, second)
        if not len(rows[0]):
            return
        scenes = scenes[rows[0]]
    found = _Comparison(pair, scenes, rows).compare(a, b, but=("name", "scene_idxs"))
    # A shape that both collides and is visible is one shape in the file.
    distinct = {(one.path, one.kind if one.kind != "changed" else (one.a, one.b)): one for one in reversed([*found])}
    for one in reversed(distinct.values()):
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


def _match_rows(a: tuple[int, ...], b: tuple[int, ...]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows of the scenes that both objects are in."""
    _, first, second = np.intersect1d(a, b, assume_unique=True, return_indices=True)
    return first, second
