"""Imports the bodies and robots of an MJCF, with time step, gravity, constraints, lights and cameras."""

from __future__ import annotations

import math
import os
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from scenecc.diagnostics.diagnostic import Location
from scenecc.geometry.rotations import Pose7, compose, from_matrix, relative_pose, rotate, to_vector
from scenecc.importers.imported_scene import ImportContext, ImportedScene, Loss, ReferencePose
from scenecc.importers.meshes import MeshError, load_mesh, mesh_as_obj
from scenecc.importers.numbers import LOOK, Names, starts_at_limits
from scenecc.importers.writer import write_world
from scenecc.robots.description import (
    IN_WORLD,
    DescribedCollision,
    DescribedConstraint,
    DescribedJoint,
    DescribedLink,
    DescribedRobot,
    LinkName,
    MeshGeometry,
)
from scenecc.robots.mujoco.equalities import WORLD_EQUALITY, built_frames
from scenecc.robots.mujoco.model import WELD_EQUALITY, WORLD
from scenecc.robots.mujoco.reader import ReadModel, read_model
from scenecc.robots.mujoco.worker import FLAGS
from scenecc.robots.rules import lost_resistance
from scenecc.robots.world import (
    DescribedCamera,
    DescribedEntity,
    DescribedLight,
    DescribedPhysics,
    DescribedWorld,
    RobotFile,
)

if TYPE_CHECKING:
    from scenecc.source.paths import ResolvedFile

_SLIDE: Final = 2
"""`mjJNT_SLIDE`; the only larger type is `mjJNT_HINGE`."""

_KINDS: Final = {
    "ball": "ball-joints",
    "ellipsoid": "ellipsoids",
    "tendon": "tendons",
    "pair": "contact-pairs",
    "spring": "joint-springs",
    "skin": "visuals",
    "contact": "contact-forces",
    "surface": "moving-surfaces",
    "friction": "surface-friction",
    "fluid": "fluids",
    "inertia": "assumed-masses",
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
    "extension": "plugins",
    "rest": "settings",
    "sensor": "sensors",
    "site": "sites",
    "softness": "softness",
    "custom": "settings",
    "visual": "settings",
    "statistic": "settings",
    "gravcomp": "gravity-shares",
    "flag": "switches",
    "camera": "settings",
    "light": "lights",
    "option": "settings",
}
"""Kind of a reader's finding, up to a slash → kind of loss."""

_BUILT: Final = frozenset({"camera", "light", "option"})
"""Findings of the reader about content that is imported here, unless the file is one model of several."""

_READ_OPTIONS: Final = frozenset({"timestep", "gravity", "density", "viscosity"})

_READ_FLAGS: Final = frozenset(each.lower() for each in (*FLAGS, "override"))
"""Attributes of <flag> that are read, or reported by the reader."""

_LIGHT_TYPES: Final[dict[int, Literal["spot", "directional", "point"]]] = {0: "spot", 1: "directional", 2: "point"}
"""`mjtLightType`; the fourth is an environment image."""

_FIXED: Final = 0
"""`mjCAMLIGHT_FIXED`."""

_AIMED: Final = (3, 4)
"""`mjCAMLIGHT_TARGETBODY` and `mjCAMLIGHT_TARGETBODYCOM`: it looks at a body, here at where this one starts."""

MJCF_LOSS_CODES: Final = frozenset({"SC484", "SC490", "SC580"})
"""Codes of findings about an MJCF that its losses cover."""


def import_mjcf(path: Path, context: ImportContext) -> ImportedScene | None:
    """Returns the scene of an MJCF; None after an error."""
    importer = _open(path, context, is_model=False)
    return None if importer is None else importer.scene()


def read_mjcf_model(path: Path, context: ImportContext) -> tuple[RobotFile, tuple[Loss, ...]] | None:
    """Returns an MJCF that is one model of several, as a file, and its losses; None after an error.

    Its constraints to the world, settings, lights and cameras are losses.
    """
    importer = _open(path, replace(context, keep_file=True), is_model=True)
    return None if importer is None else (importer.robot_file(), importer.losses())


def _open(path: Path, context: ImportContext, *, is_model: bool) -> _Importer | None:
    found = context.resolve(path)
    if found is None:
        return None
    read = read_model(found, scope=context.scope, sink=context.sink.another(), limits=context.limits)
    if read is None:
        read_model(found, scope=context.scope, sink=context.sink, limits=context.limits)
        return None
    return _Importer(path, found, read, context, is_model=is_model)


