"""What lies within the frame of a camera. Occlusion is not considered."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scenecc.plan.rendering import Camera, Intrinsic, Orthographic

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class View:
    """A camera at a pose in the world.

    Attributes:
        frame: (4, 4) pose; it looks along x, and z is up.
        left, right, down, up: ends of the picture as tangents of angles; lengths [m] for an orthographic camera.
        near, far: [m].
        orthographic: whether it has no perspective.
    """

    frame: Floats
    left: float
    right: float
    down: float
    up: float
    near: float
    far: float
    orthographic: bool

    @property
    def fovy(self) -> float:
        """Vertical field of view [rad]."""
        return math.atan(self.up) + math.atan(self.down)

    def inside(self, points: Floats) -> NDArray[np.bool_]:
        """Returns whether points (N, 3) in the world are in the frame."""
        x, y, z = ((points - self.frame[:3, 3]) @ self.frame[:3, :3]).T
        depth = np.ones_like(x) if self.orthographic else x
        wide = (y <= self.left * depth) & (-y <= self.right * depth)
        return wide & (z <= self.up * depth) & (-z <= self.down * depth) & (x >= self.near) & (x <= self.far)

    def sees(self, points: Floats) -> bool:
        """Returns whether a body is in the frame, by its centre and corners: all of them, or the centre."""
        return bool(self.inside(points)[0])

    def cuts(self, points: Floats) -> bool:
        """Returns whether a body is partly in the frame."""
        found = self.inside(points)
        return bool(found.any() and not found.all())


def view_of(camera: Camera, row: int, frame: Floats) -> View:
    """Returns the view of a camera in one of its scenes. `frame`: its pose (4, 4) in the world."""
    width, height = camera.width, camera.height
    near, far = float(camera.near.row(row)), float(camera.far.row(row))
    lens = camera.lens
    if isinstance(lens, Orthographic):
        top = float(lens.top.row(row))
        return View(frame, top * width / height, top * width / height, top, top, near, far, orthographic=True)
    if isinstance(lens, Intrinsic):
        fx, fy, cx, cy = (float(one.row(row)) for one in (lens.fx, lens.fy, lens.cx, lens.cy))
        ends = cx / fx, (width - cx) / fx, (height - cy) / fy, cy / fy
        return View(frame, *ends, near, far, orthographic=False)
    x = None if lens.fovx is None else math.tan(float(lens.fovx.row(row)) / 2)
    y = None if lens.fovy is None else math.tan(float(lens.fovy.row(row)) / 2)
    x = x if x is not None else (y or 0) * width / height
    y = y if y is not None else x * height / width
    return View(frame, x, x, y, y, near, far, orthographic=False)
