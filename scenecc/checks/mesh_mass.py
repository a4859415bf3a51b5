"""The least mass of bodies with meshes, which is known once their files are read."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Any

from scenecc.checks.mass import DYNAMIC_TYPES, MIN_MASS
from scenecc.checks.physics import named_bodies, structure_origin
from scenecc.checks.value_queries import Row, find_fault, highest, lowest, report_fault
from scenecc.plan import ConvexMesh, ConvexParts, literal
from scenecc.plan.geometry import Solid
from scenecc.plan.properties import DEFAULT_DENSITY

if TYPE_CHECKING:
    from scenecc.assets.files import AssetFiles
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import BodyStructure, CollisionShape, ScenePlan, Value

_HEAVY = 1e-2
"""Mass of the bounding boxes above which the volume of the hulls is not computed [kg]."""


def check_mesh_mass(plan: ScenePlan, files: AssetFiles, sink: Sink) -> None:
    """Checks that SAPIEN keeps the mass of bodies with convex meshes (SC511), as `check_density_mass` does for others.

    Args:
        plan: its `files` were checked.
        files: of the plan.
        sink: collects diagnostics.
    """
    for entity in plan.entities:
        for structure in entity.structures:
            for name, body, _ in named_bodies(structure, entity.name):
                if body.body_type in DYNAMIC_TYPES and body.inertial is None and _is_measurable(body):
                    origin = body.origin or structure_origin(structure, entity, plan)
                    _check_body(body, name, origin, plan, files, sink)


def _is_measurable(body: BodyStructure) -> bool:
    """Whether all shapes have a known volume, and some are meshes."""
    meshes = [shape.geometry for shape in body.collisions if isinstance(shape.geometry, ConvexMesh | ConvexParts)]
    others = [shape.geometry for shape in body.collisions if isinstance(shape.geometry, Solid)]
    known = all(mesh.file.is_constant and getattr(mesh, "coacd", None) is None for mesh in meshes)
    return bool(meshes) and known and len(meshes) + len(others) == len(body.collisions)


def _check_body(body: BodyStructure, name: str, origin: Origin, plan: ScenePlan, files: AssetFiles, sink: Sink) -> None:
    values: list[Value] = [shape.density or literal(DEFAULT_DENSITY) for shape in body.collisions]
    counts: list[int] = []
    for shape in body.collisions:
        geometry: Any = shape.geometry
        sizes: tuple[Value, ...] = geometry.values if isinstance(geometry, Solid) else (geometry.scale,)
        counts.append(len(sizes))
        values += sizes

    def weigh(row: tuple[Row, ...], *, hulls: bool) -> float:
        densities, sizes = row[: len(counts)], iter(row[len(counts) :])
        total = 0.0
        for shape, count, (density,) in zip(body.collisions, counts, densities, strict=True):
            numbers = list(chain.from_iterable(next(sizes) for _ in range(count)))
            total += density * _volume(shape, numbers, plan, files, hulls=hulls)
        return total

    def rule(*row: Row) -> float | None:
        if not any(chain.from_iterable(row[: len(counts)])) or weigh(row, hulls=False) > _HEAVY:
            return None
        weight = weigh(row, hulls=True)
        return weight if weight < MIN_MASS else None

    def corners() -> list[tuple[Row, ...]]:
        return [tuple(map(lowest, values)), tuple(map(highest, values))]

    fault = find_fault(values, rule, corners=corners)
    if fault is not None:
        message = f"`{name}` weighs {fault.found:.3g} kg by its densities, which SAPIEN would replace by a milligram"
        hint = "correct the scale (lengths are in metres) or the densities, or give `inertial`"
        report_fault(sink, "SC511", message, origin, hint, fault.sample, at="key")


def _volume(shape: CollisionShape, sizes: list[float], plan: ScenePlan, files: AssetFiles, *, hulls: bool) -> float:
    """Returns the volume of a shape [m³], of a mesh that of its hulls or of their bounding boxes."""
    geometry = shape.geometry
    if isinstance(geometry, Solid):
        return geometry.volume(*sizes)
    assert isinstance(geometry, ConvexMesh | ConvexParts)
    file = plan.files[int(geometry.file.numbers()[0])]
    volume = files.hull_volume(file, parts=isinstance(geometry, ConvexParts)) if hulls else files.box_volume(file)
    return volume * abs(sizes[0] * sizes[1] * sizes[2])
