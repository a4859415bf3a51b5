"""Writes entities: one block each, or one loop over entities that differ only in name and numbers."""

from __future__ import annotations

import re
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.emit.python.articulations import ArticulationScript, write_articulation
from scenecc.emit.python.bodies import BodyScript, write_body
from scenecc.emit.python.context import (
    SceneValues,
    ScriptContext,
    append_in_scenes,
    scene_loop_header,
    scene_selection,
    structure_variants,
)
from scenecc.emit.python.source import SourceNode, SourceWriter, list_of, string
from scenecc.plan import ArticulationStructure, CollisionShape, Entity, Value, VisualShape, literal

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan import BodyStructure, ScenePlan

MIN_LOOP_BODIES = 3
"""From this number of bodies on, a loop is shorter to read; for articulations, from two."""

_NUMBER_SUFFIX = re.compile(r"[-_.][0-9]+")
"""Suffix by which names of copies differ."""


@dataclass(frozen=True, slots=True)
class RepeatedEntity:
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


def fold_repeats(plan: ScenePlan) -> tuple[ScenePlan, list[Entity | RepeatedEntity]]:
    """The entities of a plan in their order, those that are built alike as runs.

    The first is the plan that the material indices of the runs refer to.
    """
    folding = _Folding(plan)
    found: list[Entity | RepeatedEntity] = []
    for _, group in groupby(plan.entities, folding.form):
        alike = list(group)
        fewest = 2 if isinstance(alike[0].structures[0], ArticulationStructure) else MIN_LOOP_BODIES
        found += [folding.run(alike)] if len(alike) >= fewest else alike
    entities = tuple(each.entity if isinstance(each, RepeatedEntity) else each for each in found)
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

    def run(self, alike: Sequence[Entity]) -> RepeatedEntity:
        """Entities of one form as one."""
        first, names = alike[0], tuple(entity.name for entity in alike)
        rows = len(first.scene_idxs)
        stems = {_NUMBER_SUFFIX.sub("", name) for name in names}
        stem = stems.pop() if len(stems) == 1 else first.name
        pose = _concatenate([entity.pose for entity in alike], rows)
        structure = self._merged([entity.structures[0] for entity in alike], rows)
        scene_idxs = first.scene_idxs * len(alike)
        return RepeatedEntity(
            Entity(stem, scene_idxs, pose, (structure,), hidden=first.hidden, origin=first.origin), names
        )

    def _form(self, part: Any) -> Hashable:
        if isinstance(part, Value):
            return part.data.shape[1:]
        if isinstance(part, tuple):
            return tuple(map(self._form, part))  # pyright: ignore[reportUnknownArgumentType]
        if not is_dataclass(part):
            return part
        made = self._form(self._material(part)) if isinstance(part, CollisionShape | VisualShape) else None
        return type(part), made, tuple(self._form(getattr(part, name)) for name in _compared_fields(part))

    def _material(self, shape: CollisionShape | VisualShape) -> Any:
        """The one material that a shape has in every scene; None where these are several that are made ahead."""
        if shape.material is None:
            return None
        table = self.tables[_material_table(shape)]
        found = [table[index] for index in np.unique(shape.material.data).tolist()]
        if len(found) == 1:
            return found[0]
        # Of several that differ from scene to scene it depends on the scene which is made: nothing is like it.
        return id(shape) if any(map(_varies, found)) else None

    def _merged(self, parts: Sequence[Any], rows: int) -> Any:
        first = parts[0]
        if isinstance(first, Value):
            return _concatenate(parts, rows)
        if isinstance(first, tuple):
            return tuple(self._merged(items, rows) for items in zip(*parts, strict=True))
        if not is_dataclass(first):
            return first
        merged = {name: self._merged([getattr(part, name) for part in parts], rows) for name in _compared_fields(first)}
        if isinstance(first, CollisionShape | VisualShape):
            materials = [self._material(shape) for shape in parts]
            if any(material is not None and _varies(material) for material in materials):
                # Made in the loop, as where it differs in one entity.
                table = self.tables[_material_table(first)]
                table.append(self._merged(materials, rows))
                merged["material"] = literal(len(table) - 1, "int64")
        return replace(first, **merged)  # pyright: ignore[reportArgumentType, reportUnknownVariableType]


def _material_table(shape: CollisionShape | VisualShape) -> str:
    return "physical_materials" if isinstance(shape, CollisionShape) else "visual_materials"


def _varies(material: Any) -> bool:
    return any(value.varies for value in material.values())


