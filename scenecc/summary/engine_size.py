"""How large what was built is, where only the engine can tell: of meshes, and of links at their start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray


Size = tuple[float, float, float]


def mesh_size(body: Any) -> Size | None:
    """Extents of a body that collides by meshes alone: their corners are known once the engine has read them."""
    shapes = body.collision_shapes
    if not shapes or not all(hasattr(shape, "vertices") for shape in shapes):
        return None
    return _extents(_placed(shape.vertices * shape.scale, shape.local_pose) for shape in shapes)


def articulation_size(links: Iterable[Any]) -> Size | None:
    """Extents of what of some links collides, along the axes of the first one, where they are now.

    None where nothing of them collides, or a plane does.
    """
    found: list[NDArray[np.float64]] = []
    root: Any = None
    for link in links:
        pose = link.entity_pose
        root = pose.inv() if root is None else root
        for shape in link.collision_shapes:
            corners = _corners(shape)
            if corners is None:
                return None
            found.append(_placed(corners, root * pose * shape.local_pose))
    return _extents(found) if found else None


def _corners(shape: Any) -> NDArray[np.float64] | None:
    """Points that enclose a shape, in its own frame."""
    if hasattr(shape, "vertices"):
        return np.asarray(shape.vertices * shape.scale, dtype=np.float64)
    if hasattr(shape, "half_size"):
        half = shape.half_size
    elif hasattr(shape, "radius"):
        radius = shape.radius
        length = getattr(shape, "half_length", 0.0)
        # A capsule's ends are round, a cylinder's flat; a ball has no length.
        flat = type(shape).__name__.endswith("Cylinder")
        half = (length if flat else length + radius, radius, radius)
    else:
        return None
    signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
    return signs * np.asarray(half, dtype=np.float64)


def _placed(points: NDArray[Any], pose: Any) -> NDArray[np.float64]:
    matrix = pose.to_transformation_matrix()
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def _extents(points: Iterable[NDArray[Any]]) -> Size:
    x, y, z = np.ptp(np.concatenate(list(points)), axis=0).tolist()
    return (x, y, z)
