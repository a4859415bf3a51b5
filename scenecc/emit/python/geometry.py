"""Geometry as arguments of SAPIEN's calls: one row a type."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.emit.python.source import SourceNode, call
from scenecc.emit.python.values import SceneValues, numbers_literal
from scenecc.plan import (
    Box,
    Capsule,
    CollisionGeometry,
    ConvexMesh,
    ConvexParts,
    Cylinder,
    Mesh,
    Plane,
    Sphere,
    TiledPlane,
    TriangleMesh,
    Value,
    VisualGeometry,
    VisualPlane,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.emit.python.files import ScriptFiles

Arguments = dict[str, SourceNode]


@dataclass(frozen=True, slots=True)
class ShapeCall:
    """How a type of shape is made.

    Attributes:
        add: method of `ActorBuilder`; "" where it has none.
        make: constructor of the shape itself.
        arguments: geometry to keyword arguments of both.
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
    return {
        "filename": call("str", columns.value(geometry.file, "file", files.name)),
        **_scale_argument(geometry.scale, columns),
    }


def _scale_argument(scale: Value, columns: SceneValues) -> Arguments:
    if not scale.varies and (scale.data == 1).all():
        return {}
    return {"scale": columns.value(scale, "scale")}


def _convex_arguments(geometry: ConvexMesh | ConvexParts, columns: SceneValues, files: ScriptFiles) -> Arguments:
    is_parts = isinstance(geometry, ConvexParts)
    if is_parts and geometry.coacd is not None:
        file = files.parts(columns.value(geometry.file, "file", files.name), geometry.coacd)
    else:
        file = call("str", columns.value(geometry.file, "file", files.name))
    scale = geometry.scale
    if (scale.data < 0).any():
        file = files.mirrored(file, columns.value(Value(np.sign(scale.data)), "signs", _tuple_literal), parts=is_parts)
        scale = Value(np.abs(scale.data))
    return {"filename": file, **_scale_argument(scale, columns)}


def _tuple_literal(row: Any) -> SourceNode:
    return "({})".format(", ".join(f"{item:g}" for item in row))


def _visual_plane_arguments(geometry: VisualPlane, columns: SceneValues, files: ScriptFiles) -> Arguments:
    del files
    # As SAPIEN's own ground has it; the first number shows nowhere.
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


_HALF_SIZE = _size_arguments("half_size")
_RADIUS = _size_arguments("radius")
_RADIUS_AND_LENGTH = _size_arguments("radius", "half_length")
_CONVEX = "physx.PhysxCollisionShapeConvexMesh"

COLLISIONS: dict[type[CollisionGeometry], ShapeCall] = {
    Box: ShapeCall("add_box_collision", "physx.PhysxCollisionShapeBox", _HALF_SIZE),
    Sphere: ShapeCall("add_sphere_collision", "physx.PhysxCollisionShapeSphere", _RADIUS),
    Capsule: ShapeCall("add_capsule_collision", "physx.PhysxCollisionShapeCapsule", _RADIUS_AND_LENGTH),
    Cylinder: ShapeCall("add_cylinder_collision", "physx.PhysxCollisionShapeCylinder", _RADIUS_AND_LENGTH),
    Plane: ShapeCall("add_plane_collision", "physx.PhysxCollisionShapePlane", _no_arguments),
    ConvexMesh: ShapeCall("add_convex_collision_from_file", _CONVEX, _convex_arguments),
    ConvexParts: ShapeCall("add_multiple_convex_collisions_from_file", f"{_CONVEX}.load_multiple", _convex_arguments),
    TriangleMesh: ShapeCall(
        "add_nonconvex_collision_from_file", "physx.PhysxCollisionShapeTriangleMesh", _mesh_arguments
    ),
}

VISUALS: dict[type[VisualGeometry], ShapeCall] = {
    Box: ShapeCall("add_box_visual", "sapien.render.RenderShapeBox", _HALF_SIZE),
    Sphere: ShapeCall("add_sphere_visual", "sapien.render.RenderShapeSphere", _RADIUS),
    Capsule: ShapeCall("add_capsule_visual", "sapien.render.RenderShapeCapsule", _RADIUS_AND_LENGTH),
    Cylinder: ShapeCall("add_cylinder_visual", "sapien.render.RenderShapeCylinder", _RADIUS_AND_LENGTH),
    VisualPlane: ShapeCall("add_plane_visual", "sapien.render.RenderShapePlane", _visual_plane_arguments),
    Mesh: ShapeCall("add_visual_from_file", "sapien.render.RenderShapeTriangleMesh", _mesh_arguments),
    TiledPlane: ShapeCall("", "sapien.render.RenderShapeTriangleMesh", _tiled_plane_arguments),
}
