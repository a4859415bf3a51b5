"""Writes a described world as a scene document: the one writer for all formats.

A reader fills `scenecc.robots.world.DescribedWorld` and calls `write_world`. It must fill:

- `DescribedEntity.name` and `DescribedLink.name`: unique in the world and in the robot, and of any characters; the
  writer makes valid names. A `LinkName` consists of these two. `DescribedLink.source`: the name in the source's
  library.
- `DescribedRobot.links` in build order, each after its parent. A single body has a `body_type`; None: an articulation,
  also one of a single link. `fixed` and `pose` of the root in the world.
- `DescribedJoint`: one freedom; `scenecc.robots.rules.split_joint` makes several of a joint with more. Its frames have
  x along the axis. A moving joint has `limits`, infinite ones for none.
- `DescribedInertial` of each dynamic body and link whose mass does not follow from densities. Its moments obey the
  triangle rule (`scenecc.robots.rules.enforce_triangle_rule`); the reader reports what it changes.
- Shapes: round solids along x, planes with normal x. A collision and a visual with equal geometry and pose become one
  shape. Meshes that collide have a positive scale.
- `DescribedCollision.friction`, also where it is the default of the format: the writer leaves out what equals
  `DescribedPhysics.friction`. Materials that have a name in the file are written to the section `materials`.

What a scene cannot express is the reader's loss; the writer reports only `WrittenWorld.unwritten`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import AXES, IDENTITY, rotate
from scenecc.importers.ignored_pairs import Collider, IgnoredPairs
from scenecc.importers.imported_scene import Asset, Loss
from scenecc.importers.numbers import (
    Names,
    clean_pose,
    light_place,
    plain_number,
    plain_numbers,
    plain_pose,
    pose_key,
    short_number,
)
from scenecc.importers.shape_entries import NamedMaterials, axis_frames, friction_keys, shape_lists, texture_value
from scenecc.importers.tree_entries import drive_keys, joint_names, tree_of
from scenecc.robots.description import IN_WORLD, LinkName
from scenecc.robots.solids import follows_from_shapes
from scenecc.robots.world import RobotFile
from scenecc.scene_file import Node
from scenecc.scene_file.shared_keys import SHAPE_LISTS, move_shape_keys_up, move_up

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics.diagnostic import Location
    from scenecc.robots.description import (
        DescribedConstraint,
        DescribedDrive,
        DescribedDynamics,
        DescribedInertial,
        DescribedLink,
        DescribedMotion,
        DescribedRobot,
    )
    from scenecc.robots.world import DescribedCamera, DescribedEntity, DescribedLight, DescribedPhysics, DescribedWorld

_DEFAULT_BITS: Final = (1, 1)

_WHOLE: Final = 1e-5
"""Allowed rounding error of an angle that is written in degrees [degrees]."""


@frozen
class WrittenWorld:
    """A world as a scene document.

    Attributes:
        document: as `ImportedScene.document`.
        bodies, places: as in `ImportedScene`.
        names: link in the world → name in the scene, `ENTITY` or `ENTITY/LINK`.
        unwritten: pairs of names that collide in the scene, since it cannot ignore so many different pairs.
    """

    document: Node
    bodies: Mapping[str, str]
    places: Mapping[str, Location]
    names: Mapping[LinkName, str]
    unwritten: tuple[tuple[str, str], ...] = ()

    def lost_filters(self, place: Location) -> list[Loss]:
        """Returns the losses for `unwritten`. `place`: in the source."""
        return [Loss("collision-filters", f"`{a}` and `{b}` would collide", place) for a, b in self.unwritten]


def write_world(world: DescribedWorld) -> WrittenWorld:
    """Returns a world as a scene document with short, editable keys."""
    return _WorldWriter(world).write()


@dataclass(slots=True)
class _WorldWriter:
    world: DescribedWorld
    bodies: dict[str, str] = field(default_factory=dict[str, str])
    places: dict[str, Any] = field(default_factory=dict[str, Any])
    names: dict[LinkName, str] = field(default_factory=lambda: {IN_WORLD: "world"})
    colliders: list[Collider] = field(default_factory=list[Collider])
    materials: NamedMaterials = field(default_factory=NamedMaterials)

    def write(self) -> WrittenWorld:
        """Returns the document with its names."""
        world, free = self.world, Names("world")
        entities: dict[str, Node] = {}
        for entity in world.entities:
            name = free.new(entity.wish or entity.name)
            self.places[name] = entity.location
            entities[name] = self._entity(name, entity, len(entities))
        pairs = frozenset(frozenset(self.names[link] for link in pair) for pair in world.ignored)
        closed = frozenset(
            index
            for index, entity in enumerate(world.entities)
            if not isinstance(entity.content, RobotFile) and not entity.content.self_collisions
        )
        ignored = IgnoredPairs(self.colliders, list(entities.values()), pairs, closed)
        ignored.write()
        sections: dict[str, Any] = {
            "physics": _physics(world.physics),
            "environment": self._environment(),
            "materials": self.materials.named,
            "collision_groups": ignored.groups,
            "entities": entities,
            "constraints": self._named(world.constraints, self._constraint),
            "lights": self._named(world.lights, self._light),
            # Entities and cameras share their names.
            "cameras": self._named(world.cameras, self._camera, *entities),
        }
        document = {"scenecc": 1, "name": world.name, **{key: value for key, value in sections.items() if value}}
        return WrittenWorld(document, self.bodies, self.places, self.names, tuple(ignored.unwritten))

    def _named(self, described: Any, keys: Any, *taken: str) -> dict[str, Node]:
        names = Names(*taken, "world")
        return {names.new(one.name): keys(one) for one in described}

    def _environment(self) -> Node:
        made: Node = {}
        if self.world.ambient is not None and any(self.world.ambient):
            made["ambient_light"] = plain_numbers(self.world.ambient)
        if self.world.environment is not None:
            made["map"] = texture_value(self.world.environment)
        return made

    # --- entities

    def _entity(self, name: str, entity: DescribedEntity, index: int) -> Node:
        content = entity.content
        if isinstance(content, RobotFile):
            return self._file(name, entity.name, content)
        if content.body_type is None:
            return self._articulation(name, entity.name, content, index)
        return self._body(name, entity.name, content, index)

    def _file(self, name: str, wish: str, file: RobotFile) -> Node:
        self._note_file(name, wish, file)
        node: Node = {file.format: Asset(file.path.name, file.path), **dict(file.keys)}
        node |= pose_key(clean_pose(file.pose))
        free, parts = Names(), dict[str, Node]()
        for part in file.parts:
            own = free.new(part.name)
            self.places[f"{name}/{own}"] = part.location
            to = self.names[part.to].removeprefix(f"{name}/")
            inner = self._file(f"{name}/{own}", part.name, replace(part.file, pose=part.pose))
            parts[own] = {"to": to, **inner}
        return {**node, "attach": parts} if parts else node

    def _note_file(self, name: str, wish: str, file: RobotFile) -> None:
        """Records the names of links in a file, which become several entities if the file has several robots."""
        is_one, is_whole = len(file.robots) == 1, "body_type" in dict(file.keys)
        for robot in file.robots:
            root, is_part = robot.links[0].name, "/" in name
            entity = name if is_one else f"{name}/{root}"
            for link in robot.links:
                is_body = is_whole or (robot.body_type is not None and not is_part)
                self._note((wish, link.name), link, entity if is_body else f"{entity}/{link.name}")

    def _note(self, link_name: LinkName, link: DescribedLink, name: str) -> None:
        self.names[link_name] = name
        # The links of a file that is one body have its name; its frame is that of the first.
        if not link.is_added:
            self.bodies.setdefault(name, link.source or link.name)
        self.places.setdefault(name, link.location)

    def _body(self, name: str, wish: str, robot: DescribedRobot, index: int) -> Node:
        (link,) = robot.links
        self._note((wish, link.name), link, name)
        kind = "none" if robot.body_type == "static" and not link.collisions else robot.body_type
        node: Node = {} if kind == "dynamic" else {"body_type": kind}
        node |= pose_key(clean_pose(robot.pose))
        moves = kind == "dynamic"
        if moves:
            node |= _given(robot.dynamics)
        node |= self._link_keys(link, moves=moves)
        node = self._with_shapes(node, link, name, index, 0, is_link=False, moves=moves, is_static=kind == "static")
        if not any(node.get(key) for key in SHAPE_LISTS):
            node["shapes"] = []
        return node

    def _articulation(self, name: str, wish: str, robot: DescribedRobot, index: int) -> Node:
        fixed = {"fix_root_link": True} if robot.fixed else {}
        entity: Node = {**pose_key(clean_pose(robot.pose)), **fixed, **_given(robot.dynamics)}
        free, links = Names("world"), list[Node]()
        for number, link in enumerate(robot.links):
            own = free.new(link.name)
            self._note((wish, link.name), link, f"{name}/{own}")
            keys: Node = {"name": own, **self._link_keys(link, moves=True)}
            links.append(self._with_shapes(keys, link, f"{name}/{own}", index, number, is_link=True))
        # The look of a material would also be that of links that do not collide.
        owners = [keys for keys, link in zip(links, robot.links, strict=True) if link.collisions]
        if not any(self.materials.is_look(keys.get("material")) for keys in owners):
            move_up(entity, owners, "material", 2)
        move_up(entity, links, "gravity")
        return entity | tree_of(robot, links, joint_names(robot))

    def _link_keys(self, link: DescribedLink, *, moves: bool) -> Node:
        """Returns mass and motion of a link or body."""
        if not moves:
            return {}
        keys: Node = {}
        if link.inertial is not None:
            keys = _mass_keys(link.inertial, plain=follows_from_shapes(link.inertial, link.collisions))
        if link.disable_gravity:
            keys["gravity"] = False
        return keys | _given(link.motion)

    def _with_shapes(
        self,
        node: Node,
        link: DescribedLink,
        name: str,
        entity: int,
        number: int,
        *,
        is_link: bool,
        moves: bool = True,
        is_static: bool = False,
    ) -> Node:
        """Returns the keys of a link or body with its shapes, and records it if it collides."""
        inertial = link.inertial
        weighs = moves and (inertial is None or inertial.inertia is None)
        friction, materials = self.world.physics.friction, self.materials
        lists, entries = shape_lists(link.collisions, link.visuals, friction, materials, weighs=weighs)
        made = {**node, **lists}
        move_shape_keys_up(made, is_link=is_link)
        materials.replace_in(made)
        if link.collisions:
            bits = tuple(shape.bits or _DEFAULT_BITS for shape in link.collisions)
            self.colliders.append(
                Collider(made, entries, bits, name, entity, number, link.parent, link.ignore_bits, is_static=is_static)
            )
        return made

    # --- constraints, lights, cameras

    def _constraint(self, constraint: DescribedConstraint) -> Node:
        ends = {"parent": self.names[constraint.parent], "child": self.names[constraint.child]}
        keys: Node = {"type": constraint.type, **ends}
        in_parent, in_child = clean_pose(constraint.pose_in_parent), clean_pose(constraint.pose_in_child)
        if constraint.type in {"hinge", "slider"}:
            axis, in_parent, in_child = axis_frames(in_parent, in_child)
            keys |= {} if axis == "x" else {"axis": axis}
        # Left out, the frame in the parent would follow from the initial poses.
        keys |= {"pose_in_parent": plain_pose(in_parent), **pose_key(in_child, "pose_in_child")}
        if constraint.span is not None and any(map(math.isfinite, constraint.span)):
            keys["limits"] = plain_numbers(constraint.span)
        if constraint.limits:
            keys["limits"] = {axis: plain_numbers((low, high)) for axis, low, high in constraint.limits}
        if constraint.type in {"hinge", "slider"}:
            keys |= {"drive": _motor_keys(constraint.drives[0][1])} if constraint.drives else {}
        elif constraint.drives:
            keys["drive"] = {axis: drive_keys(drive) for axis, drive in constraint.drives}
        keys |= pose_key(clean_pose(constraint.target), "target")
        if constraint.velocity_target is not None:
            pairs = zip(("linear", "angular"), constraint.velocity_target, strict=True)
            speeds = {key: plain_numbers(speed) for key, speed in pairs if any(speed)}
            keys |= {"velocity_target": speeds} if speeds else {}
        return {**keys, "collide": True} if constraint.collide else keys

    def _light(self, light: DescribedLight) -> Node:
        keys: Node = {"type": light.type, "color": plain_numbers(light.color)}
        keys |= light_place(light.type, light.position, light.direction)
        if light.cone is not None and light.type == "spot":
            for key, angle in zip(("inner_fov", "outer_fov"), light.cone, strict=True):
                keys |= _angle_key(key, angle)
        if light.shadow:
            keys["shadow"] = True
        return keys | self._mount(light.mount)

    def _camera(self, camera: DescribedCamera) -> Node:
        kind, value = camera.lens
        keys: Node = {**self._mount(camera.mount), **pose_key(clean_pose(camera.pose))}
        if camera.size is not None:
            keys |= dict(zip(("width", "height"), camera.size, strict=True))
        keys |= {kind: {"top": plain_number(value)}} if kind == "orthographic" else _angle_key(kind, value)
        if camera.clip is not None:
            keys |= dict(zip(("near", "far"), plain_numbers(camera.clip), strict=True))
        return keys

    def _mount(self, link: LinkName | None) -> Node:
        return {} if link is None else {"mount": self.names[link]}


def _physics(physics: DescribedPhysics) -> Node:
    keys: Node = {}
    if physics.timestep is not None:
        keys["timestep"] = plain_number(physics.timestep)
    if physics.gravity is not None:
        keys["gravity"] = plain_numbers(physics.gravity)
    if physics.friction is not None:
        keys["default_material"] = friction_keys(physics.friction)
    return keys


def _angle_key(key: str, angle: float) -> Node:
    """Returns an angle [rad] under its key, in degrees if that has few digits."""
    degrees = math.degrees(angle)
    if abs(degrees - round(degrees, 2)) < _WHOLE:
        return {f"{key}_deg": round(degrees, 2)}
    return {key: plain_number(angle)}


def _motor_keys(drive: DescribedDrive) -> Node:
    # A target does nothing without its gain.
    targets = {"target": drive.stiffness and drive.target, "velocity_target": drive.damping and drive.velocity_target}
    return {**drive_keys(drive), **{key: plain_number(value) for key, value in targets.items() if value}}


def _mass_keys(inertial: DescribedInertial, *, plain: bool) -> Node:
    """Returns `mass` or `inertial`. Axes along those of the link are not written: the moments are in their order.

    `plain`: whether the inertia follows from the shapes with one density.
    """
    mass = short_number(inertial.mass)
    if inertial.inertia is None and inertial.keeps_com:
        return {"mass": mass, "com": plain_numbers(inertial.com[:3])}
    if inertial.inertia is None or plain:
        return {"mass": mass}
    com, inertia = clean_pose(inertial.com), inertial.inertia
    turn = np.array([rotate(com[3:], axis) for axis in AXES.values()]).T
    if max(inertia) - min(inertia) <= 1e-6 * max(inertia):
        com = (*com[:3], *IDENTITY)
    elif np.abs(turn - np.round(turn)).max() < 1e-6:
        com, inertia = (*com[:3], *IDENTITY), tuple((turn**2 @ np.array(inertia)).tolist())
    return {"inertial": {"mass": mass, **pose_key(com, "com"), "inertia": [short_number(each) for each in inertia]}}


def _given(described: DescribedMotion | DescribedDynamics | None) -> Node:
    """Returns the values of a described object that are in the file, by field."""
    keys: Node = {}
    for one in () if described is None else fields(described):
        value: Any = getattr(described, one.name)
        if isinstance(value, tuple):
            keys |= {one.name: _plain_row(value)} if value else {}  # pyright: ignore[reportUnknownArgumentType]
        elif value is not None:
            keys[one.name] = value if isinstance(value, int) else plain_number(value)
    return keys


def _plain_row(row: tuple[Any, ...]) -> list[Any]:
    return [one if isinstance(one, str) else plain_number(one) for one in row]
