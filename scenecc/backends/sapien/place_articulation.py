"""Puts articulations where a state says, as `place` does bodies, between which they stand.

Links are taken out of the engine's simulation from the last to the root and put in again in build order; the engine
makes the articulation anew then, with its joints, drives and tendons, and without forces on joints. Where its joints
are it lets nobody say until all links are in.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.articulation_builder import place as place_joints
from scenecc.backends.sapien.bodies import root_is_fixed
from scenecc.backends.sapien.columns import poses
from scenecc.backends.sapien.rows import padded
from scenecc.backends.sapien.state import ArticulationState

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.backends.sapien.bodies import Articulations


def read_articulations(held: Articulations, scene_idxs: Iterable[int]) -> ArticulationState:
    """The state of an articulation in those of the scenes that have it.

    Raises:
        RuntimeError: the engine knows none of an articulation that is not in a scene.
    """
    rows = held.rows_in(scene_idxs)
    objs, joints = [held.objs[row] for row in rows], [held.joints[row] for row in rows]
    roots = [held.links[row][0] for row in rows]
    dof = held.dof

    def root(name: str, width: int) -> Any:
        return np.array([getattr(obj, name) for obj in objs], np.float32).reshape(-1, width)

    def numbers(name: str) -> Any:
        return padded([getattr(obj, name) for obj in objs], dof)

    def targets(name: str) -> Any:
        return padded([np.array([getattr(joint, name)[0] for joint in row], np.float32) for row in joints], dof)

    return ArticulationState(
        tuple(held.scene_idxs[row] for row in rows),
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


class ArticulationPlacement:
    """One entity's articulations with the state that they are to have, as `Placement` of bodies."""

    def __init__(self, held: Articulations, state: ArticulationState) -> None:
        self._held = held
        self._state = state
        self._row_of = {index: row for row, index in enumerate(state.scene_idxs)}
        self._poses = poses(state.pose)

    def take_out(self, scene: int) -> None:
        """Takes the articulation out of the simulation of a scene."""
        row = self._own(scene)
        if row is not None:
            for entity, link in zip(reversed(self._held.entities[row]), reversed(self._held.links[row]), strict=True):
                entity.remove_component(link)

    def move(self, scene: int) -> None:
        """Sets where the root is; outside of the simulation there are no joints."""
        row = self._own(scene)
        if row is not None:
            self._held.entities[row][0].set_pose(self._poses[self._row_of[scene]])

    def put_in(self, scene: int) -> None:
        """Puts the articulation into the simulation again."""
        row = self._own(scene)
        if row is not None:
            for entity, link in zip(self._held.entities[row], self._held.links[row], strict=True):
                entity.add_component(link)

    def settle(self, scene: int) -> None:
        """Sets where the joints are, how all moves, and what pulls; and lets it rest or wakes it."""
        row = self._own(scene)
        if row is None:
            return
        number, state = self._row_of[scene], self._state
        obj, joints = self._held.objs[row], self._held.joints[row]
        dof = len(joints)
        obj.set_root_pose(self._poses[number])
        if not root_is_fixed(self._held.links[row]):
            obj.set_root_linear_velocity(state.linear_velocity[number])
            obj.set_root_angular_velocity(state.angular_velocity[number])
        place_joints(obj, state.qpos[number, :dof])
        if dof:
            obj.set_qvel(state.qvel[number, :dof])
            # Also where it is 0, for nothing has taken it off an articulation that only moved to another scene.
            obj.set_qf(state.qf[number, :dof])
        numbers = zip(state.drive_target[number].tolist(), state.drive_velocity_target[number].tolist(), strict=True)
        for joint, (target, velocity) in zip(joints, numbers, strict=False):
            joint.set_drive_target(target)
            joint.set_drive_velocity_target(velocity)
        if state.asleep[number]:
            self._held.links[row][0].put_to_sleep()
        else:
            self._held.links[row][0].wake_up()

    def _own(self, scene: int) -> int | None:
        """Its row, if it is in this scene now. One that was removed has its state when it is added again."""
        row = self._held.row_of.get(scene)
        return row if row is not None and scene in self._row_of and self._held.in_scene(row) else None
