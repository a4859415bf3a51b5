"""A grid on the ground that shows the scale: intersects each pixel's ray with the plane, and hides what is behind
surfaces by the depth picture.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.render.projection import Projection

_NEAR_SURFACE: Final = 3e-3
"""Largest relative difference in depth between a surface on the ground and the plane."""

_SEEN_GROUND: Final = 0.005
"""Smallest fraction of pixels that must be ground surface, for the grid to be drawn only on surfaces."""

_HEAVY: Final = 5
"""One line in this many is wider."""

_STRENGTH, _HEAVY_STRENGTH = 0.22, 0.42
_X_AXIS, _Y_AXIS = (0.75, 0.03, 0.03), (0.03, 0.35, 0.03)


def draw_ground(
    linear: NDArray[np.float64],
    depth: NDArray[np.float32],
    projection: Projection,
    height: float,
    cell: float,
    shift: tuple[float, float] = (0, 0),
) -> NDArray[np.float64]:
    """Returns a picture with lines every `cell` metres along the world's x and y, and the axes in red and green.

    If there is a surface at this height, they are drawn on it; otherwise as if on a pane of glass.

    Args:
        linear: (H, W, 3) linear colours.
        depth: (H, W, 1) [m], 0 where there is nothing.
        projection: of the camera.
        height: of the plane z = height [m].
        cell: side of a cell [m].
        shift: of the picture [px], as for `CameraBatch.capture`.
    """
    points, away = projection.plane_points(height, shift)
    seen = np.where(depth[..., 0] > 0, depth[..., 0], np.inf)
    with np.errstate(invalid="ignore"):
        on = np.isfinite(seen) & (np.abs(away - seen) <= _NEAR_SURFACE * away)
        before = (away > 0) & (away <= seen * (1 + _NEAR_SURFACE))
    where = on if on.mean() > _SEEN_GROUND else before
    dark = linear[where].mean() > 0.18 if where.any() else True
    ink = np.zeros(3) if dark else np.ones(3)
    found = linear
    for axis, color in ((1, _X_AXIS), (0, _Y_AXIS)):
        across = points[..., axis]
        found = _draw_lines(found, across, where, cell, 1.0, _STRENGTH, ink)
        found = _draw_lines(found, across, where, _HEAVY * cell, 1.6, _HEAVY_STRENGTH, ink)
        found = _draw_lines(found, across, where, np.inf, 2.0, 0.8, np.array(color))
    return found


def _draw_lines(
    picture: NDArray[np.float64],
    across: NDArray[np.float64],
    where: NDArray[np.bool_],
    spacing: float,
    width: float,
    strength: float,
    ink: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Draws lines `width` pixels wide, `spacing` metres apart (inf: one at 0), which fade where they are too dense."""
    with np.errstate(invalid="ignore"):
        down, right = np.gradient(across, axis=0), np.gradient(across, axis=1)
        pixel: NDArray[np.float64] = np.hypot(down, right)
        off = np.abs(across if np.isinf(spacing) else across - spacing * np.round(across / spacing))
        covered = np.clip((width + 1) / 2 - off / np.maximum(pixel, 1e-12), 0, 1)
        fades = np.clip(2 - 8 * pixel / spacing, 0, 1) if np.isfinite(spacing) else 1.0
    share = np.nan_to_num(np.where(where, strength * covered * fades, 0.0))[..., None]
    return picture * (1 - share) + ink * share
