"""Converts SDF worlds and models to scenes. Versions 1.4 to 1.12."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Final

from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose, rotate
from scenecc.importers.imported_scene import ImportContext, ImportedScene, Loss
from scenecc.importers.numbers import Names, light_place, plain_number, plain_numbers, pose_key
from scenecc.importers.sdf_files import SMALLEST, SdfFile, SourceElement, find_element, read_sdf_file, text_of
from scenecc.importers.sdf_joints import SdfJoint, hinges_of, joint_type, make_constraint
from scenecc.importers.sdf_models import BuiltLink, Crossing, SceneParts, SdfModelReader, add_robot
from scenecc.importers.sdf_scopes import SEPARATOR, WORLD, Scope, ScopeReader
from scenecc.importers.urdf import UNREAL_INERTIAS

Node = dict[str, Any]

_CAMERAS: Final = frozenset(
    {"camera", "depth", "depth_camera", "rgbd_camera", "rgbd", "segmentation", "wideanglecamera", "boundingbox_camera"}
)

_IGNORED_BIT: Final = 1 << 29
"""Bit of the third collision integer: links with it do not collide if their fourth integers are equal."""

_MAX_MASKS: Final = 64
"""Maximum number of bitmasks to compare pairwise; with more, collision bits are always written."""

_FIRST_NUMBER: Final = 1000
"""First value for the fourth collision integer; those of other articulations start at 0."""

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
    reader = ScopeReader(file)
    world = reader.world(top)
    parts = SceneParts()
    for model in world.models.values():
        if model.robot is not None:
            add_robot(model, world.model_pose(model), model.name, parts)
            continue
        SdfModelReader(model, world.model_pose(model), parts).read()
        _report_losses(model)
    _apply_bitmasks(parts)
    for joint in (*parts.crossings, *(Crossing(world, joint, name) for name, joint in world.joints.items())):
        _connect(joint, parts)
    if not is_world and not world.models and not losses:
        file.error("there is nothing to import: the file has no world and no model", top)
    document = _document(path, file, world, parts, is_world=is_world)
    return ImportedScene(document, tuple(losses), parts.bodies, places=parts.locations, codes_of_losses=UNREAL_INERTIAS)


def _connect(crossing: Crossing, parts: SceneParts) -> None:
    """Makes a joint between two entities a constraint. One that fixes the root of a robot to the world is its key."""
    scope, element, name = crossing.scope, crossing.element, crossing.name
    kind, file = joint_type(element), scope.file
    ends: list[tuple[str, Pose7, bool]] = []
    paths: list[str] = []
    for tag in ("parent", "child"):
        word = text_of(element, tag)
        path = "" if word == WORLD else scope.link_of(word, element)
        if path is None:
            return
        paths.append(crossing.prefix + path if path else "")
        built = parts.links.get(paths[-1], BuiltLink(WORLD, IDENTITY_POSE, is_moved=False))
        ends.append((built.name or WORLD, built.pose if built.name else IDENTITY_POSE, built.is_moved))
    if not kind:
        file.lose("joints", f"the joint `{name}` of type `{element.attributes.get('type', '')}`", element)
        return
    if ends[0][0] == ends[1][0]:
        file.error(f"the joint `{name}` connects a body to itself", element)
        return
    fixed = parts.free_roots.get(next((path for path in paths if path), ""))
    if kind == "fixed" and "" in paths and fixed is not None:
        fixed.pop("fix_root_link", None)
        return
    pose = compose(crossing.turn, scope.pose_of(name, element))
    joint = SdfJoint(scope, element, name, kind, ends[0][0], ends[1][0], pose, crossing.turn)
    hinges = hinges_of(joint)
    if not ends[1][2]:
        ends.reverse()
    if ends[1][2]:
        made = make_constraint(joint, (ends[0][0], ends[1][0]), (ends[0][1], ends[1][1]), hinges)
        parts.constraints[parts.constraint_names.new(name)] = made


def _apply_bitmasks(parts: SceneParts) -> None:
    """Converts bitmasks to collision bits, if any two bodies have no bit in common."""
    masks = {one.mask for one in parts.bitmasks}
    if len(masks) <= _MAX_MASKS and all(a & b for a in masks for b in masks):
        return
    apart: dict[str, int] = {}
    for one in parts.bitmasks:
        entity = parts.entities[one.entity]
        if "collision_group" in entity:
            what = f"the bitmask of `{one.link.path}`; it collides with everything"
            one.link.scope.file.lose("collision-bitmasks", what, one.link.element, one.link.path)
            continue
        if entity.pop("disable_self_collisions", False):
            apart[one.entity] = _FIRST_NUMBER + len(apart)
        ignored = [_IGNORED_BIT, apart[one.entity]] if one.entity in apart else [0, 0]
        one.node["collision_bits"] = [one.mask, one.mask, *ignored]


def _document(path: Path, file: SdfFile, world: Scope, parts: SceneParts, *, is_world: bool) -> Node:
    element = world.element
    name = element.attributes.get("name") if is_world else next(iter(world.models), None)
    document: Node = {"scenecc": 1, "name": name or path.stem, "physics": _physics(file, element, is_world=is_world)}
    _lose_elements(element, file, "", skip={"model"})
    lights = _Rendering(parts)
    for light in element.all("light"):
        lights.add_light(light, file, world.placed(light, world.base), None, light.attributes.get("name", "light"))
    for path_, (link, _place) in parts.places.items():
        lights.add_link(path_, link)
    ambient = find_element(element, "scene", "ambient")
    if ambient is not None:
        color = file.numbers(ambient, len(ambient.text.split()) if len(ambient.text.split()) in {3, 4} else 4)
        if color is not None:
            document["environment"] = {"ambient_light": plain_numbers([max(each, 0.0) for each in color[:3]])}
    sections = {
        "collision_groups": parts.groups,
        "entities": parts.entities,
        "constraints": parts.constraints,
        "lights": lights.lights,
        "cameras": lights.cameras,
    }
    return {**document, **{key: value for key, value in sections.items() if value}}


def _physics(file: SdfFile, world: SourceElement, *, is_world: bool) -> Node:
    """Returns the physics section. SDF defaults: friction 1, restitution 0."""
    material = {"static_friction": 1, "dynamic_friction": 1, "restitution": 0}
    if not is_world:
        return {"default_material": material}
    physics: Node = {}
    element = next((each for each in world.all("physics") if each.attributes.get("default") in {"true", "1"}), None)
    element = element or world.find("physics")
    if element is not None and element.find("max_step_size") is not None:
        physics["timestep"] = plain_number(file.positive(element, "max_step_size", default=0.001))
    gravity = find_element(world, "gravity") or find_element(element, "gravity")
    physics["gravity"] = plain_numbers(file.numbers(gravity, 3) or (0, 0, -9.8))
    return {**physics, "default_material": material}


def _report_losses(model: Scope) -> None:
    """Reports the content of a model that the scene does not use."""
    _lose_elements(model.element, model.file, model.name, skip={"model", "link", "joint"})
    for name, link in model.links.items():
        _lose_elements(link, model.file, f"{model.name}{SEPARATOR}{name}", skip={"visual", "collision"})
        for shape in (*link.all("visual"), *link.all("collision")):
            _lose_elements(shape, model.file, f"{model.name}{SEPARATOR}{name}", skip=set())
    for joint in model.joints.values():
        _lose_elements(joint, model.file, model.name, skip=set())
    for inner in model.models.values():
        _report_losses(inner)


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


class _Rendering:
    def __init__(self, parts: SceneParts) -> None:
        self.lights: Node = {}
        self.cameras: Node = {}
        self._parts = parts
        self._names = Names()

    def add_link(self, path: str, link: SourceElement) -> None:
        """Adds lights and cameras of a link; in the world frame if the link is not built."""
        place, built = self._parts.places[path][1], self._parts.links[path]
        file, mount = place.scope.file, built.name or None
        for element in (*link.all("light"), *link.all("sensor")):
            word = element.attributes.get("name", element.tag)
            name = f"{path}{SEPARATOR}{word}"
            pose = element.find("pose")
            if pose is not None and not place.scope.knows(pose.attributes.get("relative_to", "")):
                file.lose(f"{element.tag}s", f"<{element.tag}> `{name}` is relative to an unknown frame", element)
                continue
            local = place.local(element)
            if element.tag == "light":
                self.add_light(element, file, local if mount else compose(built.pose, local), mount, name)
            elif element.attributes.get("type", "") in _CAMERAS:
                camera = element.find("camera")
                if camera is not None:
                    local = compose(local, file.pose(camera))
                    self._add_camera(camera, file, local if mount else compose(built.pose, local), mount, name)

    def add_light(self, element: SourceElement, file: SdfFile, pose: Pose7, mount: str | None, name: str) -> None:
        """Adds a light. SDF's lights shine along `direction`, by default -z."""
        kind = element.attributes.get("type", "point")
        if kind not in {"point", "directional", "spot"}:
            file.lose("lights", f"the light `{name}` of type `{kind}`", element)
            return
        diffuse = element.find("diffuse")
        color = None if diffuse is None else file.numbers(diffuse, min(max(len(diffuse.text.split()), 3), 4))
        intensity = max(file.number(element, "intensity", default=1), 0.0)
        light: Node = {
            "type": kind,
            "color": plain_numbers([max(each, 0) * intensity for each in (color or (1, 1, 1))[:3]]),
        }
        aim = file.vector(element, "direction", default=(0, 0, -1))
        direction = rotate(pose[3:], aim if math.hypot(*aim) >= SMALLEST else (0.0, 0.0, -1.0))
        light |= light_place(kind, pose[:3], direction)
        if kind == "spot":
            inner = file.number(element, "spot", "inner_angle", default=0.6)
            outer = file.number(element, "spot", "outer_angle", default=1.0)
            outer = min(max(outer, 0.02), math.pi - 0.01)
            light |= {"inner_fov": plain_number(min(max(inner, 0.01), outer)), "outer_fov": plain_number(outer)}
        if file.flag(element, "cast_shadows", default=False):
            light["shadow"] = True
        if find_element(element, "attenuation") is not None and kind != "directional":
            file.lose(
                "light-falloff",
                f"<attenuation> of `{name}`; SAPIEN's lights fall off with the squared distance",
                element,
            )
        self.lights[self._names.new(name)] = {**light, **({"mount": mount} if mount else {})}

    def _add_camera(self, camera: SourceElement, file: SdfFile, pose: Pose7, mount: str | None, name: str) -> None:
        width, height = (
            int(file.number(camera, "image", tag, default=320 - 80 * i)) for i, tag in enumerate(("width", "height"))
        )
        fov = file.number(camera, "horizontal_fov", default=1.047)
        if not (0 < fov < math.pi and 0 < width <= 16384 and 0 < height <= 16384):
            file.lose(
                "sensors",
                f"the camera `{name}` with a field of view of {fov:g} rad and {width} by {height} pixels",
                camera,
            )
            return
        near, far = (file.number(camera, "clip", tag, default=value) for tag, value in (("near", 0.1), ("far", 100)))
        made: Node = {"width": width, "height": height, "fovx": plain_number(fov)}
        if 0 < near < far < math.inf:
            made |= {"near": plain_number(near), "far": plain_number(far)}
        made |= pose_key(pose)
        self.cameras[self._names.new(name)] = {**made, **({"mount": mount} if mount else {})}
