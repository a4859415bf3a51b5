"""Describes SDF models: bodies, robots, and the joints that become constraints between them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose, from_matrix
from scenecc.importers.numbers import plain_name
from scenecc.importers.sdf_files import find_element
from scenecc.importers.sdf_joints import SdfJoint, freedoms_of, read_sdf_joint, sdf_constraint
from scenecc.importers.sdf_scopes import SEPARATOR, WORLD, Scope
from scenecc.importers.sdf_shapes import SdfLink, read_collisions, read_visuals
from scenecc.names import UniqueNames
from scenecc.plan.articulation import MAX_LINKS
from scenecc.robots.description import (
    IN_WORLD,
    DescribedCollision,
    DescribedConstraint,
    DescribedInertial,
    DescribedJoint,
    DescribedLink,
    DescribedMotion,
    DescribedRobot,
    LinkName,
    PlaneGeometry,
    SolidGeometry,
    ball_moment,
)
from scenecc.robots.rules import enforce_triangle_rule, split_joint
from scenecc.robots.solids import exact_mass
from scenecc.robots.world import DescribedEntity, RobotFile

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.importers.urdf import ReadUrdf

_LEAST: Final = 1e-30
"""Smaller masses and moments count as 0 in the engine's single precision [kg, kg·m²]."""

_SMALL_MASS: Final = 1e-6
"""Mass of a link whose mass is 0 [kg]."""


@dataclass(frozen=True, slots=True)
class BuiltLink:
    """A link in the described world.

    Attributes:
        name: `IN_WORLD` if it is not built.
        pose: in the world.
        is_moved: whether forces can move it.
        link: of an SDF; None: of a URDF.
    """

    name: LinkName
    pose: Pose7
    is_moved: bool
    link: SdfLink | None = None


@dataclass(slots=True)
class WorldParts:
    """Collects the described models of a world.

    Attributes:
        entities, constraints: of the world.
        links: by path from the world.
        free_roots: path of the root of an included URDF that is free → index of its entity.
        loose: joints that no tree contains.
        apart: number of models whose bodies do not collide with one another.
    """

    entities: list[DescribedEntity] = field(default_factory=list[DescribedEntity])
    constraints: list[DescribedConstraint] = field(default_factory=list[DescribedConstraint])
    links: dict[str, BuiltLink] = field(default_factory=dict[str, BuiltLink])
    free_roots: dict[str, int] = field(default_factory=dict[str, int])
    loose: list[SdfJoint] = field(default_factory=list[SdfJoint])
    apart: int = 0

    def connect(self, joint: SdfJoint) -> None:
        """Describes a loose joint as a constraint. One that fixes the root of a URDF to the world is its key."""
        in_world = BuiltLink(IN_WORLD, IDENTITY_POSE, is_moved=False)
        ends = [self.links.get(path, in_world) for path in (joint.parent, joint.child)]
        ends = [in_world if end.name == IN_WORLD else end for end in ends]
        if ends[0].name == ends[1].name:
            joint.scope.file.error(f"the joint `{joint.path}` connects a body to itself", joint.element)
            return
        root = self.free_roots.get(joint.child or joint.parent)
        if joint.type == "fixed" and "" in (joint.parent, joint.child) and root is not None:
            entity = self.entities[root]
            assert isinstance(entity.content, RobotFile)
            keys = tuple(row for row in entity.content.keys if row[0] != "fix_root_link")
            self.entities[root] = replace(entity, content=replace(entity.content, keys=keys))
            return
        is_reversed = not ends[1].is_moved
        parent, child = reversed(ends) if is_reversed else ends
        if child.is_moved:
            rows = (parent.name, parent.pose), (child.name, child.pose)
            self.constraints.append(sdf_constraint(joint, *rows, is_reversed=is_reversed))


