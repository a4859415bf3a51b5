"""Reads states from engine objects, validates saved states and restores them.

A body is restored by removing it from the simulation and adding it again, in build order. Only setting poses and
velocities would keep the engine's contact cache, with the impulses that warm-start the solver, pending forces, and
targets of kinematic bodies. Links are removed from the last to the root and added in build order. The engine then
makes the articulation again, and `qpos` can be set once all links are in. Three differences from a new scene remain:

- The engine reuses contact numbers in the order in which they were freed, and solves in that order. Bodies that touch
  nothing, or touch only the ground and each other in pairs, move bit-identically to a new scene. Three or more bodies
  that touch, and bodies with several constraints, may differ in the last bit, which grows: 17 of the 41 scenes of the
  repository do. Hence `exact`: `restore_in_new_scene` makes a simulation without such a history, so that an episode
  can be replayed from its passport.
- SAPIEN does not expose sleep timers, so an awake body gets that of a new body.
- A pose is that of the entity, while the engine keeps that of the centre of mass. Converting between the two may round
  the last bit once.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from scenecc.backends.sapien.articulation_builder import set_joint_positions
from scenecc.backends.sapien.engine import physx, sapien
from scenecc.backends.sapien.objects import (
    ArticulationObjects,
    BodyObjects,
    is_dynamic,
    is_kinematic,
    pad_rows,
    root_is_fixed,
)
from scenecc.backends.sapien.properties import to_poses
from scenecc.geometry.rotations import UNIT_TOLERANCE

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray
    from typing_extensions import Self


DOF: Final = -1
"""Width of an array with one number for each active joint."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionState:
    """State of one body or articulation, a row for each of its scenes by ascending index. Equal means bit-identical.

    Attributes:
        scene_idxs: indices among all scenes of the plan.
        pose: (B, 7) float32 of the body or of the root, p [m] then q (wxyz), in the world of the scene.
        linear_velocity, angular_velocity: (B, 3) float32 [m/s, rad/s], world frame; 0 if static, kinematic or fixed.
        WIDTHS: the arrays in order, with the numbers in a row of each; 0: one number without an axis of its own.
    """

    WIDTHS: ClassVar[Mapping[str, int]] = {"pose": 7, "linear_velocity": 3, "angular_velocity": 3}

    scene_idxs: tuple[int, ...]
    pose: NDArray[np.float32]
    linear_velocity: NDArray[np.float32]
    angular_velocity: NDArray[np.float32]

    @classmethod
    def shapes(cls, count: int, dof: int = 0) -> dict[str, tuple[int, ...]]:
        """Returns the shape of each array, by name, for `count` scenes and `dof` active joints."""
        widths = {name: dof if width == DOF else width for name, width in cls.WIDTHS.items()}
        return {name: (count, width) if cls.WIDTHS[name] else (count,) for name, width in widths.items()}

    @classmethod
    def at_rest(cls, scene_idxs: tuple[int, ...], pose: NDArray[Any], dof: int = 0) -> Self:
        """Returns the state at poses (B, 7), awake and without velocity; all joints are at 0 and have no target."""
        shapes = cls.shapes(len(scene_idxs), dof)
        found: dict[str, Any] = {
            name: np.zeros(shape, np.float32 if cls.WIDTHS[name] else np.bool_) for name, shape in shapes.items()
        }
        found["pose"][:] = pose
        return cls(scene_idxs, **found)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return NotImplemented
        pairs = ((getattr(self, name), getattr(other, name)) for name in self.WIDTHS)
        return self.scene_idxs == other.scene_idxs and all(_same_bits(a, b) for a, b in pairs)

    def __hash__(self) -> int:
        return hash((self.scene_idxs, self.pose.tobytes()))

    def rows(self, rows: Sequence[int]) -> Self:
        """Returns a copy of some rows, in the order given, which must keep the scenes ascending."""
        scene_idxs = tuple(self.scene_idxs[row] for row in rows)
        index = np.array(rows, dtype=np.intp)
        return type(self)(scene_idxs, *(getattr(self, name)[index] for name in self.WIDTHS))


