"""Visible bodies of a live scene as boxes, for framing it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.engine import physx, render
from scenecc.plan.framing import Motion, Solids
from scenecc.plan.rendering import PLANE_HALF_SIZE

if TYPE_CHECKING:
    from numpy.typing import NDArray


_LEVEL = 0.999
"""Smallest vertical component of the unit normal of a floor."""


def read_solids(scene: Any) -> tuple[Solids, list[Any]]:
    """Returns boxes of all visible bodies in a `sapien.Scene`, and the entity of each body.

    A horizontal plane is a flat box. Render bodies must be up to date (`update_render`).
    """
    boxes: list[NDArray[np.float64]] = []
    bodies: list[int] = []
    entities: list[Any] = []
    for body in scene.render_system.render_bodies:
        found = _body_boxes(body)
        boxes += found
        bodies += [len(entities)] * len(found)
        entities.append(body.entity)
    motions = np.array([_motion(entity) for entity in entities], np.int64)
    return Solids(np.array(boxes).reshape(-1, 2, 3), np.array(bodies, np.int64), motions), entities


def _body_boxes(body: Any) -> list[NDArray[np.float64]]:
    """Returns the exact box of a box, a flat box for a level plane, and otherwise one around the whole body."""
    found: list[NDArray[np.float64]] = []
    others = False
    for shape in body.render_shapes:
        pose = body.entity.pose * shape.local_pose
        turn = np.asarray(pose.to_transformation_matrix(), np.float64)[:3, :3]
        if isinstance(shape, render.RenderShapePlane):
            if abs(turn[2, 0]) > _LEVEL:
                side = np.array([PLANE_HALF_SIZE, PLANE_HALF_SIZE, 0])
                found.append(np.stack([pose.p - side, pose.p + side]))
        elif isinstance(shape, render.RenderShapeBox):
            half = np.abs(turn) @ np.asarray(shape.half_size, np.float64)
            found.append(np.stack([pose.p - half, pose.p + half]))
        else:
            others = True
    if others:
        whole = np.asarray(body.compute_global_aabb_tight(), np.float64)
        found += [whole] if np.isfinite(whole).all() else []
    return found


def _motion(entity: Any) -> Motion:
    for component in entity.components:
        if isinstance(component, physx.PhysxArticulationLinkComponent):
            return Motion.DYNAMIC
        if isinstance(component, physx.PhysxRigidDynamicComponent):
            return Motion.KINEMATIC if component.kinematic else Motion.DYNAMIC
    return Motion.STATIC