def add_robot(model: Scope, pose: Pose7, path: str, parts: WorldParts) -> None:
    """Adds an included URDF. Its root is free, unless it is called `world`, as URDF writes a fixed base.

    Args:
        model: its scope.
        pose: of the model in the world.
        path: of the model from the world.
        parts: receives the entity, and a constraint for each single body called `world`.
    """
    read = model.robot
    if read is None:
        return
    model.file.losses.extend(read.losses)
    place = model.placing.location
    shown = path.rpartition(SEPARATOR)[0] if model.is_merged else path
    keys = [*read.keys, *([("body_type", "static")] if model.is_static else [])]
    is_freed = False
    for robot in read.robots:
        root = robot.links[0].name
        is_free = not model.is_static and root != WORLD
        for link in robot.links:
            world = compose(pose, model.pose_of(link.name, model.placing))
            # The links of a static model are one body.
            name = IN_WORLD if model.is_static else (path, link.name)
            parts.links[path + SEPARATOR + link.name] = BuiltLink(name, world, not model.is_static)
        if model.is_static:
            continue
        is_freed = is_freed or is_free or len(robot.links) == 1
        if is_free and len(robot.links) > 1:
            parts.free_roots[path + SEPARATOR + root] = len(parts.entities)
        elif not is_free and len(robot.links) == 1:
            at = parts.links[path + SEPARATOR + root].pose
            weld = DescribedConstraint(shown, "weld", IN_WORLD, (path, root), at, IDENTITY_POSE, place)
            parts.constraints.append(weld)
    keys += [("fix_root_link", False)] if is_freed else []
    if model.is_static and not any(link.collisions or link.visuals for robot in read.robots for link in robot.links):
        model.file.lose("empty-links", f"`{shown}` has no shape and does not move", model.placing)
        return
    file = RobotFile("urdf", read.path, pose, tuple(keys), _named(read, shown))
    parts.entities.append(DescribedEntity(path, file, place, shown.replace(SEPARATOR, ".")))


def _named(read: ReadUrdf, path: str) -> tuple[DescribedRobot, ...]:
    """Returns the robots of a URDF, whose links have the names that Drake gives them in a model."""
    return tuple(
        replace(robot, links=tuple(replace(link, source=path + SEPARATOR + link.name) for link in robot.links))
        for robot in read.robots
    )


class SdfModelReader:
    """Reads one top model.

    Args:
        model: its scope.
        pose: of its frame in the world.
        parts: receives the result.
    """

    def __init__(self, model: Scope, pose: Pose7, parts: WorldParts) -> None:
        self.model = model
        self._pose = pose
        self._parts = parts
        self._links: dict[str, SdfLink] = {}
        self._joints: list[SdfJoint] = []
        self._bit = 0
        self.self_collisions = model.file.flag(model.element, "self_collide", default=False)

    def read(self) -> None:
        """Adds the model's entities and loose joints."""
        self._collect(self.model, "", self._pose)
        groups = self._groups()
        if len(groups) > 1 and not self.model.is_static and not self.self_collisions:
            self._bit = 1 << self._parts.apart
            self._parts.apart += 1
        first_of = {path: group[0] for group in groups for path in group}
        joints_of: dict[str, list[SdfJoint]] = {}
        for joint in self._joints:
            joints_of.setdefault(first_of[joint.child or joint.parent], []).append(joint)
        for group in groups:
            self._add(group, joints_of.get(group[0], []), is_only=len(groups) == 1)

    def _collect(self, scope: Scope, prefix: str, turn: Pose7) -> None:
        """Collects all links and joints, including nested ones. `turn`: pose of the scope's frame in the world."""
        above = f"{self.model.name}{SEPARATOR}{prefix}"
        named = [("model", scope.name, scope.placing)]
        named += [("link", name, link) for name, link in scope.links.items()]
        named += [("joint", name, joint) for name, joint in scope.joints.items()]
        for what, name, element in named:
            if plain_name(name) != name.replace(SEPARATOR, "."):
                scope.file.lose("names", f"the {what} `{cut(name)}` is renamed to `{plain_name(name)}`", element)
        for name, link in scope.links.items():
            own = scope.pose_of(name, link)
            self._links[above + name] = SdfLink(scope, link, prefix + name, own, compose(turn, own))
        for name, model in scope.models.items():
            pose = compose(turn, scope.model_pose(model))
            if model.robot is None:
                self._collect(model, f"{prefix}{name}{SEPARATOR}", pose)
            else:
                add_robot(model, pose, above + name, self._parts)
        for name, element in scope.joints.items():
            joint = read_sdf_joint(scope, element, name, (above, prefix), turn)
            if joint is not None:
                own = all(not end or end in self._links for end in (joint.parent, joint.child))
                (self._joints if own else self._parts.loose).append(joint)

    def _groups(self) -> list[list[str]]:
        """Groups links that joints connect, each group in file order; in a static model each link is a group."""
        owner = {path: path for path in self._links}

        def top(path: str) -> str:
            while owner[path] != path:
                owner[path] = path = owner[owner[path]]
            return path

        if not self.model.is_static:
            for joint in self._joints:
                if joint.parent and joint.child:
                    owner[top(joint.child)] = top(joint.parent)
        groups: dict[str, list[str]] = {}
        for path in self._links:
            groups.setdefault(top(path), []).append(path)
        return list(groups.values())

    def _add(self, group: list[str], joints: list[SdfJoint], *, is_only: bool) -> None:
        first, model = self._links[group[0]], self.model
        is_fixed = len(group) == 1 and bool(joints) and all(joint.type == "fixed" for joint in joints)
        if model.is_static or is_fixed:
            made = self._body(group[0], "static")
        elif len(group) == 1 and not joints:
            made = self._body(group[0], "dynamic")
        elif len(group) > MAX_LINKS:
            message = f"joints connect {len(group)} links of `{model.name}`, more than PhysX supports"
            model.file.error(message, model.element, hint=f"an articulation has at most {MAX_LINKS} links")
            return
        else:
            tree = _Tree({path: self._links[path] for path in group}, joints, self)
            made = tree.robot()
            self._parts.loose += tree.loose
        if made is None:
            return
        wish = model.name if is_only else f"{model.name}.{first.path}"
        self._parts.entities.append(DescribedEntity(group[0], made, model.element.location, wish))
        is_moved = made.body_type in {None, "dynamic"}
        for path in group:
            link = self._links[path]
            self._parts.links[path] = BuiltLink((group[0], link.path), link.pose, is_moved, link)

    def _body(self, path: str, body_type: Any) -> DescribedRobot | None:
        """Returns a single body; None if it would neither move nor be seen."""
        link = self._links[path]
        file = link.scope.file
        if body_type == "dynamic" and file.flag(link.element, "kinematic", default=False):
            body_type = "kinematic"
        made = self.describe(path, moves=body_type == "dynamic")
        if body_type != "dynamic" and not (made.collisions or made.visuals):
            self._parts.links[path] = BuiltLink(IN_WORLD, link.pose, is_moved=False, link=link)
            file.lose("empty-links", f"the link `{link.path}` has no shape and does not move", link.element)
            return None
        return DescribedRobot((made,), body_type, pose=link.pose, location=link.element.location)

    def describe(self, path: str, *, moves: bool, joints: bool = False) -> DescribedLink:
        """Returns shapes, mass and motion of a link."""
        link = self._links[path]
        file, element = link.scope.file, link.element
        visuals, collisions = read_visuals(link, moves=moves), read_collisions(link, moves=moves)
        made = DescribedLink(
            link.path, element.location, collisions=collisions, visuals=visuals, ignore_bits=self._bit, source=path
        )
        if not moves:
            return made
        if joints and file.flag(element, "kinematic", default=False):
            file.lose("kinematic-links", f"the link `{link.path}` is kinematic, but has joints", element)
        inertial, collisions = _weigh(link, collisions)
        decay = [
            max(file.number(element, "velocity_decay", tag, default=0), 0.0)
            if find_element(element, "velocity_decay", tag) is not None
            else None
            for tag in ("linear", "angular")
        ]
        return replace(
            made,
            collisions=collisions,
            inertial=inertial,
            disable_gravity=not file.flag(element, "gravity", default=True),
            motion=DescribedMotion(*decay),
        )


