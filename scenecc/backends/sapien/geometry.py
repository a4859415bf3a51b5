"""Geometry types in SAPIEN, one row per type: how to make a collision or render shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.assets import Resources, mirror_meshes
from scenecc.backends.sapien.engine import physx, render
from scenecc.backends.sapien.properties import Column, bind_columns, select_rows, size_column, to_vectors
from scenecc.geometry.surfaces import Profile, cached_parts
from scenecc.plan import (
    Box,
    Capsule,
    ConvexMesh,
    ConvexParts,
    Cylinder,
    Heightfield,
    Mesh,
    Plane,
    Sphere,
    TiledPlane,
    TriangleMesh,
    VisualPlane,
)
from scenecc.plan.geometry import REVOLVED_SOLIDS, RevolvedSolid

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.plan import CollisionGeometry, Value, VisualGeometry


@dataclass(frozen=True, slots=True)
class ShapeContext:
    """Input for a row of the tables.

    Attributes:
        rows: the entity's rows that are built.
        material: a column of `PhysxMaterial` or `RenderMaterial`. None: the plan sets no visual material.
        resources: files and materials of the plan.
    """

    rows: NDArray[np.intp]
    material: Column | None
    resources: Resources

    def materials(self) -> Column:
        """Returns the material, or one new `RenderMaterial` for all rows of the shape."""
        return [render.RenderMaterial()] if self.material is None else self.material


class ShapeType(NamedTuple):
    """A geometry in SAPIEN, as a collision or visual shape.

    Attributes:
        engine: SAPIEN's class.
        make: takes the geometry and returns a function from a row to a new shape (`ConvexParts`: to a list of shapes).
        sizes: names of the numbers that `engine` takes, in their order; empty for a mesh.
        many: whether one collision shape of the plan becomes several of the engine.
    """

    engine: Any
    make: Callable[[Any, ShapeContext], Callable[[int], Any]]
    sizes: tuple[str, ...] = ()
    many: bool = False


def _sized_shape(engine: Any, *sizes: str) -> ShapeType:
    """Makes a row for a class that takes its sizes, by the plan's field names, and a material."""

    def make(geometry: Any, build: ShapeContext) -> Callable[[int], Any]:
        columns = [size_column(getattr(geometry, name), build.rows) for name in sizes]
        return bind_columns(engine, [*columns, build.materials()])

    return ShapeType(engine, make, sizes)


def _convex_mesh(geometry: ConvexMesh, build: ShapeContext) -> Callable[[int], Any]:
    return bind_columns(physx.PhysxCollisionShapeConvexMesh, [*_hull_arguments(geometry, build), build.materials()])


def _convex_parts(geometry: ConvexParts, build: ShapeContext) -> Callable[[int], Any]:
    return bind_columns(
        physx.PhysxCollisionShapeConvexMesh.load_multiple, [*_hull_arguments(geometry, build), build.materials()]
    )


def _hull_arguments(geometry: ConvexMesh | ConvexParts, build: ShapeContext) -> tuple[Column, Column]:
    """Returns file and scale. PhysX needs a positive scale."""
    file, scale = select_rows(geometry.file, build.rows), select_rows(geometry.scale, build.rows)
    if isinstance(geometry, ConvexParts):
        meshes = build.resources.parts(file, geometry.coacd)
    else:
        meshes = build.resources.collision_meshes(file)
    return mirror_meshes(meshes, scale, parts=isinstance(geometry, ConvexParts)), to_vectors(np.abs(scale))


def _triangle_mesh(geometry: TriangleMesh, build: ShapeContext) -> Callable[[int], Any]:
    file = build.resources.collision_meshes(select_rows(geometry.file, build.rows))
    scale = to_vectors(select_rows(geometry.scale, build.rows))
    return bind_columns(physx.PhysxCollisionShapeTriangleMesh, [file, scale, build.materials(), [geometry.sdf]])


def _heightfield(geometry: Heightfield, build: ShapeContext) -> Callable[[int], Any]:
    found = [geometry.surface(row) for row in _distinct_rows(geometry, build.rows)]
    columns: list[Column] = [[surface[0] for surface in found], [surface[1] for surface in found]]
    return bind_columns(physx.PhysxCollisionShapeTriangleMesh, [*columns, [np.ones(3)], build.materials()])


def _revolved_parts(geometry: RevolvedSolid, build: ShapeContext) -> Callable[[int], Any]:
    found = [geometry.unit_profile(*geometry.sizes(row)) for row in _distinct_rows(geometry, build.rows)]
    profiles: Column = [profile for profile, _ in found]
    return bind_columns(make_revolved_parts, [profiles, to_vectors(np.array([s for _, s in found])), build.materials()])


def make_revolved_parts(profile: Profile, scale: Any, material: Any) -> list[Any]:
    """Returns the convex shapes of a profile of unit size, scaled."""
    return [physx.PhysxCollisionShapeConvexMesh(part, scale, material) for part in cached_parts(profile)]


def _distinct_rows(geometry: RevolvedSolid | Heightfield, rows: NDArray[np.intp]) -> list[int]:
    """Returns the rows that are built, or one of them if the sizes are the same in every scene."""
    found: list[int] = rows.tolist()
    return found if any(value.varies for value in geometry.values) else found[:1]


_REVOLVED_PARTS = ShapeType(physx.PhysxCollisionShapeConvexMesh, _revolved_parts, many=True)

