"""Converts a USD stage: bodies, joints, materials, lights and cameras."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import compose, to_vector
from scenecc.importers.imported_scene import ImportContext, ImportedScene, ReferencePose
from scenecc.importers.numbers import plain_name, plain_numbers
from scenecc.importers.usd_articulations import JointTree, UsdArticulationReader, find_trees
from scenecc.importers.usd_bodies import UsdBody, UsdBodyReader
from scenecc.importers.usd_contacts import report_contacts
from scenecc.importers.usd_filters import CollisionFilters
from scenecc.importers.usd_instancers import expand_instancers
from scenecc.importers.usd_joints import UsdJoint, UsdJointReader, usd_constraint
from scenecc.importers.usd_losses import check_attribute_types, report_unread
from scenecc.importers.usd_materials import UsdMaterialReader
from scenecc.importers.usd_rendering import RenderingReader
from scenecc.importers.usd_shapes import SOLID_TYPES
from scenecc.importers.usd_stage import UP_ROTATIONS, Prim, UsdLayers, UsdStage
from scenecc.importers.writer import write_world
from scenecc.names import UniqueNames
from scenecc.robots.description import IN_WORLD, DescribedConstraint, DescribedRobot, LinkName
from scenecc.robots.world import DescribedEntity, DescribedPhysics, DescribedWorld

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.geometry.rotations import Pose7


def read_stage(path: Path, context: ImportContext) -> ImportedScene | None:
    """Reads a stage in this process; returns None after an error, which is reported in the context's sink."""
    layers = UsdLayers(context)
    try:
        opened = layers.open(path)
        return None if opened is None else _read_opened(UsdStage(opened, path, layers), path, context)
    except (layers.error, UnicodeDecodeError) as error:
        layers.report_unreadable(path, error)
        return None


def _read_opened(stage: UsdStage, path: Path, context: ImportContext) -> ImportedScene | None:
    for unit, size in (("metersPerUnit", stage.frames.metres), ("kilogramsPerUnit", stage.frames.kilograms)):
        if not _MIN_UNIT <= size <= 1 / _MIN_UNIT:
            context.sink.report("SC430", f"`{unit}` is {size:g}, which is out of range", Location(str(path)))
    if stage.frames.up_axis not in UP_ROTATIONS:
        context.sink.report("SC430", f"`upAxis` is `{cut(stage.frames.up_axis)}`: not X, Y or Z", Location(str(path)))
    check_attribute_types(stage, context.sink)
    if context.sink.failed:
        return None
    expand_instancers(stage, context.limits.objects)
    if not stage.layers.composes(stage.stage, path):
        return None
    for prim in stage.prims():
        if prim.IsA(stage.geom.Xformable) and not np.isfinite(stage.frames.world(prim)).all():
            message = f"the transform of {prim.GetPath()} is not finite"
            context.sink.report("SC430", message, Location(str(path)))
    return None if context.sink.failed else UsdSceneReader(stage, context).read()


_MIN_UNIT: Final = 1e-9

_EARTH: Final = (0.0, 0.0, -9.81)
"""Default gravity of a scene [m/s²]."""

_ROOT_NAMES: Final = frozenset({"world", "root", "scene", "stage"})
"""Names of a prim that contains everything, in lower case; no body is named after it."""


