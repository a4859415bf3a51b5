"""Exports one measured scene to a MuJoCo model. This module assembles the model, and writes lights and cameras."""

from __future__ import annotations

from math import degrees, tan
from typing import TYPE_CHECKING, Any, Final

from scenecc.assets.errors import AssetError
from scenecc.emit.mjcf.bodies import write_constraints, write_contact_exclusions, write_entity_bodies
from scenecc.emit.mjcf.model import SECTIONS, MjcfModel, pose_attributes
from scenecc.emit.output import (
    PHYSX_SETTINGS,
    AssetFolder,
    UnsupportedFeatures,
    XmlElement,
    format_document,
    optional_fields,
    to_pose,
    transform_direction,
)
from scenecc.geometry.rotations import compose
from scenecc.meshes.builder import MeshBuilder
from scenecc.plan.rendering import (
    AreaLight,
    DirectionalLight,
    Intrinsic,
    Orthographic,
    Perspective,
    PointLight,
    Shadow,
    SpotLight,
    TexturedLight,
)

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.emit import ExportOptions
    from scenecc.geometry.rotations import Pose7
    from scenecc.plan import ScenePlan
    from scenecc.plan.rendering import Camera, Light
    from scenecc.plan.snapshot import EngineSnapshot


def write(plan: ScenePlan, measured: EngineSnapshot, options: ExportOptions, sink: Sink) -> dict[str, bytes] | None:
    """Returns the model, `NAME.xml`, and its meshes and images; None after an error. See `scenecc.emit.export`."""
    unsupported = UnsupportedFeatures(sink, left_out="SC730", otherwise="SC731")
    assets = AssetFolder(options.name)
    mesh_builder = MeshBuilder(
        plan, lambda problem, place: unsupported.leave_out(plan.name, str(problem), place), options.max_triangles
    )
    model = MjcfModel(
        plan, measured.scenes[0], mesh_builder, assets, unsupported, XmlElement("mujoco", model=plan.name)
    )
    try:
        for entity in model.scene.entities:
            write_entity_bodies(model, entity)
    except AssetError as problem:
        problem.report(sink, mesh_builder.at)
        return None
    write_contact_exclusions(model)
    write_constraints(model)
    _write_lights(model)
    _write_cameras(model)
    unsupported.fields("physics", plan.physics, PHYSX_SETTINGS, plan.physics.origin)
    unsupported.report()
    return {f"{options.name}.xml": format_document(_assemble_root(model)), **assets.files}


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
    """Writes a keyframe for the initial velocities and actuator targets, which a model itself cannot store."""
    starts = [model.starts[id(each)] for each in model.world.walk() if id(each) in model.starts]
    qpos = [number for start in starts for number in start.qpos]
    qvel = [number for start in starts for number in start.qvel]
    if any(qvel) or any(model.controls) or model.is_commanded:
        model.sections["keyframe"].add("key", name="start", qpos=qpos, qvel=qvel, ctrl=model.controls or None)


_CAMERA_TO_MUJOCO: Final[Pose7] = (0.0, 0.0, 0.0, 0.5, 0.5, -0.5, -0.5)
"""From SAPIEN's camera frame (x forward, z up) to MuJoCo's (-z forward, y up)."""

_DEFAULT_NEAR, _DEFAULT_FAR = 0.01, 100.0
"""Clip planes of a camera that does not set them [m]."""

_UNSUPPORTED_SHADOW_FIELDS: Final = optional_fields(Shadow)


def _write_lights(model: MjcfModel) -> None:
    """Writes lights and ambient light. A scene without either keeps MuJoCo's headlight."""
    around, index = model.plan.environment, model.scene.index
    lights = [light for light in model.plan.lights if index in light.scene_idxs]
    for light in lights:
        _write_light(model, light, light.scene_idxs.index(index))
    ambient = None if around is None or around.ambient_light is None else around.ambient_light.row(index)
    if around is not None and around.map is not None:
        model.unsupported.leave_out("environment", "its `map`", around.origin)
    if lights or ambient is not None:
        dark = (0, 0, 0)
        headlight = model.head("visual").add("headlight", ambient=dark if ambient is None else ambient)
        headlight.attributes |= {"diffuse": "0 0 0", "specular": "0 0 0"}


