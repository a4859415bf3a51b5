"""Planes where environments share one simulation: endless there too, so that one is enough for all.

PhysX keeps what belongs to different environments apart by their distance alone, and a plane has none. ManiSkill's own
builder leaves out every copy but the first.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from scenecc.backends.maniskill.failure import UNFIT
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.plan import BodyStructure, Entity, Plane, Value

if TYPE_CHECKING:
    from scenecc.plan import CollisionShape, ScenePlan

_HINT = "environments share one simulation on the GPU: put a box there, or the same plane in all of them"


def planes_once(plan: ScenePlan) -> ScenePlan:
    """The plan with each plane in the first scene alone, but for those that are asked for in every scene.

    Raises:
        EngineFailure: a plane is not the same in all scenes.
    """
    if plan.num_scenes == 1 or not any(map(_has_plane, plan.entities)):
        return plan
    entities = [_once(entity, plan.num_scenes) if _has_plane(entity) else entity for entity in plan.entities]
    return replace(plan, entities=tuple(entities))


def without_planes(structure: BodyStructure) -> BodyStructure:
    """The structure without those planes that are built once."""
    return replace(structure, collisions=tuple(shape for shape in structure.collisions if not _is_shared(shape)))


def _has_plane(entity: Entity) -> bool:
    return any(map(_is_shared, (shape for body in entity.bodies for shape in body.collisions)))


def _is_shared(shape: CollisionShape) -> bool:
    return isinstance(shape.geometry, Plane) and not shape.geometry.every_scene


def _once(entity: Entity, num_scenes: int) -> Entity:
    if len(entity.scene_idxs) < num_scenes:
        message = f"the plane of '{entity.name}' would be in every environment, and is asked for in some"
        raise EngineFailure(UNFIT, message, origin=entity.origin, hint=_HINT)
    whole = entity.structures[0]
    if len(entity.structures) > 1 or not isinstance(whole, BodyStructure) or _varies(entity, whole):
        message = f"the plane of '{entity.name}' differs between environments"
        raise EngineFailure(UNFIT, message, origin=entity.origin, hint=_HINT)
    pick = np.ones(num_scenes, dtype=np.int64)
    pick[0] = 0
    return replace(entity, structures=(whole, without_planes(whole)), pick=Value(pick))


def _varies(entity: Entity, structure: BodyStructure) -> bool:
    planes = filter(_is_shared, structure.collisions)
    values = [entity.pose, *(value for shape in planes for value in (shape.pose, shape.material))]
    return any(value is not None and value.varies for value in values)
