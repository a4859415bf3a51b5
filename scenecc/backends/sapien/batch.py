"""Live scenes and their entities, as a user handles them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.engine import physx, sapien
from scenecc.backends.sapien.rows import pose_rows, vector_rows
from scenecc.backends.sapien.selected import scene_indices

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import TracebackType

    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import Self

    from scenecc.plan import ScenePlan


class EntityBatch:
    """One entity of the plan, in every scene that has it.

    Rows of every array are its scenes by ascending index. Poses are p [m] then q (wxyz), in the world
    of their scene; velocities are in the world frame.
    """

    def __init__(self, name: str, scene_idxs: tuple[int, ...], objs: list[Any], components: list[Any]) -> None:
        self._name = name
        self._scene_idxs = scene_idxs
        self._objs = objs
        self._components = components
        self._row_of = {index: row for row, index in enumerate(scene_idxs)}
        self._closed = False

    def __len__(self) -> int:
        return len(self._scene_idxs)

    def __repr__(self) -> str:
        return f"EntityBatch({self._name!r}, scene_idxs={list(self._scene_idxs)})"

    @property
    def name(self) -> str:
        """Its name in the plan; every `sapien.Entity` has the same."""
        return self._name

    @property
    def objs(self) -> list[sapien.Entity]:
        """The `sapien.Entity` of each scene. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return self._objs

    @property
    def scene_idxs(self) -> tuple[int, ...]:
        """Indices among all scenes of the plan: those of this batch that have the entity."""
        return self._scene_idxs

    @property
    def pose(self) -> NDArray[np.float32]:
        """(B, 7) float32. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return np.array([entity.get_pose().__getstate__() for entity in self._objs], dtype=np.float32)

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
            self._objs[row].set_pose(new)

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
        if scene_idxs is None:
            return range(len(self._objs))
        asked = scene_indices(scene_idxs)
        missing = [index for index in asked if index not in self._row_of]
        if missing:
            raise KeyError(
                f"'{self._name}' is not in scene {missing[0]} of this batch; it is in {list(self._scene_idxs)}"
            )
        return [self._row_of[index] for index in asked]

    def _moving(self, what: str) -> list[Any]:
        self._check_open()
        for component in self._components:
            if not isinstance(component, physx.PhysxRigidDynamicComponent):
                kind = "has no physics" if component is None else "is static"
                raise TypeError(f"'{self._name}' {kind}: it has no {what}")
        return self._components

    def _driven(self) -> list[Any]:
        components = self._moving("velocity")
        if any(component.get_kinematic() for component in components):
            raise TypeError(f"'{self._name}' is kinematic: the engine moves it by its pose, and ignores a velocity")
        return components

    def _check_open(self) -> None:
        if self._closed:
            raise RuntimeError(f"the scenes of '{self._name}' are closed")

    def _close(self) -> None:
        self._closed = True
        self._objs, self._components = [], []


class SceneBatch:
    """Parallel scenes, built from one plan.

    Use it as a context manager, or call `close`, to free the engine's objects at a known time.
    """

    def __init__(
        self,
        plan: ScenePlan,
        scene_idxs: tuple[int, ...],
        scenes: list[Any],
        entities: dict[str, EntityBatch],
        *,
        render: bool,
    ) -> None:
        self._plan = plan
        self._scene_idxs = scene_idxs
        self._scenes = scenes
        self._entities = entities
        self._render = render
        self._steps = [scene.physx_system.step for scene in scenes]
        self._scene_of = dict(zip(scene_idxs, scenes, strict=True))
        self._removed: dict[str, EntityBatch] = {}
        self._closed = False

    def __len__(self) -> int:
        return len(self._scene_idxs)

    def __repr__(self) -> str:
        state = "closed" if self._closed else f"{len(self._entities)} entities"
        return f"SceneBatch({self._plan.name!r}, {len(self)} scenes, {state})"

    def __enter__(self) -> Self:
        self._check_open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def plan(self) -> ScenePlan:
        """What it was built from."""
        return self._plan

    @property
    def scene_idxs(self) -> tuple[int, ...]:
        """Which of the plan's scenes were instantiated, ascending; `scenes` follows this order."""
        return self._scene_idxs

    @property
    def render(self) -> bool:
        """Whether visuals were built."""
        return self._render

    @property
    def scenes(self) -> list[sapien.Scene]:
        """The scenes. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return self._scenes

    @property
    def entities(self) -> dict[str, EntityBatch]:
        """Entities that are in the scenes now, by name, in build order. Raises RuntimeError once closed."""
        self._check_open()
        return self._entities

    @property
    def timestep(self) -> float:
        """Length of one step [s], as the engine holds it. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return self._scenes[0].timestep

    def step(self, n: int = 1) -> None:
        """Simulates `n` time steps in every scene. Raises ValueError if negative, RuntimeError once closed."""
        self._check_open()
        if n < 0:
            raise ValueError(f"n must not be negative, not {n}")
        for step in self._steps:
            for _ in range(n):
                step()

    def remove(self, name: str) -> None:
        """Takes an entity out of every scene; `add` puts it back.

        Raises:
            KeyError: the plan has no such entity here.
            ValueError: it is removed already.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        if name in self._removed:
            raise ValueError(f"'{name}' is removed already")
        entity = self._known(name)
        for index, obj in zip(entity.scene_idxs, entity.objs, strict=True):
            self._scene_of[index].remove_entity(obj)
        self._removed[name] = self._entities.pop(name)

    def add(self, name: str) -> None:
        """Puts a removed entity back as it was when it was removed: same objects, poses and velocities.

        It is the last in the build order from then on, in the engine and in `entities`.

        Raises:
            KeyError: the plan has no such entity here.
            ValueError: it is there.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        if name not in self._removed:
            self._known(name)
            raise ValueError(f"'{name}' is there; only what was removed can be added")
        entity = self._removed.pop(name)
        for index, obj in zip(entity.scene_idxs, entity.objs, strict=True):
            self._scene_of[index].add_entity(obj)
        self._entities[name] = entity

    def close(self) -> None:
        """Empties every scene and lets go of it. Closing twice is allowed."""
        if self._closed:
            return
        self._closed = True
        for entity in (*self._entities.values(), *self._removed.values()):
            entity._close()  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]
        for scene in self._scenes:
            scene.clear()
        self._steps = []
        self._scenes, self._scene_of = [], {}
        self._entities, self._removed = {}, {}

    def _known(self, name: str) -> EntityBatch:
        if name not in self._entities:
            raise KeyError(f"no entity '{name}'; there are {', '.join(sorted(self._entities)) or 'none'}")
        return self._entities[name]

    def _check_open(self) -> None:
        if self._closed:
            raise RuntimeError("the batch is closed")
