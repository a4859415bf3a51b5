"""Exports one measured scene to a MuJoCo model, section by section."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.emit.mjcf.bodies import write_entity
from scenecc.emit.mjcf.constraints import write_constraints, write_contact_exclusions
from scenecc.emit.mjcf.model import SECTIONS, MjcfModel
from scenecc.emit.mjcf.rendering import write_cameras, write_lights
from scenecc.emit.unsupported import PHYSX_SETTINGS, UnsupportedFeatures
from scenecc.emit.xml import AssetFolder, XmlElement, format_document
from scenecc.meshes.builder import MeshBuilder
from scenecc.meshes.surface import MeshError, report_mesh_error

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.emit import ExportOptions
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot


def write(plan: ScenePlan, measured: EngineSnapshot, choice: ExportOptions, sink: Sink) -> dict[str, bytes] | None:
    """The model, `NAME.xml`, and its meshes and images; None after an error. See `scenecc.emit.export`."""
    unsupported = UnsupportedFeatures(sink, left_out="SC730", otherwise="SC731")
    assets = AssetFolder(choice.name)
    drawer = MeshBuilder(plan, lambda problem, place: unsupported.leave_out(plan.name, str(problem), place))
    model = MjcfModel(plan, measured.scenes[0], drawer, assets, unsupported, XmlElement("mujoco", model=plan.name))
    try:
        for entity in model.scene.entities:
            write_entity(model, entity)
    except MeshError as problem:
        report_mesh_error(problem, drawer.at, sink)
        return None
    write_contact_exclusions(model)
    write_constraints(model)
    write_lights(model)
    write_cameras(model)
    unsupported.fields("physics", plan.physics, PHYSX_SETTINGS, plan.physics.origin)
    unsupported.report()
    return {f"{choice.name}.xml": format_document(_assemble_root(model)), **assets.files}


def _assemble_root(model: MjcfModel) -> XmlElement:
    root, scene = model.root, model.scene
    head = [
        XmlElement(
            "compiler",
            angle="radian",
            autolimits="true",
            inertiafromgeom="false",
            assetdir=model.assets.folder if model.assets.files else None,
        ),
        XmlElement("option", timestep=scene.timestep, gravity=scene.gravity, integrator="implicitfast"),
    ]
    root.children[:0] = head
    _write_keyframe(model)
    for tag in SECTIONS:
        if model.sections[tag].children:
            root.take(model.sections[tag])
    return root


def _write_keyframe(model: MjcfModel) -> None:
    """A keyframe with what a model does not start with by itself: velocities, and targets of actuators."""
    starts = [model.starts[id(each)] for each in model.world.walk() if id(each) in model.starts]
    qpos = [number for start in starts for number in start.qpos]
    qvel = [number for start in starts for number in start.qvel]
    if any(qvel) or any(model.controls):
        model.sections["keyframe"].add("key", name="start", qpos=qpos, qvel=qvel, ctrl=model.controls or None)
