"""One entity of a batch, as a user handles it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.bodies import chosen_rows
from scenecc.backends.sapien.engine import physx, sapien
from scenecc.backends.sapien.rows import pose_rows, vector_rows

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from scenecc.backends.sapien.bodies import Bodies


class EntityBatch:
    """One entity of the plan, in every scene that has it.

    Rows of every array are its scenes by ascending index. Poses are p [m] then q (wxyz), in the world
    of their scene; velocities are in the world frame.
    """

    def __init__(self, bodies: Bodies) -> None:
        self._bodies = bodies
        self._closed = False

    def __len__(self) -> int:
        return len(self._bodies.scene_idxs)

    def __repr__(self) -> str:
        return f"EntityBatch({self._bodies.name!r}, scene_idxs={list(self._bodies.scene_idxs)})"

    @property
    def name(self) -> str:
        """Its name in the plan; every `sapien.Entity` has the same."""
        return self._bodies.name

    @property
    def objs(self) -> list[sapien.Entity]:
        """The `sapien.Entity` of each scene. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return self._bodies.objs

    @property
    def scene_idxs(self) -> tuple[int, ...]:
        """Indices among all scenes of the plan: those of this batch that have the entity."""
        return self._bodies.scene_idxs

    @property
    def pose(self) -> NDArray[np.float32]:
        """(B, 7) float32. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return np.array([entity.get_pose().__getstate__() for entity in self._bodies.objs], dtype=np.float32)

    def set_pose(
        self, pose: ArrayLike | sapien.Pose | Sequence[sapien.Pose], scene_idxs: Sequence[int] | None = None
    ) -> None:
        """Moves the entity at once, in all of its scenes or in those named; velocities stay.

        Args:
            pose: (7,) or (B, 7), a `sapien.Pose` or B of them; B is the number of scenes moved.
            scene_idxs: indices among all scenes of the plan.

        Raises:
            ValueError: the shape does not fit, a number is not finite or a quaternion not of unit length.
            KeyError: the entity is in no such scene of this batch.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        rows = self._rows(scene_idxs)
        for row, new in zip(rows, pose_rows(pose, len(rows)), strict=True):
            self._bodies.objs[row].set_pose(new)

    @property
    def linear_velocity(self) -> NDArray[np.float32]:
        """(B, 3) float32 [m/s]. Raises TypeError for a static body and for one without physics."""
        return np.array([c.get_linear_velocity() for c in self._moving("velocity")], dtype=np.float32)

    @linear_velocity.setter
    def linear_velocity(self, velocity: ArrayLike) -> None:
        self.set_linear_velocity(velocity)

    @property
    def angular_velocity(self) -> NDArray[np.float32]:
        """(B, 3) float32 [rad/s]. Raises TypeError for a static body and for one without physics."""
        return np.array([c.get_angular_velocity() for c in self._moving("velocity")], dtype=np.float32)

    @angular_velocity.setter
    def angular_velocity(self, velocity: ArrayLike) -> None:
        self.set_angular_velocity(velocity)

    def set_linear_velocity(self, velocity: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (3,) or (B, 3) [m/s] in all of its scenes or in those named.

        Raises:
            TypeError: not a dynamic body.
            ValueError: the shape does not fit or a number is not finite.
            KeyError: the entity is in no such scene of this batch.
            RuntimeError: the batch is closed.
        """
        components, rows = self._driven(), self._rows(scene_idxs)
        for row, new in zip(rows, vector_rows(velocity, len(rows)), strict=True):
            components[row].set_linear_velocity(new)

    def set_angular_velocity(self, velocity: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (3,) or (B, 3) [rad/s], otherwise as `set_linear_velocity`."""
        components, rows = self._driven(), self._rows(scene_idxs)
        for row, new in zip(rows, vector_rows(velocity, len(rows)), strict=True):
            components[row].set_angular_velocity(new)

    def _rows(self, scene_idxs: Sequence[int] | None) -> Sequence[int]:
        return chosen_rows(self._bodies, scene_idxs)

    def _moving(self, what: str) -> list[Any]:
        self._check_open()
        for component in self._bodies.components:
            if not isinstance(component, physx.PhysxRigidDynamicComponent):
                kind = "has no physics" if component is None else "is static"
                raise TypeError(f"'{self._bodies.name}' {kind}: it has no {what}")
        return self._bodies.components

    def _driven(self) -> list[Any]:
        components = self._moving("velocity")
        if any(component.get_kinematic() for component in components):
            raise TypeError(f"'{self.name}' is kinematic: the engine moves it by its pose, and ignores a velocity")
        return components

    def _check_open(self) -> None:
        if self._closed:
            raise RuntimeError(f"the scenes of '{self._bodies.name}' are closed")

    def _close(self) -> None:
        self._closed = True
        self._bodies = replace(self._bodies, objs=[], components=[])
