"""Emits a plan as a readable script of plain SAPIEN calls.

The script needs SAPIEN and not scenecc. A plan that no SAPIEN call can express is reported.
"""

from __future__ import annotations

import textwrap
from inspect import getsource
from typing import TYPE_CHECKING

from scenecc.diagnostics.diagnostic import Location
from scenecc.emit.python.articulations import needs_soft_tendons
from scenecc.emit.python.bodies import BODY_PROPERTIES, RENDER_PROPERTIES
from scenecc.emit.python.context import MountTargets, ScriptContext, ScriptMaterials, present_fields
from scenecc.emit.python.entities import write_entity
from scenecc.emit.python.files import ScriptFiles, plan_values, unused_files
from scenecc.emit.python.rendering import write_sections
from scenecc.emit.python.source import Group, Identifiers, SourceNode, SourceWriter, call, list_of, number_literal
from scenecc.plan import ArticulationStructure
from scenecc.plan.articulation import MAX_LINKS, NON_LINK_FIELDS, VELOCITY_FIELDS, tendon_links
from scenecc.plan.body import rebase_file
from scenecc.plan.scene import SCENE_CONFIG_FIELDS, process_wide_settings
from scenecc.plan.tendons import link_dynamics, soft_tendon

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import BodyStructure, Mimic, ScenePlan
    from scenecc.plan.scene import Physics


class ProcessSettings:
    """PhysX's process-wide defaults that a plan changes."""

    def __init__(self, physics: Physics) -> None:
        self._workers = physics.cpu_workers
        self._changes = {
            kind: {name: _setting_literal(value) for name, value in given.items()}
            for kind, given in process_wide_settings(physics).items()
        }

    @property
    def needed(self) -> bool:
        """Whether a default is changed."""
        return bool(self._kinds())

    def imports(self) -> list[str]:
        """Returns the import statements that the text of `write` needs."""
        if not self.needed:
            return []
        return ["from collections.abc import Iterator", "from contextlib import contextmanager"]

    def write(self, source: SourceWriter) -> None:
        """Writes a context manager `physics_settings`."""
        if not self.needed:
            return
        source.line()
        source.line()
        source.line("@contextmanager")
        with source.block("def physics_settings() -> Iterator[None]:"):
            source.line('"""Sets process-wide defaults of SAPIEN, and restores them once the scenes are built."""')
            for kind in self._kinds():
                source.line(f"{kind}_config = physx.get_{kind}_config()")
            for kind in self._kinds():
                self._write_change(source, kind)
            with source.block("try:"):
                source.line("yield")
            with source.block("finally:"):
                for kind in self._kinds():
                    source.line(f"physx.set_{kind}_config({kind}_config)")

    def _kinds(self) -> list[str]:
        return [
            kind for kind, table in self._changes.items() if table or (kind == "scene" and self._workers is not None)
        ]

    def _write_change(self, source: SourceWriter, kind: str) -> None:
        source.line(f"config = physx.get_{kind}_config()")
        for name, node in self._changes[kind].items():
            source.statement(node, assign=f"config.{name}")
        source.statement(self._setter(kind))

    def _setter(self, kind: str) -> Group:
        if kind != "scene" or self._workers is None:
            return call(f"physx.set_{kind}_config", "config")
        # The number of workers has no property, and the call that takes it sets everything.
        everything: dict[str, SourceNode] = {name: f"config.{name}" for name in SCENE_CONFIG_FIELDS}
        return call("physx.set_scene_config", **everything, cpu_workers=str(self._workers))


def _setting_literal(value: float | tuple[float, ...]) -> SourceNode:
    if isinstance(value, tuple):
        return list_of([number_literal(float(x)) for x in value])
    return number_literal(value)


def _check_supported(plan: ScenePlan, sink: Sink) -> bool:
    """Returns whether a script can express the whole plan; otherwise reports errors to `sink`."""
    found = True
    for entity in plan.entities:
        for structure in entity.structures:
            for place, words in _unsupported_parts(structure):
                sink.report("SC720", f"`{entity.name}`: {words}", place or entity.origin or Location(None))
                found = False
    return found


def _unsupported_parts(structure: BodyStructure | ArticulationStructure) -> Iterator[tuple[Origin | None, str]]:
    """Yields origin and description of the parts of a structure that SAPIEN does not support."""
    for body in structure.bodies:
        for name in _unsupported_fields(body):
            yield (
                body.origin or structure.origin,
                f"a body of type {body.body_type} without visuals has no `{name}`",
            )
    if isinstance(structure, ArticulationStructure):
        if len(structure.links) > MAX_LINKS:
            yield (
                structure.origin,
                f"an articulation has {len(structure.links)} links; PhysX on the CPU supports at most {MAX_LINKS}",
            )
        if structure.fix_root_link:
            for name in present_fields(structure, VELOCITY_FIELDS):
                yield structure.origin, f"a fixed root has no `{name}`"
        for mimic in structure.mimics:
            words = _tendon_error(structure, mimic)
            if words is not None:
                yield mimic.origin or structure.origin, words


def _tendon_error(structure: ArticulationStructure, mimic: Mimic) -> str | None:
    try:
        tendon_links(structure, mimic)
    except ValueError as error:
        return str(error)
    return None