def _write_light(model: MjcfModel, light: Light, row: int) -> None:
    unsupported, kind = model.unsupported, light.light
    if isinstance(kind, AreaLight):
        unsupported.leave_out(light.name, "an area light", light.origin)
        return
    pose = to_pose(light.pose.row(row))
    shadow = light.shadow
    if shadow is not None:
        unsupported.fields(light.name, shadow, _UNSUPPORTED_SHADOW_FIELDS, light.origin, " of a shadow")
    attributes: dict[str, Any] = {"type": "directional"}
    match kind:
        case DirectionalLight():
            pass
        case PointLight():
            attributes = {"type": "point", "attenuation": (0, 0, 1)}
        case SpotLight() | TexturedLight():
            attributes = {
                "type": "spot",
                "attenuation": (0, 0, 1),
                "cutoff": degrees(float(kind.outer_fov.row(row)) / 2),
            }
            if float(kind.inner_fov.row(row)) == float(kind.outer_fov.row(row)):
                attributes["exponent"] = 0  # uniform brightness; MuJoCo's default fades towards the edge
            else:
                unsupported.leave_out(light.name, "`inner_fov` of a light", light.origin)
    if isinstance(kind, TexturedLight):
        unsupported.change(light.name, "its texture is left out: it is written as a spot light", light.origin)
    _mount_element(model, light).add(
        "light",
        name=model.name("light", light.name),
        pos=pose[:3],
        dir=transform_direction(pose, (1.0, 0.0, 0.0)),
        castshadow=shadow is not None and bool(shadow.on.row(row)),
        ambient=(0, 0, 0),
        diffuse=light.color.row(row),
        specular=light.color.row(row),
        **attributes,
    )


def _write_cameras(model: MjcfModel) -> None:
    """Writes all cameras of the scene."""
    for camera in model.plan.cameras:
        if model.scene.index in camera.scene_idxs:
            _write_camera(model, camera, camera.scene_idxs.index(model.scene.index))


def _write_camera(model: MjcfModel, camera: Camera, row: int) -> None:
    if (float(camera.near.row(row)), float(camera.far.row(row))) != (_DEFAULT_NEAR, _DEFAULT_FAR):
        model.unsupported.leave_out(camera.name, "`near` and `far` of one camera", camera.origin)
    model.unsupported.fields(camera.name, camera, ("shader",), camera.origin)
    _mount_element(model, camera).add(
        "camera",
        name=model.name("camera", camera.name),
        **pose_attributes(compose(to_pose(camera.pose.row(row)), _CAMERA_TO_MUJOCO)),
        resolution=(camera.width, camera.height),
        **_projection(model, camera, row),
    )


def _projection(model: MjcfModel, camera: Camera, row: int) -> dict[str, Any]:
    """Returns the attributes of the projection: a field of view [degrees], or intrinsics [px] with a sensor size."""
    width, height, lens = camera.width, camera.height, camera.lens
    match lens:
        case Orthographic():
            return {"projection": "orthographic", "fovy": 2 * float(lens.top.row(row))}
        case Perspective(fovx=None, fovy=fovy) if fovy is not None:
            return {"fovy": degrees(float(fovy.row(row)))}
        case Perspective():
            assert lens.fovx is not None  # one of the two is given
            fx = width / 2 / tan(float(lens.fovx.row(row)) / 2)
            fy = fx if lens.fovy is None else height / 2 / tan(float(lens.fovy.row(row)) / 2)
            return _pixel_projection(width, height, fx, fy, (0.0, 0.0))
        case Intrinsic():
            fx, fy, cx, cy, skew = (float(getattr(lens, name).row(row)) for name in ("fx", "fy", "cx", "cy", "skew"))
            if skew:
                model.unsupported.leave_out(camera.name, "`skew` of a camera", camera.origin)
            # MuJoCo shifts the view: a positive number moves the principal point left, or up.
            return _pixel_projection(width, height, fx, fy, (width / 2 - cx, height / 2 - cy))


def _pixel_projection(width: int, height: int, fx: float, fy: float, middle: tuple[float, float]) -> dict[str, Any]:
    return {"sensorsize": (width / fy, height / fy), "focalpixel": (fx, fy), "principalpixel": middle}


def _mount_element(model: MjcfModel, mounted: Light | Camera) -> XmlElement:
    return model.world if mounted.mount is None else model.bodies[model.key(mounted.mount)].element
