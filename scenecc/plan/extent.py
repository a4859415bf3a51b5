"""How large a body of a plan is."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.plan.geometry import Box, Capsule, Cylinder, Plane, Sphere, TiledPlane, VisualPlane

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.plan.body import BodyStructure
    from scenecc.plan.geometry import CollisionGeometry, VisualGeometry

_HALF: Final[dict[type, Callable[[Any, int], tuple[float, float, float]]]] = {
    Box: lambda g, row: tuple(g.half_size.row(row)),
    Sphere: lambda g, row: (g.radius.row(row),) * 3,
    Capsule: lambda g, row: (g.half_length.row(row) + g.radius.row(row), g.radius.row(row), g.radius.row(row)),
    Cylinder: lambda g, row: (g.half_length.row(row), g.radius.row(row), g.radius.row(row)),
    VisualPlane: lambda g, row: (0.0, *g.half_size.row(row)),
    TiledPlane: lambda g, row: (*g.half_size.row(row), 0.0),
}
"""Half extents along a shape's own axes [m]; types that are not here have none without reading a file, or no end."""


def extent(structure: BodyStructure, row: int = 0) -> tuple[float, float, float] | None:
    """The extents of a body along the axes of its own frame [m], shapes that are only seen included.

    Args:
        structure: the body.
        row: which of its entity's scenes.

    Returns:
        None where a shape is a mesh, or an endless plane that nothing is seen of.
    """
    corners: list[NDArray[np.float64]] = []
    seen_plane = any(isinstance(shape.geometry, VisualPlane) for shape in structure.visuals)
    for shape in chain(structure.collisions, structure.visuals):
        half = _half(shape.geometry, row)
        if half is None:
            if seen_plane and isinstance(shape.geometry, Plane):
                continue
            return None
        pose = np.array([0, 0, 0, 1, 0, 0, 0.0]) if shape.pose is None else shape.pose.row(row)
        reach = np.abs(_matrix(pose[3:])) @ np.array(half)
        corners += [pose[:3] - reach, pose[:3] + reach]
    if not corners:
        return None
    x, y, z = np.max(corners, axis=0) - np.min(corners, axis=0)
    # What the rotation of a flat shape leaves of its thickness is rounding.
    return (round(float(x), 12), round(float(y), 12), round(float(z), 12))


def _half(geometry: CollisionGeometry | VisualGeometry, row: int) -> tuple[float, float, float] | None:
    measure = _HALF.get(type(geometry))
    return None if measure is None else measure(geometry, row)


def _matrix(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation matrix of a unit quaternion [w, x, y, z]."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
