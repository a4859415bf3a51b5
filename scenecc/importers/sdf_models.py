"""SDF models as entities: bodies, articulations, and constraints that close loops."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose, from_matrix, invert, relative_pose
from scenecc.importers.numbers import Names, plain_name, plain_number, pose_key
from scenecc.importers.sdf_files import SourceElement, find_element, text_of
from scenecc.importers.sdf_joints import (
    Hinge,
    SdfJoint,
    hinges_of,
    joint_type,
    make_constraint,
    mimic_of,
    sdf_tree_joint,
)
from scenecc.importers.sdf_scopes import SEPARATOR, WORLD, Scope
from scenecc.importers.sdf_shapes import LinkPlace, read_shapes, solid_mass

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Location

Node = dict[str, Any]

_MAX_GROUPS, _MAX_LINKS = 31, 255

_LEAST_INERTIA: Final = 1e-30
"""Smaller masses and moments count as 0 in the engine's single precision [kg, kg·m²]."""

_DUMMY_MASS: Final = 1e-6
"""Mass of a link between the hinges of one joint [kg]."""


@dataclass(frozen=True, slots=True)
class SdfLink:
    """A link of a top model.

    Attributes:
        scope: the scope that contains it.
        element: the <link>.
        path: from the top model.
        pose: in the top model's frame.
        turn: pose of the scope's frame in the top model's frame.
    """

    scope: Scope
    element: SourceElement
    path: str
    pose: Pose7
    turn: Pose7


@dataclass(frozen=True, slots=True)
class BuiltLink:
    """A link in the scene.

    Attributes:
        name: `ENTITY` or `ENTITY/LINK`.
        pose: in the world.
        is_moved: whether forces can move it.
    """

    name: str
    pose: Pose7
    is_moved: bool


@dataclass(frozen=True, slots=True)
class Bitmask:
    """The collision bitmask of a link, or of one of its shapes if these differ.

    Attributes:
        node: node of the document.
        mask: the bits.
        link: the link.
        entity: name of its entity.
    """

    node: Node
    mask: int
    link: SdfLink
    entity: str


@dataclass(frozen=True, slots=True)
class Crossing:
    """A joint between two entities, or between an entity and the world.

    Attributes:
        scope: the scope that contains it.
        element: the <joint>.
        name: its name in the scope.
        prefix: path from the world to the scope, with a separator at its end; "" for the world.
        turn: pose of the scope's frame in the world.
    """

    scope: Scope
    element: SourceElement
    name: str
    prefix: str = ""
    turn: Pose7 = IDENTITY_POSE


@dataclass(slots=True)
class SceneParts:
    """Collects the converted models of a world.

    Attributes:
        entities, constraints, groups: sections `entities`, `constraints` and `collision_groups` of the document.
        bodies: name in the scene → name in the source.
        links: path from the world → link in the scene.
        free_roots: path from the world of the root of an included URDF → its entity, if it is free.
        crossings: joints between an included URDF and something else, made when all links are built.
        locations: name of a body or entity in the scene → location in the file.
        bitmasks: of the links that collide.
        places: path from the world → placement of its shapes, lights and sensors.
        names: entity names in use.
        constraint_names: constraint names in use.
    """

    entities: Node = field(default_factory=dict[str, Any])
    groups: Node = field(default_factory=dict[str, Any])
    constraints: Node = field(default_factory=dict[str, Any])
    bodies: dict[str, str] = field(default_factory=dict[str, str])
    links: dict[str, BuiltLink] = field(default_factory=dict[str, BuiltLink])
    free_roots: dict[str, Node] = field(default_factory=dict[str, Node])
    crossings: list[Crossing] = field(default_factory=list["Crossing"])
    places: dict[str, tuple[SourceElement, LinkPlace]] = field(
        default_factory=dict[str, tuple["SourceElement", LinkPlace]]
    )
    locations: dict[str, Location] = field(default_factory=dict[str, "Location"])
    bitmasks: list[Bitmask] = field(default_factory=list["Bitmask"])
    names: Names = field(default_factory=Names)
    constraint_names: Names = field(default_factory=Names)


