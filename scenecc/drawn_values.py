"""The values of scenes that are drawn or differ between scenes, by name. No engine is needed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.plan.articulation import VELOCITY_FIELDS, ArticulationStructure
from scenecc.plan.display import SPEC_FIELD_NAMES, item_path
from scenecc.plan.properties import Quantity
from scenecc.plan.scene import is_unnamed_draw
from scenecc.plan.schema import plan_fields
from scenecc.plan.starts import StartTable
from scenecc.plan.walk import walk_fields
from scenecc.variation.evaluation import Batch, row_array, rows_with_value, to_field_rows

if TYPE_CHECKING:
    from collections.abc import Container

    from numpy.typing import NDArray

    from scenecc.plan import Entity, ScenePlan, Value
    from scenecc.plan.body import AssetFile

_PLAN_NAMES = {word: name for name, word in SPEC_FIELD_NAMES.items()}
"""Fields that have the plan's name here, as in `SceneBatch.state`: `disable_gravity` is the opposite of `gravity`."""


@dataclass(frozen=True, slots=True, eq=False)
class SceneDraws:
    """What a build with one seed draws.

    Attributes:
        seed: the seed.
        scene_idxs: scenes of the rows.
        values: name → (B, …), a row for each of these scenes.
    """

    seed: int
    scene_idxs: tuple[int, ...]
    values: Mapping[str, NDArray[Any]]


class DrawnRow(Mapping[str, Any]):
    """The drawn values of one scene, by name. They are read on first access.

    Args:
        read: returns the values of this scene, with one row each.
    """

    def __init__(self, read: Callable[[], Mapping[str, NDArray[Any]]]) -> None:
        self._read = read

    @cached_property
    def _values(self) -> dict[str, Any]:
        return {name: rows[0] for name, rows in self._read().items()}

    def __getitem__(self, name: str) -> Any:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return repr(self._values)

    def __reduce__(self) -> tuple[type[dict[str, Any]], tuple[dict[str, Any]]]:
        return dict, (self._values,)  # a copy or a pickle is a dict


class _Group(NamedTuple):
    """Scenes that were last reset together, each with its row in the result. `drawing`: None if they are as built.
    `begun`: name → scene → value of what their starts set.
    """

    drawing: Batch | None
    numbers: dict[int, int]
    begun: dict[str, dict[int, Any]]


class _Part(NamedTuple):
    """A value of the plan that a name has in some scenes. `rows`: scene → row of the value."""

    value: Value
    rows: Mapping[int, int]
    files: tuple[AssetFile, ...] | None

    def read(self, scenes: Sequence[int], drawing: Batch | None) -> NDArray[Any]:
        """Returns the values in scenes that it has: as a reset drew them, or as built if `drawing` is None."""
        recipe, data = self.value.recipe, self.value.data
        if drawing is None or recipe is None:
            taken = data[[self.rows[scene] if len(data) > 1 else 0 for scene in scenes]]
        else:
            part = drawing.only(np.searchsorted(drawing.scenes, scenes))
            taken = np.asarray(to_field_rows(part.evaluate(recipe)), data.dtype)
        if self.files is None:
            return taken
        return np.array([self.files[int(index)].uri for index in taken.tolist()], object)


