"""Whether a saved state is one of these bodies, before any of them moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.backends.sapien.bodies import Articulations, Bodies, can_move
from scenecc.backends.sapien.rows import UNIT_TOLERANCE
from scenecc.backends.sapien.state import ArticulationState, EntityState

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.state import AnyState, SceneState

_OF_ROOTS = ("pose", "linear_velocity", "angular_velocity")
_OF_JOINTS = ("qpos", "qvel", "qf", "drive_target", "drive_velocity_target")
_WIDTHS = {"pose": 7, "linear_velocity": 3, "angular_velocity": 3, "kinematic_target": 7}


def fitting(
    state: SceneState, bodies: Mapping[str, Bodies | Articulations], scene_idxs: Sequence[int]
) -> dict[str, AnyState]:
    """The part of a state that is in some scenes.

    Raises:
        ValueError: the state has not these scenes, entities or kinds of bodies, or holds what the engine cannot.
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
        if isinstance(there, ArticulationState) and isinstance(here, Articulations):
            _check_shapes(name, there, here.dof)
            found[name] = part = there.rows([row_of[index] for index in saved])
            _check_numbers(name, part, here)
        elif isinstance(there, EntityState) and isinstance(here, Bodies):
            _check(name, there)
            found[name] = part = there.rows([row_of[index] for index in saved])
            _check_kinds(name, part, here)
        else:
            kinds = ("a body", "an articulation") if isinstance(here, Articulations) else ("an articulation", "a body")
            message = f"the state is of another plan: '{name}' is {kinds[0]} there, and {kinds[1]} here"
            raise ValueError(message)  # noqa: TRY004 - it is not the argument's type that is wrong
    return found


def _check_shapes(name: str, state: ArticulationState, dof: int) -> None:
    count = len(state.scene_idxs)
    widths = {field: _WIDTHS[field] for field in _OF_ROOTS} | dict.fromkeys(_OF_JOINTS, dof)
    for field, width in widths.items():
        if getattr(state, field).shape != (count, width):
            raise ValueError(f"{field} of '{name}' must be ({count}, {width}), not {getattr(state, field).shape}")
    if state.asleep.shape != (count,):
        raise ValueError(f"asleep of '{name}' must be ({count},), not {state.asleep.shape}")


def _check_numbers(name: str, state: ArticulationState, held: Articulations) -> None:
    dofs = np.array([len(held.joints[held.row_of[index]]) for index in state.scene_idxs])
    present = np.arange(held.dof) < dofs[:, None]
    for field in (*_OF_ROOTS, *_OF_JOINTS):
        numbers = getattr(state, field)
        if not np.isfinite(numbers[present] if field in _OF_JOINTS else numbers).all():
            raise ValueError(f"{field} of '{name}' must be finite")
    _check_lengths(name, state.pose)


def _check_lengths(name: str, pose: NDArray[np.float32]) -> None:
    lengths = np.linalg.norm(pose[:, 3:].astype(np.float64), axis=1)
    if (np.abs(lengths - 1) > UNIT_TOLERANCE).any():
        raise ValueError(f"the quaternions of '{name}' must be of unit length")


def _check(name: str, state: EntityState) -> None:
    count = len(state.scene_idxs)
    for field, width in _WIDTHS.items():
        if getattr(state, field).shape != (count, width):
            raise ValueError(f"{field} of '{name}' must be ({count}, {width}), not {getattr(state, field).shape}")
    for field in ("dynamic", "asleep"):
        if getattr(state, field).shape != (count,):
            raise ValueError(f"{field} of '{name}' must be ({count},), not {getattr(state, field).shape}")
    for field in ("pose", "linear_velocity", "angular_velocity"):
        if not np.isfinite(getattr(state, field)).all():
            raise ValueError(f"{field} of '{name}' must be finite")
    _check_lengths(name, state.pose)


def _check_kinds(name: str, state: EntityState, bodies: Bodies) -> None:
    for index, dynamic in zip(state.scene_idxs, state.dynamic.tolist(), strict=True):
        if dynamic != can_move(bodies.components[bodies.row_of[index]]):
            kinds = ("dynamic", "not dynamic") if dynamic else ("not dynamic", "dynamic")
            raise ValueError(f"the state has '{name}' {kinds[0]} in scene {index}, where it is {kinds[1]} here")
