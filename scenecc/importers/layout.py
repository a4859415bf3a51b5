"""Imports EmbodiedGen's `layout.json`: the bodies that its loader for SAPIEN builds.

They follow `load_assets_from_layout_file` and `load_actor_from_urdf` in EmbodiedGen's `utils/simulation.py`: the
context is static, other objects are dynamic with a density of 1000 kg/m³, whatever mass their URDF has, and the parts
of a collision mesh collide as their hulls. An articulated URDF stays a file.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import Pose7, normalized, to_vector
from scenecc.importers.imported_scene import ImportContext, ImportedScene, Loss
from scenecc.importers.numbers import Names, plain_name, starts_at_limits
from scenecc.importers.urdf import URDF_LOSS_CODES, ReadUrdf, read_repaired_urdf, read_urdf_root
from scenecc.importers.writer import write_world
from scenecc.importers.yaml_values import ValueFault, YamlValue, read_yaml_value
from scenecc.robots.description import DescribedLink, DescribedRobot, MeshGeometry
from scenecc.robots.world import DescribedEntity, DescribedWorld, RobotFile
from scenecc.robots.xml import SourceElement, parse_number
from scenecc.source.paths import Refusal, resolve_path

if TYPE_CHECKING:
    from pathlib import Path

_KEYS: Final = ("tree", "relation", "objs_desc", "objs_mapping", "assets", "quality", "position")

_BACKGROUND, _CONTEXT, _ROBOT = "background", "context", "robot"

_FRICTION_RANGES: Final = {"mu1": (0.1, 0.7), "mu2": (0.1, 0.6)}
"""Ranges to which the loader cuts the static and the dynamic friction of a URDF."""

_RESTITUTION: Final = 0.05

_DENSITY: Final = 1000.0
"""SAPIEN's and the scene's default density, which the loader does not change [kg/m³]."""


def import_layout(path: Path, context: ImportContext) -> ImportedScene | None:
    """Returns the scene of a layout; None after an error."""
    found = context.resolve(path)
    top = None if found is None else read_yaml_value(found.path, str(path), context, is_json=True)
    if found is None or top is None:
        return None
    try:
        layout = _Layout(top, found.path.parent, context)
    except ValueFault as fault:
        hint = "a layout of EmbodiedGen has the keys `tree`, `relation`, `assets`, `objs_mapping` and `position`"
        context.sink.report("SC430", f"it is not a layout of EmbodiedGen: {fault.message}", fault.place, hint=hint)
        return None
    entities = layout.entities()
    if context.sink.failed:
        return None
    if not entities and not layout.losses:
        context.sink.report("SC430", "there is nothing to import: `assets` is empty", Location(str(path)))
        return None
    folder = path.absolute().parent.name
    world = DescribedWorld(Names().new(folder if path.stem == "layout" and folder else path.stem), tuple(entities))
    written = write_world(world)
    content = written.document, tuple(layout.losses), written.bodies
    return ImportedScene(*content, places=written.places, codes_of_losses=URDF_LOSS_CODES)


@dataclass(slots=True)
class _Asset:
    """An object of a layout: its node, folder and pose."""

    node: str
    value: YamlValue
    pose: Pose7
    is_static: bool


class _Layout:
    """A layout. Raises ValueFault if the file has not the form of one."""

    def __init__(self, top: YamlValue, folder: Path, context: ImportContext) -> None:
        keys = top.entries()
        missing = [key for key in ("tree", "relation", "assets", "objs_mapping", "position") if key not in keys]
        if missing:
            raise ValueFault(f"it has no key `{missing[0]}`", top.location)
        self._relation = keys["relation"].entries()
        self._assets = keys["assets"].entries()
        self._mapping = keys["objs_mapping"].entries()
        self._position = keys["position"].entries()
        self._folder = folder
        self._context = context
        self.losses = [
            Loss("settings", f"the key `{cut(key)}`", value.location) for key, value in keys.items() if key not in _KEYS
        ]

    def entities(self) -> list[DescribedEntity]:
        """Returns the entities, in the order of `assets`; each fault is reported."""
        found: list[DescribedEntity] = []
        for node, value in self._assets.items():
            try:
                entity = self._entity(node, value)
            except ValueFault as fault:
                fault.report(self._context.sink, self.losses)
                continue
            found += [] if entity is None else [entity]
        try:
            self._lose_robot()
        except ValueFault as fault:
            fault.report(self._context.sink, self.losses)
        return found

    def _lose_robot(self) -> None:
        """Lists the robot: the layout names it, but EmbodiedGen takes it from ManiSkill's agents."""
        if _ROBOT not in self._relation:
            return
        robot = self._relation[_ROBOT]
        name = robot.text()
        at = ", ".join(f"{each:g}" for each in self._pose(name, robot)) if name in self._position else "the origin"
        words = f"the robot `{cut(name)}` at {at}; add its file as an entity with this `pose`"
        self.losses.append(Loss("robots", words, robot.location))

    def _pose(self, node: str, value: YamlValue) -> Pose7:
        """Returns a pose, which a layout writes as x y z qx qy qz qw."""
        if node not in self._position:
            raise value.fault(f"`{cut(node)}` has no `position`")
        x, y, z, *turn = self._position[node].numbers(7)
        if math.hypot(*turn) < 1e-6:
            raise self._position[node].fault("the quaternion of {} has length 0")
        return (x, y, z, *normalized((turn[3], turn[0], turn[1], turn[2])))

    def _entity(self, node: str, value: YamlValue) -> DescribedEntity | None:
        if node not in self._mapping:
            raise value.fault(f"`{cut(node)}` is not in `objs_mapping`")
        if self._mapping[node].text() == _BACKGROUND:
            words = f"the background `{cut(node)}`, Gaussian splats without collision shapes"
            raise value.fault(words, loss="visuals")
        context = self._relation.get(_CONTEXT)
        asset = _Asset(node, value, self._pose(node, value), context is not None and context.text() == node)
        uri = f"{value.text().rstrip('/')}/{node.replace(' ', '_')}.urdf"
        found = resolve_path(uri, base=self._folder, scope=self._context.scope)
        if isinstance(found, Refusal):
            raise value.fault(f"the object `{cut(node)}`: {found.message}", found.hint, loss="models")
        read = read_repaired_urdf(found.path, self._context)
        if read is None:
            return None
        links = [link for robot in read.robots for link in robot.links]
        content = self._body(asset, read, links[0]) if len(links) == 1 else _robot_file(asset, read)
        if isinstance(content, RobotFile):
            self.losses.extend(read.losses)
        if plain_name(node) != node and plain_name(node) != node.replace(" ", "_"):
            self.losses.append(Loss("names", f"`{cut(node)}` is renamed to `{plain_name(node)}`", value.location))
        return DescribedEntity(node, content, value.location)

    def _body(self, asset: _Asset, read: ReadUrdf, link: DescribedLink) -> DescribedRobot:
        """Returns a URDF of one link as a body: with its own friction, and the mass of its shapes."""
        friction = _friction(read_urdf_root(read.path, self._context))
        collisions = tuple(
            replace(
                shape,
                friction=friction,
                geometry=replace(shape.geometry, collision="parts")
                if isinstance(shape.geometry, MeshGeometry)
                else shape.geometry,
            )
            for shape in link.collisions
        )
        if link.inertial is not None and not asset.is_static:
            words = (
                f"the mass of `{cut(asset.node)}` in its URDF, {link.inertial.mass:g} kg: like EmbodiedGen's loader, "
                f"the scene gives it {_DENSITY:g} kg/m³; `mass` of the entity changes that"
            )
            self.losses.append(Loss("assumed-masses", words, link.inertial.location))
        body = replace(link, collisions=collisions, inertial=None)
        kind: Any = "static" if asset.is_static else "dynamic"
        return DescribedRobot((body,), kind, pose=asset.pose, location=asset.value.location)


def _robot_file(asset: _Asset, read: ReadUrdf) -> RobotFile:
    root = () if asset.is_static else (("fix_root_link", False),)
    keys = (*read.keys, *root, *starts_at_limits(read.robots).items())
    return RobotFile("urdf", read.path, asset.pose, keys, read.robots)


def _friction(root: SourceElement | None) -> tuple[float, float, float] | None:
    """Returns the friction in the first <collision> with a <gazebo>, cut as by EmbodiedGen's loader."""
    if root is None:
        return None
    found = (gazebo for link in root.all("link") for shape in link.all("collision") for gazebo in shape.all("gazebo"))
    gazebo = next(found, None)
    rows: list[float] = []
    for tag, (low, high) in _FRICTION_RANGES.items() if gazebo is not None else ():
        element = None if gazebo is None else gazebo.find(tag)
        number = None if element is None else parse_number(element.text)
        if number is None or math.isnan(number):
            return None
        rows.append(min(max(number, low), high))
    return to_vector((*rows, _RESTITUTION)) if rows else None
