"""Where the bodies of a batch are and how they move, as plain data. Imports no engine."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray
    from typing_extensions import Self

DOF: Final = -1
"""In place of a width: as many numbers a row as the articulation has joints that move."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionState:
    """One body or articulation, a row for each of its scenes by ascending index. Two are equal if every bit is.

    Attributes:
        scene_idxs: indices among all scenes of the plan.
        pose: (B, 7) float32 of the body or of the root, p [m] then q (wxyz), in the world of the scene.
        linear_velocity, angular_velocity: (B, 3) float32 [m/s, rad/s], world frame; 0 where it is static, kinematic or
            fixed.
        WIDTHS: the arrays in their order, and how many numbers a row of each has; 0: one, without an axis of its own.
    """

    WIDTHS: ClassVar[Mapping[str, int]] = {"pose": 7, "linear_velocity": 3, "angular_velocity": 3}

    scene_idxs: tuple[int, ...]
    pose: NDArray[np.float32]
    linear_velocity: NDArray[np.float32]
    angular_velocity: NDArray[np.float32]

    @classmethod
    def shapes(cls, count: int, dof: int = 0) -> dict[str, tuple[int, ...]]:
        """Shapes of the arrays, by name, of `count` scenes and `dof` joints that move."""
        widths = {name: dof if width == DOF else width for name, width in cls.WIDTHS.items()}
        return {name: (count, width) if cls.WIDTHS[name] else (count,) for name, width in widths.items()}

    @classmethod
    def at_rest(cls, scene_idxs: tuple[int, ...], pose: NDArray[Any], dof: int = 0) -> Self:
        """At poses (B, 7), without velocity, awake; all joints are at 0 and without a target."""
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
        """A copy of some rows, in the order given, which keeps the scenes ascending."""
        scene_idxs = tuple(self.scene_idxs[row] for row in rows)
        index = np.array(rows, dtype=np.intp)
        return type(self)(scene_idxs, *(getattr(self, name)[index] for name in self.WIDTHS))


@dataclass(frozen=True, slots=True, eq=False)
class EntityState(MotionState):
    """One entity, with what `MotionState` has.

    Attributes:
        kinematic_target: (B, 7) float32, where a kinematic body was told to go in the next step; NaN where it was not.
        dynamic: (B,) bool, whether it moves by itself.
        asleep: (B,) bool, whether the engine lets it rest; only what is dynamic and in the scene.
    """

    WIDTHS: ClassVar[Mapping[str, int]] = {**MotionState.WIDTHS, "kinematic_target": 7, "dynamic": 0, "asleep": 0}

    kinematic_target: NDArray[np.float32]
    dynamic: NDArray[np.bool_]
    asleep: NDArray[np.bool_]


JOINT_FIELDS: Final = ("qpos", "qvel", "qf", "drive_target", "drive_velocity_target")
"""Arrays of an `ArticulationState` with a column a joint."""


@dataclass(frozen=True, slots=True, eq=False)
class ArticulationState(MotionState):
    """One articulation, with what `MotionState` has.

    Columns are its joints that move, in the engine's order, as those of `ArticulationBatch`; NaN where it has fewer.

    Attributes:
        qpos, qvel: (B, dof) float32 positions [m, rad] and velocities.
        qf: (B, dof) float32 forces [N, N·m] that were set on joints, which act until others are set.
        drive_target, drive_velocity_target: (B, dof) float32, what the drives pull to.
        asleep: (B,) bool, whether the engine lets it rest.
    """

    WIDTHS: ClassVar[Mapping[str, int]] = {**MotionState.WIDTHS, **dict.fromkeys(JOINT_FIELDS, DOF), "asleep": 0}

    qpos: NDArray[np.float32]
    qvel: NDArray[np.float32]
    qf: NDArray[np.float32]
    drive_target: NDArray[np.float32]
    drive_velocity_target: NDArray[np.float32]
    asleep: NDArray[np.bool_]


AnyState = EntityState | ArticulationState


@dataclass(frozen=True, slots=True)
class SceneState:
    """What `SceneBatch.state` gives and `SceneBatch.set_state` takes: it can be pickled, compared and looked into.

    Attributes:
        scene_idxs: the scenes that were asked for, ascending, as indices among all scenes of the plan.
        entities: name → state, of every body that is in one of these scenes, removed ones too, in the plan's order.
        articulations: the same of articulations.
    """

    scene_idxs: tuple[int, ...]
    entities: dict[str, EntityState]
    articulations: dict[str, ArticulationState] = field(default_factory=dict[str, ArticulationState])

    @staticmethod
    def of(scene_idxs: tuple[int, ...], states: Mapping[str, AnyState]) -> SceneState:
        """Both kinds, told apart, without those that are in none of the scenes."""
        there = [(name, state) for name, state in states.items() if state.scene_idxs]
        entities = {name: state for name, state in there if isinstance(state, EntityState)}
        articulations = {name: state for name, state in there if isinstance(state, ArticulationState)}
        return SceneState(scene_idxs, entities, articulations)

    @property
    def all(self) -> dict[str, AnyState]:
        """Both kinds, by name."""
        return {**self.entities, **self.articulations}


def bodies_at_rest(scene_idxs: tuple[int, ...], pose: NDArray[Any], dynamic: NDArray[np.bool_]) -> EntityState:
    """Bodies at their poses (B, 7), without velocity, awake."""
    found = EntityState.at_rest(scene_idxs, pose)
    found.kinematic_target[:] = np.nan
    found.dynamic[:] = dynamic
    return found


def _same_bits(a: NDArray[Any], b: NDArray[Any]) -> bool:
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()