COLLISION_SHAPES: dict[type[CollisionGeometry], ShapeType] = {
    Box: _sized_shape(physx.PhysxCollisionShapeBox, "half_size"),
    Sphere: _sized_shape(physx.PhysxCollisionShapeSphere, "radius"),
    Capsule: _sized_shape(physx.PhysxCollisionShapeCapsule, "radius", "half_length"),
    Cylinder: _sized_shape(physx.PhysxCollisionShapeCylinder, "radius", "half_length"),
    **dict.fromkeys(REVOLVED_SOLIDS.values(), _REVOLVED_PARTS),
    Plane: _sized_shape(physx.PhysxCollisionShapePlane),
    ConvexMesh: ShapeType(physx.PhysxCollisionShapeConvexMesh, _convex_mesh),
    ConvexParts: ShapeType(physx.PhysxCollisionShapeConvexMesh, _convex_parts, many=True),
    Heightfield: ShapeType(physx.PhysxCollisionShapeTriangleMesh, _heightfield),
    TriangleMesh: ShapeType(physx.PhysxCollisionShapeTriangleMesh, _triangle_mesh),
}
"""Collision geometry."""


def _visual_plane(geometry: VisualPlane, look: ShapeContext) -> Callable[[int], Any]:
    half_size = select_rows(geometry.half_size, look.rows)
    # SAPIEN's own ground gives a plane the scale [10, y, z]; the first number has no visible effect.
    scale = np.insert(half_size, 0, 10.0, axis=1)
    return bind_columns(render.RenderShapePlane, [to_vectors(scale), look.materials()])


def _visual_mesh(geometry: Mesh, look: ShapeContext) -> Callable[[int], Any]:
    file = look.resources.visual_meshes(select_rows(geometry.file, look.rows))
    material: Column = [None] if look.material is None else look.material
    return bind_columns(
        render.RenderShapeTriangleMesh, [file, to_vectors(select_rows(geometry.scale, look.rows)), material]
    )


def _visual_tiled_plane(geometry: TiledPlane, look: ShapeContext) -> Callable[[int], Any]:
    vertices, uvs = tiled_plane_vertices(
        select_rows(geometry.half_size, look.rows), select_rows(geometry.texture_repeat, look.rows)
    )
    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
    normals = np.tile(np.array([0, 0, 1], dtype=np.float32), (4, 1))
    columns = [to_vectors(vertices), [triangles], [normals], to_vectors(uvs), look.materials()]
    return bind_columns(render.RenderShapeTriangleMesh, columns)


def tiled_plane_vertices(
    half_size: NDArray[np.float64], repeat: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Returns corners (B, 4, 3) and texture coordinates (·, 4, 2) of tiled planes, counterclockwise from -x, -y.

    Args:
        half_size: (B, 2) [m].
        repeat: (·, 2) number of texture repeats.
    """
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
    vertices = np.zeros((len(half_size), 4, 3))
    vertices[:, :, :2] = half_size[:, None] * corners
    return vertices, 0.5 + corners / 2 * repeat[:, None]


def _visual_surface(geometry: RevolvedSolid | Heightfield, look: ShapeContext) -> Callable[[int], Any]:
    surfaces = [geometry.surface(row) for row in _distinct_rows(geometry, look.rows)]
    columns: list[Column] = [list(column) for column in zip(*surfaces, strict=True)]
    return bind_columns(render.RenderShapeTriangleMesh, [*columns, look.materials()])


_SURFACE = ShapeType(render.RenderShapeTriangleMesh, _visual_surface)


VISUAL_SHAPES: dict[type[VisualGeometry], ShapeType] = {
    Box: _sized_shape(render.RenderShapeBox, "half_size"),
    Sphere: _sized_shape(render.RenderShapeSphere, "radius"),
    Capsule: _sized_shape(render.RenderShapeCapsule, "radius", "half_length"),
    Cylinder: _sized_shape(render.RenderShapeCylinder, "radius", "half_length"),
    **dict.fromkeys(REVOLVED_SOLIDS.values(), _SURFACE),
    Heightfield: _SURFACE,
    VisualPlane: ShapeType(render.RenderShapePlane, _visual_plane),
    Mesh: ShapeType(render.RenderShapeTriangleMesh, _visual_mesh),
    TiledPlane: ShapeType(render.RenderShapeTriangleMesh, _visual_tiled_plane),
}
"""Visual geometry."""

RENDER_SHAPES: dict[Any, ShapeType] = {
    shape.engine: visual
    for geometry, shape in COLLISION_SHAPES.items()
    for other, visual in VISUAL_SHAPES.items()
    if geometry is other and shape.sizes
}
"""SAPIEN's classes of collision shapes → visual shapes of the same form, for those defined by sizes."""


def front_face_column(geometry: VisualGeometry, given: str | None, rows: NDArray[np.intp]) -> Column | None:
    """Returns the visible side for each row; None if SAPIEN's default is right.

    A mirrored mesh is inside out. Its side is swapped, as in SAPIEN's `ActorBuilder`.
    """
    if given is not None:
        return [given]
    if not isinstance(geometry, Mesh):
        return None
    mirrored = _is_mirrored(geometry.scale, rows)
    return ["clockwise" if m else "counterclockwise" for m in mirrored] if any(mirrored) else None


def _is_mirrored(scale: Value, rows: NDArray[np.intp]) -> list[bool]:
    return (np.prod(select_rows(scale, rows), axis=1) < 0).tolist()