class DrawnValues:
    """Reads the drawn values of a plan.

    Args:
        plan: the plan.
        kept: names of fields that a reset keeps, although they have a recipe.
    """

    def __init__(self, plan: ScenePlan, kept: Container[str] = ()) -> None:
        self._plan = plan
        self._kept = kept

    def read(
        self, scene_idxs: Sequence[int], drawings: Sequence[Batch | None] | None = None
    ) -> dict[str, NDArray[Any]]:
        """Returns name → (B, …), a row for each of some scenes.

        The names are those of the shared draws (`INSTANCE/NAME` in an instance) and of the fields that are drawn or
        differ between scenes: `cube.mass`, `cube.shapes[0].half_size`, `arm/elbow.stiffness`, `lights/lamp.color`. A
        pose is 7 numbers, p [m] then q (wxyz). `cube.pick` is the index of the scene's variant. A file is its path
        as written. In a scene without the value, numbers are NaN and texts None; integers and flags are then floats.

        Args:
            scene_idxs: the scenes.
            drawings: for each scene, the batch that its last reset drew from; None: it is as built.
        """
        groups: dict[int, _Group] = {}
        for number, drawing in enumerate(drawings or [None] * len(scene_idxs)):
            groups.setdefault(id(drawing), _Group(drawing, {}, {})).numbers[scene_idxs[number]] = number
        if self._plan.starts:
            for group in groups.values():
                self._begin(group)
        count, found = len(scene_idxs), dict[str, "NDArray[Any]"]()
        for name, _ in self._plan.draws:
            if not is_unnamed_draw(name):
                found[name] = self._read_draw(name, groups.values(), count)
        for name in self._fields:
            found[name] = self._read_field(name, groups.values(), count)
        return found

    def _read_draw(self, name: str, groups: Iterable[_Group], count: int) -> NDArray[Any]:
        pieces: list[tuple[list[int], NDArray[Any]]] = []
        for group in groups:
            batch = self._as_built if group.drawing is None else group.drawing
            rows = np.searchsorted(batch.scenes, sorted(group.numbers))
            found = dict(rows_with_value(name, batch.only(rows)))
            if found:
                pieces.append(([group.numbers[scene] for scene in found], row_array([*found.values()])))
        return _merge(pieces, count)

    def _read_field(self, name: str, groups: Iterable[_Group], count: int) -> NDArray[Any]:
        pieces: list[tuple[list[int], NDArray[Any]]] = []
        for part in self._fields[name]:
            for group in groups:
                if scenes := sorted(group.numbers.keys() & part.rows.keys()):
                    if name in group.begun:
                        rows = np.array([group.begun[name][scene] for scene in scenes], part.value.data.dtype)
                    else:
                        rows = part.read(scenes, None if name in self._kept else group.drawing)
                    pieces.append(([group.numbers[scene] for scene in scenes], rows))
        if not pieces:  # none of these scenes has the value, but it keeps its shape
            part = self._fields[name][0]
            return _merge([([], part.read([*part.rows][:1], None)[:0])], count)
        return _merge(pieces, count)

    def _begin(self, group: _Group) -> None:
        """Notes what the starts of scenes that were reset set: poses, joint positions, and velocities of 0."""
        if group.drawing is None:
            return
        drawing = group.drawing.only(np.searchsorted(group.drawing.scenes, sorted(group.numbers)))
        seeds = [drawing.seed] * len(group.numbers) if isinstance(drawing.seed, int) else drawing.seed
        for scene, seed in zip(drawing.scenes.tolist(), seeds, strict=True):
            for part, pose, qpos in self._starts.states(scene, seed):
                who = part.entity.name
                values = {f"{who}.pose": pose, **{f"{who}.{field}": np.zeros(3) for field in VELOCITY_FIELDS}}
                values |= {f"{who}/{one.name}.qpos": float(at) for one, at in zip(part.joints, qpos, strict=True)}
                for name, value in values.items():
                    group.begun.setdefault(name, {})[scene] = value

    @cached_property
    def _starts(self) -> StartTable:
        return StartTable(self._plan)

    @cached_property
    def _as_built(self) -> Batch:
        """The batch that a build draws from. A scene that begins at a start has the seed of this start."""
        plan = self._plan
        seeds = dict.fromkeys(range(plan.num_scenes), plan.seed)
        if plan.starts:
            begun = sorted({*seeds} - {*self._starts.lacks([*seeds])})
            seeds |= zip(begun, self._starts.seeds(begun, [plan.seed] * len(begun)), strict=True)
        one = tuple(seeds.values()) if len({*seeds.values()}) > 1 else seeds[0]
        return Batch(np.arange(plan.num_scenes), one, plan.num_scenes, dict(plan.draws), {})

    @cached_property
    def _fields(self) -> dict[str, list[_Part]]:
        parts: dict[str, list[_Part]] = {}
        wanted: set[str] = set()
        for name, part, is_choice in self._parts():
            known = parts.setdefault(name, [])
            # A shape that collides and is visible has the same values twice.
            if all(part.rows.keys().isdisjoint(one.rows) for one in known):
                known.append(part)
            if is_choice or not part.value.is_constant:
                wanted.add(name)
        return {name: found for name, found in parts.items() if name in wanted}

    def _parts(self) -> Iterator[tuple[str, _Part, bool]]:
        """Yields names and values, and whether a value is one of several that a scene has."""
        plan, taken = self._plan, set[str]()
        materials: list[tuple[str, str, Value, Mapping[int, int]]] = []
        for entity in plan.entities:
            for name, kind, value, rows in _entity_fields(entity):
                taken.add(name)
                if kind.table in {None, "files"}:
                    yield name, self._part(kind, value, rows), False
                else:
                    materials.append((name, str(kind.table), value, rows))
        for name, table, material, rows in materials:
            for index, some in _rows_by_item(material, rows).items():
                for path, kind, value in _quantities(walk_fields(getattr(plan, table)[index])):
                    yield f"{name}.{path}", self._part(kind, value, some), not material.is_constant
        sections = (("constraints", plan.constraints), ("lights", plan.lights), ("cameras", plan.cameras))
        for section, node in ((section, node) for section, nodes in sections for node in nodes):
            rows = {scene: row for row, scene in enumerate(node.scene_idxs)}
            for path, kind, value in _quantities(walk_fields(node)):
                name = f"{node.name}.{_component_path(path, node)}"
                # An instance may be called `lights`, and have an entity with the name of a light.
                divider = ":" if f"{section}/{name}" in taken else "/"
                yield f"{section}{divider}{name}", self._part(kind, value, rows), False
        if plan.environment is not None:
            rows = {scene: scene for scene in range(plan.num_scenes)}
            for path, kind, value in _quantities(walk_fields(plan.environment)):
                yield f"environment.{path}", self._part(kind, value, rows), False

    def _part(self, kind: Quantity, value: Value, rows: Mapping[int, int]) -> _Part:
        return _Part(value, rows, self._plan.files if kind.table == "files" else None)