def _weigh(
    link: SdfLink, collisions: tuple[DescribedCollision, ...]
) -> tuple[DescribedInertial | None, tuple[DescribedCollision, ...]]:
    """Returns the inertial of a link, and its shapes with the densities that its mass depends on.

    It is from the file, from its shapes (`auto`), or SDF's default 1 kg, 1 kg·m².
    """
    file, inertial = link.scope.file, link.element.find("inertial")
    if inertial is None or inertial.attributes.get("auto", "").lower() not in {"true", "1"} or not collisions:
        return _inertial(link, collides=bool(collisions)), tuple(replace(each, density=None) for each in collisions)
    density = file.positive(inertial, "density", default=1000)
    dense = tuple(each if each.density is not None else replace(each, density=density) for each in collisions)
    if inertial.find("mass") is not None:
        mass = file.positive(inertial, "mass", default=1)
    else:
        mass = math.fsum(map(_mass_of, dense))
    if math.isnan(mass):
        return None, dense
    is_even = all(each.density is None for each in collisions)
    return DescribedInertial(mass, IDENTITY_POSE, None, inertial.location), collisions if is_even else dense


def _mass_of(shape: DescribedCollision) -> float:
    """Returns the mass of a solid [kg]; nan for a mesh. SAPIEN's cylinders and cones are hulls and weigh less."""
    solid = shape.geometry
    if isinstance(solid, PlaneGeometry):
        return 0.0
    exact = exact_mass(solid, shape.pose) if isinstance(solid, SolidGeometry) else None
    return math.nan if exact is None else (shape.density or 0.0) * exact.mass


