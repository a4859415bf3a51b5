"""A measured scene as a model of MuJoCo, section by section."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.emit.mjcf.bodies import write_entity
from scenecc.emit.mjcf.contacts import write_contacts
from scenecc.emit.mjcf.model import SECTIONS, Model
from scenecc.emit.mjcf.seen import write_cameras, write_lights
from scenecc.emit.mjcf.ties import write_ties
from scenecc.emit.problems import tell_problem
from scenecc.emit.xml.elements import Element, document
from scenecc.emit.xml.lost import SETTINGS_OF_PHYSX, Lost
from scenecc.emit.xml.meshes import Beside
from scenecc.meshes import Drawer, MeshProblem

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.emit.choice import Choice
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot


def write(plan: ScenePlan, measured: EngineSnapshot, choice: Choice, sink: Sink) -> dict[str, bytes] | None:
    """The model, `NAME.xml`, and its meshes and images; None after an error. See `scenecc.emit.export`."""
    lost = Lost(sink, left_out="SC730", otherwise="SC731")
    beside = Beside(choice.name)
    drawer = Drawer(plan, lambda problem, place: lost.leave_out(plan.name, str(problem), place))
    model = Model(plan, measured.scenes[0], drawer, beside, lost, Element("mujoco", model=plan.name))
    try:
        for entity in model.scene.entities:
            write_entity(model, entity)
    except MeshProblem as problem:
        tell_problem(problem, drawer.at, sink)
        return None
    write_contacts(model)
    write_ties(model)
    write_lights(model)
    write_cameras(model)
    lost.fields("physics", plan.physics, SETTINGS_OF_PHYSX, plan.physics.origin)
    lost.tell()
    return {f"{choice.name}.xml": document(_whole(model)), **beside.files}


def _whole(model: Model) -> Element:
    root, scene = model.root, model.scene
    head = [
        Element(
            "compiler",
            angle="radian",
            autolimits="true",
            inertiafromgeom="false",
            assetdir=model.beside.folder if model.beside.files else None,
        ),
        Element("option", timestep=scene.timestep, gravity=scene.gravity, integrator="implicitfast"),
    ]
    root.children[:0] = head
    _write_start(model)
    for tag in SECTIONS:
        if model.sections[tag].children:
            root.take(model.sections[tag])
    return root


def _write_start(model: Model) -> None:
    """A keyframe with what a model does not start with by itself: velocities, and targets of actuators."""
    starts = [model.starts[id(each)] for each in model.world.walk() if id(each) in model.starts]
    qpos = [number for start in starts for number in start.qpos]
    qvel = [number for start in starts for number in start.qvel]
    if any(qvel) or any(model.controls):
        model.sections["keyframe"].add("key", name="start", qpos=qpos, qvel=qvel, ctrl=model.controls or None)
