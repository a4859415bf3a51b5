"""Writes entities, one block for each of their structures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.emit.python.articulations import ArticulationScript, write_articulation
from scenecc.emit.python.bodies import BodyScript, write_body
from scenecc.emit.python.context import SceneValues, ScriptContext, append_in_scenes, structure_variants
from scenecc.emit.python.source import SourceWriter, string
from scenecc.plan import ArticulationStructure

if TYPE_CHECKING:
    from scenecc.plan import BodyStructure, Entity


def write_entity(source: SourceWriter, entity: Entity, num_scenes: int, tables: ScriptContext) -> None:
    """Writes one entity."""
    for index, structure, rows in structure_variants(entity):
        columns = SceneValues(entity.name, rows, tables.names)
        inner = SourceWriter(depth=source.depth + (len(rows) > 1))
        _write_in_scene(inner, entity, structure, columns, tables)
        source.line()
        source.comment(entity.name if entity.pick is None else f"{entity.name}, variant {index}")
        _write_description(source, entity, structure, columns, tables)
        numbers: list[int] = rows.tolist()
        scene_idxs = tuple(entity.scene_idxs[row] for row in numbers)
        append_in_scenes(source, inner, columns, scene_idxs, num_scenes)


def _write_in_scene(
    source: SourceWriter,
    entity: Entity,
    structure: BodyStructure | ArticulationStructure,
    columns: SceneValues,
    tables: ScriptContext,
) -> None:
    name, targets = string(entity.name), tables.mount_targets
    if isinstance(structure, ArticulationStructure):
        links = targets.links(entity.name)
        write_articulation(ArticulationScript(entity, name, structure, source, columns, tables, links))
    else:
        held = targets.is_body(entity.name)
        write_body(BodyScript(entity, name, structure, source, columns, tables.files, tables.materials, held))


def _write_description(
    source: SourceWriter,
    entity: Entity,
    structure: BodyStructure | ArticulationStructure,
    columns: SceneValues,
    tables: ScriptContext,
) -> None:
    """Writes comments: the files of an articulation, and how to hide a body from sensors."""
    if isinstance(structure, ArticulationStructure) and structure.description_files:
        indices = [index for file in structure.description_files for index in columns.of_rows(file).tolist()]
        files = [tables.files.uri(index) for index in dict.fromkeys(indices)]
        source.comment(f"From {', '.join(files)}.")
    if entity.hidden:
        source.comment("Hidden from sensors: set its visibility to 0 while you take their pictures.")
