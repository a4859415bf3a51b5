"""Visible bodies of a live scene as boxes, for framing it."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.engine import physx, render
from scenecc.plan.framing import Motion, Solids
from scenecc.plan.rendering import PLANE_HALF_SIZE

if TYPE_CHECKING:
    from numpy.typing import NDArray


_DIRECTIONS = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
_CUBE, _BALL = _DIRECTIONS, 1.04 * _DIRECTIONS / np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)
"""(26, 3) points around a cube of half size 1 and a ball of radius 1. The ball's are as far out as its mean outline
requires: their hull is within 5 % of it.
"""

_LEVEL = 0.999
"""Smallest vertical component of the unit normal of a floor."""


def read_solids(scene: Any) -> tuple[Solids, list[Any]]:
    """Returns boxes of all visible bodies in a `sapien.Scene`, and the entity of each body.

    A horizontal plane is a flat box. Render bodies must be up to date (`update_render`).
    """
    boxes: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
    bodies: list[int] = []
    entities: list[Any] = []
    for body in scene.render_system.render_bodies:
        found = _body_boxes(body)
        boxes += found
        bodies += [len(entities)] * len(found)
        entities.append(body.entity)
    motions = np.array([_motion(entity) for entity in entities], np.int64)
    solids = Solids(
        np.array([box for box, _ in boxes]).reshape(-1, 2, 3),
        np.array(bodies, np.int64),
        motions,
        np.array([points for _, points in boxes]).reshape(-1, len(_BALL), 3),
    )
    return solids, entities


def _body_boxes(body: Any) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Returns boxes (2, 3) and outlines (26, 3): of each box and ball, a flat box for a level plane, and one around the
    rest of the body.
    """
    found: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
    others = False
    for shape in body.render_shapes:
        pose = body.entity.pose * shape.local_pose
        turn = np.asarray(pose.to_transformation_matrix(), np.float64)[:3, :3]
        if isinstance(shape, render.RenderShapePlane):
            if abs(turn[2, 0]) > _LEVEL:
                side = np.array([PLANE_HALF_SIZE, PLANE_HALF_SIZE, 0])
                found.append(_with_corners(np.stack([pose.p - side, pose.p + side])))
        elif isinstance(shape, render.RenderShapeBox):
            size = np.asarray(shape.half_size, np.float64)
            half = np.abs(turn) @ size
            found.append((np.stack([pose.p - half, pose.p + half]), pose.p + (_CUBE * size) @ turn.T))
        elif isinstance(shape, render.RenderShapeSphere):
            found.append((np.stack([pose.p - shape.radius, pose.p + shape.radius]), pose.p + _BALL * shape.radius))
        else:
            others = True
    if others:
        whole = np.asarray(body.compute_global_aabb_tight(), np.float64)
        found += [_with_corners(whole)] if np.isfinite(whole).all() else []
    return found


def _with_corners(box: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return box, box.mean(axis=0) + _CUBE * (box[1] - box[0]) / 2


def _motion(entity: Any) -> Motion:
    for component in entity.components:
        if isinstance(component, physx.PhysxArticulationLinkComponent):
            return Motion.DYNAMIC
        if isinstance(component, physx.PhysxRigidDynamicComponent):
            return Motion.KINEMATIC if component.kinematic else Motion.DYNAMIC
    return Motion.STATIC
