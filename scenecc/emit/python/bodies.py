"""One body of a plan as statements: `ActorBuilder` where it can, the components themselves where it cannot."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scenecc.emit.python.columns import IDENTITY, Columns, pose
from scenecc.emit.python.geometry import COLLISIONS, VISUALS, Arguments
from scenecc.emit.python.held import Held
from scenecc.emit.python.knobs import (
    ARGUMENTS,
    BODY_KNOBS,
    LOOK_KNOBS,
    OFFSETS,
    given,
    inertial_nodes,
    write_body_knobs,
    write_inertial,
    write_mass,
    write_offsets,
)
from scenecc.emit.python.layout import Node, Source, call, string
from scenecc.plan import (
    BodyStructure,
    CollisionShape,
    ConvexMesh,
    ConvexParts,
    Mesh,
    Plane,
    TiledPlane,
    TriangleMesh,
    VisualShape,
)

if TYPE_CHECKING:
    from collections.abc import Generator

    from scenecc.emit.python.files import Files
    from scenecc.emit.python.materials import Materials
    from scenecc.plan import Entity, Value

_DYNAMIC = "physx.PhysxRigidDynamicComponent"
_STATIC = "physx.PhysxRigidStaticComponent"
_LOOK = "sapien.render.RenderBodyComponent"


@dataclass(frozen=True, slots=True)
class Body:
    """One structure of an entity in some of its scenes.

    Attributes:
        name: an expression for the entity's.
        source: where statements go; the loop over scenes, if any, is open.
        columns: the entity's quantities in these scenes.
        held: whether something holds on to it.
    """

    entity: Entity
    name: str
    structure: BodyStructure
    source: Source
    columns: Columns
    files: Files
    materials: Materials
    held: bool = False


def write_body(body: Body) -> None:
    """Builds the body in `scene`, row `i` of the block."""
    body.materials.write_own(body.source, (body.structure,), body.columns, body.files)
    if needs_components(body.structure):
        _write_components(body)
    else:
        _write_builder(body)
    if body.held:
        Held.write_body(body.source, body.name, "entity")


def needs_components(structure: BodyStructure) -> bool:
    """Whether `ActorBuilder`, or a builder of links, would build something else."""
    shapes, dynamic = structure.collisions, structure.body_type in {"dynamic", "link"}
    parts = any(isinstance(shape.geometry, ConvexParts) for shape in shapes)
    return (
        structure.body_type == "none"
        # Shapes are then found by their place, and nobody knows how many parts there are before they are loaded.
        or (parts and any(given(shape, OFFSETS) for shape in shapes))
        # The builder decides by the body's type whether to cook a signed distance field, and a plane's density is 0.
        or any(isinstance(shape.geometry, TriangleMesh) and shape.geometry.sdf != dynamic for shape in shapes)
        or any(isinstance(shape.geometry, Plane) and shape.density is not None for shape in shapes)
        or any(shape.front_face is not None or isinstance(shape.geometry, TiledPlane) for shape in structure.visuals)
    )


def _write_builder(body: Body) -> None:
    source, structure, columns = body.source, body.structure, body.columns
    source.line("builder = scene.create_actor_builder()")
    if structure.body_type != "dynamic":
        source.line(f'builder.set_physx_body_type("{structure.body_type}")')
    write_shapes(body, "builder")
    source.statement(columns.value(body.entity.pose, "pose", pose), assign="builder.initial_pose")
    component = _STATIC if structure.body_type == "static" else _DYNAMIC
    touched = _touches_body(structure)
    build = call("builder.build", name=body.name)
    source.statement(build, assign="entity" if touched or body.held or given(structure, LOOK_KNOBS) else "")
    if touched:
        source.line(f"body = entity.find_component_by_type({component})")
        _write_kinematic_inertial(body)
        write_mass(source, structure, columns)
        write_offsets(source, structure.collisions, columns)
        write_body_knobs(source, structure, columns)
    write_look(body, "entity")


def write_shapes(body: Body, builder: str) -> None:
    """What a builder is told before it builds."""
    source, structure, columns = body.source, body.structure, body.columns
    if structure.collision_groups is not None:
        source.statement(columns.value(structure.collision_groups, "groups"), assign=f"{builder}.collision_groups")
    for shape in structure.collisions:
        row = COLLISIONS[type(shape.geometry)]
        source.statement(call(f"{builder}.{row.add}", **_collision_arguments(shape, body)))
    if structure.visuals:
        with _rendered(source, columns):
            for shape in structure.visuals:
                row = VISUALS[type(shape.geometry)]
                source.statement(call(f"{builder}.{row.add}", **_visual_arguments(shape, body)))
    if structure.inertial is not None and structure.body_type in {"dynamic", "link"}:
        source.statement(call(f"{builder}.set_mass_and_inertia", *inertial_nodes(structure.inertial, columns)))


def write_look(body: Body, entity: str) -> None:
    """Properties of the render component of what is built. `entity`: an expression for its entity."""
    if given(body.structure, LOOK_KNOBS):
        with _rendered(body.source, body.columns):
            body.source.line(f"look = {entity}.find_component_by_type({_LOOK})")
            _write_look_knobs(body)


def _touches_body(structure: BodyStructure) -> bool:
    return (
        structure.mass is not None
        or (structure.inertial is not None and structure.body_type == "kinematic")
        or bool(given(structure, BODY_KNOBS))
        or any(given(shape, OFFSETS) for shape in structure.collisions)
    )


def _write_kinematic_inertial(body: Body) -> None:
    """The builder leaves out what a kinematic body weighs."""
    if body.structure.inertial is not None and body.structure.body_type == "kinematic":
        write_inertial(body.source, body.structure.inertial, body.columns)


def _collision_arguments(shape: CollisionShape, body: Body) -> Arguments:
    columns = body.columns
    return {
        **_pose_argument(shape.pose, columns),
        **COLLISIONS[type(shape.geometry)].arguments(shape.geometry, columns, body.files),
        **_material_argument(shape, body),
        **{name: columns.value(getattr(shape, name), name) for name in given(shape, ARGUMENTS)},
    }


def _material_argument(shape: CollisionShape, body: Body) -> Arguments:
    if shape.material is not None:
        return {"material": body.materials.physical(shape.material, body.columns)}
    return {} if body.materials.default is None else {"material": body.materials.default}


def _visual_arguments(shape: VisualShape, body: Body) -> Arguments:
    name: Arguments = {"name": string(shape.name)} if shape.name else {}
    return {
        **_pose_argument(shape.pose, body.columns),
        **VISUALS[type(shape.geometry)].arguments(shape.geometry, body.columns, body.files),
        **_look_argument(shape, body),
        **name,
    }


def _look_argument(shape: VisualShape, body: Body) -> Arguments:
    if shape.material is None:
        return {}
    return {"material": body.materials.look(shape.material, body.columns)}


def _pose_argument(value: Value | None, columns: Columns) -> Arguments:
    if value is None or value.data.tobytes() == IDENTITY.tobytes():
        return {}
    return {"pose": columns.value(value, "shape_pose", pose)}


def _write_components(body: Body) -> None:
    source, structure, columns = body.source, body.structure, body.columns
    source.line("entity = sapien.Entity()")
    write_look_component(body)
    if structure.body_type != "none":
        source.line(f"body = {_STATIC if structure.body_type == 'static' else _DYNAMIC}()")
        source.statement(body.name, assign="body.name")
        if structure.body_type == "kinematic":
            source.line("body.kinematic = True")
        write_body_component(body)
    source.statement(body.name, assign="entity.name")
    source.statement(columns.value(body.entity.pose, "pose", pose), assign="entity.pose")
    source.line("scene.add_entity(entity)")


def write_look_component(body: Body) -> None:
    """The render component of `entity`, where anything is seen."""
    if body.structure.visuals:
        with _rendered(body.source, body.columns):
            body.source.line(f"look = {_LOOK}()")
            body.source.statement(body.name, assign="look.name")
            for shape in body.structure.visuals:
                _write_visual(shape, body)
            _write_look_knobs(body)
            body.source.line("entity.add_component(look)")


def write_body_component(body: Body) -> None:
    """Shapes, mass and properties of `body`, which is then the component of `entity`."""
    source, structure, columns = body.source, body.structure, body.columns
    for shape in structure.collisions:
        _write_collision(shape, body)
    if structure.inertial is not None:
        write_inertial(source, structure.inertial, columns)
    write_mass(source, structure, columns)
    write_body_knobs(source, structure, columns)
    source.line("entity.add_component(body)")


def _write_collision(shape: CollisionShape, body: Body) -> None:
    source, geometry = body.source, shape.geometry
    row = COLLISIONS[type(geometry)]
    arguments = row.arguments(geometry, body.columns, body.files)
    if isinstance(geometry, ConvexMesh | ConvexParts | TriangleMesh):
        arguments.setdefault("scale", "[1, 1, 1]")  # what has no default here
    arguments |= _material_argument(shape, body) or {"material": call("physx.get_default_material")}
    if isinstance(geometry, TriangleMesh):
        arguments["sdf"] = str(geometry.sdf)
    if isinstance(geometry, ConvexParts):
        source.statement(call(row.make, **arguments), assign="parts")
        with source.block("for shape in parts:"):
            _write_shape(shape, body)
    else:
        source.statement(call(row.make, **arguments), assign="shape")
        _write_shape(shape, body)


def _write_shape(shape: CollisionShape, body: Body) -> None:
    source, columns = body.source, body.columns
    for node in _pose_argument(shape.pose, columns).values():
        source.statement(node, assign="shape.local_pose")
    if body.structure.collision_groups is not None:
        groups = columns.value(body.structure.collision_groups, "groups")
        source.statement(call("shape.set_collision_groups", groups))
    if shape.density is None and isinstance(shape.geometry, Plane):
        source.line("shape.density = 0")
    for name in given(shape, (*ARGUMENTS, *OFFSETS)):
        source.statement(columns.value(getattr(shape, name), name), assign=f"shape.{name}")
    source.line("body.attach(shape)")


def _write_visual(shape: VisualShape, body: Body) -> None:
    source, columns = body.source, body.columns
    row = VISUALS[type(shape.geometry)]
    arguments = row.arguments(shape.geometry, columns, body.files)
    fresh: Arguments = {} if isinstance(shape.geometry, Mesh) else {"material": call("sapien.render.RenderMaterial")}
    arguments |= _look_argument(shape, body) or fresh
    source.statement(call(row.make, **arguments), assign="shape")
    for node in _pose_argument(shape.pose, columns).values():
        source.statement(node, assign="shape.local_pose")
    if shape.name:
        source.statement(string(shape.name), assign="shape.name")
    face = _front_face(shape, columns)
    if face is not None:
        source.statement(call("shape.set_front_face", face))
    source.line("look.attach(shape)")


def _front_face(shape: VisualShape, columns: Columns) -> Node | None:
    """The builder turns a mirrored mesh, and so must a script that does without it."""
    if shape.front_face is not None:
        return string(shape.front_face)
    if not isinstance(shape.geometry, Mesh):
        return None
    mirrored = np.count_nonzero(columns.of_rows(shape.geometry.scale) < 0, axis=1) % 2 == 1
    if not mirrored.any():
        return None
    return columns.words(["clockwise" if m else "counterclockwise" for m in mirrored.tolist()], "front_face")


def _write_look_knobs(body: Body) -> None:
    for name in given(body.structure, LOOK_KNOBS):
        body.source.statement(body.columns.value(getattr(body.structure, name), name), assign=f"look.{name}")


@contextmanager
def _rendered(source: Source, columns: Columns) -> Generator[None]:
    """A block that runs where there is a renderer; so do the lists that it needs."""
    with source.block("if render:"), columns.rendered():
        yield