@dataclass(frozen=True, slots=True, eq=False)
class EntityState(MotionState):
    """State of one entity; see `MotionState`.

    Attributes:
        kinematic_target: (B, 7) float32 target of a kinematic body for the next step; NaN without one.
        dynamic: (B,) bool, whether the body is dynamic.
        asleep: (B,) bool, whether the engine lets it sleep; only for dynamic bodies in the scene.
    """

    WIDTHS: ClassVar[Mapping[str, int]] = {**MotionState.WIDTHS, "kinematic_target": 7, "dynamic": 0, "asleep": 0}

    kinematic_target: NDArray[np.float32]
    dynamic: NDArray[np.bool_]
    asleep: NDArray[np.bool_]


JOINT_FIELDS: Final = ("qpos", "qvel", "qf", "drive_target", "drive_velocity_target")
"""Arrays of an `ArticulationState` with a column for each joint."""


@dataclass(frozen=True, slots=True, eq=False)
class ArticulationState(MotionState):
    """State of one articulation; see `MotionState`.

    Columns are its active joints, in the engine's order, as in `ArticulationBatch`. Missing joints are NaN.

    Attributes:
        qpos, qvel: (B, dof) float32 positions [m, rad] and velocities.
        qf: (B, dof) float32 forces [N, N·m] that were set on joints; they act until others are set.
        drive_target, drive_velocity_target: (B, dof) float32 targets of the drives.
        asleep: (B,) bool, whether the engine lets it sleep.
    """

    WIDTHS: ClassVar[Mapping[str, int]] = {**MotionState.WIDTHS, **dict.fromkeys(JOINT_FIELDS, DOF), "asleep": 0}

    qpos: NDArray[np.float32]
    qvel: NDArray[np.float32]
    qf: NDArray[np.float32]
    drive_target: NDArray[np.float32]
    drive_velocity_target: NDArray[np.float32]
    asleep: NDArray[np.bool_]


AnyState = EntityState | ArticulationState


@dataclass(frozen=True, slots=True, eq=False)
class DrawnFieldState:
    """The values of a drawn field in some scenes, as the engine received them. Equal means bit-identical.

    Attributes:
        scene_idxs: ascending, among all scenes of the plan.
        numbers: (B, …) float64. For a mass that scales the inertia (B, 4): mass [kg] and inertia [kg·m²].
        seen: whether only a rendering batch has it.
    """

    scene_idxs: tuple[int, ...]
    numbers: NDArray[np.float64]
    seen: bool = False

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, DrawnFieldState):
            return NotImplemented
        return self.scene_idxs == other.scene_idxs and _same_bits(self.numbers, other.numbers)

    def __hash__(self) -> int:
        return hash((self.scene_idxs, self.numbers.tobytes()))


@dataclass(frozen=True, slots=True)
class SceneState:
    """The result of `SceneBatch.state`, for `SceneBatch.set_state`. It can be pickled, compared and inspected.

    Attributes:
        scene_idxs: the requested scenes, ascending, as indices among all scenes of the plan.
        entities: name → state of every body in one of these scenes, including removed ones, in the plan's order.
        articulations: the same for articulations.
        drawn: everything else that a reset redraws, by holder and field: "cube.mass".
    """

    scene_idxs: tuple[int, ...]
    entities: dict[str, EntityState]
    articulations: dict[str, ArticulationState] = field(default_factory=dict[str, ArticulationState])
    drawn: dict[str, DrawnFieldState] = field(default_factory=dict[str, DrawnFieldState])

    @staticmethod
    def of(
        scene_idxs: tuple[int, ...], states: Mapping[str, AnyState], drawn: dict[str, DrawnFieldState]
    ) -> SceneState:
        """Makes a state from those of bodies and articulations in at least one of the scenes."""
        there = [(name, state) for name, state in states.items() if state.scene_idxs]
        entities = {name: state for name, state in there if isinstance(state, EntityState)}
        articulations = {name: state for name, state in there if isinstance(state, ArticulationState)}
        return SceneState(scene_idxs, entities, articulations, drawn)

    @property
    def all(self) -> dict[str, AnyState]:
        """Returns entities and articulations by name."""
        return {**self.entities, **self.articulations}


