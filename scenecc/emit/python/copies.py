"""Entities that are built alike, one after the other, as one entity over all their scenes: a loop in the script."""

from __future__ import annotations

import re
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.plan import ArticulationStructure, CollisionShape, Entity, Value, VisualShape, literal

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan import ScenePlan

FEWEST = 3
"""How many bodies make a loop that is worth reading; of articulations two do."""

_NUMBERED = re.compile(r"[-_.][0-9]+")
"""What tells the names of copies apart."""


@dataclass(frozen=True, slots=True)
class Run:
    """Several entities.

    Attributes:
        entity: all of them as one, named after them without their numbers. Its scenes are those of every
            copy, copy by copy, and so are the rows of its values.
        names: of the copies, in the order in which they are built.
    """

    entity: Entity
    names: tuple[str, ...]

    @property
    def scenes(self) -> int:
        """In how many scenes each copy is."""
        return len(self.entity.scene_idxs) // len(self.names)


def folded(plan: ScenePlan) -> tuple[ScenePlan, list[Entity | Run]]:
    """The entities of a plan in their order, those that are built alike as runs.

    The first is the plan that the material indices of the runs refer to.
    """
    folding = _Folding(plan)
    found: list[Entity | Run] = []
    for _, group in groupby(plan.entities, folding.form):
        alike = list(group)
        fewest = 2 if isinstance(alike[0].structures[0], ArticulationStructure) else FEWEST
        found += [folding.run(alike)] if len(alike) >= fewest else alike
    entities = tuple(each.entity if isinstance(each, Run) else each for each in found)
    tables = {name: tuple(rows) for name, rows in folding.tables.items()}
    return replace(plan, entities=entities, **tables), found


class _Folding:
    def __init__(self, plan: ScenePlan) -> None:
        self.tables: dict[str, list[Any]] = {
            "physical_materials": list(plan.physical_materials),
            "visual_materials": list(plan.visual_materials),
        }

    def form(self, entity: Entity) -> Hashable:
        """Everything about an entity but its name and its numbers: equal where one loop builds both."""
        if entity.pick is not None or len(entity.structures) != 1:
            return entity.name
        return entity.scene_idxs, entity.hidden, self._form(entity.structures[0])

    def run(self, alike: Sequence[Entity]) -> Run:
        """Entities of one form as one."""
        first, names = alike[0], tuple(entity.name for entity in alike)
        rows = len(first.scene_idxs)
        stems = {_NUMBERED.sub("", name) for name in names}
        stem = stems.pop() if len(stems) == 1 else first.name
        pose = _joined([entity.pose for entity in alike], rows)
        structure = self._merged([entity.structures[0] for entity in alike], rows)
        scene_idxs = first.scene_idxs * len(alike)
        return Run(Entity(stem, scene_idxs, pose, (structure,), hidden=first.hidden, origin=first.origin), names)

    def _form(self, part: Any) -> Hashable:
        if isinstance(part, Value):
            return part.data.shape[1:]
        if isinstance(part, tuple):
            return tuple(map(self._form, part))  # pyright: ignore[reportUnknownArgumentType]
        if not is_dataclass(part):
            return part
        made = self._form(self._material(part)) if isinstance(part, CollisionShape | VisualShape) else None
        return type(part), made, tuple(self._form(getattr(part, name)) for name in _names(part))

    def _material(self, shape: CollisionShape | VisualShape) -> Any:
        """The one material that a shape has in every scene; None where these are several that are made ahead."""
        if shape.material is None:
            return None
        table = self.tables[_table(shape)]
        found = [table[index] for index in np.unique(shape.material.data).tolist()]
        if len(found) == 1:
            return found[0]
        # Of several that differ from scene to scene it depends on the scene which is made: nothing is like it.
        return id(shape) if any(map(_varies, found)) else None

    def _merged(self, parts: Sequence[Any], rows: int) -> Any:
        first = parts[0]
        if isinstance(first, Value):
            return _joined(parts, rows)
        if isinstance(first, tuple):
            return tuple(self._merged(items, rows) for items in zip(*parts, strict=True))
        if not is_dataclass(first):
            return first
        merged = {name: self._merged([getattr(part, name) for part in parts], rows) for name in _names(first)}
        if isinstance(first, CollisionShape | VisualShape):
            materials = [self._material(shape) for shape in parts]
            if any(material is not None and _varies(material) for material in materials):
                # Made in the loop, as where it differs in one entity.
                table = self.tables[_table(first)]
                table.append(self._merged(materials, rows))
                merged["material"] = literal(len(table) - 1, "int64")
        return replace(first, **merged)  # pyright: ignore[reportArgumentType, reportUnknownVariableType]


def _table(shape: CollisionShape | VisualShape) -> str:
    return "physical_materials" if isinstance(shape, CollisionShape) else "visual_materials"


def _varies(material: Any) -> bool:
    return any(value.varies for value in material.values())


def _names(part: Any) -> list[str]:
    return [field.name for field in fields(part) if field.compare]


def _joined(values: Sequence[Value], rows: int) -> Value:
    """Values of several entities of so many scenes as one, which is the same everywhere if all agree."""
    first = values[0]
    data: NDArray[Any] = first.data
    if len(data) == 1 and all(value is first or value.data.tobytes() == data.tobytes() for value in values):
        return first
    parts: list[Any] = [np.broadcast_to(value.data, (rows, *data.shape[1:])) for value in values]
    return Value(np.concatenate(parts))
