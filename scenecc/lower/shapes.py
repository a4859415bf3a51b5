"""Shapes as written to shapes of the plan: one row a type in each of two tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc import plan
from scenecc.lower.materials import PLAIN, Materials, Surface, colored
from scenecc.lower.poses import IDENTITY_POSE, Pose7, direction, lower_local_pose, turned
from scenecc.lower.rotations import IDENTITY, Quat, shortest_from_x
from scenecc.plan import CollisionShape, Value, VisualShape, constant
from scenecc.spec import shape_keys as keys
from scenecc.spec import shapes as spec

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.tables import Tables

AXIS_TURNS: dict[str, Quat] = {
    "x": IDENTITY,
    "y": shortest_from_x((0.0, 1.0, 0.0)),
    "z": shortest_from_x((0.0, 0.0, 1.0)),
}

COLLISION_NUMBERS = ("contact_offset", "rest_offset", "patch_radius", "min_patch_radius")


@dataclass(frozen=True, slots=True)
class BodyDefaults:
    """What a body says for the shapes that say nothing."""

    surface: Surface | None
    color: Any
    density: float | None


class Shapes:
    """Lowers the shapes of a document."""

    def __init__(self, tables: Tables, materials: Materials, sink: Sink) -> None:
        self._tables = tables
        self._materials = materials
        self._sink = sink

    def collision(self, shape: Any, body: BodyDefaults, origin: Origin) -> CollisionShape | None:
        """The colliding side of a shape from `shapes` or `collisions`; None where it was reported."""
        geometry = _COLLISION_GEOMETRY[shape.type](shape, self._tables, origin)
        if isinstance(shape, keys.ConvexPartsKeys) and shape.decomposition == "none" and shape.decomposition_params:
            self._sink.report(
                "SC115",
                "`decomposition_params` does nothing without a decomposition",
                origin.child("decomposition_params"),
                at="key",
                hint="set decomposition: coacd, or leave it out",
            )
        if geometry is None:
            return None
        surface = self._surface(shape, body, origin)
        density = shape.density
        if density is None:
            density = surface.density if surface.density is not None else body.density
        return CollisionShape(
            geometry,
            self._pose(shape, origin),
            surface.physical,
            None if density is None else constant(density),
            *(None if (n := getattr(shape, name)) is None else constant(n) for name in COLLISION_NUMBERS),
            origin,
        )

    def visual(self, shape: Any, body: BodyDefaults, origin: Origin) -> VisualShape | None:
        """The visible side of a shape from `shapes` or `visuals`; None where it was reported."""
        geometry = _VISUAL_GEOMETRY[shape.type](shape, self._tables, origin)
        if geometry is None:
            return None
        visual = self._surface(shape, body, origin).visual
        color = shape.color
        if color is None and not (shape.material is not None and visual is not None and visual.base_color):
            # A material that the shape itself names is closer to it than the body's colour.
            color = body.color
        visual = colored(visual, color)
        return VisualShape(
            geometry,
            self._pose(shape, origin),
            None if visual is None else self._tables.visual_materials.value(visual),
            shape.name,
            shape.front_face,
            origin,
        )

    def _surface(self, shape: keys.ShapeKeys, body: BodyDefaults, origin: Origin) -> Surface:
        if shape.material is None:
            return body.surface or PLAIN
        return self._materials.surface(shape.material, origin.child("material")) or PLAIN

    def _pose(self, shape: Any, origin: Origin) -> Value | None:
        pose = lower_local_pose(shape.pose, origin.child("pose"), "a shape", self._sink)
        pose = self._turned(shape, pose, origin)
        return None if pose == IDENTITY_POSE else constant(pose)

    def _turned(self, shape: Any, pose: Pose7, origin: Origin) -> Pose7:
        """With `axis`, or `normal` and `offset`, put before the pose."""
        if isinstance(shape, keys.CapsuleKeys | keys.CylinderKeys):
            return turned(pose, AXIS_TURNS[shape.axis])
        if isinstance(shape, keys.PlaneKeys):
            normal = direction(shape.normal)
            if not any(normal):
                self._sink.report("SC114", "a normal of length 0 has no direction", origin.child("normal"))
                return pose
            return turned(pose, shortest_from_x(normal), shape.offset)
        return pose


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
    return None if index is None else constant(index, int)


def _scale(shape: Any, tables: Tables) -> Value:
    scale = shape.scale
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
        coacd = plan.CoacdParams(**(shape.decomposition_params.model_dump() if shape.decomposition_params else {}))
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