def _unsupported_fields(structure: BodyStructure) -> list[str]:
    """Returns the fields that SAPIEN does not support."""
    fields: list[str] = []
    if structure.body_type in {"static", "none"}:
        fields += present_fields(structure, (*BODY_PROPERTIES, "mass", "com", "inertial"))
    if structure.body_type == "link":
        fields += present_fields(structure, NON_LINK_FIELDS)
    if structure.body_type == "none":
        fields += present_fields(structure, ("collision_groups",)) + (["collisions"] if structure.collisions else [])
    return fields if structure.visuals else fields + present_fields(structure, RENDER_PROPERTIES)


def write(plan: ScenePlan, sink: Sink, base: Path | None) -> str | None:
    """Returns the script, or None if SAPIEN does not support the plan, which is reported to `sink`.

    The script finds files relative to its own folder. `base`: that folder. None: the plan's own.
    """
    if not _check_supported(plan, sink):
        return None
    names = Identifiers()
    files = plan.files if base is None else tuple(rebase_file(file, base) for file in plan.files)
    tables = ScriptContext(
        names, ScriptFiles(files, names, unused_files(plan)), ScriptMaterials(plan, names), MountTargets(plan)
    )
    blocks = SourceWriter(depth=1)
    tables.mount_targets.write_head(blocks)
    for entity in plan.entities:
        write_entity(blocks, entity, plan.num_scenes, tables)
    write_sections(blocks, plan, tables)
    settings = ProcessSettings(plan.physics)
    source = SourceWriter()
    _write_head(source, plan, is_bound=tables.files.is_bound)
    has_soft_tendons = any(needs_soft_tendons(structure) for entity in plan.entities for structure in entity.structures)
    _write_imports(source, tables.files, settings, has_soft_tendons=has_soft_tendons)
    tables.files.write_head(source)
    for function in (link_dynamics, soft_tendon) if has_soft_tendons else ():
        source.line()
        source.line()
        source.lines(getsource(function))
    settings.write(source)
    source.line()
    source.line()
    if settings.needed:
        source.line("@physics_settings()")
    with source.block("def build_scenes(render: bool = False) -> list[sapien.Scene]:"):
        source.line(f'"""Builds {_scene_count_text(plan.num_scenes)}. `render`: also build visuals."""')
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
    """Simulates 100 steps and prints the poses of all entities in the first scene."""
    scenes = build_scenes()
    for _ in range(100):
        for scene in scenes:
            scene.step()
    for entity in scenes[0].entities:
        print(entity.name, entity.pose.p, entity.pose.q)


if __name__ == "__main__":
    main()
'''


def _write_head(source: SourceWriter, plan: ScenePlan, *, is_bound: bool) -> None:
    """Writes the comment at the top. `is_bound`: see `ScriptFiles`."""
    # Python obeys a "coding:" comment in the first two lines, so neither may contain text of the scene.
    source.comment("A script of plain SAPIEN calls, written by scenecc.")
    source.comment("")
    source.comment(f"{plan.name}: {_scene_count_text(plan.num_scenes)}.")
    for paragraph in plan.description.splitlines():
        for line in textwrap.wrap(paragraph, 96):
            source.comment(line)
    source.comment("")
    source.comment("Run this file, or import it and call build_scenes(). It needs sapien, but not scenecc.")
    if is_bound:
        source.comment("It finds its files relative to its own folder: move it together with them, or emit it again.")
    if any(value.recipe is not None for _, _, value in plan_values(plan)):
        source.comment(f"Values that a reset would draw again are those of seed {plan.seed}.")
    if plan.physics.scene_spacing is not None or plan.physics.gpu_memory is not None:
        source.comment("Scene spacing and GPU memory are left out: they only apply to a shared GPU simulation.")
    source.line()


def _scene_count_text(count: int) -> str:
    return "one scene" if count == 1 else f"{count} parallel scenes"


def _write_imports(
    source: SourceWriter, files: ScriptFiles, settings: ProcessSettings, *, has_soft_tendons: bool
) -> None:
    standard = [*files.imports(), *settings.imports()]
    if has_soft_tendons:
        standard = list(dict.fromkeys([*standard, "from typing import Any"]))
    for line in sorted(standard, key=lambda line: (line.startswith("from"), line)):
        source.line(line)
    if standard:
        source.line()
    if files.cut:
        source.line("import coacd")
    if files.writes_meshes or files.computes or has_soft_tendons:
        source.line("import numpy as np")
    source.line("import sapien")
    if files.reads_meshes:
        source.line("import trimesh")
    if files.computes:
        source.line("from numpy.typing import NDArray")
    source.line("from sapien import physx")


def _write_scenes(source: SourceWriter, plan: ScenePlan) -> None:
    if plan.num_scenes == 1:
        _write_scene(source, plan)
        return
    source.line("scenes: list[sapien.Scene] = []")
    with source.block(f"for _ in range({plan.num_scenes}):"):
        _write_scene(source, plan)
        source.line("scenes.append(scene)")


def _write_scene(source: SourceWriter, plan: ScenePlan) -> None:
    source.line("systems = [physx.PhysxCpuSystem()]")
    with source.block("if render:"):
        source.line("systems.append(sapien.render.RenderSystem())")
    source.line("scene = sapien.Scene(systems)")
    if plan.physics.timestep is not None:
        source.line(f"scene.timestep = {number_literal(float(plan.physics.timestep))}")
