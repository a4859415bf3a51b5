"""Models that Drake's directives add: read by the readers of their formats, then moved, fixed and posed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import (
    IDENTITY,
    IDENTITY_POSE,
    Pose7,
    compose,
    from_axis_angle,
    from_rpy,
    invert,
    to_vector,
)
from scenecc.importers.imported_scene import ImportContext, Loss
from scenecc.importers.meshes import MeshError, load_mesh
from scenecc.importers.mjcf import import_mjcf
from scenecc.importers.numbers import plain_number, starts_at_limits
from scenecc.importers.sdf import report_model_losses
from scenecc.importers.sdf_files import SdfFile, find_file, find_included_model
from scenecc.importers.sdf_models import SdfModelReader, WorldParts, add_robot
from scenecc.importers.sdf_scopes import SEPARATOR, Scope, ScopeReader
from scenecc.importers.sdf_shapes import FRICTION
from scenecc.robots.description import (
    IN_WORLD,
    DescribedCollision,
    DescribedInertial,
    DescribedJoint,
    DescribedLink,
    DescribedRobot,
    DescribedVisual,
    LinkName,
    MeshGeometry,
)
from scenecc.robots.files import FileReport, read_robot_bytes
from scenecc.robots.mujoco.reader import read_mjcf
from scenecc.robots.rules import default_position
from scenecc.robots.world import DescribedEntity, RobotFile
from scenecc.robots.xml import XmlBounds, element_at, parse_number, parse_xml
from scenecc.source.paths import Refusal, resolve_path

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.importers.yaml_values import YamlValue

_MESHES: Final = (".obj", ".gltf", ".glb", ".vtk")

_MAX_FRAME: Final = 1e6
"""Largest coordinate of a frame of a URDF [m]."""

_WATER: Final = 1000.0
"""Density that Drake gives a mesh that is a model [kg/m³]."""


@dataclass(frozen=True, slots=True)
class DmdModel:
    """A model that was read.

    Attributes:
        name: with its namespaces.
        reader: that read it.
        scope: names of an SDF or URDF; None for other files.
        links: link → its name in the world, of other files.
        frames: further frames: name → link and pose in the link.
    """

    name: str
    reader: ModelReader
    scope: Scope | None = None
    links: dict[str, LinkName] = field(default_factory=dict[str, LinkName])
    frames: dict[str, tuple[str, Pose7]] = field(default_factory=dict[str, "tuple[str, Pose7]"])

    def names(self) -> list[str]:
        """Returns the names of its links and frames."""
        own = [] if self.scope is None else [*self.scope.links, *self.scope.frames]
        return [*own, *self.links, *self.frames]

    def knows(self, name: str) -> bool:
        """Returns whether it has a frame of this name."""
        in_scope = self.scope is not None and name not in self.scope.joints and self.scope.knows(name)
        return in_scope or name in self.links or name in self.frames

    def frame(self, name: str) -> tuple[LinkName, Pose7] | None:
        """Returns the link that carries a frame, and the frame's pose in it; None if there is none."""
        if not self.knows(name):
            return None
        if name in self.frames:
            inner, pose = self.frames[name]
            found = self.frame(inner)
            return None if found is None else (found[0], compose(found[1], pose))
        if self.scope is None:
            return self.links[name], IDENTITY_POSE
        path = self.scope.link_of(name, self.scope.placing)
        built = None if path is None else self.reader.parts.links.get(self.scope.name + SEPARATOR + path)
        if path is None or built is None:
            return None
        place = self.scope.placing
        pose = compose(invert(self.scope.pose_of(path, place)), self.scope.pose_of(name, place))
        return built.name, pose if built.name != IN_WORLD else compose(built.pose, pose)


