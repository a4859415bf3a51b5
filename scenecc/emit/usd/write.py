"""A measured scene as a stage, and the stage as a file."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.emit.problems import tell_problem
from scenecc.emit.usd.bodies import Bodies
from scenecc.emit.usd.constraints import write_constraint
from scenecc.emit.usd.joints import write_joints
from scenecc.emit.usd.looks import Looks
from scenecc.emit.usd.stage import Stage
from scenecc.emit.xml.lost import SETTINGS_OF_PHYSX, Lost
from scenecc.interrupt import interrupts_wait, undoing
from scenecc.meshes import Drawer, MeshProblem
from scenecc.plan import ArticulationStructure

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.emit.choice import Choice
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot, MeasuredEntity, MeasuredScene

_NOT_OF_PHYSICS: Final = ("timestep", *SETTINGS_OF_PHYSX)
"""Settings of a simulation, which UsdPhysics leaves to the program that simulates."""


def write(plan: ScenePlan, measured: EngineSnapshot, choice: Choice, sink: Sink) -> dict[str, bytes] | None:
    """The file and its images; None after an error, which `sink` then tells."""
    lost = Lost(sink, left_out="SC750", otherwise="SC750")
    drawer = Drawer(plan, lambda problem, origin: tell_problem(problem, origin, sink))
    try:
        stage = Stage(choice.name, lost)
        _fill(stage, plan, measured.scenes[0], Bodies(stage, drawer, Looks(stage), choice.show))
    except MeshProblem as problem:
        tell_problem(problem, drawer.at, sink)
        return None
    _tell(stage, plan, measured.scenes[0].index)
    suffix = ".usdc" if choice.binary else ".usda"
    return {f"{choice.name}{suffix}": _bytes(stage, suffix), **stage.files}


def _fill(stage: Stage, plan: ScenePlan, scene: MeasuredScene, bodies: Bodies) -> None:
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
    stage: Stage, entity: MeasuredEntity, bodies: Bodies, paths: dict[tuple[str, str | None], str]
) -> None:
    name = entity.entity.name
    if entity.entity.hidden:
        stage.lost.leave_out(name, "that only people see it", entity.entity.origin)
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


def _tell(stage: Stage, plan: ScenePlan, scene: int) -> None:
    """Warns of all that is not in the file."""
    lost = stage.lost
    for item in (*plan.lights, *plan.cameras):
        if scene in item.scene_idxs:
            lost.leave_out(item.name, "a light" if item in plan.lights else "a camera", item.origin)
    if plan.environment is not None:
        lost.leave_out("environment", "surroundings", plan.environment.origin)
    lost.fields("physics", plan.physics, _NOT_OF_PHYSICS, plan.physics.origin)
    lost.tell()


def _bytes(stage: Stage, suffix: str) -> bytes:
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
