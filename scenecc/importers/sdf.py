"""Converts SDF worlds and models to scenes. Versions 1.4 to 1.12."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose, rotate, to_vector
from scenecc.importers.imported_scene import ImportContext, ImportedScene, Loss
from scenecc.importers.sdf_files import SMALLEST, SdfFile, SourceElement, find_element, read_sdf_file
from scenecc.importers.sdf_joints import read_sdf_joint
from scenecc.importers.sdf_models import BuiltLink, SdfModelReader, WorldParts, add_robot
from scenecc.importers.sdf_scopes import SEPARATOR, Scope, ScopeReader
from scenecc.importers.sdf_shapes import FRICTION, SdfLink
from scenecc.importers.urdf import URDF_LOSS_CODES
from scenecc.importers.writer import write_world
from scenecc.robots.description import IN_WORLD, LinkName
from scenecc.robots.world import DescribedCamera, DescribedLight, DescribedPhysics, DescribedWorld

_CAMERAS: Final = frozenset(
    {"camera", "depth", "depth_camera", "rgbd_camera", "rgbd", "segmentation", "wideanglecamera", "boundingbox_camera"}
)

_LOST: Final = {
    "plugin": "plugins",
    "sensor": "sensors",
    "actor": "actors",
    "road": "roads",
    "population": "populations",
    "state": "saved-states",
    "drake:joint": "drake-elements",
    "drake:linear_bushing_rpy": "drake-elements",
    "drake:collision_filter_group": "drake-elements",
    "wind": "wind",
    "particle_emitter": "particles",
    "projector": "projectors",
    "audio_source": "sounds",
    "gui": "settings",
    "spherical_coordinates": "settings",
    "sky": "settings",
    "fog": "settings",
    "gripper": "grippers",
    "fluid_added_mass": "fluids",
}
"""Tag → kind of loss."""


def import_sdf(path: Path, context: ImportContext) -> ImportedScene | None:
    """Reads the scene of an SDF file, its first world if there are several; returns None after an error."""
    losses: list[Loss] = []
    found = read_sdf_file(path, context, losses)
    if found is None:
        return None
    file, root = found
    worlds = list(root.all("world"))
    top = worlds[0] if worlds else root
    for other in worlds[1:]:
        file.lose("worlds", f"the world `{other.attributes.get('name', '')}`; only the first is read", other)
    try:
        return _build(path, file, top, is_world=bool(worlds))
    except RecursionError:
        file.error("the chain of frames or links is too long", top)
        return None


def _build(path: Path, file: SdfFile, top: SourceElement, *, is_world: bool) -> ImportedScene:
    losses = file.losses
    world = ScopeReader(file).world(top)
    parts = WorldParts()
    for model in world.models.values():
        if model.robot is not None:
            add_robot(model, world.model_pose(model), model.name, parts)
            continue
        SdfModelReader(model, world.model_pose(model), parts).read()
        report_model_losses(model)
    joints = (read_sdf_joint(world, element, name, ("", ""), IDENTITY_POSE) for name, element in world.joints.items())
    for joint in (*parts.loose, *joints):
        if joint is not None:
            parts.connect(joint)
    if not is_world and not world.models and not losses:
        file.error("there is nothing to import: the file has no world and no model", top)
    written = write_world(_describe(path, world, parts, is_world=is_world))
    losses += written.lost_filters(top.location)
    content = written.document, tuple(losses), written.bodies
    return ImportedScene(*content, places=written.places, codes_of_losses=URDF_LOSS_CODES)


def _describe(path: Path, world: Scope, parts: WorldParts, *, is_world: bool) -> DescribedWorld:
    element, file = world.element, world.file
    name = element.attributes.get("name") if is_world else next(iter(world.models), None)
    _lose_elements(element, file, "", skip={"model"})
    views = SdfViews()
    for light in element.all("light"):
        views.add_light(light, file, world.placed(light, world.base), None, light.attributes.get("name", "light"))
    for full, built in parts.links.items():
        if built.link is not None:
            views.add_link(full, built, built.link)
    ambient = find_element(element, "scene", "ambient")
    color = None
    if ambient is not None:
        color = file.numbers(ambient, len(ambient.text.split()) if len(ambient.text.split()) in {3, 4} else 4)
    return DescribedWorld(
        name or path.stem,
        tuple(parts.entities),
        _physics(file, element) if is_world else DescribedPhysics(friction=FRICTION),
        tuple(parts.constraints),
        tuple(views.lights),
        tuple(views.cameras),
        ambient=None if color is None else to_vector(max(each, 0.0) for each in color[:3]),
    )


def _physics(file: SdfFile, world: SourceElement) -> DescribedPhysics:
    element = next((each for each in world.all("physics") if each.attributes.get("default") in {"true", "1"}), None)
    element = element or world.find("physics")
    step = None
    if element is not None and element.find("max_step_size") is not None:
        step = file.positive(element, "max_step_size", default=0.001)
    gravity = find_element(world, "gravity") or find_element(element, "gravity")
    return DescribedPhysics(step, to_vector(file.numbers(gravity, 3) or (0, 0, -9.8)), FRICTION)


def report_model_losses(model: Scope) -> None:
    """Reports the content of a model that the scene does not use."""
    _lose_elements(model.element, model.file, model.name, skip={"model", "link", "joint"})
    for name, link in model.links.items():
        _lose_elements(link, model.file, f"{model.name}{SEPARATOR}{name}", skip={"visual", "collision"})
        for shape in (*link.all("visual"), *link.all("collision")):
            _lose_elements(shape, model.file, f"{model.name}{SEPARATOR}{name}", skip=set())
    for joint in model.joints.values():
        _lose_elements(joint, model.file, model.name, skip=set())
    for inner in model.models.values():
        report_model_losses(inner)


def _lose_elements(element: SourceElement, file: SdfFile, path: str, *, skip: set[str]) -> None:
    for child in element.children:
        if child.tag in skip:
            continue
        kind = _LOST.get(child.tag)
        word = child.attributes.get("type") or child.attributes.get("filename") or child.attributes.get("name") or ""
        if child.tag == "sensor" and word in _CAMERAS and element.tag == "link":
            continue
        if child.tag == "scene":
            _lose_elements(child, file, path, skip=set())
        elif child.tag == "wind" and not any(file.vector(child, "linear_velocity", default=(0, 0, 0))):
            continue
        elif kind is not None:
            file.lose(
                kind, f"<{child.tag}>{f' `{word}`' if word else ''}{f' of `{path}`' if path else ''}", child, path
            )


@dataclass(slots=True)
class SdfViews:
    """Collects the lights and cameras of a world."""

    lights: list[DescribedLight] = field(default_factory=list[DescribedLight])
    cameras: list[DescribedCamera] = field(default_factory=list[DescribedCamera])

    def add_link(self, path: str, built: BuiltLink, link: SdfLink) -> None:
        """Adds lights and cameras of a link; in the world frame if the link is not built."""
        file, mount = link.scope.file, None if built.name == IN_WORLD else built.name
        for element in (*link.element.all("light"), *link.element.all("sensor")):
            name = f"{path}{SEPARATOR}{element.attributes.get('name', element.tag)}"
            pose = element.find("pose")
            if pose is not None and not link.scope.knows(pose.attributes.get("relative_to", "")):
                file.lose(f"{element.tag}s", f"<{element.tag}> `{name}` is relative to an unknown frame", element)
                continue
            local = link.local(element)
            local = local if mount else compose(built.pose, local)
            camera = element.find("camera")
            if element.tag == "light":
                self.add_light(element, file, local, mount, name)
            elif element.attributes.get("type", "") in _CAMERAS and camera is not None:
                self._add_camera(camera, file, compose(local, file.pose(camera)), mount, name)

    def add_light(self, element: SourceElement, file: SdfFile, pose: Pose7, mount: LinkName | None, name: str) -> None:
        """Adds a light. SDF's lights shine along `direction`, by default -z."""
        kind = element.attributes.get("type", "point")
        if kind != "point" and kind != "directional" and kind != "spot":  # noqa: PLR1714 - narrows the type
            file.lose("lights", f"the light `{name}` of type `{kind}`", element)
            return
        diffuse = element.find("diffuse")
        color = None if diffuse is None else file.numbers(diffuse, min(max(len(diffuse.text.split()), 3), 4))
        intensity = max(file.number(element, "intensity", default=1), 0.0)
        aim = file.vector(element, "direction", default=(0, 0, -1))
        cone = None
        if kind == "spot":
            outer = min(max(file.number(element, "spot", "outer_angle", default=1.0), 0.02), math.pi - 0.01)
            cone = min(max(file.number(element, "spot", "inner_angle", default=0.6), 0.01), outer), outer
        if find_element(element, "attenuation") is not None and kind != "directional":
            words = f"<attenuation> of `{name}`; SAPIEN's lights fall off with the squared distance"
            file.lose("light-falloff", words, element)
        light = DescribedLight(
            name,
            kind,
            to_vector(max(each, 0) * intensity for each in (color or (1, 1, 1))[:3]),
            pose[:3],
            rotate(pose[3:], aim if math.hypot(*aim) >= SMALLEST else (0.0, 0.0, -1.0)),
            element.location,
            cone,
            file.flag(element, "cast_shadows", default=False),
            mount,
        )
        self.lights.append(light)

    def _add_camera(self, camera: SourceElement, file: SdfFile, pose: Pose7, mount: LinkName | None, name: str) -> None:
        width, height = (
            int(file.number(camera, "image", tag, default=320 - 80 * i)) for i, tag in enumerate(("width", "height"))
        )
        fov = file.number(camera, "horizontal_fov", default=1.047)
        if not (0 < fov < math.pi and 0 < width <= 16384 and 0 < height <= 16384):
            words = f"the camera `{name}` with a field of view of {fov:g} rad and {width} by {height} pixels"
            file.lose("sensors", words, camera)
            return
        near, far = (file.number(camera, "clip", tag, default=value) for tag, value in (("near", 0.1), ("far", 100)))
        clip = (near, far) if 0 < near < far < math.inf else None
        place = camera.location
        self.cameras.append(DescribedCamera(name, pose, ("fovx", fov), place, (width, height), clip, mount))