def add_robot(model: Scope, pose: Pose7, path: str, parts: SceneParts) -> None:
    """Adds an included URDF. Its root is free, unless it is called `world`, as URDF writes a fixed base.

    Args:
        model: its scope.
        pose: of the model in the world.
        path: of the model from the world.
        parts: receives the entity, and a constraint for each single body of a static model.
    """
    read = model.robot
    if read is None:
        return
    model.file.losses.extend(read.losses)
    shown = path.rpartition(SEPARATOR)[0] if model.is_merged else path
    name = parts.names.new(shown.replace(SEPARATOR, "."))
    entity: Node = {**read.entity(), **pose_key(pose)}
    parts.entities[name], parts.locations[name] = entity, model.placing.location
    if model.is_static and any(
        link.joint and link.joint.type != "fixed" for robot in read.robots for link in robot.links
    ):
        entity["joints"] = {".*": {"limits": [0, 0]}}
    names = {link: mine for mine, link in read.bodies(name).items()}
    for robot in read.robots:
        root = robot.links[0].name
        is_free = not model.is_static and root != WORLD
        for link in robot.links:
            own, world = f"{path}{SEPARATOR}{link.name}", compose(pose, model.pose_of(link.name, model.placing))
            parts.bodies[names[link.name]] = f"{shown}{SEPARATOR}{link.name}"
            parts.links[own] = BuiltLink(names[link.name], world, is_moved=not model.is_static)
        if is_free or len(robot.links) == 1:
            entity["fix_root_link"] = False
        if is_free and len(robot.links) > 1:
            parts.free_roots[f"{path}{SEPARATOR}{root}"] = entity
        elif not is_free and len(robot.links) == 1:
            at = parts.links[f"{path}{SEPARATOR}{root}"].pose
            weld = {"type": "weld", "parent": WORLD, "child": names[root], **pose_key(at, "pose_in_parent")}
            parts.constraints[parts.constraint_names.new(name)] = weld


