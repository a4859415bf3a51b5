"""Entities of a plan as statements: a block each, or a loop over copies of one another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.emit.python.articulations import Robot, write_articulation
from scenecc.emit.python.bodies import Body, write_body
from scenecc.emit.python.columns import Columns, variants
from scenecc.emit.python.layout import Node, Source, list_of, string
from scenecc.emit.python.scenes import over_scenes, selected
from scenecc.plan import ArticulationStructure

if TYPE_CHECKING:
    from scenecc.emit.python.copies import Run
    from scenecc.emit.python.tables import Tables
    from scenecc.plan import BodyStructure, Entity


def write_entity(source: Source, entity: Entity, num_scenes: int, tables: Tables) -> None:
    """One entity, a block a structure that its scenes have."""
    for index, structure, rows in variants(entity):
        columns = Columns(entity.name, rows, tables.names)
        looped = len(rows) > 1
        inner = Source(depth=source.depth + looped)
        _write(inner, entity, string(entity.name), (entity.name,), structure, columns, tables)
        source.line()
        source.comment(entity.name if entity.pick is None else f"{entity.name}, variant {index}")
        _write_description(source, entity, structure, columns, tables)
        numbers: list[int] = rows.tolist()
        scenes = selected(source, columns, tuple(entity.scene_idxs[row] for row in numbers), num_scenes)
        columns.write(source)
        if not looped:
            if num_scenes > 1:
                source.line(f"scene = {scenes}")
            source.append(inner)
            continue
        with source.block(over_scenes(scenes, columns)):
            source.append(inner)


def write_run(source: Source, run: Run, num_scenes: int, tables: Tables) -> None:
    """Copies of one another, in a loop over their names and scenes."""
    entity, rows = run.entity, run.scenes
    columns = Columns(entity.name, np.arange(len(entity.scene_idxs)), tables.names, len(run.names))
    looped = rows > 1
    inner = Source(depth=source.depth + 1 + looped)
    structure = entity.structures[0]
    _write(inner, entity, "name", run.names, structure, columns, tables)
    source.line()
    source.comment(f"{run.names[0]} to {run.names[-1]}")
    _write_description(source, entity, structure, columns, tables)
    scenes = selected(source, columns, entity.scene_idxs[:rows], num_scenes)
    names = tables.names.take(f"{entity.name}_names")
    source.statement(_names_of(run.names), assign=names)
    columns.write(source)
    if not looped and num_scenes > 1:
        source.line(f"scene = {scenes}")
    with source.block(f"for k, name in enumerate({names}):" if columns.reads("k") else f"for name in {names}:"):
        if not looped:
            source.append(inner)
            return
        with source.block(over_scenes(scenes, columns)):
            source.append(inner)


def _write(
    source: Source,
    entity: Entity,
    name: str,
    names: tuple[str, ...],
    structure: BodyStructure | ArticulationStructure,
    columns: Columns,
    tables: Tables,
) -> None:
    """The statements in one scene. `name`: an expression for the entity's, which is one of `names`."""
    if isinstance(structure, ArticulationStructure):
        write_articulation(Robot(entity, name, structure, source, columns, tables, tables.held.links(names)))
    else:
        held = tables.held.is_body(names)
        write_body(Body(entity, name, structure, source, columns, tables.files, tables.materials, held))


def _write_description(
    source: Source,
    entity: Entity,
    structure: BodyStructure | ArticulationStructure,
    columns: Columns,
    tables: Tables,
) -> None:
    """What no call says: the files that an articulation was read from, and what sensors do not see."""
    if isinstance(structure, ArticulationStructure) and structure.file is not None:
        files = [tables.files.uri(index) for index in dict.fromkeys(columns.of_rows(structure.file).tolist())]
        source.comment(f"As in {', '.join(files)}.")
    if entity.hidden:
        source.comment("Only people see it: who takes pictures for sensors sets its visibility to 0 meanwhile.")


def _names_of(names: tuple[str, ...]) -> Node:
    """A list of names, as a comprehension where they are numbered from 0."""
    stem = names[0].removesuffix("0")
    if names == tuple(f"{stem}{k}" for k in range(len(names))):
        text = string(stem.replace("{", "{{").replace("}", "}}") + "{k}")
        return f"[f{text} for k in range({len(names)})]"
    return list_of([string(name) for name in names])
