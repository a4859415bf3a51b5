"""The mass that a body must have: from the plan where it gives one, from density times volume where not."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.audit.difference import CODE
from scenecc.backends.sapien.columns import taken
from scenecc.plan import Box, Capsule, ConvexMesh, ConvexParts, Cylinder, Plane, Sphere, TriangleMesh
from scenecc.plan.properties import FLOAT32_MAX

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.backends.sapien.audit.meshes import Meshes
    from scenecc.plan import BodyStructure, CollisionGeometry, CollisionShape, Value

FLOOR = 1e-6
"""Mass [kg] and moments [kg·m²] that SAPIEN gives where the shapes' are less."""

LOST = "SC512"
"""The code of a mass, or of a centre of mass, that single precision does not hold."""

DENSITY = 1000.0
"""SAPIEN's [kg/m³]."""

CYLINDER = 32 / (2 * math.pi) * math.sin(2 * math.pi / 32)
"""Area of the 32-sided prism that PhysX has for a cylinder, by that of the circle around it."""

RELATIVE_TOLERANCE = 1e-4
"""Between an engine that adds in float32 and this."""


def stored(value: NDArray[np.float64]) -> NDArray[np.float32]:
    """What PhysX gives back of a mass or a moment of inertia: it keeps the inverse, in float32."""
    with np.errstate(divide="ignore", over="ignore"):
        return np.float32(1) / (np.float32(1) / value.astype(np.float32))


def expected_mass(structure: BodyStructure, rows: NDArray[np.intp], meshes: Meshes) -> tuple[NDArray[Any], bool]:
    """The mass [kg] a row, or one for all rows, and whether it must be met to the bit."""
    given = structure.inertial.mass if structure.inertial is not None else structure.mass
    if given is not None:
        return stored(taken(given, rows)), True
    return shapes_mass(structure, rows, meshes), False


def shapes_mass(structure: BodyStructure, rows: NDArray[np.intp], meshes: Meshes) -> NDArray[np.float64]:
    """What the shapes weigh [kg] a row, or in all rows, by their densities and volumes."""
    total = np.zeros(1)
    for shape in structure.collisions:
        if isinstance(shape.geometry, Plane):
            break  # SAPIEN weighs a body anew with each shape; PhysX cannot, once one of them is endless
        total = total + _density(shape, rows) * volume(shape.geometry, rows, meshes)
    if structure.body_type == "kinematic":
        # It is moved by nobody's force, so that nobody minds the milligram.
        return np.maximum(total, FLOOR)
    return np.where(total == 0, FLOOR, total)


def misses(found: NDArray[Any], expected: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether masses are not those that the shapes give; so is what is no number."""
    return ~(np.abs(found - expected) <= RELATIVE_TOLERANCE * expected)


def fault(expected: float) -> str:
    """The code of a mass that differs: what a mesh weighs is known only now, of all else a check has told it."""
    return "SC511" if expected < FLOOR else CODE if expected <= FLOAT32_MAX else LOST


def _density(shape: CollisionShape, rows: NDArray[np.intp]) -> NDArray[np.float64]:
    if shape.density is None:
        return np.array([0.0 if isinstance(shape.geometry, Plane) else DENSITY])
    return taken(shape.density, rows)


def volume(geometry: CollisionGeometry, rows: NDArray[np.intp], meshes: Meshes) -> NDArray[np.float64]:
    """[m³] a row, or one for all rows."""
    return VOLUME[type(geometry)](geometry, rows, meshes)


def _box(geometry: Box, rows: NDArray[np.intp], meshes: Meshes) -> NDArray[np.float64]:
    del meshes
    return 8 * np.prod(taken(geometry.half_size, rows), axis=1)


def _sphere(geometry: Sphere, rows: NDArray[np.intp], meshes: Meshes) -> NDArray[np.float64]:
    del meshes
    return 4 / 3 * math.pi * taken(geometry.radius, rows) ** 3


def _prism(geometry: Capsule | Cylinder, rows: NDArray[np.intp]) -> NDArray[np.float64]:
    return 2 * math.pi * taken(geometry.radius, rows) ** 2 * taken(geometry.half_length, rows)


def _capsule(geometry: Capsule, rows: NDArray[np.intp], meshes: Meshes) -> NDArray[np.float64]:
    del meshes
    return _prism(geometry, rows) + 4 / 3 * math.pi * taken(geometry.radius, rows) ** 3


def _cylinder(geometry: Cylinder, rows: NDArray[np.intp], meshes: Meshes) -> NDArray[np.float64]:
    del meshes
    return CYLINDER * _prism(geometry, rows)


def _plane(geometry: Plane, rows: NDArray[np.intp], meshes: Meshes) -> NDArray[np.float64]:
    del geometry, rows, meshes
    return np.zeros(1)


def _scaled(file: Value, scale: Value, rows: NDArray[np.intp], unscaled: Callable[[int], float]) -> NDArray[np.float64]:
    of_file = {index: unscaled(index) for index in np.unique(taken(file, rows)).tolist()}
    units = np.array([of_file[index] for index in taken(file, rows).tolist()])
    return units * np.abs(np.prod(taken(scale, rows), axis=1))


def _convex_mesh(geometry: ConvexMesh, rows: NDArray[np.intp], meshes: Meshes) -> NDArray[np.float64]:
    return _scaled(geometry.file, geometry.scale, rows, meshes.hull_volume)


def _convex_parts(geometry: ConvexParts, rows: NDArray[np.intp], meshes: Meshes) -> NDArray[np.float64]:
    return _scaled(geometry.file, geometry.scale, rows, lambda file: meshes.parts_volume(file, geometry.coacd))


def _triangle_mesh(geometry: TriangleMesh, rows: NDArray[np.intp], meshes: Meshes) -> NDArray[np.float64]:
    if not geometry.sdf:
        return np.zeros(1)
    return _scaled(geometry.file, geometry.scale, rows, meshes.triangle_volume)


VOLUME: dict[type[CollisionGeometry], Callable[[Any, NDArray[np.intp], Meshes], NDArray[np.float64]]] = {
    Box: _box,
    Sphere: _sphere,
    Capsule: _capsule,
    Cylinder: _cylinder,
    Plane: _plane,
    ConvexMesh: _convex_mesh,
    ConvexParts: _convex_parts,
    TriangleMesh: _triangle_mesh,
}
"""Geometry to its volume; PhysX counts none for a plane and for a triangle mesh without a distance field."""
