"""Bounds that prove without contacts that no two bodies of a scene are deep in each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch

    Floats = NDArray[np.float64]

_PAIRS: Final = 4_000_000
"""Of boxes that are compared in one scene, at most: beyond, to read the contacts is no slower."""

_ENDLESS: Final = 1e6
"""[m] What is larger is a plane, whose bounding box says nothing."""


def scenes_in_doubt(batch: SceneBatch, depth: float) -> list[int]:
    """The scenes of which the bounding boxes do not prove that no two bodies penetrate each other by more than `depth`.

    What is moved apart along an axis until the boxes no longer overlap along it is free of each other: two bodies are
    not deeper in each other than the boxes are along any of the three axes.

    Args:
        batch: the poses are those of now.
        depth: [m].
    """
    return [
        index
        for index, scene in zip(batch.scene_idxs, batch.scenes, strict=True)
        if _is_in_doubt(scene.physx_system, depth)
    ]


def solid_components(system: Any) -> list[Any]:
    """The engine's components of a scene that collide, those of static bodies first."""
    static, dynamic = system.get_rigid_static_components(), system.get_rigid_dynamic_components()
    return [each for each in (*static, *dynamic, *system.get_articulation_link_components()) if each.collision_shapes]


def bounding_boxes(solid: list[Any]) -> Floats:
    """(N, 2, 3) [m] the least and the greatest corner of some components that collide."""
    return np.array([each.get_global_aabb_fast() for each in solid], np.float64).reshape(-1, 2, 3)


def is_plane(shape: Any) -> bool:
    """Whether one of the engine's collision shapes has no end."""
    return type(shape).__name__ == "PhysxCollisionShapePlane"


def _is_in_doubt(system: Any, depth: float) -> bool:
    solid = solid_components(system)
    boxes = bounding_boxes(solid)
    endless = (boxes[:, 1] - boxes[:, 0] > _ENDLESS).any(axis=1)
    if any(_cuts_plane(solid[number], boxes[~endless], depth) for number in np.flatnonzero(endless).tolist()):
        return True
    kept = np.flatnonzero(~endless).tolist()
    pairs = _deep_pairs(boxes[kept], depth)
    return pairs is None or any(not _never_meet(solid[kept[a]], solid[kept[b]]) for a, b in pairs.tolist())


def _cuts_plane(component: Any, boxes: Floats, depth: float) -> bool:
    """Whether a box reaches below a plane by more than `depth`, or the component is more than a plane."""
    shapes = component.collision_shapes
    if len(shapes) != 1 or not is_plane(shapes[0]):
        return True
    frame = (component.entity_pose * shapes[0].local_pose).to_transformation_matrix().astype(np.float64)
    normal, point = frame[:3, 0], frame[:3, 3]
    lowest = np.where(normal > 0, boxes[:, 0], boxes[:, 1])
    return bool(((lowest - point) @ normal < -depth).any())


def _deep_pairs(boxes: Floats, depth: float) -> NDArray[np.intp] | None:
    """(N, 2) numbers of boxes that are deeper in each other than `depth` along all axes; None where that takes long."""
    candidates = [_candidates(boxes[:, 0, axis], boxes[:, 1, axis], depth) for axis in range(3)]
    order, last = min(candidates, key=lambda one: one[1].sum())
    counts = last - np.arange(1, len(order) + 1)
    if counts.sum() > _PAIRS:
        return None
    first = np.repeat(np.arange(len(order)), counts)
    second = first + 1 + np.arange(len(first)) - np.repeat(counts.cumsum() - counts, counts)
    a, b = order[first], order[second]
    reach = np.minimum(boxes[a, 1] - boxes[b, 0], boxes[b, 1] - boxes[a, 0])
    deep = (reach > depth).all(axis=1)
    return np.stack([a[deep], b[deep]], axis=1)


def _candidates(low: Floats, high: Floats, depth: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The boxes by where they begin on an axis, and of each the end of those that begin within it (N,)."""
    order = np.argsort(low, kind="stable")
    last = np.searchsorted(low[order], high[order] - depth, side="left")
    return order, np.maximum(last, np.arange(1, len(order) + 1))


def _never_meet(one: Any, other: Any) -> bool:
    """Whether PhysX leaves two components alone: those that it does not move, and links that a joint connects."""
    if _is_still(one) and _is_still(other):
        return True
    return getattr(one, "parent", None) is other or getattr(other, "parent", None) is one


def _is_still(component: Any) -> bool:
    return bool(getattr(component, "kinematic", not hasattr(component, "mass")))
