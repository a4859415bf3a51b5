"""A whole plan as a script that needs SAPIEN and nothing else."""

from __future__ import annotations

import textwrap
from dataclasses import is_dataclass
from typing import TYPE_CHECKING, Final

from scenecc.emit.python.cameras import write_cameras
from scenecc.emit.python.columns import number
from scenecc.emit.python.constraints import write_constraints
from scenecc.emit.python.copies import Run, folded
from scenecc.emit.python.entities import write_entity, write_run
from scenecc.emit.python.files import Files, unread_files
from scenecc.emit.python.held import Held
from scenecc.emit.python.layout import Source
from scenecc.emit.python.lights import write_environment, write_lights
from scenecc.emit.python.lost import expressible
from scenecc.emit.python.materials import Materials
from scenecc.emit.python.names import Names
from scenecc.emit.python.settings import Settings
from scenecc.emit.python.tables import Tables
from scenecc.plan import Value
from scenecc.plan.material import rebase_file
from scenecc.plan.schema import ListKind, ObjectKind, UnionKind, plan_fields

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan

SECTIONS: Final[dict[str, Callable[[Source, ScenePlan, Tables], None]]] = {
    "constraints": write_constraints,
    "environment": write_environment,
    "lights": write_lights,
    "cameras": write_cameras,
}
"""What is built once the entities are there, in this order: the field of the plan, and what writes it.

A writer is given the body of `build_scenes`, and writes nothing where the plan has nothing of the section. See
`scenecc.emit.python.scenes.in_scenes` and `scenecc.emit.python.held`.
"""


def write(plan: ScenePlan, sink: Sink, base: Path | None) -> str | None:
    """The script; None if the plan holds what no SAPIEN call takes, which `sink` then tells.

    The script finds files relative to its own place: `base` is the folder that it will lie in, None the plan's own.
    """
    if not expressible(plan, sink, SECTIONS):
        return None
    names = Names()
    files = plan.files if base is None else tuple(rebase_file(file, base) for file in plan.files)
    whole, parts = folded(plan)
    tables = Tables(names, Files(files, names, unread_files(plan)), Materials(whole, names), Held(plan))
    blocks = Source(depth=1)
    tables.held.write_head(blocks)
    for part in parts:
        if isinstance(part, Run):
            write_run(blocks, part, plan.num_scenes, tables)
        else:
            write_entity(blocks, part, plan.num_scenes, tables)
    for write_section in SECTIONS.values():
        write_section(blocks, plan, tables)
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
        source.comment(f"What a reset would draw anew is as the seed {plan.seed} draws it.")
    if plan.physics.scene_spacing is not None or plan.physics.gpu_memory is not None:
        source.comment("Scene spacing and GPU memory are left out: they concern scenes that share a GPU simulation.")
    source.line()


def _draws_anew(plan: ScenePlan) -> bool:
    """Whether a reset would draw anything anew."""
    return any(value.recipe is not None for value in _values(plan))


def _values(node: object) -> Iterator[Value]:
    """All values below a dataclass of the plan."""
    for slot in plan_fields(type(node)):
        item = getattr(node, slot.name)
        for one in item if isinstance(slot.kind, ListKind) else (item,):
            if isinstance(one, Value):
                yield one
            elif isinstance(slot.kind, ObjectKind | UnionKind | ListKind) and is_dataclass(one):
                yield from _values(one)


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
    if files.mirrors:
        source.line("import numpy as np")
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
