"""Imports an MJCF as an entity that refers to the file, with time step, gravity, lights and cameras."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.geometry.rotations import Pose7, compose, rotate
from scenecc.importers.imported_scene import Asset, ImportContext, ImportedScene, Loss, ReferencePose
from scenecc.importers.numbers import LOOK, Names, light_place, plain_number, plain_numbers, plain_pose
from scenecc.robots.mujoco.equalities import WORLD_EQUALITY, equality_frames
from scenecc.robots.mujoco.model import WELD_EQUALITY, WORLD
from scenecc.robots.mujoco.reader import ReadModel, read_model
from scenecc.robots.mujoco.worker import FLAGS

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Location

_SLIDE: Final = 2
"""`mjJNT_SLIDE`; the only larger type is `mjJNT_HINGE`."""

_KINDS: Final = {
    "ball": "ball-joints",
    "ellipsoid": "ellipsoids",
    "frictionloss": "joint-friction",
    "tendon": "tendons",
    "pair": "contact-pairs",
    "spring": "joint-springs",
    "skin": "visuals",
    "contact": "contact-forces",
    "surface": "moving-surfaces",
    "friction": "surface-friction",
    "fluid": "fluids",
    "mocap": "kinematic-links",
    "hull": "hulls",
    "sleep": "settings",
    "look": "material-looks",
    "texture": "material-looks",
    "equality": "loops",
    "coupling": "joint-couplings",
    "parent": "parent-contacts",
    "inactive": "inactive-equalities",
    "actuator": "actuators",
    "sensor": "sensors",
    "site": "sites",
    "softness": "softness",
    "custom": "settings",
    "visual": "settings",
    "statistic": "settings",
    "gravcomp": "gravity-shares",
    "flag": "switches",
}
"""Kind of a reader's finding, up to a slash → kind of loss."""

_BUILT: Final = frozenset({"camera", "light", "option"})
"""Findings of the reader about content that is imported here."""

_READ_OPTIONS: Final = frozenset({"timestep", "gravity", "density", "viscosity"})

_READ_FLAGS: Final = frozenset(each.lower() for each in (*FLAGS, "override"))
"""Attributes of <flag> that are read, or reported by the reader."""

_LIGHT_TYPES: Final = {0: "spot", 1: "directional", 2: "point"}
"""`mjtLightType`; the fourth is an environment image."""

_FIXED: Final = 0
"""`mjCAMLIGHT_FIXED`."""


def import_mjcf(path: Path, context: ImportContext) -> ImportedScene | None:
    """Returns the scene of an MJCF; None after an error."""
    found = context.resolve(path)
    if found is None:
        return None
    trial = context.sink.another()
    read = read_model(found, scope=context.scope, sink=trial, limits=context.limits)
    if read is None:
        read_model(found, scope=context.scope, sink=context.sink, limits=context.limits)
        return None
    made = _Importer(path, read).scene()
    # Paths of included files are relative to the root of the scope.
    root = context.scope.root or Path.cwd()
    base = root if path.is_absolute() else Path(os.path.relpath(root))
    places = [loss.place for loss in made.losses]
    shown = [
        place if place.file == str(path) else replace(place, file=str(base / (place.file or ""))) for place in places
    ]
    losses = tuple(replace(loss, place=place) for loss, place in zip(made.losses, shown, strict=True))
    return replace(made, losses=losses)