def bodies_at_rest(scene_idxs: tuple[int, ...], pose: NDArray[Any], dynamic: NDArray[np.bool_]) -> EntityState:
    """Returns the state of awake bodies at poses (B, 7), without velocity."""
    found = EntityState.at_rest(scene_idxs, pose)
    found.kinematic_target[:] = np.nan
    found.dynamic[:] = dynamic
    return found


def _same_bits(a: NDArray[Any], b: NDArray[Any]) -> bool:
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()


def read_articulations(objects: ArticulationObjects, scene_idxs: Iterable[int]) -> ArticulationState:
    """Returns the state of an articulation in the given scenes that have it.

    Raises:
        RuntimeError: it is not in a scene, where the engine has no articulation.
    """
    rows = objects.rows_in(scene_idxs)
    objs, joints = [objects.objs[row] for row in rows], [objects.joints[row] for row in rows]
    roots = [objects.links[row][0] for row in rows]
    dof = objects.dof

    def root(name: str, width: int) -> Any:
        return np.array([getattr(obj, name) for obj in objs], np.float32).reshape(-1, width)

    def numbers(name: str) -> Any:
        return pad_rows([getattr(obj, name) for obj in objs], dof)

    def targets(name: str) -> Any:
        return pad_rows([np.array([getattr(joint, name)[0] for joint in row], np.float32) for row in joints], dof)

    return ArticulationState(
        tuple(objects.scene_idxs[row] for row in rows),
        np.array([obj.get_root_pose().__getstate__() for obj in objs], np.float32).reshape(-1, 7),
        root("root_linear_velocity", 3),
        root("root_angular_velocity", 3),
        numbers("qpos"),
        numbers("qvel"),
        numbers("qf"),
        targets("drive_target"),
        targets("drive_velocity_target"),
        np.array([link.sleeping for link in roots], np.bool_),
    )


class StateWriter(ABC):
    """Writes the state of one entity in some scenes. Everything is looked up before anything moves."""

    def __init__(self, objects: BodyObjects | ArticulationObjects, state: MotionState) -> None:
        self._parts = objects.parts
        self._rows = objects.row_of
        self._row_of = {index: row for row, index in enumerate(state.scene_idxs)}
        self._poses = to_poses(state.pose)

    def take_out(self, scene: int) -> None:
        """Removes the entity from the simulation of a scene."""
        row = self._row_in(scene)
        if row is not None:
            for entity, component in reversed(self._parts(row)):
                entity.remove_component(component)

    def put_in(self, scene: int) -> None:
        """Adds the entity to the simulation again."""
        row = self._row_in(scene)
        if row is not None:
            for entity, component in self._parts(row):
                entity.add_component(component)

    @abstractmethod
    def move(self, scene: int) -> None:
        """Sets what can be set while the entity is out of the simulation."""

    @abstractmethod
    def settle(self, scene: int) -> None:
        """Sets what can only be set once the entity is in the simulation again."""

    def _row_in(self, scene: int) -> int | None:
        """Returns the row of this scene, or None if the entity is not in it."""
        return self._rows.get(scene)


