"""Projects the world to the picture and back with a camera's matrices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Projection:
    """A camera's matrices.

    Attributes:
        width, height: of its picture [px].
        model: (4, 4) from its frame (x right, y up, z backwards) to the world.
        lens: (4, 4) from its frame to the picture, -1 to 1 from left to right and from top to bottom.
    """

    width: int
    height: int
    model: NDArray[np.float64]
    lens: NDArray[np.float64]

    @classmethod
    def of(cls, component: Any) -> Projection:
        """Reads the matrices of a `RenderCameraComponent`."""
        return cls(
            component.width,
            component.height,
            np.asarray(component.get_model_matrix(), np.float64),
            np.asarray(component.get_projection_matrix(), np.float64),
        )

    def project(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Projects points (N, 3) of the world [m] to (N, 2) right and down in the picture [px], and depths (N,) [m].

        A point that is not in front of the camera becomes NaN.
        """
        local = (points - self.model[:3, 3]) @ self.model[:3, :3]
        clip = np.concatenate([local, np.ones((len(local), 1))], axis=1) @ self.lens.T
        depth = -local[:, 2]
        with np.errstate(invalid="ignore", divide="ignore"):
            flat = clip[:, :2] / clip[:, 3:]
        pixels = (flat + 1) / 2 * (self.width, self.height)
        return np.where(depth[:, None] > 0, pixels, np.nan), depth

    def plane_points(
        self, height: float, shift: tuple[float, float] = (0, 0)
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Returns where each pixel's ray meets the plane z = height: points (H, W, 3) and depths (H, W) [m], or NaN.

        `shift` [px] is as for `CameraBatch.capture`.
        """
        columns = (np.arange(self.width) + 0.5 - shift[0]) / self.width * 2 - 1
        rows = (np.arange(self.height) + 0.5 - shift[1]) / self.height * 2 - 1
        x, y = np.meshgrid(columns, rows)
        back = np.linalg.inv(self.lens)
        near, far = ((np.stack([x, y, np.full_like(x, z), np.ones_like(x)], axis=-1) @ back.T) for z in (0.25, 0.75))
        near, far = near[..., :3] / near[..., 3:], far[..., :3] / far[..., 3:]
        way = far - near
        up = self.model[2, :3]
        with np.errstate(invalid="ignore", divide="ignore"):
            steps = (height - self.model[2, 3] - near @ up) / (way @ up)
        local = near + steps[..., None] * way
        depth = -local[..., 2]
        seen = np.isfinite(depth) & (depth > 0)
        points = local @ self.model[:3, :3].T + self.model[:3, 3]
        return np.where(seen[..., None], points, np.nan), np.where(seen, depth, np.nan)
