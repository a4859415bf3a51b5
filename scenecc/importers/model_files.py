"""Reads model files of any format into one world, with the readers of their formats: SDF, URDF, MJCF, meshes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import (
    IDENTITY_POSE,
    Pose7,
    Quat,
    Vec3,
    compose,
    from_rpy,
    invert,
    to_rpy,
    to_vector,
)
from scenecc.importers.imported_scene import ImportContext, Loss
from scenecc.importers.meshes import MeshError, load_mesh
from scenecc.importers.mjcf import read_mjcf_model
from scenecc.importers.numbers import starts_at_limits
from scenecc.importers.placed_entities import PlacedEntities, robots_of
from scenecc.importers.sdf import report_model_losses
from scenecc.importers.sdf_files import SdfFile, find_file, find_included_model
from scenecc.importers.sdf_models import SdfModelReader, WorldParts, add_robot
from scenecc.importers.sdf_scopes import SEPARATOR, Scope, ScopeReader
from scenecc.importers.sdf_shapes import FRICTION
from scenecc.importers.urdf import read_urdf_root
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
from scenecc.robots.world import DescribedEntity, RobotFile
from scenecc.robots.xml import element_at, parse_number

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.importers.yaml_values import YamlValue

_MESHES: Final = (".obj", ".gltf", ".glb", ".vtk")

_MAX_FRAME: Final = 1e6
"""Largest coordinate of a frame of a URDF [m]."""

_WATER: Final = 1000.0
"""Density of a mesh that is a model, as in Drake [kg/m³]."""


@dataclass(frozen=True, slots=True)
class NamedModel:
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
        scope = self.scope
        if scope is not None and scope.knows(name):
            # Unlike in an SDF, a joint is no frame.
            return name not in scope.joints or name in scope.links or name in scope.frames
        return name in self.links or name in self.frames

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
        self.placed = PlacedEntities(self.parts.entities)
        self._full: dict[str, str] = {}

    def read(self, name: str, uri: YamlValue, file: SdfFile) -> NamedModel | None:
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
        first = len(self.parts.entities)
        if suffix in {"xml", "mjcf"}:
            model = self._mjcf(name, plain, found, uri)
        else:
            model = self._mesh(name, plain, found, uri) if is_other else self._included(name, plain, found, uri, file)
        self.parts.entities[first:] = [_as_in_drake(each, plain, name) for each in self.parts.entities[first:]]
        return model

    def model_of(self, link: LinkName) -> str:
        """Returns the name of a link's model, with its namespaces."""
        return self._full[link[0].partition(SEPARATOR)[0]]

    def _included(self, name: str, plain: str, found: Path, uri: YamlValue, file: SdfFile) -> NamedModel | None:
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
            return NamedModel(name, self, model, frames=self._urdf_frames(found))
        SdfModelReader(model, scope.model_pose(model), self.parts).read()
        report_model_losses(model)
        for joint in self.parts.loose:
            self.parts.connect(joint)
        self.parts.loose.clear()
        return NamedModel(name, self, model)

    def _urdf_frames(self, path: Path) -> dict[str, tuple[str, Pose7]]:
        """Returns the frames that the element <frame> adds to a URDF, as Drake reads it; invalid ones are unknown."""
        root = read_urdf_root(path, self._context)
        found: dict[str, tuple[str, Pose7]] = {}
        for element in () if root is None else root.all("frame"):
            words = [word for key in ("xyz", "rpy") for word in element.attributes.get(key, "0 0 0").split()]
            numbers = [number for word in words if (number := parse_number(word)) is not None]
            name, link = (element.attributes.get(key, "") for key in ("name", "link"))
            if name and name != link and len(numbers) == len(words) == 6 and max(map(abs, numbers)) < _MAX_FRAME:
                found.setdefault(name, (link, (*to_vector(numbers[:3]), *from_rpy(*numbers[3:]))))
        return found

    def _start_robot(self, entity: DescribedEntity) -> None:
        """Gives a URDF the start positions of the joints that cannot be at 0."""
        assert isinstance(entity.content, RobotFile)
        starts = starts_at_limits(entity.content.robots).get("qpos", {})
        for joint, value in starts.items():
            self.placed.set_position(entity.name, joint, value)

    def _mjcf(self, name: str, plain: str, found: Path, uri: YamlValue) -> NamedModel | None:
        read = read_mjcf_model(found, self._context)
        if read is None:
            return None
        file, losses = read
        self._losses.extend(losses)
        self.parts.entities.append(DescribedEntity(plain, file, uri.location))
        return NamedModel(
            name, self, links={link.name: (plain, link.name) for robot in file.robots for link in robot.links}
        )

    def _mesh(self, name: str, plain: str, found: Path, uri: YamlValue) -> NamedModel | None:
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
        return NamedModel(name, self, links={link.name: (plain, link.name)})

    def set_joint(self, model: NamedModel, joint: str, value: YamlValue, row: tuple[float, ...]) -> None:
        """Sets the start position of a joint [m, rad], within its limits. A joint of several axes has become several
        joints: Drake has roll, pitch and yaw of a ball joint, the scene hinges about x, y and z in series.
        """
        plain = model.name.replace(SEPARATOR, ".")
        count = len(row)
        names = [joint] if count == 1 else [f"{joint}_{number}" for number in range(1, count + 1)]
        positions = _series_angles(from_rpy(*row)) if count == 3 else row
        for entity in self.parts.entities:
            if entity.name != plain and not entity.name.startswith(plain + SEPARATOR):
                continue
            joints = [link.joint for robot in robots_of(entity.content) for link in robot.links if link.joint]
            found = {each.name: each for each in joints if each.type != "fixed"}
            if not all(name in found for name in names) or (count > 1 and f"{joint}_{count + 1}" in found):
                continue
            for name, position in zip(names, positions, strict=True):
                self._set_position(entity, found[name], position, f"`{cut(name)}` of `{cut(model.name)}`", value)
            return
        raise value.fault(f"`{cut(model.name)}` has no joint `{cut(joint)}` with {count} positions")

    def _set_position(
        self, entity: DescribedEntity, joint: DescribedJoint, position: float, words: str, value: YamlValue
    ) -> None:
        low, high = joint.limits or (position, position)
        start = min(max(position, low), high)
        if start != position:
            text = f"{words} starts at its limit {start:g}, not at {position:g}"
            self._losses.append(Loss("joint-positions", text, value.location))
        if joint.mimic is None:
            self.placed.set_position(entity.name, joint.name, start)


def _series_angles(q: Quat) -> Vec3:
    """Returns the angles about x, y and z, applied in this order about turned axes, whose rotation is q."""
    w, x, y, z = q
    roll, pitch, yaw = to_rpy((w, -x, -y, -z))
    return -roll, -pitch, -yaw


def _as_in_drake(entity: DescribedEntity, plain: str, name: str) -> DescribedEntity:
    """Returns an entity whose links are called as in Drake, `MODEL::LINK`, for the comparison."""

    def named(robot: DescribedRobot) -> DescribedRobot:
        rows = [(link, link.source.removeprefix(plain + SEPARATOR) or link.name) for link in robot.links]
        return replace(robot, links=tuple(replace(link, source=f"{name}{SEPARATOR}{own}") for link, own in rows))

    content = entity.content
    if isinstance(content, DescribedRobot):
        return replace(entity, content=named(content))
    return replace(entity, content=replace(content, robots=tuple(map(named, content.robots))))