class ArticulationStateWriter(StateWriter):
    """Writes the state of one entity's articulations."""

    def __init__(self, objects: ArticulationObjects, state: ArticulationState) -> None:
        super().__init__(objects, state)
        self._objects = objects
        self._state = state

    def move(self, scene: int) -> None:
        """Sets the pose of the root. Outside the simulation there are no joints."""
        row = self._row_in(scene)
        if row is not None:
            self._objects.entities[row][0].set_pose(self._poses[self._row_of[scene]])

    def settle(self, scene: int) -> None:
        """Sets root velocities, joint states, drive targets and the sleep state."""
        row = self._row_in(scene)
        if row is None:
            return
        number, state = self._row_of[scene], self._state
        obj, joints = self._objects.objs[row], self._objects.joints[row]
        dof = len(joints)
        obj.set_root_pose(self._poses[number])
        if not root_is_fixed(self._objects.links[row]):
            obj.set_root_linear_velocity(state.linear_velocity[number])
            obj.set_root_angular_velocity(state.angular_velocity[number])
        set_joint_positions(obj, state.qpos[number, :dof])
        if dof:
            obj.set_qvel(state.qvel[number, :dof])
            # Also if it is 0: an articulation that only moved to another scene still has its old one.
            obj.set_qf(state.qf[number, :dof])
        numbers = zip(state.drive_target[number].tolist(), state.drive_velocity_target[number].tolist(), strict=True)
        for joint, (target, velocity) in zip(joints, numbers, strict=False):
            joint.set_drive_target(target)
            joint.set_drive_velocity_target(velocity)
        if state.asleep[number]:
            self._objects.links[row][0].put_to_sleep()
        else:
            self._objects.links[row][0].wake_up()

    def _row_in(self, scene: int) -> int | None:
        """Returns the row of this scene if the articulation is in it now. A removed one gets its state later."""
        row = super()._row_in(scene)
        return row if row is not None and scene in self._row_of and self._objects.in_scene(row) else None


def read_bodies(bodies: BodyObjects, scene_idxs: Iterable[int]) -> EntityState:
    """Returns the state of an entity in the given scenes that have it."""
    rows = bodies.rows_in(scene_idxs)
    objs, components = [bodies.objs[row] for row in rows], [bodies.components[row] for row in rows]
    pose = np.array([obj.get_pose().__getstate__() for obj in objs], np.float32).reshape(-1, 7)
    dynamic = np.array([is_dynamic(component) for component in components], np.bool_)
    state = bodies_at_rest(tuple(bodies.scene_idxs[row] for row in rows), pose, dynamic)
    for number in np.flatnonzero(dynamic).tolist():
        component = components[number]
        state.linear_velocity[number] = component.get_linear_velocity()
        state.angular_velocity[number] = component.get_angular_velocity()
        # Outside a scene the engine reports everything as asleep.
        state.asleep[number] = objs[number].get_scene() is not None and component.is_sleeping
    for number in np.flatnonzero(~dynamic).tolist():
        if is_kinematic(components[number]):
            state.kinematic_target[number] = _kinematic_target(components[number])
    return state


def _kinematic_target(component: Any) -> Sequence[float]:
    try:
        return component.get_kinematic_target().__getstate__()
    except RuntimeError:  # there is no target
        return (np.nan,) * 7


class BodyStateWriter(StateWriter):
    """Writes the state of one entity's bodies."""

    def __init__(self, bodies: BodyObjects, state: EntityState) -> None:
        super().__init__(bodies, state)
        self._bodies = bodies
        self._linear = list(state.linear_velocity)
        self._angular = list(state.angular_velocity)
        components = [bodies.components[bodies.row_of[index]] for index in state.scene_idxs]
        self._dynamic = list(map(is_dynamic, components))
        self._asleep: list[bool] = (state.asleep & self._dynamic).tolist()
        aims = np.isfinite(state.kinematic_target).all(axis=1)
        self._targets = dict(zip(np.flatnonzero(aims).tolist(), to_poses(state.kinematic_target[aims]), strict=True))

    def move(self, scene: int) -> None:
        """Sets pose and velocities while the body is out of the simulation."""
        own = self._bodies.row_of.get(scene)
        if own is None:
            return
        row, component = self._row_of[scene], self._bodies.components[own]
        self._bodies.objs[own].set_pose(self._poses[row])
        if self._dynamic[row]:
            component.set_linear_velocity(self._linear[row])
            component.set_angular_velocity(self._angular[row])

    def settle(self, scene: int) -> None:
        """Sets the sleep state or the kinematic target of the body in the simulation."""
        own = self._bodies.row_of.get(scene)
        # Outside a scene a body has no sleep state, and the engine crashes when asked for it.
        if own is None or self._bodies.objs[own].get_scene() is None:
            return
        row, component = self._row_of[scene], self._bodies.components[own]
        if self._asleep[row]:
            component.put_to_sleep()
        elif self._dynamic[row]:
            component.wake_up()  # also resets its sleep timer to that of a new body
        elif row in self._targets:
            component.set_kinematic_target(self._targets[row])