class ModelReader:
    """Reads models, and keeps what they are in the world.

    Args:
        context: of the import.
        losses: receives the losses.

    Attributes:
        parts: entities, links and constraints of all models.
    """

    def __init__(self, context: ImportContext, losses: list[Loss]) -> None:
        self.parts = WorldParts()
        self._context = context
        self._losses = losses
        self._full: dict[str, str] = {}

    def read(self, name: str, uri: YamlValue, file: SdfFile) -> DmdModel | None:
        """Reads a model; returns None after an error or a loss. `name`: with its namespaces."""
        plain = name.replace(SEPARATOR, ".")
        if plain in self._full:
            raise uri.fault(f"the models `{cut(self._full[plain])}` and `{cut(name)}` have the same name in a scene")
        self._full[plain] = name
        suffix = uri.text().lower().rpartition(".")[2]
        is_other = suffix in {"xml", "mjcf"} or f".{suffix}" in _MESHES
        found = find_file(uri.text(), file) if is_other else find_included_model(uri.text(), file)
        if isinstance(found, str):
            raise uri.fault(f"the model `{cut(name)}`: {found}", loss="models")
        if suffix in {"xml", "mjcf"}:
            return self._mjcf(name, plain, found, uri)
        return self._mesh(name, plain, found, uri) if is_other else self._included(name, plain, found, uri, file)

    def _included(self, name: str, plain: str, found: Path, uri: YamlValue, file: SdfFile) -> DmdModel | None:
        """Reads an SDF or a URDF, as if a world included it."""
        include, world = (element_at(uri.lines, uri.location, tag) for tag in ("include", "world"))
        rows = (("uri", str(found)), ("name", plain))
        include.children.extend(element_at(uri.lines, uri.location, tag, text) for tag, text in rows)
        world.children.append(include)
        scope = ScopeReader(file).world(world)
        model = scope.models.get(plain)
        if model is None:
            return None
        if model.robot is not None:
            add_robot(model, scope.model_pose(model), plain, self.parts)
            self._start_robot(self.parts.entities[-1])
            return DmdModel(name, self, model, frames=self._urdf_frames(found))
        SdfModelReader(model, scope.model_pose(model), self.parts).read()
        report_model_losses(model)
        for joint in self.parts.loose:
            self.parts.connect(joint)
        self.parts.loose.clear()
        return DmdModel(name, self, model)

    def _urdf_frames(self, path: Path) -> dict[str, tuple[str, Pose7]]:
        """Returns the frames that Drake's element <frame> adds to a URDF."""
        report = FileReport(self._context.sink.another())
        data = read_robot_bytes(path, str(path), report, XmlBounds().size)
        root = None if data is None else parse_xml(data, str(path), report)
        found: dict[str, tuple[str, Pose7]] = {}
        for element in () if root is None else root.all("frame"):
            words = [word for key in ("xyz", "rpy") for word in element.attributes.get(key, "0 0 0").split()]
            numbers = [parse_number(word) or 0.0 for word in words]
            name, link = (element.attributes.get(key, "") for key in ("name", "link"))
            if name and name != link and len(numbers) == 6 and max(map(abs, numbers)) < _MAX_FRAME:
                found.setdefault(name, (link, (*to_vector(numbers[:3]), *from_rpy(*numbers[3:]))))
        return found

    def _start_robot(self, entity: DescribedEntity) -> None:
        """Gives a URDF the start positions of the joints that cannot be at 0."""
        assert isinstance(entity.content, RobotFile)
        starts = starts_at_limits(entity.content.robots).get("qpos", {})
        for joint, value in starts.items():
            self._set_position(entity.name, joint, value)

    def _mjcf(self, name: str, plain: str, found: Path, uri: YamlValue) -> DmdModel | None:
        resolved = resolve_path(str(found), base=found.parent, scope=self._context.scope)
        kept = import_mjcf(found, replace(self._context, keep_file=True))
        if kept is None or isinstance(resolved, Refusal):
            return None
        described = read_mjcf(resolved, scope=self._context.scope, sink=self._context.sink.another())
        if described is None:
            return None
        self._losses.extend(loss for loss in kept.losses if loss.kind != "settings")
        ((_, keys),) = kept.document["entities"].items()
        rows = tuple((key, value) for key, value in keys.items() if key != "mjcf")
        file = RobotFile("mjcf", found, keys=rows, robots=described.robots)
        links = {link.name: (plain, link.name) for robot in described.robots for link in robot.links}
        self.parts.entities.append(DescribedEntity(plain, file, uri.location))
        return DmdModel(name, self, links=links)

    def _mesh(self, name: str, plain: str, found: Path, uri: YamlValue) -> DmdModel | None:
        """Returns a mesh as a body of its shape, with the density of water."""
        try:
            parts = load_mesh(found, self._context).parts
        except MeshError as error:
            raise uri.fault(f"the model `{cut(name)}`: {error}", loss="models") from None
        volume = sum(float(np.einsum("ij,ij->", v[f[:, 0]], np.cross(v[f[:, 1]], v[f[:, 2]]))) / 6 for v, f in parts)
        place, mesh = uri.location, MeshGeometry(found.name, found, (1.0, 1.0, 1.0), "hull")
        mass = abs(volume) * _WATER
        inertial = DescribedInertial(mass, IDENTITY_POSE, None, place) if mass else None
        collision = DescribedCollision(mesh, IDENTITY_POSE, place, FRICTION)
        visual = DescribedVisual(mesh, IDENTITY_POSE, place)
        link = DescribedLink(found.stem, place, collisions=(collision,), visuals=(visual,), inertial=inertial)
        self.parts.entities.append(DescribedEntity(plain, DescribedRobot((link,), "dynamic"), place))
        self._losses.append(Loss("hulls", f"the mesh `{found.name}` collides as its convex hull", place))
        return DmdModel(name, self, links={link.name: (plain, link.name)})

    # --- changes

    def _index(self, name: str) -> int:
        return next(index for index, entity in enumerate(self.parts.entities) if entity.name == name)

    def _change(self, name: str, content: Any) -> None:
        index = self._index(name)
        self.parts.entities[index] = replace(self.parts.entities[index], content=content)

    def _content(self, name: str) -> DescribedRobot | RobotFile:
        return self.parts.entities[self._index(name)].content

    def set_joint(self, model: DmdModel, joint: str, value: YamlValue, row: tuple[float, ...]) -> None:
        """Sets the start position of a joint [m, rad], within its limits."""
        plain = model.name.replace(SEPARATOR, ".")
        for entity in self.parts.entities:
            if entity.name != plain and not entity.name.startswith(plain + SEPARATOR):
                continue
            for own in (link.joint for robot in robots_of(entity.content) for link in robot.links):
                if own is None or own.name != joint or own.type == "fixed" or len(row) != 1:
                    continue
                low, high = own.limits or (row[0], row[0])
                start = min(max(row[0], low), high)
                if start != row[0]:
                    words = f"`{cut(joint)}` of `{cut(model.name)}` starts at its limit {start:g}, not at {row[0]:g}"
                    self._losses.append(Loss("joint-positions", words, value.location))
                if own.mimic is None:
                    self._set_position(entity.name, joint, start)
                return
        raise value.fault(f"`{cut(model.name)}` has no joint `{cut(joint)}` with {len(row)} positions")

    def _set_position(self, name: str, joint: str, start: float) -> None:
        content = self._content(name)

        def posed(robot: DescribedRobot) -> DescribedRobot:
            links = (
                replace(link, joint=replace(link.joint, qpos=start))
                if link.joint and link.joint.name == joint
                else link
                for link in robot.links
            )
            return replace(robot, links=tuple(links))

        if isinstance(content, DescribedRobot):
            self._change(name, posed(content))
            return
        keys = dict(content.keys)
        keys["qpos"] = {**keys.get("qpos", {}), joint: plain_number(start)}
        robots = tuple(map(posed, content.robots))
        self._change(name, replace(content, keys=tuple(keys.items()), robots=robots))

    def pose_of(self, link: LinkName) -> Pose7:
        """Returns the pose of a link in the world, with the joints at their start positions."""
        if link == IN_WORLD:
            return IDENTITY_POSE
        content = self._content(link[0])
        base = content.pose if isinstance(content, RobotFile) else IDENTITY_POSE
        robot, index = self._found(link)
        chain: list[DescribedJoint] = []
        here = robot.links[index]
        while here.joint is not None and here.parent is not None:
            chain.append(here.joint)
            here = robot.links[here.parent]
        pose = compose(base, robot.pose)
        for joint in reversed(chain):
            moved = compose(joint.pose_in_parent, _motion(joint))
            pose = compose(pose, compose(moved, invert(joint.pose_in_child)))
        return pose

    def _found(self, link: LinkName) -> tuple[DescribedRobot, int]:
        rows = ((robot, index) for robot in robots_of(self._content(link[0])) for index in range(len(robot.links)))
        return next((robot, index) for robot, index in rows if robot.links[index].name == link[1])

    def is_root(self, link: LinkName) -> bool:
        """Returns whether a link is the root of the only robot of its entity."""
        robots = robots_of(self._content(link[0]))
        return len(robots) == 1 and robots[0].links[0].name == link[1]

    def is_still(self, link: LinkName) -> bool:
        """Returns whether a link cannot move."""
        if link == IN_WORLD:
            return True
        entity = self.parts.entities[self._index(link[0])]
        robot, index = self._found(link)
        here = robot.links[index]
        while here.joint is not None and here.parent is not None:
            if here.joint.type != "fixed":
                return False
            here = robot.links[here.parent]
        return still_links(entity)

    def is_moved(self, link: LinkName) -> bool:
        """Returns whether forces can move a link."""
        return not self.is_still(link)

    def move(self, link: LinkName, motion: Pose7) -> None:
        """Moves the entity of a link by a motion in the world frame."""
        content = self._content(link[0])
        self._change(link[0], replace(content, pose=compose(motion, content.pose)))

    def fix(self, link: LinkName) -> None:
        """Fixes the root of an entity in the world; a single body becomes static."""
        content = self._content(link[0])
        if isinstance(content, DescribedRobot):
            is_body = content.body_type is not None
            self._change(link[0], replace(content, body_type="static") if is_body else replace(content, fixed=True))
            return
        keys = {key: value for key, value in content.keys if key != "fix_root_link"}
        keys |= {"body_type": "static"} if len(content.robots[0].links) == 1 else {"fix_root_link": True}
        if content.format == "urdf" and "body_type" not in keys:
            del keys["fix_root_link"]
        self._change(link[0], replace(content, keys=tuple(keys.items())))

    def named_entities(self) -> list[DescribedEntity]:
        """Returns the entities; their links are called as in Drake, `MODEL::LINK`, for the comparison."""
        return [replace(entity, content=self._named(entity)) for entity in self.parts.entities]

    def _named(self, entity: DescribedEntity) -> DescribedRobot | RobotFile:
        plain = entity.name.partition(SEPARATOR)[0]
        full = self._full[plain]

        def named(robot: DescribedRobot) -> DescribedRobot:
            links = (
                replace(link, source=f"{full}{SEPARATOR}{link.source.removeprefix(plain + SEPARATOR) or link.name}")
                for link in robot.links
            )
            return replace(robot, links=tuple(links))

        content = entity.content
        if isinstance(content, DescribedRobot):
            return named(content)
        return replace(content, robots=tuple(map(named, content.robots)))


def robots_of(content: DescribedRobot | RobotFile) -> tuple[DescribedRobot, ...]:
    """Returns the robots of an entity."""
    return content.robots if isinstance(content, RobotFile) else (content,)


def still_links(entity: DescribedEntity) -> bool:
    """Returns whether the roots of an entity are fixed in the world."""
    content = entity.content
    if isinstance(content, DescribedRobot):
        return bool(content.fixed) or content.body_type in {"static", "kinematic"}
    keys = dict(content.keys)
    if content.format == "mjcf":
        return (
            "body_type" in keys
            or keys.get("fix_root_link", False)
            or all(robot.fixed or robot.body_type == "static" for robot in content.robots)
        )
    return keys.get("fix_root_link", True)


def _motion(joint: DescribedJoint) -> Pose7:
    """Returns the motion of a joint at its start: along or about x of its frame."""
    q = default_position(joint) if joint.qpos is None else joint.qpos
    if joint.type == "fixed" or not q:
        return IDENTITY_POSE
    if joint.type == "prismatic":
        return (q, 0.0, 0.0, *IDENTITY)
    return (0.0, 0.0, 0.0, *from_axis_angle((1.0, 0.0, 0.0), q))
