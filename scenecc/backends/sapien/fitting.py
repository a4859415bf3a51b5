"""Whether a saved state is one of these bodies, before any of them moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.backends.sapien.bodies import can_move
from scenecc.backends.sapien.rows import UNIT_TOLERANCE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.backends.sapien.bodies import Bodies
    from scenecc.backends.sapien.state import EntityState, SceneState

_WIDTHS = {"pose": 7, "linear_velocity": 3, "angular_velocity": 3, "kinematic_target": 7}


def fitting(state: SceneState, bodies: Mapping[str, Bodies], scene_idxs: Sequence[int]) -> dict[str, EntityState]:
    """The part of a state that is in some scenes.

    Raises:
        ValueError: the state has not these scenes, entities or kinds of bodies, or holds what the engine cannot.
    """
    if missing := [index for index in scene_idxs if index not in state.scene_idxs]:
        raise ValueError(f"the state has no scene {missing[0]}; it has {list(state.scene_idxs)}")
    chosen = sorted(scene_idxs)
    found: dict[str, EntityState] = {}
    for name in {**bodies, **state.entities}:
        there, here = state.entities.get(name), bodies.get(name)
        row_of = {} if there is None else {index: row for row, index in enumerate(there.scene_idxs)}
        saved = [index for index in chosen if index in row_of]
        present = [] if here is None else [index for index in chosen if index in here.row_of]
        if saved != present:
            raise ValueError(
                f"the state is of another plan: '{name}' is in the scenes {saved or 'none'} there, and in "
                f"{present or 'none'} here"
            )
        if there is not None and here is not None and saved:
            _check(name, there)
            found[name] = there.rows([row_of[index] for index in saved])
            _check_kinds(name, found[name], here)
    return found


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
    lengths = np.linalg.norm(state.pose[:, 3:].astype(np.float64), axis=1)
    if (np.abs(lengths - 1) > UNIT_TOLERANCE).any():
        raise ValueError(f"the quaternions of '{name}' must be of unit length")


def _check_kinds(name: str, state: EntityState, bodies: Bodies) -> None:
    for index, dynamic in zip(state.scene_idxs, state.dynamic.tolist(), strict=True):
        if dynamic != can_move(bodies.components[bodies.row_of[index]]):
            kinds = ("dynamic", "not dynamic") if dynamic else ("not dynamic", "dynamic")
            raise ValueError(f"the state has '{name}' {kinds[0]} in scene {index}, where it is {kinds[1]} here")
