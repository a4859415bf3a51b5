"""What was built of each entity, in numbers that a person checks at a glance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.plan.extent import extent

if TYPE_CHECKING:
    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import Entity, ScenePlan


@dataclass(frozen=True, slots=True)
class SummaryRow:
    """One entity.

    Attributes:
        body_type: of its structures, joined by `|` where they differ.
        shape_count: of the structure in its first scene: colliding shapes, or visible ones where those are more.
        mass: [kg] in its first scene, as the engine has it; None where the body has none or no engine was started.
        size: extents along its own axes [m] in its first scene; None where only an engine or a file could tell.
        scene_idxs: the scenes it is in.
    """

    name: str
    body_type: str
    shape_count: int
    mass: float | None
    size: tuple[float, float, float] | None
    scene_idxs: tuple[int, ...]


def summarize(plan: ScenePlan, batch: SceneBatch | None, scene_idxs: tuple[int, ...] | None = None) -> list[SummaryRow]:
    """A row an entity, in build order.

    Args:
        plan: the whole plan.
        batch: the live scenes; None after a dry run.
        scene_idxs: the scenes that were asked for; None: all of them.
    """
    asked = range(plan.num_scenes) if scene_idxs is None else set(scene_idxs)
    present = [(entity, tuple(index for index in entity.scene_idxs if index in asked)) for entity in plan.entities]
    return [_row(entity, idxs, batch) for entity, idxs in present if idxs]


def _row(entity: Entity, scene_idxs: tuple[int, ...], batch: SceneBatch | None) -> SummaryRow:
    row = entity.scene_idxs.index(scene_idxs[0])
    structure = entity.structure(row)
    body = None if batch is None else _rigid_body(batch.entities[entity.name].objs[0])
    return SummaryRow(
        name=entity.name,
        body_type="|".join(dict.fromkeys(s.body_type for s in entity.structures)),
        shape_count=max(len(structure.collisions), len(structure.visuals)),
        mass=getattr(body, "mass", None),
        size=extent(structure, row) or (None if body is None else _mesh_size(body)),
        scene_idxs=scene_idxs,
    )


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
