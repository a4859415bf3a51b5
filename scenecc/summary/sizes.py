"""How large a body or an articulation is, as the engine has it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.plan.extent import pose_matrix, reach

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from scenecc.plan.measured import MeasuredBody, MeasuredShape

Size = tuple[float, float, float]


def measured_size(bodies: Iterable[MeasuredBody]) -> Size | None:
    """Extents of what of some bodies collides, along the axes of the first one [m].

    None where nothing of them collides, or a plane does.
    """
    found: list[NDArray[np.float64]] = []
    root: NDArray[np.float64] | None = None
    for body in bodies:
        frame = pose_matrix(body.pose)
        root = np.array(np.linalg.inv(frame), np.float64) if root is None else root
        for shape in body.shapes:
            if shape.kind == "plane":
                return None
            found.append(_bounds(shape, root @ frame @ pose_matrix(shape.pose)))
    if not found:
        return None
    x, y, z = np.ptp(np.concatenate(found), axis=0).tolist()
    return (x, y, z)


def _bounds(shape: MeasuredShape, frame: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (n, 3) that bound a shape in a frame as the shape itself does. `frame`: (4, 4), its own in that."""
    rotation, centre = frame[:3, :3], frame[:3, 3]
    if shape.mesh is not None:
        return shape.mesh.vertices @ rotation.T + centre
    assert shape.kind != "plane"
    assert shape.kind != "convex_mesh"
    assert shape.kind != "triangle_mesh"
    half = reach(shape.kind, shape.sizes, rotation)
    return np.array([centre - half, centre + half])
