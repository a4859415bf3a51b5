"""Collision geometry to SAPIEN's shapes: one row a type."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.columns import Column, caller, scalar_column, taken, vector_column, vectors
from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.mirrored import mirrored_column
from scenecc.plan import Box, Capsule, ConvexMesh, ConvexParts, Cylinder, Plane, Sphere, TriangleMesh

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.backends.sapien.resources import Resources
    from scenecc.plan import CollisionGeometry


class Build(NamedTuple):
    """What a row of the table is given.

    Attributes:
        rows: the entity's rows that are built.
        material: a column of `PhysxMaterial`.
        resources: files and materials of the plan.
    """

    rows: NDArray[np.intp]
    material: Column
    resources: Resources


def _box(geometry: Box, build: Build) -> Callable[[int], Any]:
    return caller(physx.PhysxCollisionShapeBox, [vector_column(geometry.half_size, build.rows), build.material])


def _sphere(geometry: Sphere, build: Build) -> Callable[[int], Any]:
    return caller(physx.PhysxCollisionShapeSphere, [scalar_column(geometry.radius, build.rows), build.material])


def _capsule(geometry: Capsule, build: Build) -> Callable[[int], Any]:
    radius, half_length = scalar_column(geometry.radius, build.rows), scalar_column(geometry.half_length, build.rows)
    return caller(physx.PhysxCollisionShapeCapsule, [radius, half_length, build.material])


def _cylinder(geometry: Cylinder, build: Build) -> Callable[[int], Any]:
    radius, half_length = scalar_column(geometry.radius, build.rows), scalar_column(geometry.half_length, build.rows)
    return caller(physx.PhysxCollisionShapeCylinder, [radius, half_length, build.material])


def _plane(geometry: Plane, build: Build) -> Callable[[int], Any]:
    del geometry
    return caller(physx.PhysxCollisionShapePlane, [build.material])


def _convex_mesh(geometry: ConvexMesh, build: Build) -> Callable[[int], Any]:
    return caller(physx.PhysxCollisionShapeConvexMesh, [*_hull(geometry, build), build.material])


def _convex_parts(geometry: ConvexParts, build: Build) -> Callable[[int], Any]:
    return caller(physx.PhysxCollisionShapeConvexMesh.load_multiple, [*_hull(geometry, build), build.material])


def _hull(geometry: ConvexMesh | ConvexParts, build: Build) -> tuple[Column, Column]:
    """File and scale, which PhysX wants above 0."""
    file, scale = taken(geometry.file, build.rows), taken(geometry.scale, build.rows)
    if isinstance(geometry, ConvexParts):
        meshes = build.resources.parts(file, geometry.coacd)
    else:
        meshes = build.resources.meshes(file, "SC801")
    return mirrored_column(meshes, scale, parts=isinstance(geometry, ConvexParts)), vectors(np.abs(scale))


def _triangle_mesh(geometry: TriangleMesh, build: Build) -> Callable[[int], Any]:
    file = build.resources.meshes(taken(geometry.file, build.rows), "SC801")
    scale = vectors(taken(geometry.scale, build.rows))
    return caller(physx.PhysxCollisionShapeTriangleMesh, [file, scale, build.material, [geometry.sdf]])


COLLISION: dict[type[CollisionGeometry], Callable[[Any, Build], Callable[[int], Any]]] = {
    Box: _box,
    Sphere: _sphere,
    Capsule: _capsule,
    Cylinder: _cylinder,
    Plane: _plane,
    ConvexMesh: _convex_mesh,
    ConvexParts: _convex_parts,
    TriangleMesh: _triangle_mesh,
}
"""Geometry to a function from a row to a new shape (`ConvexParts`: to a list of shapes)."""
