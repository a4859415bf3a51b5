"""One entity or one articulation of a batch, as users handle it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.engine import physx, sapien
from scenecc.backends.sapien.objects import (
    pad_rows,
    root_is_fixed,
    select_scene_rows,
    spread_joint_values,
    spread_poses,
    spread_vectors,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import ArrayLike, NDArray

    from scenecc.backends.sapien.objects import ArticulationObjects, BodyObjects


class EntityBatch:
    """One entity of the plan, in every scene that has it.

    Rows of every array are its scenes by ascending index. Poses are p [m] then q (wxyz), in the world
    of their scene; velocities are in the world frame.
    """

    def __init__(self, bodies: BodyObjects) -> None:
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
        for row, new in zip(rows, spread_poses(pose, len(rows)), strict=True):
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
        for row, new in zip(rows, spread_vectors(velocity, len(rows)), strict=True):
            components[row].set_linear_velocity(new)

    def set_angular_velocity(self, velocity: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (3,) or (B, 3) [rad/s], otherwise as `set_linear_velocity`."""
        components, rows = self._driven(), self._rows(scene_idxs)
        for row, new in zip(rows, spread_vectors(velocity, len(rows)), strict=True):
            components[row].set_angular_velocity(new)

    def _rows(self, scene_idxs: Sequence[int] | None) -> Sequence[int]:
        return select_scene_rows(self._bodies, scene_idxs)

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


_ArticulationClass = physx.PhysxArticulation

_JointClass = physx.PhysxArticulationJoint