class SdfModelReader:
    """Reads one top model.

    Args:
        model: its scope.
        pose: of its frame in the world.
        parts: receives the result.
    """

    def __init__(self, model: Scope, pose: Pose7, parts: SceneParts) -> None:
        self._model = model
        self._pose = pose
        self._parts = parts
        self._links: dict[str, SdfLink] = {}
        self._joints: list[SdfJoint] = []
        self._joint_names: dict[str, str] = {}
        self._robots: list[str] = []

    def read(self) -> None:
        """Adds the model's entities and constraints."""
        self._collect(self._model, "", IDENTITY_POSE)
        groups, entities = self._groups(), {*self._parts.entities}
        first_of = {path: group[0] for group in groups for path in group}
        joints_of: dict[str, list[SdfJoint]] = {}
        for joint in self._joints:
            joints_of.setdefault(first_of[joint.child or joint.parent], []).append(joint)
        for group in groups:
            self._add(group, joints_of.get(group[0], []), is_only=len(groups) == 1)
        if len(groups) > 1 and not self._model.is_static:
            self._disable_self_collisions(entities)

    def _disable_self_collisions(self, before: set[str]) -> None:
        """Disables collisions between the bodies of one model, unless it sets `self_collide`."""
        model, parts = self._model, self._parts
        added = [node for name, node in parts.entities.items() if name not in before and _collides(node)]
        if len(added) < 2 or model.file.flag(model.element, "self_collide", default=False):
            return
        if len(parts.groups) >= _MAX_GROUPS:
            model.file.lose(
                "self-collisions", f"bodies of `{model.name}` would collide with one another", model.element
            )
            return
        name = Names(*parts.groups).new(model.name)
        parts.groups[name] = {"ignore": [name]}
        for node in added:
            node["collision_group"] = name

    def _collect(self, scope: Scope, prefix: str, turn: Pose7) -> None:
        """Collects all links and joints, including nested ones. `turn`: pose of the scope's frame in the top model."""
        named = [("model", scope.name, scope.placing)]
        named += [("link", name, link) for name, link in scope.links.items()]
        named += [("joint", name, joint) for name, joint in scope.joints.items()]
        for what, name, element in named:
            if plain_name(name) != name.replace(SEPARATOR, "."):
                scope.file.lose("names", f"the {what} `{cut(name)}` is renamed to `{plain_name(name)}`", element)
        for name, link in scope.links.items():
            pose = compose(turn, scope.pose_of(name, link))
            self._links[prefix + name] = SdfLink(scope, link, prefix + name, pose, turn)
        for name, model in scope.models.items():
            pose = compose(turn, scope.model_pose(model))
            if model.robot is None:
                self._collect(model, f"{prefix}{name}{SEPARATOR}", pose)
            else:
                self._robots.append(f"{prefix}{name}{SEPARATOR}")
                add_robot(model, compose(self._pose, pose), f"{self._model.name}{SEPARATOR}{prefix}{name}", self._parts)
        for name, joint in scope.joints.items():
            made = self._joint(scope, joint, name, prefix, turn)
            if made is not None:
                self._joints.append(made)

    def _joint(self, scope: Scope, element: SourceElement, name: str, prefix: str, turn: Pose7) -> SdfJoint | None:
        kind, file = joint_type(element), scope.file
        if not kind:
            word = element.attributes.get("type", "")
            what = f"the joint `{prefix}{name}` of type `{word}` is left out"
            file.lose("gearbox-joints" if word == "gearbox" else "joints", what, element)
            return None
        ends: list[str] = []
        for tag in ("parent", "child"):
            end = text_of(element, tag) or text_of(element, tag, "link_name")
            found = "" if end == WORLD else scope.link_of(end, element)
            if found is None:
                return None
            ends.append(prefix + found if found else "")
        if ends[0] == ends[1]:
            file.error(f"the joint `{prefix}{name}` connects a link to itself", element)
            return None
        if any(end.startswith(robot) for end in ends for robot in self._robots):
            above = f"{self._model.name}{SEPARATOR}{prefix}"
            self._parts.crossings.append(Crossing(scope, element, name, above, compose(self._pose, turn)))
            return None
        pose = compose(turn, scope.pose_of(name, element))
        path, parent, child = prefix + name, ends[0], ends[1]
        return SdfJoint(scope, element, path, kind, parent, child, pose, turn)

    def _groups(self) -> list[list[str]]:
        """Groups links that joints connect, each group in file order; in a static model each link is a group."""
        owner = {path: path for path in self._links}

        def top(path: str) -> str:
            while owner[path] != path:
                owner[path] = path = owner[owner[path]]
            return path

        if not self._model.is_static:
            for joint in self._joints:
                if joint.parent and joint.child:
                    owner[top(joint.child)] = top(joint.parent)
        groups: dict[str, list[str]] = {}
        for path in self._links:
            groups.setdefault(top(path), []).append(path)
        return list(groups.values())

    def _add(self, group: list[str], joints: list[SdfJoint], *, is_only: bool) -> None:
        first = self._links[group[0]]
        wish = self._model.name if is_only else f"{self._model.name}.{first.path}"
        is_fixed = len(group) == 1 and all(joint.type == "fixed" for joint in joints) and bool(joints)
        if self._model.is_static or is_fixed:
            self._add_body(first, wish, "static")
        elif len(group) == 1 and not joints:
            self._add_body(first, wish, "")
        else:
            _Tree(self._links, group, joints, self).add(wish)

    def _add_body(self, link: SdfLink, wish: str, body_type: str) -> None:
        file, parts = link.scope.file, self._parts
        if not body_type and file.flag(link.element, "kinematic", default=False):
            body_type = "kinematic"
        content = self.link_content(link, moves=not body_type)
        world = compose(self._pose, link.pose)
        has_shape = any(key in content for key in ("shapes", "collisions", "visuals"))
        if body_type and not has_shape:
            self.note(link, BuiltLink("", world, is_moved=False))
            file.lose("empty-links", f"the link `{link.path}` has no shape and does not move", link.element)
            return
        name = parts.names.new(wish)
        place = pose_key(world)
        if not has_shape:
            # Only an articulation may have no shapes.
            parts.entities[name] = {**place, "root": {"name": Names().new(link.path), **content}}
            self.note(link, BuiltLink(f"{name}/{Names().new(link.path)}", world, is_moved=True))
            return
        if body_type == "static" and not any(key in content for key in ("shapes", "collisions")):
            body_type = "none"
        if body_type == "none":
            content.pop("gravity", None)
        kind = {"body_type": body_type} if body_type else {}
        content.update({**kind, **place})
        parts.entities[name] = content
        self.keep_bitmask(content, link, name)
        self.note(link, BuiltLink(name, world, is_moved=not body_type))

    def keep_bitmask(self, node: Node, link: SdfLink, entity: str) -> None:
        """Moves the bitmasks that `link_content` left in a node and its shapes to `parts`."""
        for one in (node, *_collision_shapes(node)):
            if "bitmask" in one:
                self._parts.bitmasks.append(Bitmask(one, one.pop("bitmask"), link, entity))

    def note(self, link: SdfLink, built: BuiltLink) -> None:
        """Records the location of a link."""
        path = f"{self._model.name}{SEPARATOR}{link.path}"
        self._parts.links[path] = built
        place = LinkPlace(link.scope, link.path, relative_pose(link.turn, link.pose), built.is_moved)
        self._parts.places[path] = (link.element, place)
        if built.name:
            self._parts.bodies[built.name] = path
            self._parts.locations[built.name] = link.element.location
            self._parts.locations.setdefault(built.name.partition("/")[0], self._model.element.location)

    @property
    def parts(self) -> SceneParts:
        """Receives the result."""
        return self._parts

    @property
    def model(self) -> Scope:
        """The model's scope."""
        return self._model

    @property
    def pose(self) -> Pose7:
        """Pose of the model in the world."""
        return self._pose

    def link_content(self, link: SdfLink, *, moves: bool, joints: bool = False) -> Node:
        """Returns shapes, mass and motion of a link."""
        file, element = link.scope.file, link.element
        place = LinkPlace(link.scope, link.path, relative_pose(link.turn, link.pose), moves)
        content: Node = {**read_shapes(element, place)}
        _note_bitmask(content)
        if not moves:
            return content
        content |= _mass(link, content)
        if joints and file.flag(element, "kinematic", default=False):
            file.lose("kinematic-links", f"the link `{link.path}` is kinematic, but has joints", element)
        if not file.flag(element, "gravity", default=True):
            content["gravity"] = False
        for tag, key in (("linear", "linear_damping"), ("angular", "angular_damping")):
            if find_element(element, "velocity_decay", tag) is not None:
                content[key] = plain_number(max(file.number(element, "velocity_decay", tag, default=0), 0.0))
        return content


