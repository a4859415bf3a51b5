"""Whether placements fit on their targets by their areas and sizes, before any pose is drawn (SC355)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.diagnostics.messages import cut
from scenecc.placing.bodies import Part, entity_parts, matrices
from scenecc.placing.regions import headings, rectangle_of
from scenecc.placing.surfaces import area_of, footprint, upward_surfaces
from scenecc.plan import BodyStructure
from scenecc.plan.geometry import Box, Capsule, Cylinder, Plane, Primitive, Sphere
from scenecc.variation.evaluation import Batch

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.geometry.rotation_arrays import Floats
    from scenecc.plan import Entity, Placement, ScenePlan

_KNOWN = (Box, Sphere, Capsule, Cylinder, Plane)


def warn_of_areas(
    placements: Iterable[Placement], upright: Container[str], entities: Mapping[str, Entity], sink: Sink
) -> None:
    """Warns if the footprints together exceed the surfaces of their target, or if a region is outside of the target.

    Args:
        placements: in order.
        upright: names of those that only rotate about z.
        entities: of the plan, by name.
        sink: receives the warnings.
    """
    taken: dict[str, float] = {}
    tops: dict[str, float | None] = {}
    for one in placements:
        name = one.target.entity
        if one.kind == "on" and name not in tops:
            tops[name] = _top_area(entities[name])
        if one.kind == "on" and one.target.link is None and tops[name] == 0 and one.origin is not None:
            message = f"`{cut(one.name)}` cannot fit: `{cut(name)}` has no level surface, to about a degree"
            hint = "place it on something level, or give it a `pose`"
            sink.report("SC355", message, one.origin.child("on"), hint=hint)
            continue
        if one.name in upright and _is_outside(one, entities) and one.origin is not None:
            key = "region" if one.at is None else "at"
            message = f"`{cut(one.name)}` cannot fit: its `{key}` is outside `{one.target}`"
            hint = "it is in the axes of the target, from its origin; `relative_to` names other axes"
            sink.report("SC355", message, one.origin.child(key), hint=hint)
            continue
        if one.kind != "on" or one.name not in upright or len(one.scene_idxs) < len(entities[name].scene_idxs):
            continue
        top, area = tops[name], sum(_footprint_area(entities[member]) for member in one.entities[:1])
        if top is None or one.origin is None:
            continue
        before = taken.get(name, 0.0)
        taken[name] = before + area
        if before <= top < taken[name]:
            what = "with the bodies placed there before, it has" if before else "it has"
            message = f"`{cut(one.name)}` cannot fit: {what} {taken[name]:.3g} m² of footprint, and "
            message += f"`{cut(name)}` has {top:.3g} m²"
            sink.report("SC355", message, one.origin.child("on"), hint="make the target larger, or place fewer")


def _parts(entity: Entity) -> list[Part] | None:
    """The parts of an entity if it does not vary and needs no file; otherwise None."""
    (structure, *others) = entity.structures
    if others or not isinstance(structure, BodyStructure):
        return None
    for shape in structure.collisions:
        values = shape.geometry.values if isinstance(shape.geometry, Primitive) else ()
        poses = () if shape.pose is None else (shape.pose,)
        if not isinstance(shape.geometry, _KNOWN) or not all(value.is_constant for value in (*values, *poses)):
            return None
    return entity_parts(entity, (), Batch(np.array(entity.scene_idxs[:1]), 0, 1, {}, {}))


def distance_beyond_target(one: Placement, plan: ScenePlan) -> str | None:
    """Message if the required distance from another object on the target exceeds the target's size; otherwise None.

    Args:
        one: a placement that failed.
        plan: its plan.
    """
    target = next(entity for entity in plan.entities if entity.name == one.target.entity)
    surfaces = _top_surfaces(target) if one.kind == "on" else None
    if not surfaces:
        return None
    across = float(np.hypot(*np.ptp(np.concatenate(surfaces), axis=0)))
    beside = {name for other in plan.placements if other.target == one.target for name in other.entities}
    distances = [("apart", one.apart), *(("near", each.least) for each in one.near if each.entity in beside)]
    key, distance = max(distances, key=lambda each: each[1])
    if distance <= across:
        return None
    return f"`{key}` asks for {distance:g} m, and the top of `{cut(target.name)}` is {across:.3g} m across"


def _top_area(entity: Entity) -> float | None:
    """Total area of the upward surfaces of an entity [m²]; None if unknown or infinite."""
    surfaces = _top_surfaces(entity)
    return None if surfaces is None else sum(map(area_of, surfaces))


def _top_surfaces(entity: Entity) -> list[Floats] | None:
    """The corners of the upward surfaces of an entity (·, 2); None if unknown or infinite."""
    parts = _parts(entity) if entity.pose.is_constant else None
    if not parts:
        return None
    pose = entity.pose.data
    surfaces = [one for part in parts for one in upward_surfaces(part.moved(matrices(pose[:, 3:]), pose[:, :3]))]
    corners = [one.corners[0] for one in surfaces if one.corners is not None]
    return corners if len(corners) == len(surfaces) else None


def _is_outside(one: Placement, entities: Mapping[str, Entity]) -> bool:
    """Whether no surface of the target is close enough to the region to support the object fully."""
    target = entities[one.target.entity]
    where = [value for value in (one.at, one.low, one.high, one.center, one.radius) if value is not None]
    known = target.pose.is_constant and all(value.is_constant for value in where) and len(one.entities) == 1
    if not known or not where or one.target.link is not None or not (one.frame is None or one.frame.is_constant):
        return False
    parts, own = _parts(target), _parts(entities[one.entities[0]])
    if not parts or not own:
        return False
    pose = target.pose.data
    parts = [part.moved(matrices(pose[:, 3:]), pose[:, :3]) for part in parts]
    if any(part.is_plane for part in parts):
        return False
    surfaces = [surface for part in parts for surface in upward_surfaces(part)]
    polygons = [(footprint(parts, 0)[None], surfaces[0].there)] if one.kind != "on" and surfaces else []
    polygons = polygons or [(surface.corners, surface.there) for surface in surfaces]
    axes = pose if one.frame is None else one.frame.data
    top = rectangle_of(polygons, axes[:, :3], headings(axes[:, 3:]))[0]
    ends = [value.data[0, :2] for value in where if value.data.ndim == 2]
    gap = np.maximum(np.maximum(np.min(ends, axis=0) - top[2:], top[:2] - np.max(ends, axis=0)), 0.0)
    reach = np.hypot(*footprint(own, 0).T).max() + (0.0 if one.radius is None else float(one.radius.data[0]))
    return bool(np.hypot(*gap) > reach)


def _footprint_area(entity: Entity) -> float:
    """A lower bound of the footprint's area [m²]; 0 if unknown."""
    parts = _parts(entity)
    # Polygons around round shapes are larger by less than this.
    return area_of(footprint(parts, 0)) / 1.001 if parts else 0.0
