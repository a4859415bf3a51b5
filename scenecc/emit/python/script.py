"""A whole plan as a script that needs SAPIEN and nothing else."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from scenecc.diagnostics import Location
from scenecc.emit.python.bodies import Body, write_body
from scenecc.emit.python.columns import Columns, number, variants
from scenecc.emit.python.copies import Run, folded
from scenecc.emit.python.files import Files
from scenecc.emit.python.knobs import BODY_KNOBS, LOOK_KNOBS, given
from scenecc.emit.python.layout import Node, Source, list_of, string
from scenecc.emit.python.materials import Materials
from scenecc.emit.python.names import Names
from scenecc.emit.python.settings import Settings
from scenecc.plan.uris import rebased

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.plan import BodyStructure, Entity, ScenePlan


@dataclass(frozen=True, slots=True)
class _Tables:
    """What all bodies of a script share."""

    names: Names
    files: Files
    materials: Materials


def write(plan: ScenePlan, sink: Sink, base: Path | None) -> str | None:
    """The script; None if the plan holds what no SAPIEN call takes, which `sink` then tells.

    The script finds files relative to its own place: `base` is the folder that it will lie in, None the plan's own.
    """
    if not _expressible(plan, sink):
        return None
    names = Names()
    files = plan.files if base is None else tuple(rebased(file, base) for file in plan.files)
    whole, parts = folded(plan)
    tables = _Tables(names, Files(files, names), Materials(whole, names))
    blocks = Source(depth=1)
    for part in parts:
        if isinstance(part, Run):
            _write_run(blocks, part, plan.num_scenes, tables)
        else:
            _write_entity(blocks, part, plan.num_scenes, tables)
    settings = Settings(plan.physics)
    source = Source()
    _write_head(source, plan)
    _write_imports(source, tables.files, settings)
    tables.files.write_head(source)
    settings.write(source)
    source.line()
    source.line()
    if settings.needed:
        source.line("@physics_settings()")
    with source.block("def build_scenes(render: bool = False) -> list[sapien.Scene]:"):
        source.line(f'"""Builds {_scenes_word(plan.num_scenes)}. `render`: build what is seen, too."""')
        tables.files.write_check(source)
        _write_scenes(source, plan)
        tables.materials.write(source, tables.files)
        source.append(blocks)
        source.line()
        source.line("return [scene]" if plan.num_scenes == 1 else "return scenes")
    source.lines(_MAIN)
    return source.text


_MAIN = '''

def main() -> None:
    """Simulates 100 steps and prints where everything in the first scene is."""
    scenes = build_scenes()
    for _ in range(100):
        for scene in scenes:
            scene.step()
    for entity in scenes[0].entities:
        print(entity.name, entity.pose.p, entity.pose.q)


if __name__ == "__main__":
    main()
'''


def _write_head(source: Source, plan: ScenePlan) -> None:
    # Python takes a comment in the first two lines that says "coding:" at its word, so these two are never a scene's.
    source.comment("A script of plain SAPIEN calls, written by scenecc.")
    source.comment("")
    source.comment(f"{plan.name}: {_scenes_word(plan.num_scenes)}.")
    for paragraph in plan.description.splitlines():
        for line in textwrap.wrap(paragraph, 96):
            source.comment(line)
    source.comment("")
    source.comment("Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.")
    if _draws_anew(plan):
        source.comment(f"Poses and velocities that a reset would draw anew are those of the seed {plan.seed}.")
    if plan.physics.scene_spacing is not None or plan.physics.gpu_memory is not None:
        source.comment("Scene spacing and GPU memory are left out: they concern scenes that share a GPU simulation.")
    source.line()


def _draws_anew(plan: ScenePlan) -> bool:
    """Whether a reset would draw anything anew."""
    poses = [entity.pose for entity in plan.entities]
    bodies = [body for entity in plan.entities for body in entity.structures]
    values = (*poses, *(body.linear_velocity for body in bodies), *(body.angular_velocity for body in bodies))
    return any(value is not None and value.recipe is not None for value in values)


def _scenes_word(count: int) -> str:
    return "one scene" if count == 1 else f"{count} parallel scenes"


def _write_imports(source: Source, files: Files, settings: Settings) -> None:
    standard = [*files.imports(), *settings.imports()]
    for line in sorted(standard, key=lambda line: (line.startswith("from"), line)):
        source.line(line)
    if standard:
        source.line()
    if files.cut:
        source.line("import coacd")
    source.line("import sapien")
    if files.cut:
        source.line("import trimesh")
    source.line("from sapien import physx")


def _write_scenes(source: Source, plan: ScenePlan) -> None:
    if plan.num_scenes == 1:
        _write_scene(source, plan)
        return
    source.line("scenes: list[sapien.Scene] = []")
    with source.block(f"for _ in range({plan.num_scenes}):"):
        _write_scene(source, plan)
        source.line("scenes.append(scene)")


def _write_scene(source: Source, plan: ScenePlan) -> None:
    source.line("systems = [physx.PhysxCpuSystem()]")
    with source.block("if render:"):
        source.line("systems.append(sapien.render.RenderSystem())")
    source.line("scene = sapien.Scene(systems)")
    if plan.physics.timestep is not None:
        source.line(f"scene.timestep = {number(float(plan.physics.timestep))}")


def _write_entity(source: Source, entity: Entity, num_scenes: int, tables: _Tables) -> None:
    for index, structure, rows in variants(entity):
        columns = Columns(entity.name, rows, tables.names)
        looped = len(rows) > 1
        inner = Source(depth=source.depth + looped)
        write_body(Body(entity, string(entity.name), structure, inner, columns, tables.files, tables.materials))
        source.line()
        source.comment(entity.name if entity.pick is None else f"{entity.name}, variant {index}")
        scenes = _selected(source, columns, entity, rows, num_scenes)
        columns.write(source)
        if not looped:
            if num_scenes > 1:
                source.line(f"scene = {scenes}")
            source.append(inner)
            continue
        with source.block(_over_scenes(scenes, columns)):
            source.append(inner)


def _write_run(source: Source, run: Run, num_scenes: int, tables: _Tables) -> None:
    """Copies of one another, in a loop over their names and scenes."""
    entity, rows = run.entity, run.scenes
    columns = Columns(entity.name, np.arange(len(entity.scene_idxs)), tables.names, len(run.names))
    looped = rows > 1
    inner = Source(depth=source.depth + 1 + looped)
    write_body(Body(entity, "name", entity.structures[0], inner, columns, tables.files, tables.materials))
    source.line()
    source.comment(f"{run.names[0]} to {run.names[-1]}")
    scenes = _selected(source, columns, entity, np.arange(rows), num_scenes)
    names = tables.names.take(f"{entity.name}_names")
    source.statement(_names_of(run.names), assign=names)
    columns.write(source)
    if not looped and num_scenes > 1:
        source.line(f"scene = {scenes}")
    with source.block(f"for k, name in enumerate({names}):" if columns.reads("k") else f"for name in {names}:"):
        if not looped:
            source.append(inner)
            return
        with source.block(_over_scenes(scenes, columns)):
            source.append(inner)


def _over_scenes(scenes: str, columns: Columns) -> str:
    return f"for i, scene in enumerate({scenes}):" if columns.reads("i") else f"for scene in {scenes}:"


def _names_of(names: tuple[str, ...]) -> Node:
    """A list of names, as a comprehension where they are numbered from 0."""
    stem = names[0].removesuffix("0")
    if names == tuple(f"{stem}{k}" for k in range(len(names))):
        text = string(stem.replace("{", "{{").replace("}", "}}") + "{k}")
        return f"[f{text} for k in range({len(names)})]"
    return list_of([string(name) for name in names])


def _selected(source: Source, columns: Columns, entity: Entity, rows: NDArray[np.intp], num_scenes: int) -> str:
    """An expression for the scenes of a block, or for its one scene."""
    idxs: list[int] = [entity.scene_idxs[row] for row in rows]
    if len(idxs) == 1:
        return f"scenes[{idxs[0]}]"
    if len(idxs) == num_scenes:
        return "scenes"
    steps = {b - a for a, b in pairwise(idxs)}
    if len(steps) == 1:
        step = steps.pop()
        return f"scenes[{idxs[0]}:{idxs[-1] + 1}]" if step == 1 else f"scenes[{idxs[0]}:{idxs[-1] + 1}:{step}]"
    variable = columns.names.take(f"{columns.ident}_scenes")
    source.statement(list_of([str(index) for index in idxs]), assign=variable)
    return f"[scenes[k] for k in {variable}]"


def _expressible(plan: ScenePlan, sink: Sink) -> bool:
    found = True
    for entity in plan.entities:
        for structure in entity.structures:
            for name in _lost(structure):
                place = structure.origin or entity.origin or Location(None)
                kind = f"a body of type {structure.body_type}"
                sink.report("SC720", f"`{entity.name}`: {kind} without visible shapes has no `{name}`", place)
                found = False
    return found


def _lost(structure: BodyStructure) -> list[str]:
    """Fields that nothing in SAPIEN would hold."""
    lost: list[str] = []
    if structure.body_type in {"static", "none"}:
        lost += given(structure, (*BODY_KNOBS, "mass", "inertial"))
    if structure.body_type == "none":
        lost += given(structure, ("collision_groups",)) + (["collisions"] if structure.collisions else [])
    return lost if structure.visuals else lost + given(structure, LOOK_KNOBS)