_MATERIAL_LINE: Final = re.compile(rb"^[ \t]*(?:mtllib|usemtl)\b.*$", re.MULTILINE)

_ADDED_ROOT: Final = "base"
"""Name of the root that is added to a robot whose first body has joints."""

_FRICTION: Final = (1.0, 1.0, 0.0)
"""MuJoCo's default sliding friction of a geom, as static and dynamic friction, and restitution.

Its attribute `friction` defaults to "1 0.005 0.0001" (XML reference).
"""


class _Importer:
    def __init__(
        self, path: Path, file: ResolvedFile, read: ReadModel, context: ImportContext, *, is_model: bool
    ) -> None:
        self._path = path
        self._file = file
        self._context = context
        self._model = read.model
        self._links = read.links
        self._called: dict[LinkName, LinkName] = {}
        self._name = Names().new(path.stem)
        to_world = {place for kind, _, place in read.losses if kind == WORLD_EQUALITY and not is_model}
        self._constraints = self._world_constraints(to_world)
        built = {constraint.location for constraint in self._constraints}
        losses = [(kind.partition("/")[0], words, place) for kind, words, place in read.losses if place not in built]
        built_here = frozenset[str]() if is_model else _BUILT
        self._losses = [Loss(_KINDS[kind], words, place) for kind, words, place in losses if kind not in built_here]
        self._losses += [
            Loss("joint-friction", words, joint.location)
            for joint in (link.joint for robot in read.description.robots for link in robot.links)
            if joint is not None and (words := lost_resistance(joint))
        ]
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
        self._keyframe = self._find_keyframe()
        self._description = read.description
        if self._keyframe and not context.keep_file:
            again = read_model(
                file,
                scope=context.scope,
                sink=context.sink.another(),
                limits=context.limits,
                keyframe=(self._keyframe, None),
            )
            self._description = read.description if again is None else again.description

    def scene(self) -> ImportedScene:
        """Returns the scene."""
        header = self._model.header
        gravity = (0.0, 0.0, 0.0) if "GRAVITY" in header["disabled"] else to_vector(header["option"]["gravity"])
        keeps = self._context.keep_file
        entities = self._kept_file() if keeps else tuple(map(self._entity, self._description.robots))
        constraints = (
            *(() if keeps else map(self._between_entities, self._description.constraints)),
            *self._constraints,
        )
        world = DescribedWorld(
            self._name,
            entities,
            DescribedPhysics(header["option"]["timestep"], gravity, None if keeps else _FRICTION),
            tuple(map(self._renamed, constraints)),
            self._lights(),
            self._cameras(),
            ambient=to_vector(header["ambient"]),
        )
        written = write_world(world)
        self._losses += written.lost_filters(Location(str(self._path)))
        return ImportedScene(
            written.document,
            self.losses(),
            written.bodies,
            self._reference(),
            engine="MuJoCo",
            places={} if keeps else written.places,
            codes_of_losses=MJCF_LOSS_CODES | {"SC494"},
        )

    def losses(self) -> tuple[Loss, ...]:
        """Returns what is lost so far. Places in included files, relative to the scope's root, become user's paths."""
        root = self._context.scope.root or Path.cwd()
        base = root if self._path.is_absolute() else Path(os.path.relpath(root))
        return tuple(
            loss
            if loss.place.file == str(self._path)
            else replace(loss, place=replace(loss.place, file=str(base / (loss.place.file or ""))))
            for loss in self._losses
        )

    def robot_file(self) -> RobotFile:
        """Returns the MJCF as a file that the scene names."""
        keys: dict[str, Any] = {"keyframe": self._keyframe} if self._keyframe else {}
        keys = keys or starts_at_limits(self._description.robots)
        return RobotFile("mjcf", self._file.path, keys=tuple(keys.items()), robots=self._description.robots)

    def _kept_file(self) -> tuple[DescribedEntity, ...]:
        for robot in self._description.robots:
            self._called |= {(robot.links[0].name, link.name): (self._name, link.name) for link in robot.links}
        return (DescribedEntity(self._name, self.robot_file(), Location(str(self._path))),)

    def _entity(self, robot: DescribedRobot) -> DescribedEntity:
        """Returns a robot or body as an entity.

        It has the name of its first body, not of an added link. A prefix that all its names share (`PREFIX/`) becomes
        the entity's name.
        """
        root, *others = robot.links
        bodies = {self._model.body_name(body) for body in range(len(self._model["body_mass"]))}
        is_added = bool(others) and root.name not in bodies
        own = others if is_added else robot.links
        first = next((link.name for link in own if link.name in bodies), own[0].name)
        prefix, slash, _ = own[0].name.partition("/")
        shared = prefix + slash
        is_shared = bool(slash) and bool(others) and all(link.name.startswith(shared) for link in own)
        links: list[DescribedLink] = []
        for link in robot.links:
            name = link.name.removeprefix(shared) if is_shared else link.name
            name = _ADDED_ROOT if is_added and link is root else name
            self._called[root.name, link.name] = (root.name, name)
            shapes = [tuple(map(self._plain_mesh, each)) for each in (link.collisions, link.visuals)]
            made = replace(link, name=name, source=link.name, collisions=shapes[0], visuals=shapes[1])
            links.append(replace(made, joint=_without_prefix(link.joint, shared)) if is_shared and link.joint else made)
        wish = prefix if is_shared else first
        return DescribedEntity(root.name, replace(robot, links=tuple(links)), robot.location or root.location, wish)

    def _plain_mesh(self, shape: Any) -> Any:
        """Returns a shape whose mesh a scene can name: unmirrored if it collides, and without materials.

        MuJoCo ignores the materials of a mesh file, which may be missing.
        """
        mesh = shape.geometry
        if not isinstance(mesh, MeshGeometry) or mesh.data is not None:
            return shape
        is_mirrored = isinstance(shape, DescribedCollision) and min(mesh.scale) < 0
        data, scale = None, mesh.scale
        try:
            file = load_mesh(mesh.path, self._context)
            if is_mirrored:
                data, scale = mesh_as_obj(file, submesh="", scale=[*mesh.scale], center=False), (1.0, 1.0, 1.0)
            elif file.missing:
                data = _MATERIAL_LINE.sub(b"", file.content)
        except MeshError:  # reported when the scene is compiled
            return shape
        if data is None:
            return shape
        return replace(shape, geometry=replace(mesh, uri=f"{mesh.path.stem}.obj", data=data, scale=scale))

    def _between_entities(self, constraint: DescribedConstraint) -> DescribedConstraint:
        """Returns a constraint of the file with the world instead of a fixed root, and a child that moves."""
        parent, child = constraint.parent, constraint.child
        if parent == self._links.get(WORLD):
            return replace(constraint, parent=IN_WORLD)
        still = {robot.links[0].name for robot in self._description.robots if robot.body_type == "static"}
        if child[0] not in still:
            return constraint
        frames = {"pose_in_parent": constraint.pose_in_child, "pose_in_child": constraint.pose_in_parent}
        return replace(constraint, parent=child, child=parent, **frames)

    def _renamed(self, constraint: DescribedConstraint) -> DescribedConstraint:
        parent, child = (self._called.get(end, end) for end in (constraint.parent, constraint.child))
        return replace(constraint, parent=parent, child=child)

    def _find_keyframe(self) -> str:
        """Returns the keyframe that adds drive targets to the file's own initial positions; "" for none."""
        model, used = self._model, ""
        # Without a keyframe drives hold the initial positions; with one they go to its controls.
        starts = model["qpos0"][model["jnt_qposadr"][model["jnt_type"] >= _SLIDE]]
        is_found = False
        for number, qpos in enumerate(model["key_qpos"]):
            name, place = model.name("key", number), model.location("key", number)
            if not is_found and name and np.allclose(qpos, model["qpos0"], rtol=0, atol=1e-6):
                controls, is_found = model["key_ctrl"][number], True
                used = name if controls.any() or (controls.size and starts.any()) else ""
                if model["key_qvel"][number].any():
                    self._losses.append(Loss("saved-states", f"the velocities of the keyframe `{name}`", place))
            else:
                hint = f"; set `keyframe: {name}` to start there" if name and self._context.keep_file else ""
                self._losses.append(Loss("saved-states", f"the keyframe `{name}`{hint}", place))
        return used

    def _world_constraints(self, lost: set[Location]) -> tuple[DescribedConstraint, ...]:
        """Returns constraints between moving bodies and the world. `lost`: locations of these equalities."""
        model = self._model
        made: list[DescribedConstraint] = []
        for number, kind in enumerate(model["eq_type"].tolist()):
            place = model.location("eq", number)
            if place not in lost:
                continue
            ends = built_frames(model, number, kind, self._links)
            (first, in_world), (body, in_body) = ends if ends[0][0] == WORLD else ends[::-1]
            if first != WORLD or body not in self._links or not model["body_weldid"][body]:
                continue
            name = model.name("eq", number) or f"equality_{number}"
            word = "weld" if kind == WELD_EQUALITY else "connection"
            made.append(DescribedConstraint(name, word, IN_WORLD, self._links[body], in_world, in_body, place))
        return tuple(made)

    def _reference(self) -> dict[str, ReferencePose]:
        """Returns masses and body poses from MuJoCo's kinematics, with joints within their limits."""
        model = self._model
        return {
            model.body_name(body): ReferencePose(self._world_pose(body), float(model["body_mass"][body]) or None)
            for body in self._links
            if body != WORLD
        }

    def _world_pose(self, body: int) -> Pose7:
        return (*self._model["xpos"][body].tolist(), *self._model["xquat"][body].tolist())

    def _lights(self) -> tuple[DescribedLight, ...]:
        model = self._model
        made: list[DescribedLight] = []
        for number, kind in enumerate(model["light_type"].tolist()):
            place, label = model.location("light", number), model.name("light", number) or "light"
            if not model["light_active"][number]:
                continue
            if kind not in _LIGHT_TYPES:
                self._losses.append(Loss("lights", f"the environment image `{label}`", place))
                continue
            angle = math.radians(min(2 * float(model["light_cutoff"][number]), 179.0))
            local: Pose7 = (*model["light_pos"][number].tolist(), 1.0, 0.0, 0.0, 0.0)
            body = int(model["light_bodyid"][number])
            pose = compose(self._world_pose(body), local)
            if body != WORLD and body in self._links:
                self._losses.append(Loss("lights", f"the mount of the light `{label}`, which stays in place", place))
            if _LIGHT_TYPES[kind] != "directional":
                self._losses.append(Loss("light-falloff", f"the falloff of the light `{label}`", place))
            shines = rotate(self._world_pose(body)[3:], tuple(model["light_dir"][number].tolist()))
            if model["light_mode"][number] != _FIXED:
                self._losses.append(Loss("camera-modes", f"the tracking mode of the light `{label}`", place))
                shines = to_vector(model["light_xdir"][number].tolist())
            color, shadow = to_vector(model["light_diffuse"][number].tolist()), bool(model["light_castshadow"][number])
            made.append(
                DescribedLight(label, _LIGHT_TYPES[kind], color, pose[:3], shines, place, (angle, angle), shadow)
            )
        return tuple(made)

    def _cameras(self) -> tuple[DescribedCamera, ...]:
        model = self._model
        made: list[DescribedCamera] = []
        for number, body in enumerate(model["cam_bodyid"].tolist()):
            label, place = model.name("camera", number) or "camera", model.location("camera", number)
            if model["cam_mode"][number] != _FIXED:
                self._losses.append(Loss("camera-modes", f"the tracking mode of the camera `{label}`", place))
            own: Pose7 = (*model["cam_pos"][number].tolist(), *model["cam_quat"][number].tolist())
            pose, mount = compose(own, LOOK), self._links.get(body) if body != WORLD else None
            mount = mount and self._called.get(mount, mount)
            if model["cam_mode"][number] in _AIMED:
                q = from_matrix(model["cam_xmat"][number].reshape(3, 3).tolist())
                aimed = compose((*model["cam_xpos"][number].tolist(), *q), LOOK)
                pose = relative_pose(self._world_pose(body), aimed)
            if mount is None:
                pose = compose(self._world_pose(body), pose)
            width, height = model["cam_resolution"][number].tolist()
            size = (width, height) if width > 1 and height > 1 else None
            lens = ("fovy", math.radians(model["cam_fovy"][number]))
            made.append(DescribedCamera(label, pose, lens, place, size, mount=mount))
        return tuple(made)


def _without_prefix(joint: DescribedJoint, prefix: str) -> DescribedJoint:
    mimic = joint.mimic and replace(joint.mimic, source=joint.mimic.source.removeprefix(prefix))
    return replace(joint, name=joint.name.removeprefix(prefix), mimic=mimic)