def make_state_writer(objects: BodyObjects | ArticulationObjects, state: AnyState) -> StateWriter:
    """Returns the writer for the kind of the entity; the state must be of the same kind."""
    if isinstance(objects, ArticulationObjects):
        assert isinstance(state, ArticulationState)
        return ArticulationStateWriter(objects, state)
    assert isinstance(state, EntityState)
    return BodyStateWriter(objects, state)


def restore_scene(writers: Sequence[StateWriter], scene: int) -> None:
    """Restores the states of a scene's bodies. `writers` must be in build order."""
    for writer in reversed(writers):
        writer.take_out(scene)
    for writer in writers:
        writer.move(scene)
        writer.put_in(scene)
        writer.settle(scene)


def restore_in_new_scene(writers: Sequence[StateWriter], scene: int, old: Any) -> Any:
    """Restores states in a new scene without a simulation history. All objects of the old scene move to it."""
    new: Any = sapien.Scene(_copy_systems(old))
    new.set_timestep(old.get_timestep())
    entities = old.entities
    for entity in entities:
        old.remove_entity(entity)
    for writer in writers:
        writer.move(scene)
    for entity in entities:
        new.add_entity(entity)
    for writer in writers:
        writer.settle(scene)
    return new


def _copy_systems(scene: Any) -> list[Any]:
    """Returns a new physics system with the scene's settings, and the scene's render system."""
    present = physx.get_scene_config()
    physx.set_scene_config(scene.physx_system.config)
    try:
        systems = [physx.PhysxCpuSystem()]
    finally:
        physx.set_scene_config(present)
    with suppress(RuntimeError):  # there is no render system
        systems.append(scene.render_system)
    return systems


def read_state(
    objects: BodyObjects | ArticulationObjects, removed: RemovedArticulation | None, scene_idxs: Iterable[int]
) -> AnyState:
    """Returns the current state of an entity in these scenes, or its state when it was removed."""
    if isinstance(objects, BodyObjects):
        return read_bodies(objects, scene_idxs)
    if removed is not None:
        return removed.state.rows(objects.rows_in(scene_idxs))
    return read_articulations(objects, scene_idxs)


class RemovedArticulation:
    """The state of a removed articulation: as it was when removed, or as set since.

    Attributes:
        state: of all its scenes.
    """

    def __init__(self, state: ArticulationState) -> None:
        self.state = state
        self._changed: set[int] = set()

    def change(self, state: AnyState) -> None:
        """Changes the state in some scenes. The articulation gets it when it is added again."""
        rows = np.searchsorted(self.state.scene_idxs, state.scene_idxs)
        for name in self.state.WIDTHS:
            numbers: Any = getattr(self.state, name)
            numbers[rows] = getattr(state, name)
        self._changed.update(state.scene_idxs)

    def put_back(self, objects: ArticulationObjects) -> None:
        """Restores the state. Call it once the entities are in their scenes, where the engine restores its values."""
        if self._changed:
            writer = ArticulationStateWriter(objects, self.state)
            for index in self._changed:
                writer.settle(index)


