"""Exports articulations, or single bodies, to URDF."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, fields
from math import atan2, hypot
from typing import TYPE_CHECKING, Final

from scenecc.assets.errors import AssetError
from scenecc.diagnostics.diagnostic import Location
from scenecc.emit.output import (
    MAX_LIMIT,
    UNLIMITED,
    AssetFolder,
    UnsupportedFeatures,
    XmlElement,
    format_document,
    friction_loss,
    is_pure_damping,
    optional_fields,
    transform_direction,
)
from scenecc.geometry.obj import encode_obj
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose, invert
from scenecc.meshes.builder import MeshBuilder, bake_scale
from scenecc.meshes.surface import MeshShape, SurfaceMaterial
from scenecc.names import UniqueNames
from scenecc.plan import ArticulationStructure, BodyStructure, CollisionShape
from scenecc.plan.geometry import LYING_SOLIDS, SOLIDS, Solid
from scenecc.plan.schema import type_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.diagnostics import Sink
    from scenecc.emit import ExportOptions
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import (
        EngineSnapshot,
        MeasuredBody,
        MeasuredEntity,
        MeasuredJoint,
        MeasuredScene,
        MeasuredShape,
        Vec3,
    )

_GIMBAL_LOCK: Final = 1e-6
"""Below this length of x's projection onto the xy plane, roll and yaw cannot be distinguished."""


def write_origin(element: XmlElement, pose: Pose7) -> None:
    """Adds an `<origin>`, unless the pose is the identity."""
    if pose != IDENTITY_POSE:
        element.add("origin", xyz=pose[:3], rpy=roll_pitch_yaw(pose))


