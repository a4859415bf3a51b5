"""Geometry as arguments of SAPIEN's calls: one row a type."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.emit.python.columns import Columns, numbers
from scenecc.emit.python.layout import Node, call
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

    from scenecc.emit.python.files import Files

Arguments = dict[str, Node]


@dataclass(frozen=True, slots=True)
class Shape:
    """How a type of shape is made.

    Attributes:
        add: method of `ActorBuilder`; "" where it has none.
        make: constructor of the shape itself.
        arguments: geometry to keyword arguments of both.
    """

    add: str
    make: str
    arguments: Callable[[Any, Columns, Files], Arguments]


def _sizes(*fields: str) -> Callable[[Any, Columns, Files], Arguments]:
    def arguments(geometry: Any, columns: Columns, files: Files) -> Arguments:
        del files
        return {name: columns.value(getattr(geometry, name), name) for name in fields}

    return arguments


def _nothing(geometry: Plane, columns: Columns, files: Files) -> Arguments:
    del geometry, columns, files
    return {}


def _file(geometry: TriangleMesh | Mesh, columns: Columns, files: Files) -> Arguments:
    return {
        "filename": call("str", columns.value(geometry.file, "file", files.name)),
        **_scale(geometry.scale, columns),
    }


def _scale(scale: Value, columns: Columns) -> Arguments:
    if not scale.varies and (scale.data == 1).all():
        return {}
    return {"scale": columns.value(scale, "scale")}


def _hull(geometry: ConvexMesh | ConvexParts, columns: Columns, files: Files) -> Arguments:
    is_parts = isinstance(geometry, ConvexParts)
    if is_parts and geometry.coacd is not None:
        file = files.parts(columns.value(geometry.file, "file", files.name), geometry.coacd)
    else:
        file = call("str", columns.value(geometry.file, "file", files.name))
    scale = geometry.scale
    if (scale.data < 0).any():
        file = files.mirrored(file, columns.value(Value(np.sign(scale.data)), "signs", _tuple), parts=is_parts)
        scale = Value(np.abs(scale.data))
    return {"filename": file, **_scale(scale, columns)}


def _tuple(row: Any) -> Node:
    return "({})".format(", ".join(f"{item:g}" for item in row))


def _visual_plane(geometry: VisualPlane, columns: Columns, files: Files) -> Arguments:
    del files
    # As SAPIEN's own ground has it; the first number shows nowhere.
    return {"scale": columns.value(Value(np.insert(geometry.half_size.data, 0, 10.0, axis=1)), "scale")}


def _tiled_plane(geometry: TiledPlane, columns: Columns, files: Files) -> Arguments:
    del files
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
    half_size, repeat = geometry.half_size.data, geometry.texture_repeat.data
    vertices = np.zeros((len(half_size), 4, 3))
    vertices[:, :, :2] = half_size[:, None] * corners
    return {
        "vertices": columns.value(Value(vertices), "vertices"),
        "triangles": numbers(np.array([[0, 1, 2], [0, 2, 3]])),
        "normals": numbers(np.array([[0, 0, 1]] * 4)),
        "uvs": columns.value(Value(0.5 + corners / 2 * repeat[:, None]), "uvs"),
    }


_HALF_SIZE = _sizes("half_size")
_RADIUS = _sizes("radius")
_ROUND = _sizes("radius", "half_length")
_CONVEX = "physx.PhysxCollisionShapeConvexMesh"

COLLISIONS: dict[type[CollisionGeometry], Shape] = {
    Box: Shape("add_box_collision", "physx.PhysxCollisionShapeBox", _HALF_SIZE),
    Sphere: Shape("add_sphere_collision", "physx.PhysxCollisionShapeSphere", _RADIUS),
    Capsule: Shape("add_capsule_collision", "physx.PhysxCollisionShapeCapsule", _ROUND),
    Cylinder: Shape("add_cylinder_collision", "physx.PhysxCollisionShapeCylinder", _ROUND),
    Plane: Shape("add_plane_collision", "physx.PhysxCollisionShapePlane", _nothing),
    ConvexMesh: Shape("add_convex_collision_from_file", _CONVEX, _hull),
    ConvexParts: Shape("add_multiple_convex_collisions_from_file", f"{_CONVEX}.load_multiple", _hull),
    TriangleMesh: Shape("add_nonconvex_collision_from_file", "physx.PhysxCollisionShapeTriangleMesh", _file),
}

VISUALS: dict[type[VisualGeometry], Shape] = {
    Box: Shape("add_box_visual", "sapien.render.RenderShapeBox", _HALF_SIZE),
    Sphere: Shape("add_sphere_visual", "sapien.render.RenderShapeSphere", _RADIUS),
    Capsule: Shape("add_capsule_visual", "sapien.render.RenderShapeCapsule", _ROUND),
    Cylinder: Shape("add_cylinder_visual", "sapien.render.RenderShapeCylinder", _ROUND),
    VisualPlane: Shape("add_plane_visual", "sapien.render.RenderShapePlane", _visual_plane),
    Mesh: Shape("add_visual_from_file", "sapien.render.RenderShapeTriangleMesh", _file),
    TiledPlane: Shape("", "sapien.render.RenderShapeTriangleMesh", _tiled_plane),
}
