"""The document of a USD stage: its bodies, joints, materials, lights and cameras, and what no reader reads."""

from __future__ import annotations

import re
import warnings
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut
from scenecc.importers.imported_scene import ImportedScene, ReferencePose
from scenecc.importers.numbers import Names, plain_name, plain_number, plain_numbers, pose_key
from scenecc.importers.usd_articulations import ArticulationWriter, Tree, find_trees, merge_settings
from scenecc.importers.usd_bodies import BodyReader, UsdBody
from scenecc.importers.usd_filters import CollisionFilters
from scenecc.importers.usd_joints import JointReader, UsdJoint, constraint_keys
from scenecc.importers.usd_layers import UsdLayers
from scenecc.importers.usd_materials import UsdMaterials
from scenecc.importers.usd_rendering import RenderingReader
from scenecc.importers.usd_shapes import SOLID_TYPES
from scenecc.importers.usd_stage import UsdStage

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.importers.imported_scene import ImportContext
    from scenecc.importers.usd_stage import Prim


def read_stage(path: Path, context: ImportContext) -> ImportedScene | None:
    """The scene of a stage, read in this process. None after an error, which is reported in the context's sink."""
    layers = UsdLayers(context)
    opened = layers.open(path)
    if opened is None:
        return None
    stage = UsdStage(opened, path, layers)
    for unit, size in (("metersPerUnit", stage.frames.metres), ("kilogramsPerUnit", stage.frames.kilograms)):
        if not _MIN_UNIT <= size <= 1 / _MIN_UNIT:
            context.sink.report("SC430", f"`{unit}` is {size:g}, which is no unit", Location(str(path)))
    for prim in stage.prims():
        if prim.IsA(stage.geom.Xformable) and not np.isfinite(stage.frames.world(prim)).all():
            message = f"the transform of {prim.GetPath()} is not finite"
            context.sink.report("SC430", message, Location(str(path)))
    return None if context.sink.failed else SceneReader(stage, context).read()


_MIN_UNIT: Final = 1e-9


