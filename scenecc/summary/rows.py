"""What is planned or was built of each entity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.plan.extent import extent
from scenecc.summary.fields import Fields, VaryingField, entity_fields

if TYPE_CHECKING:
    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import Entity, ScenePlan


@dataclass(frozen=True, slots=True)
class SummaryRow:
    """One entity.

    Attributes:
        body_type: of its structures, joined by `|` where they differ.
        shape_count: of the structure in its first scene, or of the largest where no engine was started: colliding
            shapes, or visible ones where those are more.
        mass: [kg] in its first scene, as the engine has it; None where the body has none or no engine was started.
        size: extents along its own axes [m] in its first scene; None where only an engine or a file could tell, and
            where no engine was started and scenes differ in it.
        scene_idxs: the scenes it is in.
        field_count: how many fields have a value; 0 where an engine was started.
        varying: those that differ between scenes; empty where an engine was started.
        masses: the least and the largest of its scenes [kg], where there is a mass.
        size_differs: whether scenes may differ in its size.
    """

    name: str
    body_type: str
    shape_count: int
    mass: float | None
    size: tuple[float, float, float] | None
    scene_idxs: tuple[int, ...]
    field_count: int = 0
    varying: tuple[VaryingField, ...] = ()
    masses: tuple[float, float] | None = None
    size_differs: bool = False


def summarize(plan: ScenePlan, batch: SceneBatch | None, scene_idxs: tuple[int, ...] | None = None) -> list[SummaryRow]:
    """A row an entity, in build order.

    Args:
        plan: the whole plan.
        batch: the live scenes; None after a dry run.
        scene_idxs: the scenes that were asked for; None: all of them.
    """
    asked = range(plan.num_scenes) if scene_idxs is None else set(scene_idxs)
    present = [(entity, tuple(index for index in entity.scene_idxs if index in asked)) for entity in plan.entities]
    if batch is None:
        return [_planned(entity, idxs, entity_fields(entity, plan)) for entity, idxs in present if idxs]
    return [_built(entity, idxs, batch, entity_fields(entity, plan)) for entity, idxs in present if idxs]


_SIZES = frozenset({"half_size", "radius", "half_length", "scale", "file", "p", "q"})
"""Fields of shapes by which the size of a body differs."""


def _planned(entity: Entity, scene_idxs: tuple[int, ...], fields: Fields) -> SummaryRow:
    differs = _size_differs(entity, fields)
    structures = entity.structures
    return SummaryRow(
        name=entity.name,
        body_type=_body_types(entity),
        shape_count=max(max(len(s.collisions), len(s.visuals)) for s in structures),
        mass=None,
        size=None if differs else extent(structures[0]),
        scene_idxs=scene_idxs,
        field_count=fields.count,
        varying=fields.varying,
        size_differs=differs,
    )


def _size_differs(entity: Entity, fields: Fields) -> bool:
    return entity.pick is not None or any(
        "[" in field.field and field.field.rsplit(".", 1)[-1] in _SIZES for field in fields.varying
    )


def _built(entity: Entity, scene_idxs: tuple[int, ...], batch: SceneBatch, fields: Fields) -> SummaryRow:
    row = entity.scene_idxs.index(scene_idxs[0])
    structure = entity.structure(row)
    objs = batch.entities[entity.name].objs
    body = _rigid_body(objs[0])
    # SAPIEN gives what has nothing to weigh a milligram.
    weighs = bool(structure.collisions) or structure.inertial is not None
    masses = [mass for obj in objs if (mass := getattr(_rigid_body(obj), "mass", None)) is not None] if weighs else []
    return SummaryRow(
        name=entity.name,
        body_type=_body_types(entity),
        shape_count=max(len(structure.collisions), len(structure.visuals)),
        mass=masses[0] if masses else None,
        size=extent(structure, row) or (None if body is None else _mesh_size(body)),
        scene_idxs=scene_idxs,
        masses=(min(masses), max(masses)) if masses else None,
        size_differs=_size_differs(entity, fields),
    )


def _body_types(entity: Entity) -> str:
    return "|".join(dict.fromkeys(structure.body_type for structure in entity.structures))


def _rigid_body(obj: Any) -> Any:
    """The physical component of an entity of the engine; None where it is only seen."""
    return next((component for component in obj.components if hasattr(component, "collision_shapes")), None)


def _mesh_size(body: Any) -> tuple[float, float, float] | None:
    """Extents of a body that collides by meshes alone: their corners are known once the engine has read them."""
    shapes = body.collision_shapes
    if not shapes or not all(hasattr(shape, "vertices") for shape in shapes):
        return None
    corners: list[Any] = []
    for shape in shapes:
        matrix = shape.local_pose.to_transformation_matrix()
        corners.append((shape.vertices * shape.scale) @ matrix[:3, :3].T + matrix[:3, 3])
    x, y, z = np.ptp(np.concatenate(corners), axis=0).tolist()
    return (x, y, z)
