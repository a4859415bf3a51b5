"""Colliding shapes against the plan, every property of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.audit.defaults import Defaults, frictions
from scenecc.backends.sapien.audit.geometry import COLLISION_SIZES
from scenecc.backends.sapien.columns import plain_row
from scenecc.backends.sapien.knobs import GROUPS, SHAPE_KNOBS
from scenecc.backends.sapien.mirrored import signs_of
from scenecc.plan import ConvexMesh, ConvexParts, MeshGeometry, Plane, TriangleMesh

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.backends.sapien.audit.meshes import Meshes
    from scenecc.backends.sapien.audit.sweep import Expected, Place, Sweep
    from scenecc.plan import BodyStructure, CollisionShape, ScenePlan, Value


def part_counts(structure: BodyStructure, row: int, meshes: Meshes) -> list[int]:
    """How many shapes of the engine each shape of the plan is, in an entity's row."""
    return [
        len(meshes.parts(int(shape.geometry.file.row(row)), shape.geometry.coacd))
        if isinstance(shape.geometry, ConvexParts)
        else 1
        for shape in structure.collisions
    ]


class ShapeAudit:
    """Reads the colliding shapes of bodies."""

    def __init__(self, plan: ScenePlan, defaults: Defaults, meshes: Meshes, sweep: Sweep) -> None:
        self._defaults = defaults
        self._meshes = meshes
        self._sweep = sweep
        self._materials = plan.physical_materials
        self._frictions: dict[int, Expected] = {}

    def look_at(self, structure: BodyStructure, body: Any, row: int, place: Place) -> None:
        """All shapes of a body."""
        found, counts = body.collision_shapes, part_counts(structure, row, self._meshes)
        if len(found) != sum(counts):
            self._sweep.tell(place, "collision_shapes", sum(counts), len(found))
            return
        start = 0
        for shape, count in zip(structure.collisions, counts, strict=True):
            where = place._replace(origin=shape.origin)
            self._shape(structure, shape, found[start : start + count], row, where)
            start += count

    def _shape(
        self, structure: BodyStructure, shape: CollisionShape, parts: Sequence[Any], row: int, place: Place
    ) -> None:
        kind, sizes = COLLISION_SIZES[type(shape.geometry)]
        own = self._own(structure, shape, row)
        no_density = shape.density is None and isinstance(shape.geometry, Plane)
        defaults = self._defaults.plane if no_density else self._defaults.shape
        material = shape.material
        friction = self._defaults.friction if material is None else self._friction(int(material.row(row)), row)
        for number, part in enumerate(parts):
            if type(part) is not kind:
                self._sweep.tell(place, "type", kind.__name__, type(part).__name__)
                continue
            for name, size in sizes(shape.geometry, row).items():
                self._sweep.hold(name, size, part, place)
            if isinstance(shape.geometry, MeshGeometry):
                self._mesh(shape.geometry, part, number, row, place)
            look_at_pose(shape.pose, part, row, place, self._sweep, self._defaults)
            self._sweep.expect_but(defaults, own, part, place)
            self._sweep.expect(friction, part.physical_material, place)

    def _friction(self, index: int, row: int) -> Expected:
        known = self._frictions.get(index)
        if known is None:
            material = self._materials[index]
            known = frictions(material.row(row))
            if not any(value.varies for value in material.values()):
                self._frictions[index] = known
        return known

    def _own(self, structure: BodyStructure, shape: CollisionShape, row: int) -> Expected:
        said = {knob.get: plain_row(value, row) for knob, value in SHAPE_KNOBS.said(shape)}
        if structure.collision_groups is not None:
            said[GROUPS.get] = structure.collision_groups.row(row).tolist()
        return said

    def _mesh(
        self, geometry: ConvexMesh | ConvexParts | TriangleMesh, part: Any, number: int, row: int, place: Place
    ) -> None:
        match geometry:
            case ConvexMesh(file=file, scale=scale):
                reference = self._meshes.hull(int(file.row(row)), signs_of(scale, row))
            case ConvexParts(file=file, scale=scale, coacd=coacd):
                reference = self._meshes.parts(int(file.row(row)), coacd, signs_of(scale, row))[number]
            case TriangleMesh(file=file, sdf=sdf):
                reference = self._meshes.triangles(int(file.row(row)), sdf=sdf)
        for name in ("vertices", "triangles"):
            if not np.array_equal(getattr(reference, name), getattr(part, name)):
                self._sweep.tell(place, name, "those of the file", "others")


def look_at_pose(pose: Value | None, part: Any, row: int, place: Place, sweep: Sweep, defaults: Defaults) -> None:
    """The pose of a shape, colliding or seen, in its body."""
    if pose is None:
        sweep.expect(defaults.pose, part, place)
    else:
        sweep.hold("local_pose", pose.row(row), part, place)