def _compared_fields(part: Any) -> list[str]:
    return [field.name for field in fields(part) if field.compare]


def _concatenate(values: Sequence[Value], rows: int) -> Value:
    """Values of several entities of so many scenes as one, which is the same everywhere if all agree."""
    first = values[0]
    data: NDArray[Any] = first.data
    if len(data) == 1 and all(value is first or value.data.tobytes() == data.tobytes() for value in values):
        return first
    parts: list[Any] = [np.broadcast_to(value.data, (rows, *data.shape[1:])) for value in values]
    return Value(np.concatenate(parts))


def write_entity(source: SourceWriter, entity: Entity, num_scenes: int, tables: ScriptContext) -> None:
    """One entity, a block a structure that its scenes have."""
    for index, structure, rows in structure_variants(entity):
        columns = SceneValues(entity.name, rows, tables.names)
        inner = SourceWriter(depth=source.depth + (len(rows) > 1))
        _write_in_scene(inner, entity, string(entity.name), (entity.name,), structure, columns, tables)
        source.line()
        source.comment(entity.name if entity.pick is None else f"{entity.name}, variant {index}")
        _write_description(source, entity, structure, columns, tables)
        numbers: list[int] = rows.tolist()
        scene_idxs = tuple(entity.scene_idxs[row] for row in numbers)
        append_in_scenes(source, inner, columns, scene_idxs, num_scenes)


def write_repeated_entity(source: SourceWriter, run: RepeatedEntity, num_scenes: int, tables: ScriptContext) -> None:
    """Copies of one another, in a loop over their names and scenes."""
    entity, rows = run.entity, run.scenes
    columns = SceneValues(entity.name, np.arange(len(entity.scene_idxs)), tables.names, len(run.names))
    looped = rows > 1
    inner = SourceWriter(depth=source.depth + 1 + looped)
    structure = entity.structures[0]
    _write_in_scene(inner, entity, "name", run.names, structure, columns, tables)
    source.line()
    source.comment(f"{run.names[0]} to {run.names[-1]}")
    _write_description(source, entity, structure, columns, tables)
    scenes = scene_selection(source, columns, entity.scene_idxs[:rows], num_scenes)
    names = tables.names.take(f"{entity.name}_names")
    source.statement(_names_expression(run.names), assign=names)
    columns.write(source)
    if not looped and num_scenes > 1:
        source.line(f"scene = {scenes}")
    with source.block(f"for k, name in enumerate({names}):" if columns.reads("k") else f"for name in {names}:"):
        if not looped:
            source.append(inner)
            return
        with source.block(scene_loop_header(scenes, columns)):
            source.append(inner)


def _write_in_scene(
    source: SourceWriter,
    entity: Entity,
    name: str,
    names: tuple[str, ...],
    structure: BodyStructure | ArticulationStructure,
    columns: SceneValues,
    tables: ScriptContext,
) -> None:
    """The statements in one scene. `name`: an expression for the entity's, which is one of `names`."""
    if isinstance(structure, ArticulationStructure):
        write_articulation(
            ArticulationScript(entity, name, structure, source, columns, tables, tables.mount_targets.links(names))
        )
    else:
        is_mount_target = tables.mount_targets.is_body(names)
        write_body(
            BodyScript(entity, name, structure, source, columns, tables.files, tables.materials, is_mount_target)
        )


def _write_description(
    source: SourceWriter,
    entity: Entity,
    structure: BodyStructure | ArticulationStructure,
    columns: SceneValues,
    tables: ScriptContext,
) -> None:
    """What no call says: the files that an articulation was read from, and what sensors do not see."""
    if isinstance(structure, ArticulationStructure) and structure.description_files:
        indices = [index for file in structure.description_files for index in columns.of_rows(file).tolist()]
        files = [tables.files.uri(index) for index in dict.fromkeys(indices)]
        source.comment(f"As in {', '.join(files)}.")
    if entity.hidden:
        source.comment("Only people see it: who takes pictures for sensors sets its visibility to 0 meanwhile.")


def _names_expression(names: tuple[str, ...]) -> SourceNode:
    """A list of names, as a comprehension where they are numbered from 0."""
    stem = names[0].removesuffix("0")
    if names == tuple(f"{stem}{k}" for k in range(len(names))):
        text = string(stem.replace("{", "{{").replace("}", "}}") + "{k}")
        return f"[f{text} for k in range({len(names)})]"
    return list_of([string(name) for name in names])
