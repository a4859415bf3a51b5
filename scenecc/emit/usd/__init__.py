"""Exports one measured scene to USD: visual geometry, and bodies, colliders and joints of UsdPhysics."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.emit.unsupported import PHYSX_SETTINGS, UnsupportedFeatures
from scenecc.emit.usd.physics import UsdBodyWriter, write_constraint, write_joints
from scenecc.emit.usd.stage import Stage, UsdMaterials
from scenecc.interrupt import interrupts_wait, undoing
from scenecc.meshes.builder import MeshBuilder
from scenecc.meshes.surface import MeshError, report_mesh_error
from scenecc.plan import ArticulationStructure

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.emit import ExportOptions
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot, MeasuredEntity, MeasuredScene


_UNSUPPORTED_PHYSICS_FIELDS: Final = ("timestep", *PHYSX_SETTINGS)
"""Settings of a simulation, which UsdPhysics leaves to the program that simulates."""


def write(plan: ScenePlan, measured: EngineSnapshot, choice: ExportOptions, sink: Sink) -> dict[str, bytes] | None:
    """The file and its images; None after an error, which `sink` then tells."""
    unsupported = UnsupportedFeatures(sink, left_out="SC750", otherwise="SC750")
    drawer = MeshBuilder(plan, lambda problem, origin: report_mesh_error(problem, origin, sink))
    try:
        stage = Stage(choice.name, unsupported)
        _write_scene(stage, plan, measured.scenes[0], UsdBodyWriter(stage, drawer, UsdMaterials(stage), choice.show))
    except MeshError as problem:
        report_mesh_error(problem, drawer.at, sink)
        return None
    _report_unsupported(stage, plan, measured.scenes[0].index)
    suffix = ".usdc" if choice.binary else ".usda"
    return {f"{choice.name}{suffix}": _stage_to_bytes(stage, suffix), **stage.assets.files}


def _write_scene(stage: Stage, plan: ScenePlan, scene: MeasuredScene, bodies: UsdBodyWriter) -> None:
    physics = stage.physics.Scene.Define(stage.stage, stage.path(stage.root, "PhysicsScene"))
    strength = float(np.linalg.norm(scene.gravity))
    physics.CreateGravityMagnitudeAttr(strength)
    down = tuple(value / strength for value in scene.gravity) if strength else (0.0, 0.0, -1.0)
    physics.CreateGravityDirectionAttr(stage.vec3(down))
    paths: dict[tuple[str, str | None], str] = {}
    for entity in scene.entities:
        _write_entity(stage, entity, bodies, paths)
    for constraint in plan.constraints:
        if scene.index in constraint.scene_idxs:
            write_constraint(stage, constraint, constraint.scene_idxs.index(scene.index), paths)


def _write_entity(
    stage: Stage, entity: MeasuredEntity, bodies: UsdBodyWriter, paths: dict[tuple[str, str | None], str]
) -> None:
    name = entity.entity.name
    if entity.entity.hidden:
        stage.unsupported.leave_out(name, "that only people see it", entity.entity.origin)
    if not isinstance(entity.structure, ArticulationStructure):
        (body,) = entity.bodies
        made = stage.xform(stage.root, name, body.pose)
        paths[name, None] = str(made.GetPath())
        bodies.fill(made, entity, body)
        return
    # Links stand beside one another, each where it is in the world: a body below a body would move with it twice.
    above = str(stage.xform(stage.root, name).GetPath())
    links: list[str] = []
    for body in entity.bodies:
        made = stage.xform(above, body.name, body.pose)
        links.append(str(made.GetPath()))
        paths[name, body.name] = links[-1]
        bodies.fill(made, entity, body)
    write_joints(stage, entity, above, links)


def _report_unsupported(stage: Stage, plan: ScenePlan, scene: int) -> None:
    """Warns of all that is not in the file."""
    unsupported = stage.unsupported
    for item in (*plan.lights, *plan.cameras):
        if scene in item.scene_idxs:
            unsupported.leave_out(item.name, "a light" if item in plan.lights else "a camera", item.origin)
    if plan.environment is not None:
        unsupported.leave_out("environment", "surroundings", plan.environment.origin)
    unsupported.fields("physics", plan.physics, _UNSUPPORTED_PHYSICS_FIELDS, plan.physics.origin)
    unsupported.report()


def _stage_to_bytes(stage: Stage, suffix: str) -> bytes:
    """A stage as the bytes of a file: usd-core writes its binary form into files alone."""
    layer = stage.stage.GetRootLayer()
    if suffix == ".usda":
        return str(layer.ExportToString()).encode()
    with undoing() as undo:
        with interrupts_wait():
            folder = tempfile.mkdtemp()
            undo.callback(shutil.rmtree, folder, ignore_errors=True)
        file = Path(folder) / f"scene{suffix}"
        layer.Export(str(file))
        return file.read_bytes()
