"""Where the bodies of a batch are and how they move, as plain data. Imports no engine."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

_BODY_FIELDS = ("pose", "linear_velocity", "angular_velocity", "kinematic_target", "dynamic", "asleep")


@dataclass(frozen=True, slots=True, eq=False)
class EntityState:
    """One entity, a row for each of its scenes by ascending index. Two are equal if every bit is.

    Attributes:
        scene_idxs: indices among all scenes of the plan.
        pose: (B, 7) float32, p [m] then q (wxyz), in the world of the scene.
        linear_velocity, angular_velocity: (B, 3) float32 [m/s, rad/s], world frame; 0 where it is not dynamic.
        kinematic_target: (B, 7) float32, where a kinematic body was told to go in the next step; NaN where it was not.
        dynamic: (B,) bool, whether it moves by itself.
        asleep: (B,) bool, whether the engine lets it rest; only what is dynamic and in the scene.
    """

    scene_idxs: tuple[int, ...]
    pose: NDArray[np.float32]
    linear_velocity: NDArray[np.float32]
    angular_velocity: NDArray[np.float32]
    kinematic_target: NDArray[np.float32]
    dynamic: NDArray[np.bool_]
    asleep: NDArray[np.bool_]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, EntityState):
            return NotImplemented
        pairs = ((getattr(self, name), getattr(other, name)) for name in _BODY_FIELDS)
        return self.scene_idxs == other.scene_idxs and all(_same_bits(a, b) for a, b in pairs)

    def __hash__(self) -> int:
        return hash((self.scene_idxs, self.pose.tobytes()))

    def rows(self, rows: Sequence[int]) -> EntityState:
        """A copy of some rows, in the order given, which keeps the scenes ascending."""
        scene_idxs = tuple(self.scene_idxs[row] for row in rows)
        index = np.array(rows, dtype=np.intp)
        return EntityState(scene_idxs, *(getattr(self, name)[index] for name in _BODY_FIELDS))


ARTICULATION_FIELDS = (
    "pose",
    "linear_velocity",
    "angular_velocity",
    "qpos",
    "qvel",
    "qf",
    "drive_target",
    "drive_velocity_target",
    "asleep",
)


@dataclass(frozen=True, slots=True, eq=False)
class ArticulationState:
    """One articulation, a row for each of its scenes by ascending index. Two are equal if every bit is.

    Columns are its joints that move, in the engine's order, as those of `ArticulationBatch`; NaN where it has fewer.

    Attributes:
        scene_idxs: indices among all scenes of the plan.
        pose: (B, 7) float32 of the root, p [m] then q (wxyz), in the world of the scene.
        linear_velocity, angular_velocity: (B, 3) float32 of the root [m/s, rad/s], world frame; 0 where it is fixed.
        qpos, qvel: (B, dof) float32 positions [m, rad] and velocities.
        qf: (B, dof) float32 forces [N, N·m] that were set on joints, which act until others are set.
        drive_target, drive_velocity_target: (B, dof) float32, what the drives pull to.
        asleep: (B,) bool, whether the engine lets it rest.
    """

    scene_idxs: tuple[int, ...]
    pose: NDArray[np.float32]
    linear_velocity: NDArray[np.float32]
    angular_velocity: NDArray[np.float32]
    qpos: NDArray[np.float32]
    qvel: NDArray[np.float32]
    qf: NDArray[np.float32]
    drive_target: NDArray[np.float32]
    drive_velocity_target: NDArray[np.float32]
    asleep: NDArray[np.bool_]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ArticulationState):
            return NotImplemented
        pairs = ((getattr(self, name), getattr(other, name)) for name in ARTICULATION_FIELDS)
        return self.scene_idxs == other.scene_idxs and all(_same_bits(a, b) for a, b in pairs)

    def __hash__(self) -> int:
        return hash((self.scene_idxs, self.pose.tobytes(), self.qpos.tobytes()))

    def rows(self, rows: Sequence[int]) -> ArticulationState:
        """A copy of some rows, in the order given, which keeps the scenes ascending."""
        scene_idxs = tuple(self.scene_idxs[row] for row in rows)
        index = np.array(rows, dtype=np.intp)
        return ArticulationState(scene_idxs, *(getattr(self, name)[index] for name in ARTICULATION_FIELDS))


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
    count = len(scene_idxs)
    zeros = np.zeros((2, count, 3), np.float32)
    nowhere = np.full((count, 7), np.nan, np.float32)
    return EntityState(
        scene_idxs, pose.astype(np.float32), zeros[0], zeros[1], nowhere, dynamic, np.zeros(count, np.bool_)
    )


def articulations_at_rest(scene_idxs: tuple[int, ...], pose: NDArray[Any], dof: int) -> ArticulationState:
    """Articulations whose roots are at their poses (B, 7), all of whose joints are at 0 and without a target, awake."""
    count = len(scene_idxs)
    linear, angular = np.zeros((2, count, 3), np.float32)
    qpos, qvel, qf, target, velocity_target = np.zeros((5, count, dof), np.float32)
    root = (pose.astype(np.float32), linear, angular)
    return ArticulationState(scene_idxs, *root, qpos, qvel, qf, target, velocity_target, np.zeros(count, np.bool_))


def _same_bits(a: NDArray[Any], b: NDArray[Any]) -> bool:
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()
