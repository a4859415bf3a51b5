"""Geometry as written to the plan's: one row a type in each of two tables."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from scenecc import plan
from scenecc.lower.kinds import MIRROR_SCALE, SCALE, Kind, number, vector

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.lower.leaves import Leaves
    from scenecc.lower.tables import Tables
    from scenecc.plan import Value

Geometry = Callable[[Any, "Tables", "Leaves", "Origin"], Any]

_HALF_SIZE = vector(3, "half_size")
_HALF_SIZE_2 = vector(2, "VisualPlane.half_size")
_REPEAT = vector(2, "texture_repeat")
_RADIUS = number("radius")
_HALF_LENGTH = number("half_length")


def _size(shape: Any, name: str, kind: Kind, tables: Tables, leaves: Leaves, origin: Origin) -> Value:
    given = getattr(shape, name)
    # Equal sizes share one value.
    return tables.size(given) if given.__class__ in _PLAIN else leaves.value(given, kind, origin, name)


_PLAIN = frozenset((float, int, tuple))


def _box(shape: Any, tables: Tables, leaves: Leaves, origin: Origin) -> plan.Box:
    return plan.Box(_size(shape, "half_size", _HALF_SIZE, tables, leaves, origin))


def _sphere(shape: Any, tables: Tables, leaves: Leaves, origin: Origin) -> plan.Sphere:
    return plan.Sphere(_size(shape, "radius", _RADIUS, tables, leaves, origin))


def _capsule(shape: Any, tables: Tables, leaves: Leaves, origin: Origin) -> plan.Capsule:
    return plan.Capsule(*_round(shape, tables, leaves, origin))


def _cylinder(shape: Any, tables: Tables, leaves: Leaves, origin: Origin) -> plan.Cylinder:
    return plan.Cylinder(*_round(shape, tables, leaves, origin))


def _round(shape: Any, tables: Tables, leaves: Leaves, origin: Origin) -> tuple[Value, Value]:
    return (
        _size(shape, "radius", _RADIUS, tables, leaves, origin),
        _size(shape, "half_length", _HALF_LENGTH, tables, leaves, origin),
    )


def _plane(shape: Any, _tables: Tables, _leaves: Leaves, _origin: Origin) -> plan.Plane:
    return plan.Plane(shape.every_scene)


def _visual_plane(shape: Any, tables: Tables, leaves: Leaves, origin: Origin) -> plan.VisualPlane:
    return plan.VisualPlane(_size(shape, "half_size", _HALF_SIZE_2, tables, leaves, origin))


def _scale(shape: Any, kind: Kind, tables: Tables, leaves: Leaves, origin: Origin) -> Value:
    scale: Any = shape.scale
    if scale.__class__ not in _PLAIN:
        return leaves.value(scale, kind, origin, "scale")
    return tables.size(scale if scale.__class__ is tuple else (scale, scale, scale))


def _convex_mesh(shape: Any, tables: Tables, leaves: Leaves, origin: Origin) -> plan.ConvexMesh | None:
    file = tables.files_of(shape.file, origin.child("file"), leaves)
    return file and plan.ConvexMesh(file, _scale(shape, SCALE, tables, leaves, origin))


def _convex_parts(shape: Any, tables: Tables, leaves: Leaves, origin: Origin) -> plan.ConvexParts | None:
    file = tables.files_of(shape.file, origin.child("file"), leaves)
    if file is None:
        return None
    coacd = None
    if shape.decomposition == "coacd":
        given = shape.decomposition_params
        coacd = plan.CoacdParams(**given.model_dump()) if given else plan.CoacdParams()
    return plan.ConvexParts(file, _scale(shape, SCALE, tables, leaves, origin), coacd)


def _triangle_mesh(shape: Any, tables: Tables, leaves: Leaves, origin: Origin) -> plan.TriangleMesh | None:
    file = tables.files_of(shape.file, origin.child("file"), leaves)
    return file and plan.TriangleMesh(file, _scale(shape, SCALE, tables, leaves, origin), shape.sdf)


def _mesh(shape: Any, tables: Tables, leaves: Leaves, origin: Origin) -> plan.Mesh | None:
    file = tables.files_of(shape.file, origin.child("file"), leaves)
    return file and plan.Mesh(file, _scale(shape, MIRROR_SCALE, tables, leaves, origin))


def _tiled_plane(shape: Any, tables: Tables, leaves: Leaves, origin: Origin) -> plan.TiledPlane:
    return plan.TiledPlane(
        _size(shape, "half_size", _HALF_SIZE_2, tables, leaves, origin),
        _size(shape, "texture_repeat", _REPEAT, tables, leaves, origin),
    )


COLLIDING: dict[str, Geometry] = {
    "box": _box,
    "sphere": _sphere,
    "capsule": _capsule,
    "cylinder": _cylinder,
    "plane": _plane,
    "convex_mesh": _convex_mesh,
    "convex_parts": _convex_parts,
    "triangle_mesh": _triangle_mesh,
}
"""What collides of a type; None where a file was reported."""

SEEN: dict[str, Geometry] = {
    "box": _box,
    "sphere": _sphere,
    "capsule": _capsule,
    "cylinder": _cylinder,
    "plane": _visual_plane,
    "convex_mesh": _mesh,
    "convex_parts": _mesh,
    "triangle_mesh": _mesh,
    "mesh": _mesh,
    "tiled_plane": _tiled_plane,
}
"""What is seen of a type; likewise."""