def _inertial(link: SdfLink, *, collides: bool) -> DescribedInertial:
    """Returns the inertial that the file gives, made possible if necessary (a loss)."""
    file, inertial = link.scope.file, link.element.find("inertial")
    place = inertial or link.element
    mass = file.number(inertial, "mass", default=1)
    names, default = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), (1, 1, 1, 0, 0, 0)
    xx, yy, zz, xy, xz, yz = (
        file.number(inertial, "inertia", name, default=value) for name, value in zip(names, default, strict=True)
    )
    pose, moments = IDENTITY_POSE if inertial is None else file.pose(inertial), (xx, yy, zz)
    if xy or xz or yz:
        values, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], np.float64))
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        pose = compose(pose, (0.0, 0.0, 0.0, *from_matrix(axes.tolist())))
        moments = (float(values[0]), float(values[1]), float(values[2]))
    shown = (
        f"`{link.path}` has impossible mass {mass:g} kg and moments {', '.join(f'{m:.3g}' for m in sorted(moments))}"
    )
    if mass >= _LEAST and min(moments) >= _LEAST:
        ruled = enforce_triangle_rule(moments)
        if ruled != moments:
            file.lose("inertias", f"{shown}; the largest is lowered to {max(ruled):.3g}", place)
        return DescribedInertial(mass, pose, ruled, place.location)
    if mass >= _LEAST and collides:
        file.lose("inertias", f"{shown}; it gets {mass:g} kg with the inertia of its shapes", place)
        return DescribedInertial(mass, IDENTITY_POSE, None, place.location)
    file.lose("inertias", f"{shown}; it gets a small mass", place)
    mass = mass if mass >= _LEAST else _SMALL_MASS
    moment = ball_moment(mass)
    return DescribedInertial(mass, pose, (moment, moment, moment), place.location)


class _Tree:
    """Builds a robot from connected links.

    Attributes:
        loose: joints that close loops.
    """

    def __init__(self, links: dict[str, SdfLink], joints: list[SdfJoint], reader: SdfModelReader) -> None:
        self._links = links
        self._left = dict.fromkeys(joints)
        self._reader = reader
        self._fresh = UniqueNames(*(link.path for link in links.values()))
        self._made: list[DescribedLink] = []
        self._seen: set[str] = set()

    @property
    def loose(self) -> list[SdfJoint]:
        return [*self._left]

    def robot(self) -> DescribedRobot:
        """Returns the robot. A joint to the world fixes its root, or attaches it to a fixed link."""
        anchor = next((joint for joint in self._left if not (joint.parent and joint.child)), None)
        if anchor is None:
            children = {joint.child for joint in self._left}
            root = next((path for path in self._links if path not in children), next(iter(self._links)))
            pose = self._add(root, None, ())
        elif anchor.type == "fixed":
            del self._left[anchor]
            pose = self._add(anchor.child or anchor.parent, None, ())
        else:
            pose = IDENTITY_POSE
            self._made.append(DescribedLink(self._fresh.new("base"), anchor.element.location, is_added=True))
            self._attach(anchor, "", 0)
        place, collide = self._reader.model.element.location, self._reader.self_collisions
        links = tuple(map(self._with_known_source, self._made))
        return DescribedRobot(links, None, anchor is not None, pose, place, self_collisions=collide)

    def _add(self, path: str, parent: int | None, freedoms: Sequence[DescribedJoint]) -> Pose7:
        """Adds a link with its subtree; recursion is at most 255 deep. Returns the link's pose."""
        self._seen.add(path)
        link = replace(self._reader.describe(path, moves=True, joints=True), parent=parent)
        small = [self._fresh.new(joint.name) for joint in freedoms[:-1]]
        self._made += split_joint(link, freedoms, small, len(self._made)) if freedoms else (link,)
        index = len(self._made) - 1
        for joint in [*self._left]:
            if path in (joint.parent, joint.child) and joint in self._left:
                self._attach(joint, path, index)
        return self._links[path].pose

    def _attach(self, joint: SdfJoint, path: str, parent: int) -> None:
        """Adds the link at a joint's other end, unless the joint closes a loop. `path`: "" for the world."""
        other = joint.child if joint.parent == path else joint.parent
        if not other or other in self._seen:
            return
        del self._left[joint]
        if joint.type == "ball":
            joint.scope.file.lose("ball-joints", f"the ball joint `{joint.path}` becomes three hinges", joint.element)
        above = self._links[path].pose if path else IDENTITY_POSE
        freedoms = freedoms_of(joint, above, self._links[other].pose, is_reversed=joint.child != other)
        self._add(other, parent, freedoms)

    def _with_known_source(self, link: DescribedLink) -> DescribedLink:
        """Returns a link; after an error, without a mimic of a joint that does not move."""
        joint = link.joint
        if joint is None or joint.mimic is None:
            return link
        source, others = joint.mimic.source, (each.joint for each in self._made)
        if any(other is not None and other.name == source and other.type != "fixed" for other in others):
            return link
        message = f"`{joint.name}` mimics `{cut(source)}`, but there is no such joint that moves"
        self._reader.model.file.context.sink.report("SC433", message, joint.mimic.location)
        return replace(link, joint=replace(joint, mimic=None))