def roll_pitch_yaw(pose: Pose7) -> Vec3:
    """Returns roll, pitch and yaw [rad]."""
    x, y, z = (transform_direction(pose, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    level = hypot(x[0], x[1])
    pitch = atan2(-x[2], level)
    if level < _GIMBAL_LOCK:
        return 0.0, pitch, atan2(-y[0], y[1])
    return atan2(y[2], z[2]), pitch, atan2(x[1], x[0])


_X_TO_Z: Final[Pose7] = (0.0, 0.0, 0.0, 0.7071067811865476, 0.0, -0.7071067811865476, 0.0)
"""From shapes along z (URDF) to shapes along x (SAPIEN)."""

_UNSUPPORTED_SHAPE_FIELDS: Final = optional_fields(CollisionShape, "pose", "density")

_MATERIAL_FIELDS: Final = frozenset({"base_color", "base_color_image", "visibility"})

_DEFAULT_MATERIAL: Final = SurfaceMaterial()


def write_collisions(robot: UrdfRobot, body: MeasuredBody, back: Pose7, link: XmlElement) -> None:
    """Writes one collision per collision shape of the engine. `back`: from the link's frame to that in the file."""
    for shape in body.shapes:
        robot.unsupported.fields(robot.name, shape.shape, _UNSUPPORTED_SHAPE_FIELDS, shape.shape.origin, " of a shape")
        if shape.kind == "plane":
            robot.unsupported.leave_out(robot.name, "a plane", shape.shape.origin)
            continue
        element = link.add("collision")
        pose = compose(shape.pose, _X_TO_Z) if shape.kind in LYING_SOLIDS else shape.pose
        write_origin(element, compose(back, pose))
        _write_collision_geometry(robot, shape, element.add("geometry"))


def _write_collision_geometry(robot: UrdfRobot, shape: MeasuredShape, geometry: XmlElement) -> None:
    mesh = shape.mesh
    if mesh is None:
        _write_primitive(geometry, shape.kind, shape.sizes)
        return
    if shape.kind == "triangle_mesh":
        words = (
            f"a {type_name(type(shape.shape.geometry))} is a triangle mesh, which other readers may replace by its hull"
        )
        robot.unsupported.change(robot.name, words, shape.shape.origin)
    _write_mesh(robot, geometry, f"{robot.name}_collision", encode_obj(mesh.vertices, mesh.triangles))


def _write_primitive(geometry: XmlElement, kind: str, sizes: tuple[float, ...]) -> None:
    if kind == "box":
        geometry.add("box", size=tuple(2 * size for size in sizes))
    elif kind == "sphere":
        geometry.add("sphere", radius=sizes[0])
    else:
        geometry.add(kind, radius=sizes[0], length=2 * sizes[1])


def _write_mesh(robot: UrdfRobot, geometry: XmlElement, stem: str, data: bytes) -> None:
    file = robot.assets.add(stem, ".obj", data)
    geometry.add("mesh", filename=f"{robot.assets.folder}/{file}")


def write_visuals(robot: UrdfRobot, body: MeasuredBody, back: Pose7, link: XmlElement) -> None:
    """Writes the visual shapes, one `<visual>` per mesh part. Raises AssetError."""
    row = robot.measured.row
    for shape, plan in zip(robot.mesh_builder.visuals(body.body, row), body.body.visuals, strict=False):
        parts = bake_scale(shape)
        kind = type_name(type(plan.geometry))
        solid = plan.geometry if isinstance(plan.geometry, Solid) and kind in SOLIDS else None
        for part in parts:
            element = link.add("visual", name=shape.name or None)
            pose = compose(shape.pose, _X_TO_Z) if kind in LYING_SOLIDS else shape.pose
            write_origin(element, compose(back, pose))
            geometry = element.add("geometry")
            if solid is None:
                _write_mesh(robot, geometry, shape.name or robot.name, part.to_obj())
            else:
                _write_primitive(geometry, kind, solid.sizes(row))
            element.take(_material(robot, part.look, shape))


def _material(robot: UrdfRobot, look: SurfaceMaterial, shape: MeshShape) -> XmlElement:
    """Returns a `<material>` with a colour or a texture."""
    unsupported = [
        f"`{item.name.replace('_image', '_texture')}`" for item in fields(look) if _is_unsupported(look, item.name)
    ]
    if look.visibility < 1 and look.base_color_image is not None:
        unsupported.append("`visibility`")
    if unsupported:
        robot.unsupported.leave_out(robot.name, ", ".join(unsupported), shape.origin)
    name = robot.looks.setdefault(look, f"material_{len(robot.looks)}")
    element = XmlElement("material", name=name)
    image = look.base_color_image
    if image is None:
        element.add("color", rgba=look.tint)
    else:
        file = robot.assets.add(image.name or "texture", image.suffix, image.data)
        element.add("texture", filename=f"{robot.assets.folder}/{file}")
    return element


def _is_unsupported(look: SurfaceMaterial, field: str) -> bool:
    return field not in _MATERIAL_FIELDS and getattr(look, field) != getattr(_DEFAULT_MATERIAL, field)


_UNSUPPORTED_BODY_FIELDS: Final = optional_fields(BodyStructure, "mass", "com", "inertial", "visibility", "shapeless")

_UNSUPPORTED_ARTICULATION_FIELDS: Final = optional_fields(ArticulationStructure, "file")


@dataclass(slots=True)
class UrdfRobot:
    """One robot, while it is written.

    Attributes:
        moved: pose of each link's frame in the file, relative to the link's frame in the plan.
        joints: name of each link's joint, by the link's number.
        looks: names of materials.
    """

    measured: MeasuredEntity
    root: XmlElement
    mesh_builder: MeshBuilder
    assets: AssetFolder
    unsupported: UnsupportedFeatures
    moved: list[Pose7] = field(default_factory=list["Pose7"])
    looks: dict[SurfaceMaterial, str] = field(default_factory=dict["SurfaceMaterial", str])
    joints: dict[int, str] = field(default_factory=dict[int, str])

    @property
    def name(self) -> str:
        """Name of the entity."""
        return self.measured.entity.name


def write_robot(robot: UrdfRobot) -> None:
    """Writes all links, then all joints. Raises AssetError."""
    measured = robot.measured
    if measured.entity.hidden:
        robot.unsupported.leave_out(robot.name, "`hidden`, which hides it from sensors", measured.entity.origin)
    robot.moved = [_link_offset(robot, body) for body in measured.bodies]
    robot.joints = _joint_names(measured)
    for number, body in enumerate(measured.bodies):
        _write_link(robot, number, body)
    if isinstance(measured.structure, ArticulationStructure):
        robot.unsupported.fields(
            robot.name, measured.structure, _UNSUPPORTED_ARTICULATION_FIELDS, measured.structure.origin
        )
        for number, body in enumerate(measured.bodies):
            if body.joint is not None:
                _write_joint(robot, number, body.joint)


def _joint_names(measured: MeasuredEntity) -> dict[int, str]:
    """Returns the name of each link's joint, by the link's number: its own, or a new unique one."""
    joints = {number: body.joint.name for number, body in enumerate(measured.bodies) if body.joint is not None}
    names = UniqueNames(*joints.values())
    return {number: name or names.new(f"{measured.bodies[number].name}_joint") for number, name in joints.items()}


_NO_OFFSET: Final = 1e-6
"""A smaller offset is the engine's rounding of a pose [m]."""


def _link_offset(robot: UrdfRobot, body: MeasuredBody) -> Pose7:
    """Returns the offset of a link's frame in the file: URDF puts the frame of a revolute link on the joint's axis."""
    joint = body.joint
    if joint is None or joint.type in {"fixed", "prismatic"} or max(map(abs, joint.pose_in_child[:3])) < _NO_OFFSET:
        return IDENTITY_POSE
    words = f"the frame of the link `{body.name}` is moved to the axis of its joint"
    robot.unsupported.change(robot.name, words, joint.joint.origin)
    return (*joint.pose_in_child[:3], *IDENTITY_POSE[3:])


def _write_link(robot: UrdfRobot, number: int, body: MeasuredBody) -> None:
    link = robot.root.add("link", name=body.name)
    back = invert(robot.moved[number])
    if body.mass is not None:
        inertial = link.add("inertial")
        write_origin(inertial, compose(back, body.mass.com))
        inertial.add("mass", value=body.mass.mass)
        x, y, z = body.mass.inertia
        inertial.add("inertia", ixx=x, ixy=0, ixz=0, iyy=y, iyz=0, izz=z)
    write_visuals(robot, body, back, link)
    write_collisions(robot, body, back, link)
    robot.unsupported.fields(robot.name, body.body, _UNSUPPORTED_BODY_FIELDS, body.body.origin)


def _write_joint(robot: UrdfRobot, number: int, joint: MeasuredJoint) -> None:
    body = robot.measured.bodies[number]
    assert body.parent is not None  # every link with a joint has one
    element = robot.root.add("joint", name=robot.joints[number], type=_joint_type(joint))
    parent_back = invert(robot.moved[body.parent])
    at = compose(parent_back, compose(joint.pose_in_parent, invert(joint.pose_in_child)))
    write_origin(element, compose(at, robot.moved[number]))
    element.add("parent", link=robot.measured.bodies[body.parent].name)
    element.add("child", link=body.name)
    if joint.type == "fixed":
        return
    element.add("axis", xyz=transform_direction(joint.pose_in_child, (1.0, 0.0, 0.0)))
    _write_limit(robot, element, joint)
    damping = joint.damping if is_pure_damping(joint) else 0.0
    friction = friction_loss(joint)
    if damping or friction:
        element.add("dynamics", damping=damping, friction=friction)
    _write_mimic(robot, element, joint)
    _report_joint(robot, joint)


def _joint_type(joint: MeasuredJoint) -> str:
    if joint.type in {"fixed", "prismatic"}:
        return joint.type
    return "continuous" if all(map(math.isinf, joint.limits)) else "revolute"


def _write_limit(robot: UrdfRobot, element: XmlElement, joint: MeasuredJoint) -> None:
    low, high = joint.limits
    endless = element.attributes["type"] == "continuous"
    if not endless and (math.isinf(low) or math.isinf(high)):
        words = f"a missing limit of a joint is written as {UNLIMITED:g}"
        robot.unsupported.change(robot.name, words, joint.joint.origin)
    element.add(
        "limit",
        lower=None if endless else max(low, -UNLIMITED),
        upper=None if endless else min(high, UNLIMITED),
        effort=UNLIMITED if joint.force_limit >= MAX_LIMIT or friction_loss(joint) else joint.force_limit,
        velocity=UNLIMITED if joint.max_velocity >= MAX_LIMIT else joint.max_velocity,
    )


def _write_mimic(robot: UrdfRobot, element: XmlElement, joint: MeasuredJoint) -> None:
    structure, row = robot.measured.structure, robot.measured.row
    assert isinstance(structure, ArticulationStructure)
    for mimic in structure.mimics:
        if mimic.joint == joint.name:
            multiplier, offset = float(mimic.multiplier.row(row)), float(mimic.offset.row(row))
            element.add("mimic", joint=mimic.source, multiplier=multiplier, offset=offset)


def _report_joint(robot: UrdfRobot, joint: MeasuredJoint) -> None:
    unsupported, name, place = robot.unsupported, robot.name, joint.joint.origin
    if not is_pure_damping(joint) and not friction_loss(joint) and (joint.stiffness or joint.damping):
        unsupported.leave_out(name, "the drive of a joint, except its `force_limit`", place)
    if joint.armature:
        unsupported.leave_out(name, "`armature` of a joint", place)
    structure = robot.measured.structure
    follows = isinstance(structure, ArticulationStructure) and joint.name in {each.joint for each in structure.mimics}
    if joint.joint.qpos is not None and joint.qpos and not follows:
        unsupported.leave_out(name, "`qpos` of a joint", place)
    if joint.joint.qvel is not None and joint.qvel:
        unsupported.leave_out(name, "`qvel` of a joint", place)
    if joint.joint.friction is not None and joint.friction:
        unsupported.leave_out(name, "`friction` of a joint, a ratio; URDF has a force", place)


def write(plan: ScenePlan, measured: EngineSnapshot, options: ExportOptions, sink: Sink) -> dict[str, bytes] | None:
    """Returns a URDF, `NAME.urdf`, or one for each articulation; None after an error. See `scenecc.emit.export`."""
    chosen = _select_entities(measured.scenes[0], options, sink)
    unsupported = UnsupportedFeatures(sink, left_out="SC740", otherwise="SC741")
    mesh_builder = MeshBuilder(
        plan, lambda problem, place: unsupported.leave_out(plan.name, str(problem), place), options.max_triangles
    )
    names, files, assets = UniqueNames(), dict[str, bytes](), dict[str, bytes]()
    for entity in chosen:
        wish = re.sub(r"[^A-Za-z0-9_.-]+", "_", entity.entity.name) if options.folder else options.name
        name = names.new(wish)
        robot = UrdfRobot(
            entity, XmlElement("robot", name=entity.entity.name), mesh_builder, AssetFolder(name), unsupported
        )
        try:
            write_robot(robot)
        except AssetError as problem:
            problem.report(sink, mesh_builder.at)
            return None
        files[f"{name}.urdf"] = format_document(robot.root)
        assets |= robot.assets.files
    unsupported.report()
    return None if sink.failed else files | assets


def _select_entities(scene: MeasuredScene, options: ExportOptions, sink: Sink) -> Sequence[MeasuredEntity]:
    """Returns the entities to write; empty after an error."""
    named = {each.entity.name: each for each in scene.entities}
    robots = {name: each for name, each in named.items() if isinstance(each.structure, ArticulationStructure)}
    words = ", ".join(f"`{name}`" for name in robots) or "none"
    if options.entity is not None:
        if options.entity in named:
            return (named[options.entity],)
        message = f"there is no entity `{options.entity}` in scene {scene.index}; its articulations: {words}"
        sink.report("SC915", message, Location(None), path=("entity",))
    elif not robots:
        message, hint = f"scene {scene.index} has no articulation", "choose a body as `entity`, as a one-link robot"
        sink.report("SC915", message, Location(None), hint=hint, path=("target",))
    elif len(robots) > 1 and not options.folder:
        message = f"a file holds one robot, but scene {scene.index} has {words}"
        hint = "choose one as `entity`, or write a folder"
        sink.report("SC915", message, Location(None), hint=hint, path=("entity",))
    else:
        return tuple(robots.values())
    return ()