class SceneReader:
    """Makes the document of a stage."""

    def __init__(self, stage: UsdStage, context: ImportContext) -> None:
        self._stage = stage
        self._materials = UsdMaterials(stage, context.sink)
        self._reader = BodyReader(stage, self._materials)
        self._parsed = _parse(stage)
        self._names = Names("world")
        self._bodies: dict[str, UsdBody] = {}
        self._where: dict[str, str] = {}
        self._keys: dict[str, dict[str, Any]] = {}

    def read(self) -> ImportedScene:
        """The document and what it does not hold."""
        groups = self._collect()
        moving = {path: body for path, body in self._bodies.items() if body.body_type == "dynamic"}
        joints = self._joints()
        trees, rest = find_trees(joints, moving, self._roots())
        entities = self._entities(groups, trees)
        rest += [joint for tree in trees for joint in tree.rest]
        constraints = self._constraints(rest)
        filters = CollisionFilters(self._stage, groups, self._parsed.get("CollisionGroup", []))
        filters.add_joints([*rest, *(joint for tree in trees for joint in tree.split_joints)])
        filters.add_filtered(
            each for kind in ("RigidBody", "Shape", "Articulation") for each in self._parsed.get(kind, [])
        )
        filters.add_groups()
        sections = {
            "physics": self._physics(),
            "materials": self._materials.named,
            "collision_groups": filters.section(self._keys, self._where),
            "entities": entities,
            "constraints": constraints,
            **RenderingReader(self._stage, self._materials, self._body_of, self._where).sections(
                lambda prim: self._names.new(self._wish(prim))
            ),
        }
        report_unread(self._stage)
        document: dict[str, Any] = {"scenecc": 1, **{key: section for key, section in sections.items() if section}}
        where = {mine: own for own, mine in self._where.items()}
        return ImportedScene(document, tuple(self._stage.losses), where, self._reference())

    def _reference(self) -> dict[str, ReferencePose]:
        """Where UsdPhysics has the bodies, and what it says that they weigh."""
        found: dict[str, ReferencePose] = {}
        for path, body in self._bodies.items():
            if path in self._where:
                parsed = body.parsed
                pose = self._stage.frames.frame_in(None, parsed.position, parsed.rotation)
                found[path] = ReferencePose(pose, self._reader.masses.get(path))
        return found

    def _physics(self) -> dict[str, Any]:
        scenes = self._parsed.get("Scene", [])
        if not scenes:
            return {}
        for other in scenes[1:]:
            self._stage.lose("physics-scenes", "a second physics scene", self._stage.prim(other.primPath))
        found, frames = scenes[0], self._stage.frames
        # A direction of 0 and a negative magnitude mean gravity as on Earth, which usd-core has filled in.
        down = frames.direction(found.gravityDirection)
        gravity = plain_numbers([each * found.gravityMagnitude * frames.metres for each in down], 1e-9)
        keys: dict[str, Any] = {} if gravity == [0.0, 0.0, -9.81] else {"gravity": gravity}
        rate = self._stage.authored(self._stage.prim(found.primPath), "physxScene:timeStepsPerSecond")
        return {"timestep": plain_number(1 / rate), **keys} if rate else keys

    def _collect(self) -> dict[str, UsdBody]:
        """Finds all bodies by the path of their prim: those of UsdPhysics, and groups of prims that stand still."""
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
            seen = self._is_seen(prim)
            if path not in shapes and not seen:
                continue
            if str(prim.GetTypeName()) not in SOLID_TYPES and path not in shapes:
                stage.lose("visuals", f"a prim of the type `{prim.GetTypeName()}`", prim)
                continue
            owner = self._owner(prim)
            body = groups.setdefault(str(owner.prim.GetPath()), owner)
            if path in shapes:
                body.colliders.append((prim, shapes[path]))
                if body.body_type == "none":
                    body.body_type = "static"
            if seen and str(prim.GetTypeName()) in SOLID_TYPES:
                body.visuals.append(prim)
        return groups

    def _is_seen(self, prim: Prim) -> bool:
        image = self._stage.geom.Imageable(prim)
        if image.ComputeVisibility(self._stage.time) == self._stage.geom.Tokens.invisible:
            return False
        return image.ComputePurpose() in {self._stage.geom.Tokens.default_, self._stage.geom.Tokens.render}

    def _owner(self, prim: Prim) -> UsdBody:
        """The body that a prim is part of: the next one above it, or else what stands still with it."""
        found = self._body_of(prim)
        if found is not None:
            return found
        parent = prim.GetParent()
        default = self._stage.stage.GetDefaultPrim()
        alone = parent.IsPseudoRoot() or parent == default or not parent.IsA(self._stage.geom.Xform)
        frame = prim if alone else parent
        return UsdBody(frame, self._stage.frames.pose(frame), "none")

    def _body_of(self, prim: Prim) -> UsdBody | None:
        """The body that UsdPhysics moves a prim with."""
        above = prim
        while above and not above.IsPseudoRoot():
            found = self._bodies.get(str(above.GetPath()))
            if found is not None:
                return found
            above = above.GetParent()
        return None

    def _joints(self) -> list[UsdJoint]:
        poses = {path: body.pose for path, body in self._bodies.items()}
        reader = JointReader(self._stage, poses)
        found = [reader.read(parsed, kind) for kind, parsed in self._parsed.get("Joint", [])]
        order = {prim.GetPath(): k for k, prim in enumerate(self._stage.prims())}
        return sorted((joint for joint in found if joint is not None), key=lambda joint: order[joint.prim.GetPath()])

    def _roots(self) -> dict[str, Prim]:
        """Body → prim of its articulation root."""
        found: dict[str, Prim] = {}
        for parsed in self._parsed.get("Articulation", []):
            prim = self._stage.prim(parsed.primPath)
            for body in parsed.articulatedBodies:
                found.setdefault(str(body), prim)
        return found

    def _entities(self, groups: dict[str, UsdBody], trees: list[Tree]) -> dict[str, Any]:
        by_body = {body: tree for tree in trees for body in tree.bodies}
        done: set[int] = set()
        entities: dict[str, Any] = {}
        for path, body in groups.items():
            tree = by_body.get(path)
            if tree is None:
                entities.update(self._body(path, body))
            elif id(tree) not in done:
                done.add(id(tree))
                entities.update(self._articulation(tree))
        return entities

    def _body(self, path: str, body: UsdBody) -> dict[str, Any]:
        keys = self._reader.keys(body)
        shapes = any(key in keys for key in ("shapes", "collisions", "visuals"))
        if not shapes and body.body_type != "dynamic":
            return {}
        name = self._new(self._names, self._wish(body.prim), body.prim)
        self._where[path] = name
        placed = pose_key(body.pose)
        if not shapes:
            # A body without shapes is an articulation of one link.
            self._where[path] = f"{name}/{name}"
            speeds = {key: keys.pop(key) for key in ("linear_velocity", "angular_velocity") if key in keys}
            self._keys[path] = {"name": name, **keys}
            return {name: {**placed, **speeds, "root": self._keys[path]}}
        kind = {} if body.body_type == "dynamic" else {"body_type": body.body_type}
        self._keys[path] = {**kind, **placed, **keys}
        return {name: self._keys[path]}

    def _articulation(self, tree: Tree) -> dict[str, Any]:
        name = self._names.new(self._tree_wish(tree))
        link_names, joint_names = Names(*(() if tree.root else ("world",))), Names()
        links: dict[str, str] = {}
        for path in tree.bodies:
            prim = self._bodies[path].prim
            links[path] = self._new(link_names, self._wish(prim), prim)
            self._where[path] = f"{name}/{links[path]}"
        joints = {id(joint): joint_names.new(joint.name) for joint in tree.joints}
        writer = ArticulationWriter(self._stage, self._reader, self._bodies)
        entity = writer.entity(tree, links, joints)
        self._keys |= writer.keys
        merge_settings(entity)
        return {name: entity}

    def _tree_wish(self, tree: Tree) -> str:
        """The name of an articulation: of the innermost prim that holds all its bodies."""
        if (
            tree.prim is not None
            and str(tree.prim.GetPath()) not in self._bodies
            and not tree.prim.IsA(self._stage.physics.Joint)
        ):
            return self._wish(tree.prim)
        paths = [self._bodies[body].prim.GetPath() for body in tree.bodies]
        common = paths[0].GetParentPath()
        for path in paths[1:]:
            common = common.GetCommonPrefix(path)
        prim = self._stage.prim(common)
        while str(prim.GetTypeName()) == "Scope":
            prim = prim.GetParent()
        default = self._stage.stage.GetDefaultPrim()
        if prim and not prim.IsPseudoRoot() and (prim != default or len(tree.bodies) > 1):
            return self._wish(prim)
        return self._wish(self._bodies[tree.bodies[0]].prim)

    def _constraints(self, joints: list[UsdJoint]) -> dict[str, Any]:
        names = Names()
        found: dict[str, Any] = {}
        for given in joints:
            joint = given
            child = self._bodies.get(joint.bodies[1])
            if child is None or child.body_type != "dynamic":
                joint = joint.reversed()
                child = self._bodies.get(joint.bodies[1])
            if child is None or child.body_type != "dynamic":
                self._stage.lose("idle-joints", "a joint that connects nothing that moves", joint.prim)
                continue
            keys = constraint_keys(joint, self._stage)
            if keys["type"] == "drive" and not {"limits", "drive"} & keys.keys():
                self._stage.lose("idle-joints", "a joint that leaves everything free", joint.prim)
                continue
            parent = self._where[joint.bodies[0]] if joint.bodies[0] else "world"
            kind = keys.pop("type")
            found[names.new(joint.name)] = {
                "type": kind,
                "parent": parent,
                "child": self._where[joint.bodies[1]],
                **keys,
            }
        return found

    def _new(self, names: Names, wish: str, prim: Prim) -> str:
        """A free name. One that the language does not take as it is is told."""
        if plain_name(wish) != wish:
            self._stage.lose("names", f"`{cut(wish)}` is called `{plain_name(wish)}`", prim)
        return names.new(wish)

    def _wish(self, prim: Prim) -> str:
        """The name of a prim, as people see it."""
        return str(prim.GetDisplayName() or prim.GetName())