class ArticulationBatch:
    """One articulation of the plan, in every scene that has it.

    Rows of every array are its scenes by ascending index. Columns are its joints that move, in the engine's order
    (`active_joint_names`), which is level after level from the root and not always that of the file; numbers are [m]
    of a prismatic joint and [rad] of others. Where scenes have articulations with different numbers of joints, columns
    that one does not have are NaN, and what is set there is not looked at.
    """

    def __init__(self, articulations: ArticulationObjects) -> None:
        self._held = articulations
        self._dofs = list(map(len, articulations.joints))
        self._dof = articulations.dof
        self._closed = False

    def __len__(self) -> int:
        return len(self._held.scene_idxs)

    def __repr__(self) -> str:
        return f"ArticulationBatch({self.name!r}, dof={self.dof}, scene_idxs={list(self.scene_idxs)})"

    @property
    def name(self) -> str:
        """Its name in the plan; every `PhysxArticulation` has the same. Entities of links have their link's name."""
        return self._held.name

    @property
    def scene_idxs(self) -> tuple[int, ...]:
        """Indices among all scenes of the plan: those of this batch that have the articulation."""
        return self._held.scene_idxs

    @property
    def dof(self) -> int:
        """How many joints move; where scenes differ, of the one that has most."""
        return self._dof

    @property
    def objs(self) -> list[sapien.physx.PhysxArticulation]:
        """The `PhysxArticulation` of each scene. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return self._held.objs

    @property
    def links(self) -> dict[str, list[Any]]:
        """Name of a link → its `PhysxArticulationLinkComponent` in each scene, None where the articulation has none.

        In the order in which they were built, the root first. Raises RuntimeError once the batch is closed.
        """
        self._check_open()
        return _index_by_name(self._held.links)

    @property
    def joints(self) -> dict[str, list[Any]]:
        """Name of a joint → its `PhysxArticulationJoint` in each scene, None where the articulation has none.

        Fixed ones too, in the order of their links; those without a name are reached by `links`. Raises RuntimeError
        once the batch is closed.
        """
        self._check_open()
        return _index_by_name([[link.get_joint() for link in row[1:]] for row in self._held.links])

    @property
    def active_joint_names(self) -> tuple[str, ...]:
        """Names of the joints that move, one for each column.

        Raises:
            ValueError: scenes have different ones; then ask each of `objs`.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        found = {tuple(joint.get_name() for joint in row) for row in self._held.joints}
        if len(found) != 1:
            raise ValueError(f"'{self.name}' has other joints in other scenes: ask objs[i].active_joints")
        return found.pop()

    @property
    def qlimits(self) -> NDArray[np.float32]:
        """(B, dof, 2) lowest and highest positions; infinite where there is no limit."""
        self._check_open()
        return pad_rows([_read_rows(row, _JointClass.get_limits, (-1, 2)) for row in self._held.joints], self.dof)

    @property
    def qpos(self) -> NDArray[np.float32]:
        """(B, dof) positions. Raises RuntimeError while it is removed and once the batch is closed."""
        self._check_there()
        return pad_rows([obj.get_qpos() for obj in self._held.objs], self.dof)

    @qpos.setter
    def qpos(self, qpos: ArrayLike) -> None:
        self.set_qpos(qpos)

    def set_qpos(self, qpos: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Moves joints at once, in all scenes or in those named; velocities and targets of drives stay.

        Args:
            qpos: (dof,) or (B, dof); B is the number of scenes moved.
            scene_idxs: indices among all scenes of the plan.

        Raises:
            ValueError: the shape does not fit or a number is not finite.
            KeyError: the articulation is in no such scene of this batch.
            RuntimeError: the batch is closed, or the articulation is removed in one of these scenes.
        """
        self._tell_present(qpos, scene_idxs, "qpos", _ArticulationClass.set_qpos)

    @property
    def qvel(self) -> NDArray[np.float32]:
        """(B, dof) velocities [m/s, rad/s]. Raises RuntimeError while it is removed and once the batch is closed."""
        self._check_there()
        return pad_rows([obj.get_qvel() for obj in self._held.objs], self.dof)

    @qvel.setter
    def qvel(self, qvel: ArrayLike) -> None:
        self.set_qvel(qvel)

    def set_qvel(self, qvel: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (dof,) or (B, dof) velocities [m/s, rad/s], otherwise as `set_qpos`."""
        self._tell_present(qvel, scene_idxs, "qvel", _ArticulationClass.set_qvel)

    @property
    def qf(self) -> NDArray[np.float32]:
        """(B, dof) forces [N, N·m] that were set on joints. Raises RuntimeError while it is removed and once closed."""
        self._check_there()
        return pad_rows([obj.get_qf() for obj in self._held.objs], self.dof)

    @qf.setter
    def qf(self, qf: ArrayLike) -> None:
        self.set_qf(qf)

    def set_qf(self, qf: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (dof,) or (B, dof) forces [N, N·m], otherwise as `set_qpos`.

        They act beside the drives in every step until others are set or a reset takes them off.
        """
        self._tell_present(qf, scene_idxs, "qf", _ArticulationClass.set_qf)

    @property
    def drive_target(self) -> NDArray[np.float32]:
        """(B, dof) positions that the drives pull to. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return pad_rows([_read_rows(row, _JointClass.get_drive_target, (-1,)) for row in self._held.joints], self.dof)

    @drive_target.setter
    def drive_target(self, target: ArrayLike) -> None:
        self.set_drive_target(target)

    def set_drive_target(self, target: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (dof,) or (B, dof) positions that the drives pull to, otherwise as `set_qpos`."""
        self._tell_joints(target, scene_idxs, "drive_target", _JointClass.set_drive_target)

    @property
    def drive_velocity_target(self) -> NDArray[np.float32]:
        """(B, dof) velocities that the drives pull to [m/s, rad/s]. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return pad_rows(
            [_read_rows(row, _JointClass.get_drive_velocity_target, (-1,)) for row in self._held.joints], self.dof
        )

    @drive_velocity_target.setter
    def drive_velocity_target(self, target: ArrayLike) -> None:
        self.set_drive_velocity_target(target)

    def set_drive_velocity_target(self, target: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (dof,) or (B, dof) velocities [m/s, rad/s] that the drives pull to, otherwise as `set_qpos`."""
        self._tell_joints(target, scene_idxs, "drive_velocity_target", _JointClass.set_drive_velocity_target)

    @property
    def pose(self) -> NDArray[np.float32]:
        """(B, 7) float32 of the root, p [m] then q (wxyz), in the world of its scene."""
        self._check_open()
        return np.array([obj.get_root_pose().__getstate__() for obj in self._held.objs], np.float32)

    def set_pose(
        self, pose: ArrayLike | sapien.Pose | Sequence[sapien.Pose], scene_idxs: Sequence[int] | None = None
    ) -> None:
        """Moves the root, and with it all links, at once; also one that is fixed. Joints and velocities stay.

        Args:
            pose: (7,) or (B, 7), a `sapien.Pose` or B of them; B is the number of scenes moved.
            scene_idxs: indices among all scenes of the plan.

        Raises:
            ValueError: the shape does not fit, a number is not finite or a quaternion not of unit length.
            KeyError: the articulation is in no such scene of this batch.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        rows = select_scene_rows(self._held, scene_idxs)
        for row, new in zip(rows, spread_poses(pose, len(rows)), strict=True):
            self._held.objs[row].set_root_pose(new)

    @property
    def linear_velocity(self) -> NDArray[np.float32]:
        """(B, 3) float32 of the root [m/s], world frame."""
        self._check_open()
        return np.array([obj.get_root_linear_velocity() for obj in self._held.objs], np.float32)

    @linear_velocity.setter
    def linear_velocity(self, velocity: ArrayLike) -> None:
        self.set_linear_velocity(velocity)

    def set_linear_velocity(self, velocity: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (3,) or (B, 3) [m/s] of the root in all of its scenes or in those named.

        Raises:
            TypeError: the root is fixed.
            ValueError: the shape does not fit or a number is not finite.
            KeyError: the articulation is in no such scene of this batch.
            RuntimeError: the batch is closed.
        """
        rows = self._free(scene_idxs)
        for row, new in zip(rows, spread_vectors(velocity, len(rows)), strict=True):
            self._held.objs[row].set_root_linear_velocity(new)

    @property
    def angular_velocity(self) -> NDArray[np.float32]:
        """(B, 3) float32 of the root [rad/s], world frame."""
        self._check_open()
        return np.array([obj.get_root_angular_velocity() for obj in self._held.objs], np.float32)

    @angular_velocity.setter
    def angular_velocity(self, velocity: ArrayLike) -> None:
        self.set_angular_velocity(velocity)

    def set_angular_velocity(self, velocity: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (3,) or (B, 3) [rad/s] of the root, otherwise as `set_linear_velocity`."""
        rows = self._free(scene_idxs)
        for row, new in zip(rows, spread_vectors(velocity, len(rows)), strict=True):
            self._held.objs[row].set_root_angular_velocity(new)

    def _each(
        self, numbers: ArrayLike, rows: Sequence[int], what: str, tell: Callable[[int, NDArray[np.float32]], None]
    ) -> None:
        told = spread_joint_values(numbers, [self._dofs[row] for row in rows], self.dof, what)
        for row, new in zip(rows, told, strict=True):
            tell(row, new)

    def _tell_present(
        self, numbers: ArrayLike, scene_idxs: Sequence[int] | None, what: str, setter: Callable[[Any, Any], None]
    ) -> None:
        """For what the engine holds of an articulation in its scene alone."""
        self._check_open()
        rows = select_scene_rows(self._held, scene_idxs)
        self._check_there(rows)
        self._each(numbers, rows, what, lambda row, new: setter(self._held.objs[row], new))

    def _tell_joints(
        self, numbers: ArrayLike, scene_idxs: Sequence[int] | None, what: str, setter: Callable[[Any, float], None]
    ) -> None:
        def tell(row: int, new: NDArray[np.float32]) -> None:
            for joint, number in zip(self._held.joints[row], new.tolist(), strict=True):
                setter(joint, number)

        self._check_open()
        self._each(numbers, select_scene_rows(self._held, scene_idxs), what, tell)

    def _free(self, scene_idxs: Sequence[int] | None) -> Sequence[int]:
        self._check_open()
        rows = select_scene_rows(self._held, scene_idxs)
        if any(root_is_fixed(self._held.links[row]) for row in rows):
            raise TypeError(f"the root of '{self.name}' is fixed: it has no velocity")
        return rows

    def _check_there(self, rows: Iterable[int] | None = None) -> None:
        self._check_open()
        asked = range(len(self._held.objs)) if rows is None else rows
        gone = [self.scene_idxs[row] for row in asked if not self._held.in_scene(row)]
        if gone:
            where = "" if len(gone) == len(self) else f" in scene {gone[0]}"
            raise RuntimeError(f"'{self.name}' is removed{where}: the engine knows nothing of its joints there")

    def _check_open(self) -> None:
        if self._closed:
            raise RuntimeError(f"the scenes of '{self.name}' are closed")

    def _close(self) -> None:
        self._closed = True
        self._held = replace(self._held, objs=[], entities=[], links=[])


def _index_by_name(rows: list[list[Any]]) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for number, row in enumerate(rows):
        for each in row:
            if name := each.get_name():
                found.setdefault(name, [None] * len(rows))[number] = each
    return found


def _read_rows(joints: list[Any], getter: Callable[[Any], Any], shape: tuple[int, ...]) -> NDArray[np.float32]:
    """One row a joint."""
    return np.array([getter(joint) for joint in joints], np.float32).reshape(shape)
