"""How large a body of a plan is."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from scenecc.geometry.rotation_arrays import rotation_matrix
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan.geometry import Box, Capsule, Cylinder, Plane, Sphere, TiledPlane, VisualPlane

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.plan.body import BodyStructure


Solid = Literal["box", "sphere", "capsule", "cylinder"]

_SOLIDS: Final[dict[type, Callable[[Any, int], tuple[Solid, tuple[float, ...]]]]] = {
    Box: lambda g, row: ("box", tuple(g.half_size.row(row))),
    Sphere: lambda g, row: ("sphere", (g.radius.row(row),)),
    Capsule: lambda g, row: ("capsule", (g.radius.row(row), g.half_length.row(row))),
    Cylinder: lambda g, row: ("cylinder", (g.radius.row(row), g.half_length.row(row))),
    VisualPlane: lambda g, row: ("box", (0.0, *g.half_size.row(row))),
    TiledPlane: lambda g, row: ("box", (*g.half_size.row(row), 0.0)),
}
"""What a shape is and its sizes [m]; types that are not here have none without reading a file, or no end."""


def half_extents(solid: Solid, sizes: tuple[float, ...], rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far a shape reaches from its centre along the axes of the frame in which it is turned, (3,) [m].

    Args:
        solid: what it is.
        sizes: half sizes of a box; radius of a sphere; radius and half length of the others, which lie along x.
        rotation: (3, 3), of the shape in that frame.
    """
    if solid == "box":
        return np.abs(rotation) @ np.array(sizes)
    if solid == "sphere":
        return np.full(3, sizes[0])
    radius, half_length = sizes
    along = np.abs(rotation[:, 0])
    round_end = 1.0 if solid == "capsule" else np.sqrt(np.maximum(1 - along**2, 0))
    return along * half_length + radius * round_end


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
        measure = _SOLIDS.get(type(shape.geometry))
        if measure is None:
            if seen_plane and isinstance(shape.geometry, Plane):
                continue
            return None
        pose = np.array(IDENTITY_POSE) if shape.pose is None else shape.pose.row(row)
        half = half_extents(*measure(shape.geometry, row), rotation_matrix(pose[3:]))
        corners += [pose[:3] - half, pose[:3] + half]
    if not corners:
        return None
    x, y, z = np.max(corners, axis=0) - np.min(corners, axis=0)
    # What the rotation of a flat shape leaves of its thickness is rounding.
    return (round(float(x), 12), round(float(y), 12), round(float(z), 12))