def plain_values(rows: NDArray[Any]) -> list[Any]:
    """Returns rows of drawn values as plain data for JSON: a missing number is None, infinite ones "inf" and "-inf"."""
    return [_plain(item) for item in rows.tolist()]


def _plain(item: Any) -> Any:
    if isinstance(item, list):
        several = [_plain(one) for one in item]  # pyright: ignore[reportUnknownVariableType]
        return None if several and all(one is None for one in several) else several
    if isinstance(item, float) and not math.isfinite(item):
        return None if math.isnan(item) else str(item)
    return item


def _merge(pieces: Sequence[tuple[Sequence[int], NDArray[Any]]], count: int) -> NDArray[Any]:
    """Returns an array of `count` rows from pieces, each with the indices of its rows. Other rows are NaN, or None."""
    if not pieces:
        return np.full(count, np.nan)
    is_whole = sum(len(numbers) for numbers, _ in pieces) == count
    shapes, dtypes = {rows.shape[1:] for _, rows in pieces}, {rows.dtype for _, rows in pieces}
    dtype = dtypes.pop() if len(dtypes) == 1 else np.dtype(object)
    if len(shapes) > 1 or dtype.kind == "O":
        whole = np.full(count, None, object)
        for numbers, rows in pieces:
            for number, row in zip(numbers, rows.tolist(), strict=True):
                whole[number] = row
        return whole
    whole = np.full((count, *shapes.pop()), 0 if is_whole else np.nan, dtype if is_whole else np.float64)
    for numbers, rows in pieces:
        whole[numbers] = rows
    return whole


def _quantities(fields: Iterable[tuple[str, Any, Any]]) -> Iterator[tuple[str, Quantity, Value]]:
    for path, kind, value in fields:
        if isinstance(kind, Quantity):
            above, dot, last = path.rpartition(".")
            yield f"{above}{dot}{_PLAN_NAMES.get(last, last)}", kind, value


def _entity_fields(entity: Entity) -> Iterator[tuple[str, Quantity, Value, Mapping[int, int]]]:
    """Yields name, kind, value and rows of each field, with the names of `SceneBatch.state`."""
    every = {scene: row for row, scene in enumerate(entity.scene_idxs)}
    kinds = {slot.name: slot.kind for slot in plan_fields(entity.__class__)}
    own = {"pose": entity.pose} if entity.pick is None else {"pose": entity.pose, "pick": entity.pick}
    for name, value in own.items():
        kind = kinds[name]
        assert isinstance(kind, Quantity)
        yield f"{entity.name}.{name}", kind, value, every
    for number, structure in enumerate(entity.structures):
        rows = every
        if entity.pick is not None:
            rows = {scene: row for scene, row in every.items() if entity.pick.row(row) == number}
        parts = [(entity.name, walk_fields(structure))]
        if isinstance(structure, ArticulationStructure):
            parts = _articulation_parts(entity.name, structure)
        for who, fields in parts:
            for path, kind, value in _quantities(fields):
                yield f"{who}.{path}", kind, value, rows


def _articulation_parts(who: str, structure: ArticulationStructure) -> list[tuple[str, Iterable[tuple[str, Any, Any]]]]:
    """Returns the fields of links and joints by `ENTITY/LINK` and `ENTITY/JOINT`, and the others by the entity."""
    own = (field for field in walk_fields(structure) if not field[0].startswith("links."))
    found: list[tuple[str, Iterable[tuple[str, Any, Any]]]] = [(who, own)]
    for number, link in enumerate(structure.links):
        place = item_path("links", number, link, count=len(structure.links))
        found.append((f"{who}/{link.name}", _below(place, walk_fields(link.body, place))))
        if link.file is not None:
            found.append((f"{who}/{link.name}", [next(one for one in walk_fields(link) if one[0] == "file")]))
        if link.joint is not None:
            found.append((f"{who}/{link.joint.name or link.name}", walk_fields(link.joint)))
    return found


def _below(place: str, fields: Iterable[tuple[str, Any, Any]]) -> Iterator[tuple[str, Any, Any]]:
    return ((path.removeprefix(f"{place}."), kind, value) for path, kind, value in fields)


def _component_path(path: str, node: Any) -> str:
    """Returns the path of a field of a constraint, light or camera with the names of `SceneBatch.state`."""
    lens = getattr(node, "lens", None)
    if lens is not None and path in {slot.name for slot in plan_fields(lens.__class__)}:
        return f"lens.{path}"
    return f"drive.{path.removeprefix('drives.')}" if path.startswith("drives.") else path


def _rows_by_item(value: Value, rows: Mapping[int, int]) -> dict[int, dict[int, int]]:
    """Returns the rows of each item of a table that a value selects."""
    if len(value.data) == 1:
        return {int(value.row(0)): dict(rows)}
    found: dict[int, dict[int, int]] = {}
    for scene, row in rows.items():
        found.setdefault(int(value.row(row)), {})[scene] = row
    return found