class UsdSceneReader:
    """Describes a stage as a world, and writes it as a scene document."""

    def __init__(self, stage: UsdStage, context: ImportContext) -> None:
        self._stage = stage
        self._materials = UsdMaterialReader(stage, context.sink)
        self._reader = UsdBodyReader(stage, self._materials)
        self._parsed = _parse(stage)
        self._bodies: dict[str, UsdBody] = {}
        self._articulations = UsdArticulationReader(stage, self._reader, self._bodies)
        self._entities: list[DescribedEntity] = []
        self._links: dict[str, LinkName] = {}

    def read(self) -> ImportedScene:
        """Returns the document with its losses."""
        stage = self._stage
        groups = self._collect()
        moving = {path: body for path, body in self._bodies.items() if body.body_type == "dynamic"}
        trees, rest = find_trees(self._joints(), moving, self._roots())
        self._add_entities(groups, trees)
        rest += [joint for tree in trees for joint in tree.rest]
        filters = CollisionFilters(stage, groups, self._parsed.get("CollisionGroup", []))
        filters.add_joints([*rest, *(joint for tree in trees for joint in tree.split_joints)])
        filters.add_filtered(
            each for kind in ("RigidBody", "Shape", "Articulation") for each in self._parsed.get(kind, [])
        )
        filters.add_groups()
        adjacent = (frozenset(joint.bodies) for tree in trees for joint in tree.joints if not joint.collides)
        constraints = tuple(each for joint in rest if (each := self._constraint(joint)) is not None)
        report_contacts(stage, self._materials, groups, {*filters.pairs, *adjacent})
        rendering = RenderingReader(stage, self._materials, self._link_of)
        rendering.read()
        report_unread(stage, self._articulations.mimics)
        world = DescribedWorld(
            plain_name(stage.path.stem),
            tuple(self._entities),
            self._physics(),
            constraints,
            tuple(rendering.lights),
            tuple(rendering.cameras),
            frozenset(
                frozenset(self._links[path] for path in pair) for pair in filters.pairs if pair <= self._links.keys()
            ),
            rendering.ambient,
            rendering.environment,
        )
        written = write_world(world)
        for first, second in written.unwritten:
            stage.lose(
                "collision-filters", f"`{first}` and `{second}` would collide", stage.prim(written.bodies[first])
            )
        return ImportedScene(written.document, tuple(stage.losses), written.bodies, self._reference())

    def _reference(self) -> dict[str, ReferencePose]:
        found: dict[str, ReferencePose] = {}
        for path, body in self._bodies.items():
            if path in self._links:
                parsed = body.parsed
                pose = self._stage.frames.frame_in(None, parsed.position, parsed.rotation)
                found[path] = ReferencePose(pose, self._reader.masses.get(path))
        return found

    def _physics(self) -> DescribedPhysics:
        scenes = self._parsed.get("Scene", [])
        if not scenes:
            return DescribedPhysics()
        for other in scenes[1:]:
            self._stage.lose("physics-scenes", "a second physics scene", self._stage.prim(other.primPath))
        found, frames = scenes[0], self._stage.frames
        # usd-core replaces a zero direction or a negative magnitude by Earth's gravity.
        down = frames.direction(found.gravityDirection)
        gravity = to_vector(plain_numbers([each * found.gravityMagnitude * frames.metres for each in down], 1e-9))
        rate = self._stage.authored(self._stage.prim(found.primPath), "physxScene:timeStepsPerSecond")
        return DescribedPhysics(1 / rate if rate else None, None if gravity == _EARTH else gravity)

    def _collect(self) -> dict[str, UsdBody]:
        """Collects all bodies by prim path: those of UsdPhysics, and groups of static prims."""
        stage = self._stage
        for parsed in self._parsed.get("RigidBody", []):
            if parsed.rigidBodyEnabled:
                prim = stage.prim(parsed.primPath)
                kind = "kinematic" if parsed.kinematicBody else "dynamic"
                self._bodies[str(parsed.primPath)] = UsdBody(prim, stage.frames.pose(prim), kind, parsed=parsed)
        shapes = {str(parsed.primPath): parsed for parsed in self._parsed.get("Shape", [])}
        groups: dict[str, UsdBody] = {}
        for prim in stage.prims():
            if not prim.IsA(stage.geom.Gprim):
                if str(prim.GetPath()) in self._bodies:
                    groups.setdefault(str(prim.GetPath()), self._bodies[str(prim.GetPath())])
                continue
            path = str(prim.GetPath())
            seen = self._is_visible(prim)
            if path not in shapes and not seen:
                continue
            if str(prim.GetTypeName()) not in SOLID_TYPES and path not in shapes:
                stage.lose("visuals", f"a prim of type `{prim.GetTypeName()}`", prim)
                continue
            owner = self._owner(prim)
            body = groups.setdefault(str(owner.prim.GetPath()), owner)
            if path in shapes:
                body.colliders.append((prim, shapes[path]))
            if seen and str(prim.GetTypeName()) in SOLID_TYPES:
                body.visuals.append(prim)
        return groups

    def _is_visible(self, prim: Prim) -> bool:
        image = self._stage.geom.Imageable(prim)
        if image.ComputeVisibility(self._stage.time) == self._stage.geom.Tokens.invisible:
            return False
        return image.ComputePurpose() in {self._stage.geom.Tokens.default_, self._stage.geom.Tokens.render}

    def _owner(self, prim: Prim) -> UsdBody:
        """Returns the body that a prim belongs to: the nearest ancestor body, else a static group."""
        found = self._body_of(prim)
        if found is not None:
            return found
        parent = prim.GetParent()
        is_own_frame = parent.IsPseudoRoot() or self._is_root(parent) or not parent.IsA(self._stage.geom.Xform)
        frame = prim if is_own_frame else parent
        return UsdBody(frame, self._stage.frames.pose(frame), "static")

    def _body_of(self, prim: Prim) -> UsdBody | None:
        """Returns the nearest UsdPhysics body at or above a prim."""
        above = prim
        while above and not above.IsPseudoRoot():
            found = self._bodies.get(str(above.GetPath()))
            if found is not None:
                return found
            above = above.GetParent()
        return None

    def _joints(self) -> list[UsdJoint]:
        poses = {path: body.pose for path, body in self._bodies.items()}
        reader = UsdJointReader(self._stage, poses)
        found = [reader.read(parsed, kind) for kind, parsed in self._parsed.get("Joint", [])]
        order = {prim.GetPath(): k for k, prim in enumerate(self._stage.prims())}
        return sorted((joint for joint in found if joint is not None), key=lambda joint: order[joint.prim.GetPath()])

    def _roots(self) -> dict[str, Prim]:
        found: dict[str, Prim] = {}
        for parsed in self._parsed.get("Articulation", []):
            prim = self._stage.prim(parsed.primPath)
            for body in parsed.articulatedBodies:
                found.setdefault(str(body), prim)
        return found

    def _link_of(self, prim: Prim) -> tuple[LinkName, Pose7] | None:
        """Returns name and pose of the link that a prim belongs to; None without one."""
        body = self._body_of(prim)
        return None if body is None or body.path not in self._links else (self._links[body.path], body.pose)

    def _add_entities(self, groups: dict[str, UsdBody], trees: list[JointTree]) -> None:
        by_body = {body: tree for tree in trees for body in tree.bodies}
        done: set[int] = set()
        for path, body in groups.items():
            tree = by_body.get(path)
            if tree is None:
                self._add_body(body)
            elif id(tree) not in done:
                done.add(id(tree))
                names = UniqueNames()
                links = {each: names.new(self._checked_name(self._bodies[each].prim)) for each in tree.bodies}
                self._links |= {each: (path, name) for each, name in links.items()}
                self._add(path, self._articulations.robot(tree, links), self._preferred_tree_name(tree))

    def _add_body(self, body: UsdBody) -> None:
        link = self._reader.link(body, self._preferred_name(body.prim))
        is_seen = bool(link.collisions or link.visuals)
        if not is_seen and body.body_type != "dynamic":
            return
        dynamics = self._reader.dynamics(body) if body.body_type == "dynamic" else None
        kind = body.body_type
        if dynamics is not None and not is_seen:
            # A body without shapes becomes an articulation of one link.
            kind, dynamics = None, self._reader.velocities(body)
        self._links[body.path] = (body.path, link.name)
        robot = DescribedRobot((link,), kind, pose=body.pose, location=self._stage.place, dynamics=dynamics)
        self._add(body.path, robot, self._checked_name(body.prim))

    def _add(self, name: str, robot: DescribedRobot, wish: str) -> None:
        self._entities.append(DescribedEntity(name, robot, self._stage.place, wish))

    def _preferred_tree_name(self, tree: JointTree) -> str:
        """Returns a name for an articulation: that of the innermost prim that contains all its bodies."""
        if (
            tree.prim is not None
            and str(tree.prim.GetPath()) not in self._bodies
            and not tree.prim.IsA(self._stage.physics.Joint)
        ):
            return self._preferred_name(tree.prim)
        paths = [self._bodies[body].prim.GetPath() for body in tree.bodies]
        common = paths[0].GetParentPath()
        for path in paths[1:]:
            common = common.GetCommonPrefix(path)
        prim = self._stage.prim(common)
        while str(prim.GetTypeName()) == "Scope":
            prim = prim.GetParent()
        is_whole = len(tree.bodies) > 1 and prim and prim.GetName().lower() not in _ROOT_NAMES
        if prim and not prim.IsPseudoRoot() and (is_whole or not self._is_root(prim)):
            return self._preferred_name(prim)
        return self._preferred_name(self._bodies[tree.bodies[0]].prim)

    def _constraint(self, joint: UsdJoint) -> DescribedConstraint | None:
        """Returns a joint between bodies that are not in one tree; None if it has no effect, a loss."""
        ends = joint.bodies
        if not self._moves(ends[1]):
            joint, ends = joint.reversed(), ends[::-1]
        if not self._moves(ends[1]):
            self._stage.lose("idle-joints", "a joint without a moving body", joint.prim)
            return None
        parent = self._links.get(ends[0], IN_WORLD)
        if parent == IN_WORLD and ends[0]:  # a kinematic body without shapes, which is not built
            joint = replace(joint, frames=(compose(self._bodies[ends[0]].pose, joint.frames[0]), joint.frames[1]))
        collide = joint.collides and all(body in self._links and self._bodies[body].collides for body in ends)
        return usd_constraint(joint, parent, self._links[ends[1]], self._stage, collide=collide)

    def _is_root(self, prim: Prim) -> bool:
        """Returns whether a prim contains the whole stage: the default prim, or a top one called `World`."""
        is_top = prim.GetParent().IsPseudoRoot()
        return prim == self._stage.stage.GetDefaultPrim() or (is_top and prim.GetName().lower() in _ROOT_NAMES)

    def _moves(self, path: str) -> bool:
        return path in self._bodies and self._bodies[path].body_type == "dynamic"

    def _checked_name(self, prim: Prim) -> str:
        """Returns a prim's name, and reports one that a scene cannot have."""
        wish = self._preferred_name(prim)
        if plain_name(wish) != wish:
            self._stage.lose("names", f"`{cut(wish)}` is renamed to `{plain_name(wish)}`", prim)
        return wish

    def _preferred_name(self, prim: Prim) -> str:
        """Returns a prim's display name, else its name."""
        return str(prim.GetDisplayName() or prim.GetName())


def _parse(stage: UsdStage) -> dict[str, Any]:
    """Returns the UsdPhysics descriptors by "Scene", "RigidBody", "Shape", "Joint" (with its type) and others."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the new name is missing in the oldest usd-core supported
        rows: dict[Any, Any] = stage.physics.LoadUsdPhysicsFromRange(stage.stage, ["/"])
    found: dict[str, Any] = {}
    for kind, (_, parsed) in rows.items():
        name = str(kind).rpartition(".")[2]
        valid = [each for each in parsed if each.isValid]
        if name.endswith("Shape"):
            found.setdefault("Shape", []).extend(valid)
        elif name.endswith("Joint"):
            found.setdefault("Joint", []).extend((name, each) for each in valid)
        else:
            found[name] = valid
    return found
