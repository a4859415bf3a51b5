"""How large a body of a plan is."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from scenecc.geometry.rotation_arrays import rotation_matrix
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan.geometry import Plane, Primitive, VisualPlane

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan.body import BodyStructure


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
        if not isinstance(shape.geometry, Primitive):
            if seen_plane and isinstance(shape.geometry, Plane):
                continue
            return None
        pose = np.array(IDENTITY_POSE) if shape.pose is None else shape.pose.row(row)
        half = shape.geometry.extent(rotation_matrix(pose[3:]), *shape.geometry.sizes(row))
        corners += [pose[:3] - half, pose[:3] + half]
    if not corners:
        return None
    x, y, z = np.max(corners, axis=0) - np.min(corners, axis=0)
    # What the rotation of a flat shape leaves of its thickness is rounding.
    return (round(float(x), 12), round(float(y), 12), round(float(z), 12))