class _Importer:
    def __init__(self, path: Path, read: ReadModel) -> None:
        self._path = path
        self._model = read.model
        self._robots = read.description.robots
        self._links = read.links
        self._name = Names().new(path.stem)
        self._constraints = self._world_constraints({place for kind, _, place in read.losses if kind == WORLD_EQUALITY})
        built = {place for place, _ in self._constraints}
        losses = [(kind.partition("/")[0], words, place) for kind, words, place in read.losses if place not in built]
        self._losses = [Loss(_KINDS[kind], message, place) for kind, message, place in losses if kind not in _BUILT]
        for element in self._model.source.elements:
            if element.tag == "option":
                unread = [f"`{name}`" for name in element.attributes if name not in _READ_OPTIONS]
                self._losses += [Loss("settings", f"{name} of <option>", element.location) for name in unread]
                flags = [(name, child) for child in element.children for name in child.attributes]
                self._losses += [
                    Loss("settings", f"`{name}` of <{child.tag}>", child.location)
                    for name, child in flags
                    if name not in _READ_FLAGS
                ]

    def scene(self) -> ImportedScene:
        """Returns the scene."""
        header = self._model.header
        gravity = [0.0, 0.0, 0.0] if "GRAVITY" in header["disabled"] else header["option"]["gravity"]
        document: dict[str, Any] = {
            "scenecc": 1,
            "name": self._name,
            "physics": {"timestep": plain_number(header["option"]["timestep"]), "gravity": plain_numbers(gravity)},
            "entities": {self._name: {"mjcf": Asset(self._path.name, self._path.absolute()), **self._keyframe()}},
        }
        if self._constraints:
            names = Names()
            document["constraints"] = {names.new(keys.pop("name")): keys for _, keys in self._constraints}
        if any(header["ambient"]):
            document["environment"] = {"ambient_light": plain_numbers(header["ambient"])}
        sections = {"lights": self._lights(), "cameras": self._cameras()}
        document |= {section: made for section, made in sections.items() if made}
        bodies = {self._mount(body): self._model.body_name(body) for body in self._links if body != WORLD}
        return ImportedScene(
            document,
            tuple(self._losses),
            bodies,
            self._reference(),
            engine="MuJoCo",
            codes_of_losses=frozenset({"SC484", "SC490"}),
        )

    def _keyframe(self) -> dict[str, str]:
        """Returns the key `keyframe`, if one adds drive targets to the file's own initial positions."""
        model, used = self._model, dict[str, str]()
        # Without a keyframe drives hold the initial positions; with one they go to its controls.
        starts = model["qpos0"][model["jnt_qposadr"][model["jnt_type"] >= _SLIDE]]
        for number, qpos in enumerate(model["key_qpos"]):
            name, place = model.name("key", number), model.location("key", number)
            if not used and name and np.allclose(qpos, model["qpos0"], rtol=0, atol=1e-6):
                controls = model["key_ctrl"][number]
                used = {"keyframe": name} if controls.any() or (controls.size and starts.any()) else {}
                if model["key_qvel"][number].any():
                    self._losses.append(Loss("saved-states", f"the velocities of the keyframe `{name}`", place))
            else:
                hint = f"; set `keyframe: {name}` to start there" if name else ""
                self._losses.append(Loss("saved-states", f"the keyframe `{name}`{hint}", place))
        return used

    def _world_constraints(self, lost: set[Location]) -> list[tuple[Location, dict[str, Any]]]:
        """Returns constraints between moving bodies and the world. `lost`: locations of these equalities."""
        model = self._model
        made: list[tuple[Location, dict[str, Any]]] = []
        for number, kind in enumerate(model["eq_type"].tolist()):
            if model.location("eq", number) not in lost:
                continue
            ends = equality_frames(model, number, kind)
            (first, in_world), (body, in_body) = ends if ends[0][0] == WORLD else ends[::-1]
            if first != WORLD or body not in self._links or not model["body_weldid"][body]:
                continue
            keys: dict[str, Any] = {
                "name": model.name("eq", number) or f"equality_{number}",
                "type": "weld" if kind == WELD_EQUALITY else "connection",
                "parent": "world",
                "child": self._mount(body),
                "pose_in_parent": plain_pose(in_world),
                "pose_in_child": plain_pose(in_body),
            }
            made.append((model.location("eq", number), keys))
        return made

    def _reference(self) -> dict[str, ReferencePose]:
        """Returns masses and body poses from MuJoCo's kinematics, with joints within their limits."""
        model = self._model
        return {
            model.body_name(body): ReferencePose(self._world_pose(body), float(model["body_mass"][body]) or None)
            for body in self._links
            if body != WORLD
        }

    def _mount(self, body: int) -> str:
        root, link = self._links[body]
        entity = self._name if len(self._robots) == 1 else f"{self._name}/{root}"
        robot = next(robot for robot in self._robots if robot.links[0].name == root)
        return entity if robot.body_type is not None else f"{entity}/{link}"

    def _world_pose(self, body: int) -> Pose7:
        return (*self._model["xpos"][body].tolist(), *self._model["xquat"][body].tolist())

    def _mount_and_pose(self, body: int, local: Pose7) -> tuple[dict[str, Any], Pose7]:
        """Returns the key `mount` if something moves with a body, and its pose there or in the world."""
        if body != WORLD and body in self._links:
            return {"mount": self._mount(body)}, local
        return {}, compose(self._world_pose(body), local)

    def _lights(self) -> dict[str, Any]:
        model, names = self._model, Names()
        made: dict[str, Any] = {}
        for number, kind in enumerate(model["light_type"].tolist()):
            place, label = model.location("light", number), model.name("light", number) or "light"
            if not model["light_active"][number]:
                continue
            if kind not in _LIGHT_TYPES:
                self._losses.append(Loss("lights", f"the environment image `{label}`", place))
                continue
            keys: dict[str, Any] = {
                "type": _LIGHT_TYPES[kind],
                "color": plain_numbers(model["light_diffuse"][number].tolist()),
            }
            if keys["type"] == "spot":
                angle = min(2 * float(model["light_cutoff"][number]), 179.0)
                keys |= {"inner_fov_deg": plain_number(angle), "outer_fov_deg": plain_number(angle)}
            if model["light_castshadow"][number]:
                keys["shadow"] = True
            local: Pose7 = (*model["light_pos"][number].tolist(), 1.0, 0.0, 0.0, 0.0)
            direction = model["light_dir"][number].tolist()
            body = int(model["light_bodyid"][number])
            pose = compose(self._world_pose(body), local)
            if body != WORLD and body in self._links:
                self._losses.append(Loss("lights", f"the mount of the light `{label}`, which stays in place", place))
            if keys["type"] != "directional":
                self._losses.append(Loss("light-falloff", f"the falloff of the light `{label}`", place))
            shines = rotate(self._world_pose(body)[3:], tuple(direction))
            made[names.new(label)] = {**keys, **light_place(keys["type"], pose[:3], shines)}
        return made

    def _cameras(self) -> dict[str, Any]:
        model, names = self._model, Names()
        made: dict[str, Any] = {}
        for number, body in enumerate(model["cam_bodyid"].tolist()):
            label = model.name("camera", number) or "camera"
            if model["cam_mode"][number] != _FIXED:
                words = f"the tracking mode of the camera `{label}`"
                self._losses.append(Loss("camera-modes", words, model.location("camera", number)))
            own: Pose7 = (*model["cam_pos"][number].tolist(), *model["cam_quat"][number].tolist())
            mount, pose = self._mount_and_pose(body, compose(own, LOOK))
            keys: dict[str, Any] = {
                **mount,
                "pose": plain_pose(pose),
                "fovy_deg": plain_number(model["cam_fovy"][number]),
            }
            width, height = model["cam_resolution"][number].tolist()
            if width > 1 and height > 1:
                keys |= {"width": width, "height": height}
            made[names.new(label)] = keys
        return made
