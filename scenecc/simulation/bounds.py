"""Proofs by bounding boxes, without contacts, that no two bodies of a scene overlap deeply."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch

    Floats = NDArray[np.float64]

_PAIRS: Final = 4_000_000
"""Maximum number of box pairs to compare in one scene. Beyond it, reading the contacts is as fast."""

_ENDLESS: Final = 1e6
"""[m] Anything larger is a plane, whose bounding box is useless."""


def scenes_in_doubt(batch: SceneBatch, depth: float) -> list[int]:
    """Returns the scenes whose bounding boxes do not prove that no two bodies overlap by more than `depth`.

    Moving two bodies apart along one axis until their boxes no longer overlap also separates the bodies. So bodies
    never overlap more deeply than their boxes do along any axis.

    Args:
        batch: the batch, in its current poses.
        depth: depth [m].
    """
    return [
        index
        for index, scene in zip(batch.scene_idxs, batch.scenes, strict=True)
        if _is_in_doubt(scene.physx_system, depth)
    ]


def solid_components(system: Any) -> list[Any]:
    """Returns the engine's collision components of a scene; those of static bodies come first."""
    static, dynamic = system.get_rigid_static_components(), system.get_rigid_dynamic_components()
    return [each for each in (*static, *dynamic, *system.get_articulation_link_components()) if each.collision_shapes]


def bounding_boxes(solid: list[Any]) -> Floats:
    """Returns minimum and maximum corners (N, 2, 3) of collision components [m]."""
    return np.array([each.get_global_aabb_fast() for each in solid], np.float64).reshape(-1, 2, 3)


def is_plane(shape: Any) -> bool:
    """Returns whether one of the engine's collision shapes is infinite."""
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
    """Returns whether a box reaches deeper below a plane than `depth`, or the component has more shapes."""
    shapes = component.collision_shapes
    if len(shapes) != 1 or not is_plane(shapes[0]):
        return True
    frame = (component.entity_pose * shapes[0].local_pose).to_transformation_matrix().astype(np.float64)
    normal, point = frame[:3, 0], frame[:3, 3]
    lowest = np.where(normal > 0, boxes[:, 0], boxes[:, 1])
    return bool(((lowest - point) @ normal < -depth).any())


def _deep_pairs(boxes: Floats, depth: float) -> NDArray[np.intp] | None:
    """Returns index pairs (N, 2) of boxes that overlap by more than `depth` on all axes; None if that is too slow."""
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
    """Returns the order of boxes by their start on one axis, and per box the end of those that start within it (N,)."""
    order = np.argsort(low, kind="stable")
    last = np.searchsorted(low[order], high[order] - depth, side="left")
    return order, np.maximum(last, np.arange(1, len(order) + 1))


def _never_meet(one: Any, other: Any) -> bool:
    """Returns whether PhysX ignores a pair: two immovable components, or links connected by a joint."""
    if _is_still(one) and _is_still(other):
        return True
    return getattr(one, "parent", None) is other or getattr(other, "parent", None) is one


def _is_still(component: Any) -> bool:
    return bool(getattr(component, "kinematic", not hasattr(component, "mass")))