def _note_bitmask(content: Node) -> None:
    """Merges equal bitmasks of a link's shapes into one of the link."""
    masks = {shape["bitmask"] for shape in _collision_shapes(content)}
    if len(masks) == 1:
        (content["bitmask"],) = masks
        for shape in _collision_shapes(content):
            del shape["bitmask"]


def _collision_shapes(content: Node) -> list[Node]:
    return [*content.get("shapes", ()), *content.get("collisions", ())]


def _collides(node: Node) -> bool:
    """Returns whether an entity, or a link below it, has a collision shape."""
    return any(
        key in {"shapes", "collisions"}
        or (key == "root" and _collides(value))
        or (key == "children" and any(map(_collides, value)))
        for key, value in node.items()
    )


def _mass(link: SdfLink, content: Node) -> Node:
    """Returns the mass keys of a link: from the file, from its shapes (`auto`), or SDF's default 1 kg, 1 kg·m²."""
    file, inertial = link.scope.file, link.element.find("inertial")
    collides = bool(_collision_shapes(content))
    if inertial is not None and inertial.attributes.get("auto", "").lower() in {"true", "1"} and collides:
        if inertial.find("mass") is not None:
            return {"mass": plain_number(file.positive(inertial, "mass", default=1))}
        density = file.positive(inertial, "density", default=1000)
        mass = sum(solid_mass(shape, density) for shape in _collision_shapes(content))
        # SAPIEN's cylinders are hulls and weigh slightly less.
        return {"density": plain_number(density)} if math.isnan(mass) else {"mass": plain_number(mass)}
    for shape in _collision_shapes(content):
        shape.pop("density", None)
    mass = file.number(inertial, "mass", default=1)
    names, default = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), (1, 1, 1, 0, 0, 0)
    xx, yy, zz, xy, xz, yz = (
        file.number(inertial, "inertia", name, default=value) for name, value in zip(names, default, strict=True)
    )
    pose = IDENTITY_POSE if inertial is None else file.pose(inertial)
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], np.float64)
    moments, axes = np.diag(tensor), np.eye(3)
    if xy or xz or yz:
        moments, axes = np.linalg.eigh(tensor)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        pose = compose(pose, (0.0, 0.0, 0.0, *from_matrix(axes.tolist())))
    low, middle, high = sorted(float(each) for each in moments)
    if min(mass, low) < _LEAST_INERTIA or low + middle < high * (1 - 1e-6):
        shown = f"mass {mass:g} kg and moments {low:.3g}, {middle:.3g}, {high:.3g}"
        instead = (
            f"{mass:g} kg with the inertia of its shapes" if mass >= _LEAST_INERTIA and collides else "a small mass"
        )
        file.lose("inertias", f"`{link.path}` has impossible {shown}; it gets {instead}", inertial or link.element)
        if mass >= _LEAST_INERTIA and collides:
            return {"mass": plain_number(mass)}
        mass = mass if mass >= _LEAST_INERTIA else _DUMMY_MASS
        moments = np.full(3, mass * 1e-2)
    return {"inertial": {"mass": plain_number(mass), **pose_key(pose, "com"), "inertia": _moments(moments)}}


