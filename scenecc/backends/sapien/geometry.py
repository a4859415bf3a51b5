"""Geometry types in SAPIEN, one row per type: how a collision or render shape is made, and which sizes are read back
from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.assets import mirror_meshes
from scenecc.backends.sapien.engine import physx, render
from scenecc.backends.sapien.properties import (
    Column,
    bind_columns,
    row_value,
    scalar_column,
    select_rows,
    to_scalars,
    to_vectors,
    vector_column,
)
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

    from numpy.typing import NDArray

    from scenecc.backends.sapien.assets import Resources
    from scenecc.plan import CollisionGeometry, Value, VisualGeometry


class CollisionContext(NamedTuple):
    """What a row of the table is given.

    Attributes:
        rows: the entity's rows that are built.
        material: a column of `PhysxMaterial`.
        resources: files and materials of the plan.
    """

    rows: NDArray[np.intp]
    material: Column
    resources: Resources


def _collision_box(geometry: Box, build: CollisionContext) -> Callable[[int], Any]:
    return bind_columns(physx.PhysxCollisionShapeBox, [vector_column(geometry.half_size, build.rows), build.material])


def _collision_sphere(geometry: Sphere, build: CollisionContext) -> Callable[[int], Any]:
    return bind_columns(physx.PhysxCollisionShapeSphere, [scalar_column(geometry.radius, build.rows), build.material])


def _collision_capsule(geometry: Capsule, build: CollisionContext) -> Callable[[int], Any]:
    radius, half_length = scalar_column(geometry.radius, build.rows), scalar_column(geometry.half_length, build.rows)
    return bind_columns(physx.PhysxCollisionShapeCapsule, [radius, half_length, build.material])


def _collision_cylinder(geometry: Cylinder, build: CollisionContext) -> Callable[[int], Any]:
    radius, half_length = scalar_column(geometry.radius, build.rows), scalar_column(geometry.half_length, build.rows)
    return bind_columns(physx.PhysxCollisionShapeCylinder, [radius, half_length, build.material])


def _collision_plane(geometry: Plane, build: CollisionContext) -> Callable[[int], Any]:
    del geometry
    return bind_columns(physx.PhysxCollisionShapePlane, [build.material])


def _convex_mesh(geometry: ConvexMesh, build: CollisionContext) -> Callable[[int], Any]:
    return bind_columns(physx.PhysxCollisionShapeConvexMesh, [*_hull_arguments(geometry, build), build.material])


def _convex_parts(geometry: ConvexParts, build: CollisionContext) -> Callable[[int], Any]:
    return bind_columns(
        physx.PhysxCollisionShapeConvexMesh.load_multiple, [*_hull_arguments(geometry, build), build.material]
    )


def _hull_arguments(geometry: ConvexMesh | ConvexParts, build: CollisionContext) -> tuple[Column, Column]:
    """File and scale, which PhysX wants above 0."""
    file, scale = select_rows(geometry.file, build.rows), select_rows(geometry.scale, build.rows)
    if isinstance(geometry, ConvexParts):
        meshes = build.resources.parts(file, geometry.coacd)
    else:
        meshes = build.resources.meshes(file, "SC801")
    return mirror_meshes(meshes, scale, parts=isinstance(geometry, ConvexParts)), to_vectors(np.abs(scale))


def _triangle_mesh(geometry: TriangleMesh, build: CollisionContext) -> Callable[[int], Any]:
    file = build.resources.meshes(select_rows(geometry.file, build.rows), "SC801")
    scale = to_vectors(select_rows(geometry.scale, build.rows))
    return bind_columns(physx.PhysxCollisionShapeTriangleMesh, [file, scale, build.material, [geometry.sdf]])


COLLISION_MAKERS: dict[type[CollisionGeometry], Callable[[Any, CollisionContext], Callable[[int], Any]]] = {
    Box: _collision_box,
    Sphere: _collision_sphere,
    Capsule: _collision_capsule,
    Cylinder: _collision_cylinder,
    Plane: _collision_plane,
    ConvexMesh: _convex_mesh,
    ConvexParts: _convex_parts,
    TriangleMesh: _triangle_mesh,
}
"""Geometry to a function from a row to a new shape (`ConvexParts`: to a list of shapes)."""


@dataclass(frozen=True, slots=True)
class VisualContext:
    """What a row of the table is given.

    Attributes:
        rows: the entity's rows that are built.
        material: a column of `RenderMaterial`; None: the plan names none.
        resources: files and materials of the plan.
    """

    rows: NDArray[np.intp]
    material: Column | None
    resources: Resources

    def or_fresh(self) -> Column:
        """The material, or one new `RenderMaterial` for all rows of the shape."""
        return [render.RenderMaterial()] if self.material is None else self.material


def _visual_box(geometry: Box, look: VisualContext) -> Callable[[int], Any]:
    return bind_columns(
        render.RenderShapeBox, [to_vectors(select_rows(geometry.half_size, look.rows)), look.or_fresh()]
    )


def _visual_sphere(geometry: Sphere, look: VisualContext) -> Callable[[int], Any]:
    return bind_columns(
        render.RenderShapeSphere, [to_scalars(select_rows(geometry.radius, look.rows)), look.or_fresh()]
    )


def _visual_capsule(geometry: Capsule, look: VisualContext) -> Callable[[int], Any]:
    radius, half_length = select_rows(geometry.radius, look.rows), select_rows(geometry.half_length, look.rows)
    return bind_columns(render.RenderShapeCapsule, [to_scalars(radius), to_scalars(half_length), look.or_fresh()])


def _visual_cylinder(geometry: Cylinder, look: VisualContext) -> Callable[[int], Any]:
    radius, half_length = select_rows(geometry.radius, look.rows), select_rows(geometry.half_length, look.rows)
    return bind_columns(render.RenderShapeCylinder, [to_scalars(radius), to_scalars(half_length), look.or_fresh()])


def _visual_plane(geometry: VisualPlane, look: VisualContext) -> Callable[[int], Any]:
    half_size = select_rows(geometry.half_size, look.rows)
    # SAPIEN's own ground gives a plane the scale [10, y, z]; the first number shows nowhere.
    scale = np.insert(half_size, 0, 10.0, axis=1)
    return bind_columns(render.RenderShapePlane, [to_vectors(scale), look.or_fresh()])


def _visual_mesh(geometry: Mesh, look: VisualContext) -> Callable[[int], Any]:
    file = look.resources.meshes(select_rows(geometry.file, look.rows), "SC807")
    material: Column = [None] if look.material is None else look.material
    return bind_columns(
        render.RenderShapeTriangleMesh, [file, to_vectors(select_rows(geometry.scale, look.rows)), material]
    )


def _visual_tiled_plane(geometry: TiledPlane, look: VisualContext) -> Callable[[int], Any]:
    half_size, repeat = select_rows(geometry.half_size, look.rows), select_rows(geometry.texture_repeat, look.rows)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
    vertices = np.zeros((len(half_size), 4, 3))
    vertices[:, :, :2] = half_size[:, None] * corners
    uvs = 0.5 + corners / 2 * repeat[:, None]
    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
    normals = np.tile(np.array([0, 0, 1], dtype=np.float32), (4, 1))
    columns = [to_vectors(vertices), [triangles], [normals], to_vectors(uvs), look.or_fresh()]
    return bind_columns(render.RenderShapeTriangleMesh, columns)


VISUAL_MAKERS: dict[type[VisualGeometry], Callable[[Any, VisualContext], Callable[[int], Any]]] = {
    Box: _visual_box,
    Sphere: _visual_sphere,
    Capsule: _visual_capsule,
    Cylinder: _visual_cylinder,
    VisualPlane: _visual_plane,
    Mesh: _visual_mesh,
    TiledPlane: _visual_tiled_plane,
}
"""Geometry to a function from a row to a new render shape."""


def front_face_column(geometry: VisualGeometry, given: str | None, rows: NDArray[np.intp]) -> Column | None:
    """The side that is seen, a row; None where SAPIEN's own is right.

    A mirrored mesh is inside out, so SAPIEN's `ActorBuilder` turns it, and so does this.
    """
    if given is not None:
        return [given]
    if not isinstance(geometry, Mesh):
        return None
    mirrored = _is_mirrored(geometry.scale, rows)
    return ["clockwise" if m else "counterclockwise" for m in mirrored] if any(mirrored) else None


def _is_mirrored(scale: Value, rows: NDArray[np.intp]) -> list[bool]:
    return (np.prod(select_rows(scale, rows), axis=1) < 0).tolist()


Sizes = dict[str, Any]


def _box_sizes(geometry: Box, row: int) -> Sizes:
    return {"half_size": row_value(geometry.half_size, row)}


def _sphere_sizes(geometry: Sphere, row: int) -> Sizes:
    return {"radius": row_value(geometry.radius, row)}


def _capsule_sizes(geometry: Capsule | Cylinder, row: int) -> Sizes:
    return {"radius": row_value(geometry.radius, row), "half_length": row_value(geometry.half_length, row)}


def _mesh_sizes(geometry: TriangleMesh | Mesh, row: int) -> Sizes:
    return {"scale": geometry.scale.row(row)}


def _hull_sizes(geometry: ConvexMesh | ConvexParts, row: int) -> Sizes:
    """A mirrored one has a file of its own."""
    return {"scale": np.abs(geometry.scale.row(row))}


def _no_sizes(geometry: Plane, row: int) -> Sizes:
    del geometry, row
    return {}


def _visual_plane_sizes(geometry: VisualPlane, row: int) -> Sizes:
    return {"scale": np.concatenate([[10.0], geometry.half_size.row(row)])}


def _tiled_plane_sizes(geometry: TiledPlane, row: int) -> Sizes:
    del geometry, row
    return {"scale": np.ones(3)}


COLLISION_SIZES: dict[type[CollisionGeometry], tuple[Any, Callable[[Any, int], Sizes]]] = {
    Box: (physx.PhysxCollisionShapeBox, _box_sizes),
    Sphere: (physx.PhysxCollisionShapeSphere, _sphere_sizes),
    Capsule: (physx.PhysxCollisionShapeCapsule, _capsule_sizes),
    Cylinder: (physx.PhysxCollisionShapeCylinder, _capsule_sizes),
    Plane: (physx.PhysxCollisionShapePlane, _no_sizes),
    ConvexMesh: (physx.PhysxCollisionShapeConvexMesh, _hull_sizes),
    ConvexParts: (physx.PhysxCollisionShapeConvexMesh, _hull_sizes),
    TriangleMesh: (physx.PhysxCollisionShapeTriangleMesh, _mesh_sizes),
}
"""Geometry to the engine's type and to the properties that the entity's row must have."""

VISUAL_SIZES: dict[type[VisualGeometry], tuple[Any, Callable[[Any, int], Sizes]]] = {
    Box: (render.RenderShapeBox, _box_sizes),
    Sphere: (render.RenderShapeSphere, _sphere_sizes),
    Capsule: (render.RenderShapeCapsule, _capsule_sizes),
    Cylinder: (render.RenderShapeCylinder, _capsule_sizes),
    VisualPlane: (render.RenderShapePlane, _visual_plane_sizes),
    Mesh: (render.RenderShapeTriangleMesh, _mesh_sizes),
    TiledPlane: (render.RenderShapeTriangleMesh, _tiled_plane_sizes),
}
"""The same for what is seen."""


def tiled_plane_vertices(geometry: TiledPlane, row: int) -> tuple[Any, Any]:
    """Corners (4, 3) and texture coordinates (4, 2) of a tiled plane, counterclockwise from -x, -y."""
    x, y = geometry.half_size.row(row).tolist()
    u, v = (geometry.texture_repeat.row(row) / 2).tolist()
    corners = [[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]]
    uvs = [[0.5 - u, 0.5 - v], [0.5 + u, 0.5 - v], [0.5 + u, 0.5 + v], [0.5 - u, 0.5 + v]]
    return np.array(corners), np.array(uvs)
