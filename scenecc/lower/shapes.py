"""Shapes as written to shapes of the plan: one row a type in each of two tables."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from scenecc import plan
from scenecc.lower.materials import PLAIN, Materials, Surface, colored
from scenecc.lower.poses import IDENTITY_POSE, Pose7, direction, lower_local_pose, turned
from scenecc.lower.rotations import IDENTITY, Quat, shortest_from_x
from scenecc.plan import CollisionShape, Value, VisualShape, literal

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.tables import Tables
    from scenecc.spec import shape_keys as keys
    from scenecc.spec import shapes as spec
    from scenecc.spec.body import Body

AXIS_TURNS: dict[str, Quat] = {
    "x": IDENTITY,
    "y": shortest_from_x((0.0, 1.0, 0.0)),
    "z": shortest_from_x((0.0, 0.0, 1.0)),
}


class Shapes:
    """Lowers the shapes of a document."""

    def __init__(self, tables: Tables, materials: Materials, sink: Sink) -> None:
        self._tables = tables
        self._materials = materials
        self._sink = sink

    def both(
        self, shape: Any, body: Body, default: Surface, origin: Origin
    ) -> tuple[CollisionShape | None, VisualShape | None]:
        """The two sides of a shape from `shapes`; None where one was reported.

        Args:
            shape: as written.
            body: that has the shape.
            default: of the shapes that name no material.
            origin: of the shape.
        """
        type_ = shape.type
        make = _VISUAL_GEOMETRY[type_]
        collides = self._geometry(shape, origin)
        seen = collides if make is _COLLISION_GEOMETRY[type_] else make(shape, self._tables, origin)
        surface, pose = self._surface(shape, default, origin), self._pose(shape, origin)
        return (
            collides and self._colliding(collides, shape, body, surface, pose, origin),
            seen and self._seen(seen, shape, body, surface, pose, origin),
        )

    def collision(self, shape: Any, body: Body, default: Surface, origin: Origin) -> CollisionShape | None:
        """A shape from `collisions`; otherwise as `both`."""
        geometry = self._geometry(shape, origin)
        surface, pose = self._surface(shape, default, origin), self._pose(shape, origin)
        return geometry and self._colliding(geometry, shape, body, surface, pose, origin)

    def visual(self, shape: Any, body: Body, default: Surface, origin: Origin) -> VisualShape | None:
        """A shape from `visuals`; otherwise as `both`."""
        geometry = _VISUAL_GEOMETRY[shape.type](shape, self._tables, origin)
        surface, pose = self._surface(shape, default, origin), self._pose(shape, origin)
        return geometry and self._seen(geometry, shape, body, surface, pose, origin)

    def _colliding(
        self, geometry: Any, shape: Any, body: Body, surface: Surface, pose: Value | None, origin: Origin
    ) -> CollisionShape:
        density = shape.density
        if density is None:
            density = surface.density if surface.density is not None else body.density
        return CollisionShape(
            geometry,
            pose,
            surface.physical,
            None if density is None else literal(density),
            None if shape.contact_offset is None else literal(shape.contact_offset),
            None if shape.rest_offset is None else literal(shape.rest_offset),
            None if shape.patch_radius is None else literal(shape.patch_radius),
            None if shape.min_patch_radius is None else literal(shape.min_patch_radius),
            origin,
        )

    def _seen(
        self, geometry: Any, shape: Any, body: Body, surface: Surface, pose: Value | None, origin: Origin
    ) -> VisualShape:
        visual = surface.visual
        color = shape.color
        if color is None and not (shape.material is not None and visual is not None and visual.base_color):
            # A material that the shape itself names is closer to it than the body's colour.
            color = body.color
        visual = colored(visual, color)
        material = None if visual is None else self._tables.visual_materials.value(visual)
        return VisualShape(geometry, pose, material, shape.name, shape.front_face, origin)

    def _geometry(self, shape: Any, origin: Origin) -> Any:
        """What collides; None where it was reported."""
        if shape.type == "convex_parts" and shape.decomposition == "none" and shape.decomposition_params:
            self._sink.report(
                "SC115",
                "`decomposition_params` does nothing without a decomposition",
                origin.child("decomposition_params"),
                at="key",
                hint="set decomposition: coacd, or leave it out",
            )
        return _COLLISION_GEOMETRY[shape.type](shape, self._tables, origin)

    def _surface(self, shape: keys.ShapeKeys, default: Surface, origin: Origin) -> Surface:
        if shape.material is None:
            return default
        return self._materials.surface(shape.material, origin) or PLAIN

    def _pose(self, shape: Any, origin: Origin) -> Value | None:
        turn = _TURNS.get(shape.type)
        if shape.pose is None and turn is None:
            return None
        pose = lower_local_pose(shape.pose, origin, ("pose",), "a shape", self._sink)
        if turn is not None:
            pose = turn(shape, pose, origin, self._sink)
        return None if pose == IDENTITY_POSE else literal(pose)


def _axis_first(shape: keys.CapsuleKeys | keys.CylinderKeys, pose: Pose7, _origin: Origin, _sink: Sink) -> Pose7:
    return turned(pose, AXIS_TURNS[shape.axis])


def _normal_first(shape: keys.PlaneKeys, pose: Pose7, origin: Origin, sink: Sink) -> Pose7:
    normal = direction(shape.normal)
    if not any(normal):
        sink.report("SC114", "a normal of length 0 has no direction", origin.child("normal"))
        return pose
    # Along the normal itself: turned from x, a step along z would be off by the rotation's rounding.
    length = math.hypot(*normal)
    x, y, z = normal
    step = (x / length * shape.offset, y / length * shape.offset, z / length * shape.offset)
    return turned(pose, shortest_from_x(normal), step)


Turn = Callable[[Any, Pose7, "Origin", "Sink"], Pose7]

_TURNS: dict[str, Turn] = {
    "capsule": _axis_first,
    "cylinder": _axis_first,
    "plane": _normal_first,
}
"""What `axis`, or `normal` and `offset`, put before the pose."""

Geometry = Callable[[Any, "Tables", "Origin"], Any]


def _box(shape: keys.BoxKeys, tables: Tables, _origin: Origin) -> plan.Box:
    return plan.Box(tables.size(shape.half_size))


def _sphere(shape: keys.SphereKeys, tables: Tables, _origin: Origin) -> plan.Sphere:
    return plan.Sphere(tables.size(shape.radius))


def _capsule(shape: keys.CapsuleKeys, tables: Tables, _origin: Origin) -> plan.Capsule:
    return plan.Capsule(tables.size(shape.radius), tables.size(shape.half_length))


def _cylinder(shape: keys.CylinderKeys, tables: Tables, _origin: Origin) -> plan.Cylinder:
    return plan.Cylinder(tables.size(shape.radius), tables.size(shape.half_length))


def _plane(shape: spec.PlaneShape | spec.PlaneCollision, _tables: Tables, _origin: Origin) -> plan.Plane:
    return plan.Plane(shape.every_scene)


def _visual_plane(shape: spec.PlaneShape | spec.PlaneVisual, tables: Tables, _origin: Origin) -> plan.VisualPlane:
    return plan.VisualPlane(tables.size(shape.half_size))


def _file(shape: keys.FileKeys, tables: Tables, origin: Origin) -> Value | None:
    index = tables.file(shape.file, origin.child("file"))
    return None if index is None else literal(index, "int64")


def _scale(shape: Any, tables: Tables) -> Value:
    scale: float | tuple[float, float, float] = shape.scale
    return tables.size(scale if isinstance(scale, tuple) else (scale, scale, scale))


def _convex_mesh(shape: Any, tables: Tables, origin: Origin) -> plan.ConvexMesh | None:
    file = _file(shape, tables, origin)
    return file and plan.ConvexMesh(file, _scale(shape, tables))


def _convex_parts(shape: Any, tables: Tables, origin: Origin) -> plan.ConvexParts | None:
    file = _file(shape, tables, origin)
    if file is None:
        return None
    coacd = None
    if shape.decomposition == "coacd":
        given: keys.CoacdKeys | None = shape.decomposition_params
        coacd = plan.CoacdParams(**given.model_dump()) if given else plan.CoacdParams()
    return plan.ConvexParts(file, _scale(shape, tables), coacd)


def _triangle_mesh(shape: Any, tables: Tables, origin: Origin) -> plan.TriangleMesh | None:
    file = _file(shape, tables, origin)
    return file and plan.TriangleMesh(file, _scale(shape, tables), shape.sdf)


def _mesh(shape: Any, tables: Tables, origin: Origin) -> plan.Mesh | None:
    file = _file(shape, tables, origin)
    return file and plan.Mesh(file, _scale(shape, tables))


def _tiled_plane(shape: spec.TiledPlaneVisual, tables: Tables, _origin: Origin) -> plan.TiledPlane:
    return plan.TiledPlane(tables.size(shape.half_size), tables.size(shape.texture_repeat))


_COLLISION_GEOMETRY: dict[str, Geometry] = {
    "box": _box,
    "sphere": _sphere,
    "capsule": _capsule,
    "cylinder": _cylinder,
    "plane": _plane,
    "convex_mesh": _convex_mesh,
    "convex_parts": _convex_parts,
    "triangle_mesh": _triangle_mesh,
}
_VISUAL_GEOMETRY: dict[str, Geometry] = {
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