def _parse(stage: UsdStage) -> dict[str, Any]:
    """What UsdPhysics says of a stage: lists by "Scene", "RigidBody", "Shape", "Joint" (with its type) and others."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the new name is not in the oldest usd-core that we take
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


_VENDOR: Final = re.compile(r"(physx|newton|mjc|mjcf|state|isaac|omniphysics)[A-Za-z]*:")
"""Namespaces of schemas for simulation that usd-core does not have."""

_READ: Final = re.compile(
    r"physxRigidBody:(disableGravity|linearDamping|angularDamping|max\w+Velocity|maxContactImpulse|sleepThreshold"
    r"|solver\w+IterationCount|locked\w+Axis)"
    r"|physxCollision:(contact|rest)Offset|physxJoint:(jointFriction|armature|maxJointVelocity)"
    r"|physxArticulation:(enabledSelfCollisions|solver\w+IterationCount)|physxScene:timeStepsPerSecond"
)
"""Attributes of PhysX's schema that the readers take."""

_SOFT: Final = re.compile(r"Deformable|Particle|Cloth|Vehicle|Tendon|SurfaceVelocity|ForceAPI|MimicJoint|Gear")
"""Schemas that make a stage move in other ways than by bodies and joints."""


def report_unread(stage: UsdStage) -> None:
    """Tells of prims, schemas, animations and attributes that the scene does not hold."""
    attributes: dict[str, list[Prim]] = {}
    for prim in stage.prims():
        info = prim.GetPrimTypeInfo()
        name = str(info.GetTypeName())
        schemas = [str(each) for each in info.GetAppliedAPISchemas()]
        soft = next((each for each in (name, *schemas) if _SOFT.search(each)), None)
        if soft is not None:
            stage.lose("soft-bodies", f"`{soft}`", prim)
        elif prim.IsA(stage.geom.PointInstancer):
            stage.lose("point-instancers", "a `PointInstancer`", prim)
        elif name and prim.GetPrimDefinition() is not None and info.GetSchemaType().isUnknown:
            stage.lose("unknown-prims", f"a prim of the type `{name}`, which usd-core does not know", prim)
        if prim.IsA(stage.geom.Xformable) and stage.geom.Xformable(prim).TransformMightBeTimeVarying():
            stage.lose("animations", "a motion over time, of which the first pose is taken", prim)
        for each in prim.GetAuthoredAttributes():
            label = str(each.GetName())
            if _VENDOR.match(label) and not _READ.fullmatch(label):
                attributes.setdefault(label, []).append(prim)
    for label, prims in attributes.items():
        stage.lose("vendor-attributes", f"`{label}` of {len(prims)} prims", prims[0])
