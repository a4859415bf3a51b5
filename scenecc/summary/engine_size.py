"""How large what was built is, where only the engine can tell: of meshes, and of links at their start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.plan.extent import reach

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray


Size = tuple[float, float, float]


def mesh_size(body: Any) -> Size | None:
    """Extents of a body that collides by meshes alone: their corners are known once the engine has read them."""
    shapes = body.collision_shapes
    if not shapes or not all(hasattr(shape, "vertices") for shape in shapes):
        return None
    return _extents(_corners(shape, shape.local_pose) for shape in shapes)


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
            bounds = _bounds(shape, root * pose * shape.local_pose)
            if bounds is None:
                return None
            found.append(bounds)
    return _extents(found) if found else None


def _bounds(shape: Any, pose: Any) -> NDArray[np.float64] | None:
    """Points (n, 3) that bound a shape as it is turned itself; None for a plane. `pose`: in the frame of the points."""
    if hasattr(shape, "vertices"):
        return _corners(shape, pose)
    matrix = pose.to_transformation_matrix().astype(np.float64)
    rotation, centre = matrix[:3, :3], matrix[:3, 3]
    if hasattr(shape, "half_size"):
        half = reach("box", tuple(shape.half_size), rotation)
    elif hasattr(shape, "half_length"):
        solid = "cylinder" if type(shape).__name__.endswith("Cylinder") else "capsule"
        half = reach(solid, (shape.radius, shape.half_length), rotation)
    elif hasattr(shape, "radius"):
        half = reach("sphere", (shape.radius,), rotation)
    else:
        return None
    return np.array([centre - half, centre + half])


def _corners(mesh: Any, pose: Any) -> NDArray[np.float64]:
    matrix = pose.to_transformation_matrix()
    return np.asarray(mesh.vertices * mesh.scale, np.float64) @ matrix[:3, :3].T + matrix[:3, 3]


def _extents(points: Iterable[NDArray[Any]]) -> Size:
    x, y, z = np.ptp(np.concatenate(list(points)), axis=0).tolist()
    return (x, y, z)