def _moments(moments: Any) -> list[float]:
    """Rounds to significant digits, not decimals: moments of small bodies are small."""
    return [float(f"{float(each):.12g}") for each in moments]


class _Tree:
    """Builds an articulation from connected links; joints that close loops become constraints."""

    def __init__(
        self, links: dict[str, SdfLink], group: list[str], joints: list[SdfJoint], reader: SdfModelReader
    ) -> None:
        self._links = {path: links[path] for path in group}
        self._joints = joints
        self._reader = reader
        self._link_names, self._joint_names = Names("world"), Names()
        self._named = {path: self._link_names.new(path) for path in group}
        self._called = {joint.path: self._joint_names.new(joint.path) for joint in joints}
        self._entity: Node = {}
        self._used: set[str] = set()

    def add(self, wish: str) -> None:
        """Adds the articulation to the document, under a free name like `wish`."""
        reader = self._reader
        if len(self._links) > _MAX_LINKS:
            model = reader.model
            message = f"joints connect {len(self._links)} links of `{model.name}`, more than PhysX supports"
            model.file.error(message, model.element, hint=f"an articulation has at most {_MAX_LINKS} links")
            return
        name = reader.parts.names.new(wish)
        anchors = [joint for joint in self._joints if not (joint.parent and joint.child)]
        anchor = next(iter(anchors), None)
        if anchor is None:
            root, is_fixed = self._root(), False
            top = self._node(root, name, None)
            place = self._links[root].pose
        elif anchor.type == "fixed":
            root, is_fixed = anchor.child or anchor.parent, True
            self._used.add(anchor.path)
            top, place = self._node(root, name, None), self._links[root].pose
        else:
            is_fixed, place = True, IDENTITY_POSE
            hangs = self._attach_link(anchor, "", anchor.child or anchor.parent, name)
            top = {"name": self._link_names.new("base"), "children": [hangs]}
        entity: Node = pose_key(compose(reader.pose, place))
        if is_fixed:
            entity["fix_root_link"] = True
        model = reader.model
        if not model.file.flag(model.element, "self_collide", default=False) and _collides({"root": top}):
            entity["disable_self_collisions"] = True
        reader.parts.entities[name] = {**entity, **self._entity, "root": top}
        for joint in self._joints:
            if joint.path not in self._used:
                self._close(joint, name)

    def _root(self) -> str:
        children = {joint.child for joint in self._joints}
        return next((path for path in self._links if path not in children), next(iter(self._links)))

    def _node(self, path: str, entity: str, joint: Node | None) -> Node:
        """Returns a link with its subtree. Recursion is at most 255 deep, since larger articulations are refused."""
        link, reader = self._links[path], self._reader
        self._used.add(f"link {path}")
        reader.note(link, BuiltLink(f"{entity}/{self._named[path]}", compose(reader.pose, link.pose), is_moved=True))
        node: Node = {"name": self._named[path]}
        if joint is not None:
            node["joint"] = joint
        node |= reader.link_content(link, moves=True, joints=True)
        reader.keep_bitmask(node, link, entity)
        children: list[Node] = []
        for each in self._joints:
            other = each.child if each.parent == path else each.parent if each.child == path else ""
            if other and each.path not in self._used and f"link {other}" not in self._used:
                children.append(self._attach_link(each, path, other, entity))
        return {**node, "children": children} if children else node

    def _attach_link(self, joint: SdfJoint, parent: str, child: str, entity: str) -> Node:
        """Returns a link attached to another by a joint, with intermediate links between the joint's hinges."""
        self._used.add(joint.path)
        hinges: list[Hinge | None] = [*hinges_of(joint)] or [None]
        is_reversed = joint.child != child
        ordered = hinges[::-1] if is_reversed else hinges
        name = self._called[joint.path]
        above = self._links[parent].pose if parent else IDENTITY_POSE
        nodes: list[dict[str, Any]] = []
        for number, hinge in enumerate(ordered):
            is_last = number == len(ordered) - 1
            below = self._links[child].pose if is_last else joint.pose
            called = name if len(ordered) == 1 else self._joint_names.new(f"{name}_{number + 1}")
            made = sdf_tree_joint(called, hinge, (above, below, joint.pose), is_reversed=is_reversed)
            self._note_joint(hinge, called)
            if is_last:
                nodes.append(self._node(child, entity, self._add_mimic(joint, made)))
            else:
                small: Node = {"mass": _DUMMY_MASS, "inertia": [_DUMMY_MASS] * 3}
                nodes.append({"name": self._link_names.new(f"{name}_{number + 1}"), "joint": made, "inertial": small})
            above = below
        for outer, inner in pairwise(nodes):
            outer["children"] = [inner]
        return nodes[0]

    def _add_mimic(self, joint: SdfJoint, made: Node) -> Node:
        mimic = None if made["type"] == "fixed" else mimic_of(joint, self._called)
        return made if mimic is None else {**made, "mimic": mimic}

    def _note_joint(self, hinge: Hinge | None, name: str) -> None:
        if hinge is None:
            return
        pattern = name.replace(".", "\\.")
        if hinge.velocity is not None:
            self._entity.setdefault("joints", {})[pattern] = {"max_velocity": plain_number(hinge.velocity)}
        if hinge.drive is not None:
            self._entity.setdefault("drives", {})[pattern] = hinge.drive

    def _close(self, joint: SdfJoint, entity: str) -> None:
        ends: list[tuple[str, Pose7]] = []
        for path in (joint.parent, joint.child):
            world = invert(self._reader.pose)
            ends.append((f"{entity}/{self._named[path]}", self._links[path].pose) if path else ("world", world))
        if ends[1][0] == "world":
            ends.reverse()
        made = make_constraint(joint, (ends[0][0], ends[1][0]), (ends[0][1], ends[1][1]), hinges_of(joint))
        parts = self._reader.parts
        parts.constraints[parts.constraint_names.new(joint.path)] = made