def validate_state(
    state: SceneState, bodies: Mapping[str, BodyObjects | ArticulationObjects], scene_idxs: Sequence[int]
) -> dict[str, AnyState]:
    """Returns the part of a state that is in some scenes.

    Raises:
        ValueError: the state lacks these scenes, entities or kinds of bodies, or has values that the engine cannot
            hold.
    """
    if missing := [index for index in scene_idxs if index not in state.scene_idxs]:
        raise ValueError(f"the state has no scene {missing[0]}; it has {list(state.scene_idxs)}")
    chosen = sorted(scene_idxs)
    found: dict[str, AnyState] = {}
    states = state.all
    for name in {**bodies, **states}:
        there, here = states.get(name), bodies.get(name)
        row_of = {} if there is None else {index: row for row, index in enumerate(there.scene_idxs)}
        saved = [index for index in chosen if index in row_of]
        present = [] if here is None else [index for index in chosen if index in here.row_of]
        if saved != present:
            raise ValueError(
                f"the state is of another plan: '{name}' is in the scenes {saved or 'none'} there, and in "
                f"{present or 'none'} here"
            )
        if there is None or here is None or not saved:
            continue
        if isinstance(there, ArticulationState) and isinstance(here, ArticulationObjects):
            _check_shapes(name, there, here.dof)
            found[name] = part = there.rows([row_of[index] for index in saved])
            _check_values(name, part, _present_joints(here, part.scene_idxs))
        elif isinstance(there, EntityState) and isinstance(here, BodyObjects):
            _check_shapes(name, there)
            _check_values(name, there)
            found[name] = part = there.rows([row_of[index] for index in saved])
            _check_body_types(name, part, here)
        else:
            kinds = (
                ("a body", "an articulation")
                if isinstance(here, ArticulationObjects)
                else ("an articulation", "a body")
            )
            message = f"the state is of another plan: '{name}' is {kinds[0]} there, and {kinds[1]} here"
            raise ValueError(message)  # noqa: TRY004 - it is not the argument's type that is wrong
    return found


def _check_shapes(name: str, state: MotionState, dof: int = 0) -> None:
    for attribute, wanted in state.shapes(len(state.scene_idxs), dof).items():
        if (found := getattr(state, attribute).shape) != wanted:
            raise ValueError(f"{attribute} of '{name}' must be {wanted}, not {found}")


def _check_values(name: str, state: MotionState, present: NDArray[np.bool_] | None = None) -> None:
    """Checks the arrays of a state. `present` marks the joints to check, a row for each scene."""
    for attribute in MotionState.WIDTHS:
        _check_finite(name, attribute, getattr(state, attribute))
    for attribute in () if present is None else JOINT_FIELDS:
        _check_finite(name, attribute, getattr(state, attribute)[present])
    lengths = np.linalg.norm(state.pose[:, 3:].astype(np.float64), axis=1)
    if (np.abs(lengths - 1) > UNIT_TOLERANCE).any():
        raise ValueError(f"the quaternions of '{name}' must be of unit length")


def _check_finite(name: str, field: str, numbers: NDArray[np.float32]) -> None:
    if not np.isfinite(numbers).all():
        raise ValueError(f"{field} of '{name}' must be finite")


def _present_joints(objects: ArticulationObjects, scene_idxs: Sequence[int]) -> NDArray[np.bool_]:
    """Returns which columns are joints of each scene's articulation, (B, dof)."""
    dofs = np.array([len(objects.joints[objects.row_of[index]]) for index in scene_idxs])
    return np.arange(objects.dof) < dofs[:, None]


def _check_body_types(name: str, state: EntityState, bodies: BodyObjects) -> None:
    for index, dynamic in zip(state.scene_idxs, state.dynamic.tolist(), strict=True):
        if dynamic != is_dynamic(bodies.components[bodies.row_of[index]]):
            kinds = ("dynamic", "not dynamic") if dynamic else ("not dynamic", "dynamic")
            raise ValueError(f"the state has '{name}' {kinds[0]} in scene {index}, where it is {kinds[1]} here")
