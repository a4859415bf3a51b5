"""Visual geometry to SAPIEN's render shapes: one row a type."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.columns import Column, caller, scalars, taken, vectors
from scenecc.backends.sapien.engine import render
from scenecc.plan import Box, Capsule, Cylinder, Mesh, Sphere, TiledPlane, VisualPlane

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.backends.sapien.resources import Resources
    from scenecc.plan import Value, VisualGeometry


@dataclass(frozen=True, slots=True)
class Look:
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


def _box(geometry: Box, look: Look) -> Callable[[int], Any]:
    return caller(render.RenderShapeBox, [vectors(taken(geometry.half_size, look.rows)), look.or_fresh()])


def _sphere(geometry: Sphere, look: Look) -> Callable[[int], Any]:
    return caller(render.RenderShapeSphere, [scalars(taken(geometry.radius, look.rows)), look.or_fresh()])


def _capsule(geometry: Capsule, look: Look) -> Callable[[int], Any]:
    radius, half_length = taken(geometry.radius, look.rows), taken(geometry.half_length, look.rows)
    return caller(render.RenderShapeCapsule, [scalars(radius), scalars(half_length), look.or_fresh()])


def _cylinder(geometry: Cylinder, look: Look) -> Callable[[int], Any]:
    radius, half_length = taken(geometry.radius, look.rows), taken(geometry.half_length, look.rows)
    return caller(render.RenderShapeCylinder, [scalars(radius), scalars(half_length), look.or_fresh()])


def _plane(geometry: VisualPlane, look: Look) -> Callable[[int], Any]:
    half_size = taken(geometry.half_size, look.rows)
    # SAPIEN's own ground gives a plane the scale [10, y, z]; the first number shows nowhere.
    scale = np.insert(half_size, 0, 10.0, axis=1)
    return caller(render.RenderShapePlane, [vectors(scale), look.or_fresh()])


def _mesh(geometry: Mesh, look: Look) -> Callable[[int], Any]:
    file = look.resources.meshes(taken(geometry.file, look.rows), "SC807")
    material: Column = [None] if look.material is None else look.material
    return caller(render.RenderShapeTriangleMesh, [file, vectors(taken(geometry.scale, look.rows)), material])


def _tiled_plane(geometry: TiledPlane, look: Look) -> Callable[[int], Any]:
    half_size, repeat = taken(geometry.half_size, look.rows), taken(geometry.texture_repeat, look.rows)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
    vertices = np.zeros((len(half_size), 4, 3))
    vertices[:, :, :2] = half_size[:, None] * corners
    uvs = 0.5 + corners / 2 * repeat[:, None]
    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
    normals = np.tile(np.array([0, 0, 1], dtype=np.float32), (4, 1))
    columns = [vectors(vertices), [triangles], [normals], vectors(uvs), look.or_fresh()]
    return caller(render.RenderShapeTriangleMesh, columns)


VISUAL: dict[type[VisualGeometry], Callable[[Any, Look], Callable[[int], Any]]] = {
    Box: _box,
    Sphere: _sphere,
    Capsule: _capsule,
    Cylinder: _cylinder,
    VisualPlane: _plane,
    Mesh: _mesh,
    TiledPlane: _tiled_plane,
}
"""Geometry to a function from a row to a new render shape."""


def front_face(geometry: VisualGeometry, given: str | None, rows: NDArray[np.intp]) -> Column | None:
    """The side that is seen, a row; None where SAPIEN's own is right.

    A mirrored mesh is inside out, so SAPIEN's `ActorBuilder` turns it, and so does this.
    """
    if given is not None:
        return [given]
    if not isinstance(geometry, Mesh):
        return None
    mirrored = _mirrored(geometry.scale, rows)
    return ["clockwise" if m else "counterclockwise" for m in mirrored] if any(mirrored) else None


def _mirrored(scale: Value, rows: NDArray[np.intp]) -> list[bool]:
    return (np.prod(taken(scale, rows), axis=1) < 0).tolist()
