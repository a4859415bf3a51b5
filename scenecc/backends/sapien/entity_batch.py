"""Users' handles of one entity or one articulation of a batch."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from scenecc.backends.sapien.engine import physx, sapien
from scenecc.backends.sapien.objects import (
    ComponentBatch,
    NamedObjects,
    freeze_array,
    pad_rows,
    root_is_fixed,
    spread_array,
    spread_joint_values,
    spread_poses,
)
from scenecc.options import check_scene_idxs

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import TypeVar

    from scenecc.backends.sapien.objects import ArticulationObjects, BodyObjects

    Found = TypeVar("Found")


class MovingBatch(ComponentBatch):
    """One entity of the plan in every scene that has it: the common base of bodies and articulations.

    Rows of every array are its scenes by ascending index. Poses are p [m] then q (wxyz), in the world of their scene;
    velocities are in the world frame. Pose and velocity of an articulation are those of its root. Arrays are read-only
    copies: assign a whole array, or call a setter.
    """

    _prefix: ClassVar[str] = ""
    """Prefix of the engine's setters and getters of poses and velocities."""

    def __init__(self, objects: BodyObjects | ArticulationObjects) -> None:
        super().__init__(objects.name, objects.scene_idxs, objects.objs)
        self._row_of = objects.row_of

    @property
    def pose(self) -> NDArray[np.float32]:
        """(B, 7) float32. Raises RuntimeError once the batch is closed."""
        getter = f"get_{self._prefix}pose"
        return freeze_array(np.array([getattr(obj, getter)().__getstate__() for obj in self.objs], dtype=np.float32))

    @pose.setter
    def pose(self, pose: ArrayLike | sapien.Pose | Sequence[sapien.Pose]) -> None:
        self.set_pose(pose)

    def set_pose(
        self, pose: ArrayLike | sapien.Pose | Sequence[sapien.Pose], scene_idxs: Sequence[int] | None = None
    ) -> None:
        """Sets the pose immediately, in all or some of its scenes. Velocities and joint positions stay.

        An articulation moves with all of its links, even if its root is fixed.

        Args:
            pose: (7,) or (B, 7), a `sapien.Pose` or B of them; B is the number of scenes moved.
            scene_idxs: indices among all scenes of the plan.

        Raises:
            ValueError: wrong shape, non-finite number or quaternion not of unit length.
            KeyError: the entity is not in this scene, or the scene is not in the batch.
            RuntimeError: the batch is closed.
        """
        objs, rows = self.objs, self._rows(scene_idxs)
        for row, new in zip(rows, spread_poses(pose, len(rows)), strict=True):
            getattr(objs[row], f"set_{self._prefix}pose")(new)

    @property
    def linear_velocity(self) -> NDArray[np.float32]:
        """(B, 3) float32 [m/s]. Raises TypeError for a static body or one without physics."""
        return self._velocity("linear")

    @linear_velocity.setter
    def linear_velocity(self, velocity: ArrayLike) -> None:
        self.set_linear_velocity(velocity)

    @property
    def angular_velocity(self) -> NDArray[np.float32]:
        """(B, 3) float32 [rad/s]. Raises TypeError for a static body or one without physics."""
        return self._velocity("angular")

    @angular_velocity.setter
    def angular_velocity(self, velocity: ArrayLike) -> None:
        self.set_angular_velocity(velocity)

    def set_linear_velocity(self, velocity: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (3,) or (B, 3) [m/s] in all or some of its scenes.

        Raises:
            TypeError: the body is not dynamic, or the root is fixed.
            ValueError: wrong shape or non-finite number.
            KeyError: the entity is not in this scene, or the scene is not in the batch.
            RuntimeError: the batch is closed.
        """
        self._set_velocity("linear", velocity, scene_idxs)

    def set_angular_velocity(self, velocity: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (3,) or (B, 3) [rad/s]; otherwise like `set_linear_velocity`."""
        self._set_velocity("angular", velocity, scene_idxs)

    def _velocity(self, kind: str) -> NDArray[np.float32]:
        getter = f"get_{self._prefix}{kind}_velocity"
        return freeze_array(np.array([getattr(each, getter)() for each in self._find_moving()], dtype=np.float32))

    def _set_velocity(self, kind: str, velocity: ArrayLike, scene_idxs: Sequence[int] | None) -> None:
        moving, rows = self._find_movable(scene_idxs)
        for row, new in zip(rows, spread_array(velocity, 3, len(rows), "a velocity"), strict=True):
            getattr(moving[row], f"set_{self._prefix}{kind}_velocity")(new)

    def _rows(self, scene_idxs: Sequence[int] | None) -> Sequence[int]:
        """Returns the rows of the given scenes, or all. Raises KeyError for a scene without the entity."""
        if scene_idxs is None:
            return range(len(self))
        chosen = check_scene_idxs(scene_idxs)
        missing = [index for index in chosen if index not in self._row_of]
        if missing:
            there = list(self.scene_idxs)
            raise KeyError(f"'{self.name}' is not in scene {missing[0]} of this batch; it is in {there}")
        return [self._row_of[index] for index in chosen]

    def _find_moving(self) -> list[Any]:
        """Returns the object with a velocity in each scene."""
        return self.objs

    def _find_movable(self, scene_idxs: Sequence[int] | None) -> tuple[list[Any], Sequence[int]]:
        """Returns the objects whose velocity can be set, and the rows of the given scenes."""
        raise NotImplementedError


class EntityBatch(MovingBatch):
    """One body of the plan in every scene that has it. See `MovingBatch`."""

    def __init__(self, bodies: BodyObjects) -> None:
        super().__init__(bodies)
        self._components = bodies.components

    @property
    def objs(self) -> list[sapien.Entity]:
        """The `sapien.Entity` of each scene. Raises RuntimeError once the batch is closed."""
        return super().objs

    def _find_moving(self) -> list[Any]:
        self._check_open()
        for component in self._components:
            if not isinstance(component, physx.PhysxRigidDynamicComponent):
                kind = "has no physics" if component is None else "is static"
                raise TypeError(f"'{self.name}' {kind}, so it has no velocity")
        return self._components

    def _find_movable(self, scene_idxs: Sequence[int] | None) -> tuple[list[Any], Sequence[int]]:
        components = self._find_moving()
        if any(component.get_kinematic() for component in components):
            raise TypeError(f"'{self.name}' is kinematic: set its pose; the engine ignores its velocity")
        return components, self._rows(scene_idxs)

    def _close(self) -> None:
        super()._close()
        self._components = []


class ArticulationBatch(MovingBatch):
    """One articulation of the plan in every scene that has it. See `MovingBatch`.

    Columns are its active joints, in the engine's order (`active_joint_names`): level by level from the root, which
    may differ from the order in the file. Numbers are [m] for prismatic joints and [rad] for others. If scenes have
    articulations with different numbers of joints, columns that one does not have are NaN, and values set there are
    ignored. Entities of links have the name of their link.
    """

    _prefix = "root_"

    def __init__(self, articulations: ArticulationObjects) -> None:
        super().__init__(articulations)
        self._objects = articulations
        self._dofs = list(map(len, articulations.joints))
        self._dof = articulations.dof

    def __repr__(self) -> str:
        return f"ArticulationBatch({self.name!r}, dof={self.dof}, scene_idxs={list(self.scene_idxs)})"

    @property
    def dof(self) -> int:
        """Number of active joints; the largest if scenes differ."""
        return self._dof

    @property
    def objs(self) -> list[sapien.physx.PhysxArticulation]:
        """The `PhysxArticulation` of each scene. Raises RuntimeError once the batch is closed."""
        return super().objs

    @property
    def links(self) -> dict[str, list[Any]]:
        """Name of a link → its `PhysxArticulationLinkComponent` in each scene, None if that scene has no such link.

        In build order, the root first. Raises RuntimeError once the batch is closed.
        """
        self._check_open()
        return NamedObjects({name: [*links] for name, links in self._link_rows.items()}, "link", self.name)

    @property
    def joints(self) -> dict[str, list[Any]]:
        """Name of a joint → its `PhysxArticulationJoint` in each scene, None if that scene has no such joint.

        Includes fixed joints, in the order of their links. Joints without a name are reached through `links`. Raises
        RuntimeError once the batch is closed.
        """
        self._check_open()
        rows = [[link.get_joint() for link in row[1:]] for row in self._objects.links]
        return NamedObjects(_index_by_name(rows), "joint", self.name)

    @property
    def active_joint_names(self) -> tuple[str, ...]:
        """Names of the active joints, one for each column.

        Raises:
            ValueError: the scenes have different joints. Ask each of `objs` instead.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        found = {tuple(joint.get_name() for joint in row) for row in self._objects.joints}
        if len(found) != 1:
            raise ValueError(f"'{self.name}' has different joints in different scenes: use objs[i].active_joints")
        return found.pop()

    def joint_index(self, names: str | Sequence[str]) -> NDArray[np.intp]:
        """Returns the columns of active joints, (joints,). `qpos` at these columns is (B, joints).

        Raises:
            KeyError: no active joint has this name.
            ValueError: the scenes have different joints. Ask each of `objs` instead.
            RuntimeError: the batch is closed.
        """
        columns = {name: column for column, name in enumerate(self.active_joint_names)}
        return freeze_array(np.array(self._find(names, columns, "moving joint"), np.intp))

    def link_pose(self, names: str | Sequence[str]) -> NDArray[np.float32]:
        """Returns the poses of links (B, links, 7) in the world of their scene, in the order of the names.

        If a scene's articulation has no such link, its row is NaN.

        Raises:
            KeyError: no scene has a link of this name.
            RuntimeError: the articulation is removed, or the batch is closed.
        """
        return self._link_values(names, 7, lambda link: link.get_entity().get_pose().__getstate__())

    def link_velocity(self, names: str | Sequence[str]) -> NDArray[np.float32]:
        """Returns the velocities of links (B, links, 6) in the world frame, linear [m/s] then angular [rad/s].

        The linear velocity is that of the link's centre of mass, as in SAPIEN. Otherwise like `link_pose`.
        """
        return self._link_values(names, 6, lambda link: (*link.get_linear_velocity(), *link.get_angular_velocity()))

    @property
    def qlimits(self) -> NDArray[np.float32]:
        """(B, dof, 2) lower and upper limits; infinite if there is none."""
        return self._joint_values("limits", (-1, 2))

    @property
    def qpos(self) -> NDArray[np.float32]:
        """(B, dof) positions. Raises RuntimeError while it is removed and once the batch is closed."""
        return self._values("qpos")

    @qpos.setter
    def qpos(self, qpos: ArrayLike) -> None:
        self.set_qpos(qpos)

    def set_qpos(self, qpos: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets joint positions immediately, in all or some scenes. Velocities and drive targets stay.

        Args:
            qpos: (dof,) or (B, dof); B is the number of scenes.
            scene_idxs: indices among all scenes of the plan.

        Raises:
            ValueError: wrong shape or non-finite number.
            KeyError: the articulation is not in this scene, or the scene is not in the batch.
            RuntimeError: the batch is closed, or the articulation is removed in one of these scenes.
        """
        self._set_values("qpos", qpos, scene_idxs)

    @property
    def qvel(self) -> NDArray[np.float32]:
        """(B, dof) velocities [m/s, rad/s]. Raises RuntimeError while it is removed and once the batch is closed."""
        return self._values("qvel")

    @qvel.setter
    def qvel(self, qvel: ArrayLike) -> None:
        self.set_qvel(qvel)

    def set_qvel(self, qvel: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (dof,) or (B, dof) velocities [m/s, rad/s]; otherwise like `set_qpos`."""
        self._set_values("qvel", qvel, scene_idxs)

    @property
    def qf(self) -> NDArray[np.float32]:
        """(B, dof) forces [N, N·m] that were set on joints. Raises RuntimeError while it is removed and once closed."""
        return self._values("qf")

    @qf.setter
    def qf(self, qf: ArrayLike) -> None:
        self.set_qf(qf)

    def set_qf(self, qf: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (dof,) or (B, dof) forces [N, N·m]; otherwise like `set_qpos`.

        They act in addition to the drives in every step, until they are set again or a reset clears them.
        """
        self._set_values("qf", qf, scene_idxs)

    @property
    def drive_target(self) -> NDArray[np.float32]:
        """(B, dof) position targets of the drives. Raises RuntimeError once the batch is closed."""
        return self._joint_values("drive_target")

    @drive_target.setter
    def drive_target(self, target: ArrayLike) -> None:
        self.set_drive_target(target)

    def set_drive_target(self, target: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (dof,) or (B, dof) position targets of the drives; otherwise like `set_qpos`."""
        self._set_joint_values("drive_target", target, scene_idxs)

    @property
    def drive_velocity_target(self) -> NDArray[np.float32]:
        """(B, dof) velocity targets of the drives [m/s, rad/s]. Raises RuntimeError once the batch is closed."""
        return self._joint_values("drive_velocity_target")

    @drive_velocity_target.setter
    def drive_velocity_target(self, target: ArrayLike) -> None:
        self.set_drive_velocity_target(target)

    def set_drive_velocity_target(self, target: ArrayLike, scene_idxs: Sequence[int] | None = None) -> None:
        """Sets (dof,) or (B, dof) velocity targets of the drives [m/s, rad/s]; otherwise like `set_qpos`."""
        self._set_joint_values("drive_velocity_target", target, scene_idxs)

    def _find(self, names: str | Sequence[str], known: dict[str, Found], what: str) -> list[Found]:
        """Looks up one or several names. Raises KeyError."""
        given = [names] if isinstance(names, str) else list(names)
        if not all(isinstance(name, str) for name in given):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError(f"names of a {what} must be strings, not {names!r}")
        found = NamedObjects(known, what, self.name)
        return [found[name] for name in given]

    @cached_property
    def _link_rows(self) -> dict[str, list[Any]]:
        return _index_by_name(self._objects.links)

    def _link_values(
        self, names: str | Sequence[str], width: int, read: Callable[[Any], Sequence[float]]
    ) -> NDArray[np.float32]:
        self._check_there()
        columns = self._find(names, self._link_rows, "link")
        missing = (np.nan,) * width
        found = [
            [missing if column[row] is None else read(column[row]) for column in columns] for row in range(len(self))
        ]
        return freeze_array(np.array(found, np.float32).reshape(len(self), len(columns), width))

    def _values(self, what: str) -> NDArray[np.float32]:
        """Returns articulation values (B, dof) that the engine only has while it is in its scene."""
        self._check_there()
        return freeze_array(pad_rows([getattr(obj, f"get_{what}")() for obj in self._objects.objs], self.dof))

    def _set_values(self, what: str, numbers: ArrayLike, scene_idxs: Sequence[int] | None) -> None:
        self._check_open()
        rows = self._rows(scene_idxs)
        self._check_there(rows)
        for row, new in self._spread(what, numbers, rows):
            getattr(self._objects.objs[row], f"set_{what}")(new)

    def _joint_values(self, what: str, shape: tuple[int, ...] = (-1,)) -> NDArray[np.float32]:
        """Returns joint values (B, dof) or (B, dof, 2), also out of a scene. `shape`: for one articulation."""
        self._check_open()
        rows = [[getattr(joint, f"get_{what}")() for joint in joints] for joints in self._objects.joints]
        return freeze_array(pad_rows([np.array(row, np.float32).reshape(shape) for row in rows], self.dof))

    def _set_joint_values(self, what: str, numbers: ArrayLike, scene_idxs: Sequence[int] | None) -> None:
        self._check_open()
        for row, new in self._spread(what, numbers, self._rows(scene_idxs)):
            for joint, number in zip(self._objects.joints[row], new.tolist(), strict=True):
                getattr(joint, f"set_{what}")(number)

    def _spread(self, what: str, numbers: ArrayLike, rows: Sequence[int]) -> Iterable[tuple[int, NDArray[np.float32]]]:
        return zip(rows, spread_joint_values(numbers, [self._dofs[row] for row in rows], self.dof, what), strict=True)

    def _find_movable(self, scene_idxs: Sequence[int] | None) -> tuple[list[Any], Sequence[int]]:
        objs, rows = self.objs, self._rows(scene_idxs)
        if any(root_is_fixed(self._objects.links[row]) for row in rows):
            raise TypeError(f"the root of '{self.name}' is fixed, so it has no velocity")
        return objs, rows

    def _check_there(self, rows: Iterable[int] | None = None) -> None:
        self._check_open()
        chosen = range(len(self._objects.objs)) if rows is None else rows
        gone = [self.scene_idxs[row] for row in chosen if not self._objects.in_scene(row)]
        if gone:
            where = "" if len(gone) == len(self) else f" in scene {gone[0]}"
            raise RuntimeError(f"'{self.name}' is removed{where}, so the engine has no values for its joints")

    def _close(self) -> None:
        super()._close()
        self.__dict__.pop("_link_rows", None)
        self._objects = replace(self._objects, objs=[], entities=[], links=[])


def _index_by_name(rows: list[list[Any]]) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for number, row in enumerate(rows):
        for each in row:
            if name := each.get_name():
                found.setdefault(name, [None] * len(rows))[number] = each
    return found
