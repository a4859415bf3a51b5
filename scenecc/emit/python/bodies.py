"""Writes bodies and their shapes."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.emit.python.context import (
    IDENTITY_ROW,
    MountTargets,
    SceneValues,
    ScriptMaterials,
    numbers_literal,
    pose_call,
    present_fields,
    write_properties,
)
from scenecc.emit.python.source import SourceNode, SourceWriter, call, number_literal, string
from scenecc.plan import (
    BodyStructure,
    Box,
    Capsule,
    CollisionGeometry,
    CollisionShape,
    ConvexMesh,
    ConvexParts,
    Cylinder,
    Heightfield,
    Mesh,
    Plane,
    Sphere,
    TiledPlane,
    TriangleMesh,
    Value,
    VisualGeometry,
    VisualPlane,
    VisualShape,
)
from scenecc.plan.geometry import REVOLVED_SOLIDS, RevolvedSolid
from scenecc.plan.properties import property_fields

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    from scenecc.emit.python.files import ScriptFiles
    from scenecc.plan import Entity, Inertial

Arguments = dict[str, SourceNode]


@dataclass(frozen=True, slots=True)
class ShapeCall:
    """How to create a type of shape.

    Attributes:
        add: method of `ActorBuilder`; "" if it has none.
        make: constructor of the shape.
        arguments: returns the keyword arguments of both for a geometry.
    """

    add: str
    make: str
    arguments: Callable[[Any, SceneValues, ScriptFiles], Arguments]


def _size_arguments(*fields: str) -> Callable[[Any, SceneValues, ScriptFiles], Arguments]:
    def arguments(geometry: Any, columns: SceneValues, files: ScriptFiles) -> Arguments:
        del files
        return {name: columns.value(getattr(geometry, name), name) for name in fields}

    return arguments


def _no_arguments(geometry: Plane, columns: SceneValues, files: ScriptFiles) -> Arguments:
    del geometry, columns, files
    return {}


def _mesh_arguments(geometry: TriangleMesh | Mesh, columns: SceneValues, files: ScriptFiles) -> Arguments:
    path = files.name if isinstance(geometry, Mesh) else files.collision_path
    return {
        "filename": call("str", columns.value(geometry.file, "file", path)),
        **_scale_argument(geometry.scale, columns),
    }


def _scale_argument(scale: Value, columns: SceneValues) -> Arguments:
    if not scale.varies and (scale.data == 1).all():
        return {}
    return {"scale": columns.value(scale, "scale")}


def _convex_arguments(geometry: ConvexMesh | ConvexParts, columns: SceneValues, files: ScriptFiles) -> Arguments:
    is_parts = isinstance(geometry, ConvexParts)
    if is_parts and geometry.coacd is not None:
        file = files.parts(columns.value(geometry.file, "file", files.collision_path), geometry.coacd)
    else:
        file = call("str", columns.value(geometry.file, "file", files.collision_path))
    scale = geometry.scale
    if (scale.data < 0).any():
        file = files.mirrored(file, columns.value(Value(np.sign(scale.data)), "signs", _tuple_literal), parts=is_parts)
        scale = Value(np.abs(scale.data))
    return {"filename": file, **_scale_argument(scale, columns)}


def _tuple_literal(row: Any) -> SourceNode:
    return "({})".format(", ".join(f"{item:g}" for item in row))


def _visual_plane_arguments(geometry: VisualPlane, columns: SceneValues, files: ScriptFiles) -> Arguments:
    del files
    # SAPIEN's own ground does so; the first number has no effect.
    return {"scale": columns.value(Value(np.insert(geometry.half_size.data, 0, 10.0, axis=1)), "scale")}


def _tiled_plane_arguments(geometry: TiledPlane, columns: SceneValues, files: ScriptFiles) -> Arguments:
    del files
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
    half_size, repeat = geometry.half_size.data, geometry.texture_repeat.data
    vertices = np.zeros((len(half_size), 4, 3))
    vertices[:, :, :2] = half_size[:, None] * corners
    return {
        "vertices": columns.value(Value(vertices), "vertices"),
        "triangles": numbers_literal(np.array([[0, 1, 2], [0, 2, 3]])),
        "normals": numbers_literal(np.array([[0, 0, 1]] * 4)),
        "uvs": columns.value(Value(0.5 + corners / 2 * repeat[:, None]), "uvs"),
    }


def _revolved_part_arguments(geometry: RevolvedSolid, columns: SceneValues, files: ScriptFiles) -> Arguments:
    files.use_helper("revolved_shapes")
    found = [geometry.unit_profile(*geometry.sizes(row)) for row in _rows(geometry)]
    profiles, scales = (Value(np.array(column)) for column in zip(*found, strict=True))
    return {"profile": columns.value(profiles, "profile"), "scale": columns.value(scales, "scale")}


def _revolved_surface_arguments(geometry: RevolvedSolid, columns: SceneValues, files: ScriptFiles) -> Arguments:
    files.use_helper("revolved_visual")
    profiles = Value(np.array([geometry.profile(*geometry.sizes(row)) for row in _rows(geometry)]))
    return {"profile": columns.value(profiles, "profile")}


def _heightfield_call(helper: str) -> ShapeCall:
    def arguments(geometry: Heightfield, columns: SceneValues, files: ScriptFiles) -> Arguments:
        files.use_helper(helper)
        return {"size": columns.value(geometry.size, "size"), "heights": files.heights(geometry.heights)}

    return ShapeCall("", helper, arguments)


def _rows(geometry: RevolvedSolid) -> range:
    return range(max(len(value.data) for value in geometry.values))


_HALF_SIZE = _size_arguments("half_size")

_RADIUS = _size_arguments("radius")

_RADIUS_AND_LENGTH = _size_arguments("radius", "half_length")

_REVOLVED_PARTS = ShapeCall("", "revolved_shapes", _revolved_part_arguments)

_REVOLVED_SURFACE = ShapeCall("", "revolved_visual", _revolved_surface_arguments)

_CONVEX = "physx.PhysxCollisionShapeConvexMesh"

COLLISIONS: dict[type[CollisionGeometry], ShapeCall] = {
    Box: ShapeCall("add_box_collision", "physx.PhysxCollisionShapeBox", _HALF_SIZE),
    Sphere: ShapeCall("add_sphere_collision", "physx.PhysxCollisionShapeSphere", _RADIUS),
    Capsule: ShapeCall("add_capsule_collision", "physx.PhysxCollisionShapeCapsule", _RADIUS_AND_LENGTH),
    Cylinder: ShapeCall("add_cylinder_collision", "physx.PhysxCollisionShapeCylinder", _RADIUS_AND_LENGTH),
    **dict.fromkeys(REVOLVED_SOLIDS.values(), _REVOLVED_PARTS),
    Plane: ShapeCall("add_plane_collision", "physx.PhysxCollisionShapePlane", _no_arguments),
    ConvexMesh: ShapeCall("add_convex_collision_from_file", _CONVEX, _convex_arguments),
    ConvexParts: ShapeCall("add_multiple_convex_collisions_from_file", f"{_CONVEX}.load_multiple", _convex_arguments),
    Heightfield: _heightfield_call("heightfield_shape"),
    TriangleMesh: ShapeCall(
        "add_nonconvex_collision_from_file", "physx.PhysxCollisionShapeTriangleMesh", _mesh_arguments
    ),
}

VISUALS: dict[type[VisualGeometry], ShapeCall] = {
    Box: ShapeCall("add_box_visual", "sapien.render.RenderShapeBox", _HALF_SIZE),
    Sphere: ShapeCall("add_sphere_visual", "sapien.render.RenderShapeSphere", _RADIUS),
    Capsule: ShapeCall("add_capsule_visual", "sapien.render.RenderShapeCapsule", _RADIUS_AND_LENGTH),
    Cylinder: ShapeCall("add_cylinder_visual", "sapien.render.RenderShapeCylinder", _RADIUS_AND_LENGTH),
    **dict.fromkeys(REVOLVED_SOLIDS.values(), _REVOLVED_SURFACE),
    VisualPlane: ShapeCall("add_plane_visual", "sapien.render.RenderShapePlane", _visual_plane_arguments),
    Mesh: ShapeCall("add_visual_from_file", "sapien.render.RenderShapeTriangleMesh", _mesh_arguments),
    Heightfield: _heightfield_call("heightfield_visual"),
    TiledPlane: ShapeCall("", "sapien.render.RenderShapeTriangleMesh", _tiled_plane_arguments),
}

BODY_PROPERTIES = property_fields("body")
"""Properties of a dynamic component, by their names in the plan."""

RENDER_PROPERTIES = property_fields("look")
"""Properties of a render component, by their names in the plan."""

CONTACT_OFFSETS = ("contact_offset", "rest_offset")

LATE_SHAPE_FIELDS = (*CONTACT_OFFSETS, "collision_groups")
"""Fields of a collision shape that no `add_*_collision` takes."""

SHAPE_ARGUMENTS = tuple(name for name in property_fields("shape") if name not in CONTACT_OFFSETS)
"""Properties of a collision shape that every `add_*_collision` takes."""


def write_mass(source: SourceWriter, structure: BodyStructure, columns: SceneValues) -> None:
    """Sets the mass of `body`, scales the inertia that follows from the densities, and sets the centre of mass."""
    if structure.mass is not None:
        mass = columns.value(structure.mass, "mass", lambda row: number_literal(float(row)))
        source.line(f"body.inertia = body.inertia.astype(float) * ({mass} / body.mass)")
        source.line(f"body.mass = {mass}")
    if structure.com is not None:
        pose = call("sapien.Pose", columns.value(structure.com, "com"), "body.cmass_local_pose.q")
        source.statement(pose, assign="body.cmass_local_pose")


def inertial_nodes(inertial: Inertial, columns: SceneValues) -> tuple[SourceNode, SourceNode, SourceNode]:
    """Returns mass, centre of mass and inertia, as `ActorBuilder.set_mass_and_inertia` takes them."""
    return (
        columns.value(inertial.mass, "mass"),
        columns.value(inertial.com, "com", pose_call),
        columns.value(inertial.inertia, "inertia"),
    )


def write_inertial(source: SourceWriter, inertial: Inertial, columns: SceneValues) -> None:
    """Sets mass, centre of mass and inertia of `body`."""
    mass, com, inertia = inertial_nodes(inertial, columns)
    source.statement(mass, assign="body.mass")
    source.statement(com, assign="body.cmass_local_pose")
    source.statement(inertia, assign="body.inertia")


def write_late_fields(source: SourceWriter, shapes: tuple[CollisionShape, ...], columns: SceneValues) -> None:
    """Sets `LATE_SHAPE_FIELDS` of the shapes of `body`."""
    for index, shape in enumerate(shapes):
        write_properties(source, shape, CONTACT_OFFSETS, columns, f"body.collision_shapes[{index}]")
        if shape.collision_groups is not None:
            # SAPIEN has no property for it.
            groups = columns.value(shape.collision_groups, "collision_groups")
            source.statement(call(f"body.collision_shapes[{index}].set_collision_groups", groups))


_DYNAMIC = "physx.PhysxRigidDynamicComponent"

_STATIC = "physx.PhysxRigidStaticComponent"

_RENDER_BODY = "sapien.render.RenderBodyComponent"


@dataclass(frozen=True, slots=True)
class BodyScript:
    """One structure of an entity in some of its scenes.

    Attributes:
        name: an expression for the entity's name.
        source: receives the statements; the loop over scenes, if any, is open.
        columns: the entity's quantities in these scenes.
        is_mount_target: whether a constraint, light or camera is mounted on it.
    """

    entity: Entity
    name: str
    structure: BodyStructure
    source: SourceWriter
    columns: SceneValues
    files: ScriptFiles
    materials: ScriptMaterials
    is_mount_target: bool = False


def write_body(body: BodyScript) -> None:
    """Builds the body in `scene`, row `i` of the block."""
    body.materials.write_own(body.source, (body.structure,), body.columns, body.files)
    if needs_components(body.structure):
        _write_components(body)
    else:
        _write_builder(body)
    if body.is_mount_target:
        MountTargets.write_body(body.source, body.name, "entity")


def needs_components(structure: BodyStructure) -> bool:
    """Returns whether an actor or link builder would build something different, so that components are needed."""
    shapes, dynamic = structure.collisions, structure.body_type in {"dynamic", "link"}
    parts = any(isinstance(shape.geometry, ConvexParts) for shape in shapes)
    return (
        structure.body_type == "none"
        # These are set by shape index, and the number of parts is unknown until they are loaded.
        or (parts and any(present_fields(shape, LATE_SHAPE_FIELDS) for shape in shapes))
        # The builder decides by body type whether to cook an SDF, and sets a plane's density to 0.
        or any(isinstance(shape.geometry, TriangleMesh) and shape.geometry.sdf != dynamic for shape in shapes)
        or any(isinstance(shape.geometry, Plane) and shape.density is not None for shape in shapes)
        or not all(COLLISIONS[type(shape.geometry)].add for shape in shapes)
        # Joints store their frames relative to the centre of mass, so it is set before them.
        or (structure.body_type == "link" and structure.com is not None)
        or any(shape.front_face is not None or not VISUALS[type(shape.geometry)].add for shape in structure.visuals)
    )


def _write_builder(body: BodyScript) -> None:
    source, structure, columns = body.source, body.structure, body.columns
    source.line("builder = scene.create_actor_builder()")
    if structure.body_type != "dynamic":
        source.line(f'builder.set_physx_body_type("{structure.body_type}")')
    write_shapes(body, "builder")
    source.statement(columns.value(body.entity.pose, "pose", pose_call), assign="builder.initial_pose")
    component = _STATIC if structure.body_type == "static" else _DYNAMIC
    touched = _needs_body_component(structure)
    build = call("builder.build", name=body.name)
    source.statement(
        build,
        assign="entity" if touched or body.is_mount_target or present_fields(structure, RENDER_PROPERTIES) else "",
    )
    if touched:
        source.line(f"body = entity.find_component_by_type({component})")
        _write_kinematic_inertial(body)
        write_mass(source, structure, columns)
        write_late_fields(source, structure.collisions, columns)
        write_properties(source, structure, BODY_PROPERTIES, columns, "body")
    write_render_properties(body, "entity")


def write_shapes(body: BodyScript, builder: str) -> None:
    """Writes collision groups, shapes and inertial to a builder."""
    source, structure, columns = body.source, body.structure, body.columns
    if structure.collision_groups is not None:
        source.statement(columns.value(structure.collision_groups, "groups"), assign=f"{builder}.collision_groups")
    for shape in structure.collisions:
        row = COLLISIONS[type(shape.geometry)]
        source.statement(call(f"{builder}.{row.add}", **_collision_arguments(shape, body)))
    if structure.visuals:
        with _render_block(source, columns):
            for shape in structure.visuals:
                row = VISUALS[type(shape.geometry)]
                source.statement(call(f"{builder}.{row.add}", **_visual_arguments(shape, body)))
    if structure.inertial is not None and structure.body_type in {"dynamic", "link"}:
        source.statement(call(f"{builder}.set_mass_and_inertia", *inertial_nodes(structure.inertial, columns)))


def write_render_properties(body: BodyScript, entity: str) -> None:
    """Sets render properties of a built entity. `entity`: an expression for it."""
    if present_fields(body.structure, RENDER_PROPERTIES):
        with _render_block(body.source, body.columns):
            body.source.line(f"look = {entity}.find_component_by_type({_RENDER_BODY})")
            write_properties(body.source, body.structure, RENDER_PROPERTIES, body.columns, "look")


def _needs_body_component(structure: BodyStructure) -> bool:
    return (
        structure.mass is not None
        or structure.com is not None
        or (structure.inertial is not None and structure.body_type == "kinematic")
        or bool(present_fields(structure, BODY_PROPERTIES))
        or any(present_fields(shape, LATE_SHAPE_FIELDS) for shape in structure.collisions)
    )


def _write_kinematic_inertial(body: BodyScript) -> None:
    """Sets the inertial of a kinematic body, which the builder ignores."""
    if body.structure.inertial is not None and body.structure.body_type == "kinematic":
        write_inertial(body.source, body.structure.inertial, body.columns)


def _collision_arguments(shape: CollisionShape, body: BodyScript) -> Arguments:
    columns = body.columns
    return {
        **_pose_argument(shape.pose, columns),
        **COLLISIONS[type(shape.geometry)].arguments(shape.geometry, columns, body.files),
        **_material_argument(shape, body),
        **{name: columns.value(getattr(shape, name), name) for name in present_fields(shape, SHAPE_ARGUMENTS)},
    }


def _material_argument(shape: CollisionShape | VisualShape, body: BodyScript) -> Arguments:
    collides = isinstance(shape, CollisionShape)
    if shape.material is not None:
        return {"material": body.materials.expression(shape.material, "physical" if collides else "look", body.columns)}
    return {"material": body.materials.default} if collides and body.materials.default is not None else {}


def _visual_arguments(shape: VisualShape, body: BodyScript) -> Arguments:
    name: Arguments = {"name": string(shape.name)} if shape.name else {}
    return {
        **_pose_argument(shape.pose, body.columns),
        **VISUALS[type(shape.geometry)].arguments(shape.geometry, body.columns, body.files),
        **_material_argument(shape, body),
        **name,
    }


def _pose_argument(value: Value | None, columns: SceneValues) -> Arguments:
    if value is None or value.data.tobytes() == IDENTITY_ROW.tobytes():
        return {}
    return {"pose": columns.value(value, "shape_pose", pose_call)}


def _write_components(body: BodyScript) -> None:
    source, structure, columns = body.source, body.structure, body.columns
    source.line("entity = sapien.Entity()")
    write_render_component(body)
    if structure.body_type != "none":
        source.line(f"body = {_STATIC if structure.body_type == 'static' else _DYNAMIC}()")
        source.statement(body.name, assign="body.name")
        if structure.body_type == "kinematic":
            source.line("body.kinematic = True")
        write_body_component(body)
    source.statement(body.name, assign="entity.name")
    source.statement(columns.value(body.entity.pose, "pose", pose_call), assign="entity.pose")
    source.line("scene.add_entity(entity)")


def write_render_component(body: BodyScript) -> None:
    """Adds a render component to `entity`, if it has visual shapes."""
    if body.structure.visuals:
        with _render_block(body.source, body.columns):
            body.source.line(f"look = {_RENDER_BODY}()")
            body.source.statement(body.name, assign="look.name")
            for shape in body.structure.visuals:
                _write_visual(shape, body)
            write_properties(body.source, body.structure, RENDER_PROPERTIES, body.columns, "look")
            body.source.line("entity.add_component(look)")


def write_body_component(body: BodyScript) -> None:
    """Writes shapes, mass and properties of `body`, and adds it to `entity`."""
    source, structure, columns = body.source, body.structure, body.columns
    for shape in structure.collisions:
        _write_collision(shape, body)
    if structure.inertial is not None:
        write_inertial(source, structure.inertial, columns)
    write_mass(source, structure, columns)
    write_properties(source, structure, BODY_PROPERTIES, columns, "body")
    source.line("entity.add_component(body)")


def _write_collision(shape: CollisionShape, body: BodyScript) -> None:
    source, geometry = body.source, shape.geometry
    row = COLLISIONS[type(geometry)]
    arguments = row.arguments(geometry, body.columns, body.files)
    if isinstance(geometry, ConvexMesh | ConvexParts | TriangleMesh):
        arguments.setdefault("scale", "[1, 1, 1]")  # has no default here
    arguments |= _material_argument(shape, body) or {"material": call("physx.get_default_material")}
    if isinstance(geometry, TriangleMesh):
        arguments["sdf"] = str(geometry.sdf)
    if isinstance(geometry, ConvexParts | RevolvedSolid):
        source.statement(call(row.make, **arguments), assign="parts")
        with source.block("for shape in parts:"):
            _write_shape(shape, body)
    else:
        source.statement(call(row.make, **arguments), assign="shape")
        _write_shape(shape, body)


def _write_shape(shape: CollisionShape, body: BodyScript) -> None:
    source, columns = body.source, body.columns
    for node in _pose_argument(shape.pose, columns).values():
        source.statement(node, assign="shape.local_pose")
    groups = shape.collision_groups or body.structure.collision_groups
    if groups is not None:
        source.statement(call("shape.set_collision_groups", columns.value(groups, "groups")))
    if shape.density is None and isinstance(shape.geometry, Plane):
        source.line("shape.density = 0")
    write_properties(source, shape, (*SHAPE_ARGUMENTS, *CONTACT_OFFSETS), columns, "shape")
    source.line("body.attach(shape)")


def _write_visual(shape: VisualShape, body: BodyScript) -> None:
    source, columns = body.source, body.columns
    row = VISUALS[type(shape.geometry)]
    arguments = row.arguments(shape.geometry, columns, body.files)
    fresh: Arguments = {} if isinstance(shape.geometry, Mesh) else {"material": call("sapien.render.RenderMaterial")}
    arguments |= _material_argument(shape, body) or fresh
    source.statement(call(row.make, **arguments), assign="shape")
    for node in _pose_argument(shape.pose, columns).values():
        source.statement(node, assign="shape.local_pose")
    if shape.name:
        source.statement(string(shape.name), assign="shape.name")
    face = _front_face(shape, columns)
    if face is not None:
        source.statement(call("shape.set_front_face", face))
    source.line("look.attach(shape)")


def _front_face(shape: VisualShape, columns: SceneValues) -> SourceNode | None:
    """Returns the front face of a shape, flipped for a mirrored mesh, as the builder does."""
    if shape.front_face is not None:
        return string(shape.front_face)
    if not isinstance(shape.geometry, Mesh):
        return None
    mirrored = np.count_nonzero(columns.of_rows(shape.geometry.scale) < 0, axis=1) % 2 == 1
    if not mirrored.any():
        return None
    return columns.words(["clockwise" if m else "counterclockwise" for m in mirrored.tolist()], "front_face")


@contextmanager
def _render_block(source: SourceWriter, columns: SceneValues) -> Generator[None]:
    """Opens a block that runs only if `render`, like the lists that it needs."""
    with source.block("if render:"), columns.rendered():
        yield
