"""Sizes that the engine's shapes must have: one row a geometry type."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.columns import plain_row
from scenecc.backends.sapien.engine import physx, render
from scenecc.plan import (
    Box,
    Capsule,
    ConvexMesh,
    ConvexParts,
    Cylinder,
    Mesh,
    Plane,
    Sphere,
    TiledPlane,
    TriangleMesh,
    VisualPlane,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.plan import CollisionGeometry, VisualGeometry

Sizes = dict[str, Any]


def _half_size(geometry: Box, row: int) -> Sizes:
    return {"half_size": plain_row(geometry.half_size, row)}


def _radius(geometry: Sphere, row: int) -> Sizes:
    return {"radius": plain_row(geometry.radius, row)}


def _radius_and_length(geometry: Capsule | Cylinder, row: int) -> Sizes:
    return {"radius": plain_row(geometry.radius, row), "half_length": plain_row(geometry.half_length, row)}


def _scale(geometry: TriangleMesh | Mesh, row: int) -> Sizes:
    return {"scale": geometry.scale.row(row)}


def _unmirrored(geometry: ConvexMesh | ConvexParts, row: int) -> Sizes:
    """A mirrored one has a file of its own."""
    return {"scale": np.abs(geometry.scale.row(row))}


def _none(geometry: Plane, row: int) -> Sizes:
    del geometry, row
    return {}


def _plane_scale(geometry: VisualPlane, row: int) -> Sizes:
    return {"scale": np.concatenate([[10.0], geometry.half_size.row(row)])}


def _no_scale(geometry: TiledPlane, row: int) -> Sizes:
    del geometry, row
    return {"scale": np.ones(3)}


COLLISION_SIZES: dict[type[CollisionGeometry], tuple[Any, Callable[[Any, int], Sizes]]] = {
    Box: (physx.PhysxCollisionShapeBox, _half_size),
    Sphere: (physx.PhysxCollisionShapeSphere, _radius),
    Capsule: (physx.PhysxCollisionShapeCapsule, _radius_and_length),
    Cylinder: (physx.PhysxCollisionShapeCylinder, _radius_and_length),
    Plane: (physx.PhysxCollisionShapePlane, _none),
    ConvexMesh: (physx.PhysxCollisionShapeConvexMesh, _unmirrored),
    ConvexParts: (physx.PhysxCollisionShapeConvexMesh, _unmirrored),
    TriangleMesh: (physx.PhysxCollisionShapeTriangleMesh, _scale),
}
"""Geometry to the engine's type and to the properties that the entity's row must have."""

VISUAL_SIZES: dict[type[VisualGeometry], tuple[Any, Callable[[Any, int], Sizes]]] = {
    Box: (render.RenderShapeBox, _half_size),
    Sphere: (render.RenderShapeSphere, _radius),
    Capsule: (render.RenderShapeCapsule, _radius_and_length),
    Cylinder: (render.RenderShapeCylinder, _radius_and_length),
    VisualPlane: (render.RenderShapePlane, _plane_scale),
    Mesh: (render.RenderShapeTriangleMesh, _scale),
    TiledPlane: (render.RenderShapeTriangleMesh, _no_scale),
}
"""The same for what is seen."""


def tiles(geometry: TiledPlane, row: int) -> tuple[Any, Any]:
    """Corners (4, 3) and texture coordinates (4, 2) of a tiled plane, counterclockwise from -x, -y."""
    x, y = geometry.half_size.row(row).tolist()
    u, v = (geometry.texture_repeat.row(row) / 2).tolist()
    corners = [[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]]
    uvs = [[0.5 - u, 0.5 - v], [0.5 + u, 0.5 - v], [0.5 + u, 0.5 + v], [0.5 - u, 0.5 + v]]
    return np.array(corners), np.array(uvs)
