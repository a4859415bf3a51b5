"""Sets where objects of a `ManiSkillScene` are: on the CPU on the engine's objects, on a GPU in ManiSkill's buffers.

ManiSkill's setters handle one environment on the CPU and those that are being reset on a GPU. ManiSkill hands what the
buffers hold to the simulation at the end of a reset.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from scenecc.backends.maniskill.theirs import Pose, torch
from scenecc.backends.sapien.bodies import Articulations, can_move, root_is_fixed
from scenecc.backends.sapien.columns import poses
from scenecc.backends.sapien.place_articulation import ArticulationPlacement
from scenecc.backends.sapien.state import ArticulationState

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from scenecc.backends.sapien.bodies import Bodies
    from scenecc.backends.sapien.state import AnyState, EntityState


def set_on_cpu(held: Bodies | Articulations, state: AnyState) -> None:
    """Puts an entity where its state says, in the scenes that the state is of. What is static stays."""
    if isinstance(held, Articulations):
        assert isinstance(state, ArticulationState)
        placement = ArticulationPlacement(held, state)
        for index in state.scene_idxs:
            placement.settle(index)
        return
    assert not isinstance(state, ArticulationState)
    where = poses(state.pose)
    for number, row in enumerate(held.rows_in(state.scene_idxs)):
        component = held.components[row]
        if not _moves(component):
            continue
        held.objs[row].set_pose(where[number])
        if can_move(component):
            component.set_linear_velocity(state.linear_velocity[number])
            component.set_angular_velocity(state.angular_velocity[number])


def set_on_gpu(objects: Sequence[Any], held: Bodies | Articulations, state: AnyState) -> None:
    """The same in ManiSkill's buffers, by the setters of `Actor`s or `Articulation`s.

    Args:
        objects: those of ManiSkill that have the entity's bodies, in scene order.
        held: the engine's.
        state: of the environments that ManiSkill's setters reach now.
    """
    if not isinstance(state, ArticulationState):
        _set_actor(objects[0], state)
        return
    assert isinstance(held, Articulations)
    for each in objects:
        own = set(each._scene_idxs.tolist())  # noqa: SLF001
        rows = [row for row, index in enumerate(state.scene_idxs) if index in own]
        if rows:
            _set_articulation(each, state.rows(rows), fixed=root_is_fixed(held.links[held.row_of[min(own)]]))


@contextmanager
def only(scene: Any, chosen: Sequence[int]) -> Generator[None]:
    """Lets ManiSkill's setters reach some environments alone, as while these are reset."""
    before = scene._reset_mask  # noqa: SLF001
    mask = torch.zeros_like(before)
    mask[list(chosen)] = True
    scene._reset_mask = mask  # noqa: SLF001
    try:
        yield
    finally:
        scene._reset_mask = before  # noqa: SLF001


def _set_actor(actor: Any, state: EntityState) -> None:
    if actor.px_body_type == "static":
        return
    actor.set_pose(Pose.create(torch.from_numpy(state.pose), device=actor.device))
    if actor.px_body_type == "dynamic":
        actor.set_linear_velocity(state.linear_velocity)
        actor.set_angular_velocity(state.angular_velocity)


def _set_articulation(articulation: Any, state: ArticulationState, *, fixed: bool) -> None:
    articulation.set_pose(Pose.create(torch.from_numpy(state.pose), device=articulation.device))
    dof = articulation.max_dof
    if dof:
        articulation.set_qpos(state.qpos[:, :dof])
        articulation.set_qvel(state.qvel[:, :dof])
        articulation.set_qf(state.qf[:, :dof])
        joints = articulation.active_joints
        articulation.set_joint_drive_targets(state.drive_target[:, :dof], joints)
        articulation.set_joint_drive_velocity_targets(state.drive_velocity_target[:, :dof], joints)
    if not fixed:
        articulation.set_root_linear_velocity(state.linear_velocity)
        articulation.set_root_angular_velocity(state.angular_velocity)


def _moves(component: Any) -> bool:
    return component is not None and hasattr(component, "get_kinematic")
