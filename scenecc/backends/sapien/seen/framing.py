"""A camera that sees all of a scene, for plans that have none."""

from __future__ import annotations

from math import atan, radians, sin, tan
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.backends.sapien.engine import render
from scenecc.geometry import rotation_arrays
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan import Camera, Perspective, literal
from scenecc.plan.rendering import FLAT_THICKNESS, FRAMING_DIRECTION

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

NAME: Final = "default"
WIDTH, HEIGHT, FOVY = 640, 480, radians(60)
SPARE: Final = 1.1


def default_camera(num_scenes: int, width: int = WIDTH, height: int = HEIGHT) -> Camera:
    """The camera, at no place yet. `width`, `height`: of its pictures [px]."""
    return Camera(
        name=NAME,
        scene_idxs=tuple(range(num_scenes)),
        pose=literal(IDENTITY_POSE),
        width=width,
        height=height,
        lens=Perspective(fovy=literal(FOVY)),
        near=literal(0.01),
        far=literal(100.0),
    )


def framing(scene: Any, width: int = WIDTH, height: int = HEIGHT) -> tuple[NDArray[np.float64], float, float]:
    """The pose (7,) of a camera that sees all of a scene, with its near and far planes [m].

    The sphere around the boxes of all that is seen fills the picture in width or height, whichever is less. What is
    flat, as the ground is, counts only where there is nothing else.
    """
    low, high = _bounds(scene.render_system.render_bodies)
    middle, radius = (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 0.05)
    half = FOVY / 2 if width >= height else atan(tan(FOVY / 2) * width / height)
    distance = SPARE * radius / sin(half)
    back = np.array(FRAMING_DIRECTION) / np.linalg.norm(FRAMING_DIRECTION)
    q, _ = rotation_arrays.looking(-back[None])
    pose = np.concatenate([middle + distance * back, q[0]])
    return pose, max(0.01, 0.01 * (distance - radius)), 100 * (distance + radius)


def _bounds(bodies: Iterable[Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    boxes = [np.asarray(body.compute_global_aabb_tight(), np.float64) for body in bodies if _has_bounds(body)]
    boxes = [box for box in boxes if np.isfinite(box).all()]
    solid = [box for box in boxes if (box[1] - box[0]).min() > FLAT_THICKNESS] or boxes
    if not solid:
        return np.full(3, -0.5), np.full(3, 0.5)
    corners = np.stack(solid)
    return corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)


def _has_bounds(body: Any) -> bool:
    return bool(body.render_shapes) and not all(
        isinstance(shape, render.RenderShapePlane) for shape in body.render_shapes
    )
