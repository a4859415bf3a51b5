"""Whether scenes depend on their neighbours: builds them in another order and size, and compares states to the bit."""

from __future__ import annotations

from contextlib import ExitStack
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.pipeline import build_batch
from scenecc.simulation.findings import Finding

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch, SceneState
    from scenecc.backends.sapien.state import AnyState
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan

SECONDS: Final = 1.0
"""Simulated time before the states are compared [s]."""

_UNITS: Final = {"linear_velocity": " m/s", "angular_velocity": " rad/s", "qpos": " m or rad", "qvel": " m/s or rad/s"}
"""Units of the arrays of a state."""


def permuted_findings(plan: ScenePlan, scene_idxs: Sequence[int], sink: Sink) -> Iterator[Finding]:
    """Yields scenes that differ from themselves in another batch, after a second of simulation.

    The scenes are built once as one batch, and once as two batches of every second scene that are in the engine
    together. The one with the later scenes is built and simulated first.

    Args:
        plan: the plan.
        scene_idxs: the scenes to compare.
        sink: collects diagnostics of the builds.

    Raises:
        SceneError: the scenes cannot be built.
    """
    with _build(plan, scene_idxs, sink) as batch:
        whole = _simulated(batch)
        joints = {name: _joint_names(batch, name) for name in batch.articulations}
    with ExitStack() as built:
        halves = [half for half in (scene_idxs[1::2], scene_idxs[::2]) if half]
        batches = [built.enter_context(_build(plan, half, sink)) for half in halves]
        parts = [_simulated(batch) for batch in batches]
    for part in sorted(parts, key=lambda one: one.scene_idxs):
        for scene in part.scene_idxs:
            yield from islice(_differences(whole, part, scene, joints), 1)


def _build(plan: ScenePlan, scene_idxs: Sequence[int], sink: Sink) -> SceneBatch:
    return build_batch(plan, sink, scene_idxs=scene_idxs, render=False, audit=False)


def _simulated(batch: SceneBatch) -> SceneState:
    batch.step(max(round(SECONDS / batch.timestep), 1))
    return batch.state()


def _joint_names(batch: SceneBatch, name: str) -> dict[int, list[str]]:
    """Returns the names of the active joints of an articulation in each of its scenes."""
    articulation = batch.articulations[name]
    joints = [[joint.name for joint in obj.active_joints] for obj in articulation.objs]
    return dict(zip(articulation.scene_idxs, joints, strict=True))


def _differences(
    whole: SceneState, part: SceneState, scene: int, joints: dict[str, dict[int, list[str]]]
) -> Iterator[Finding]:
    """Yields bodies and joints of a scene that differ, in build order of bodies, then articulations."""
    for name, state in part.all.items():
        if scene not in state.scene_idxs:
            continue
        a, b = _row(whole.all[name], scene), _row(state, scene)
        for array, width in state.WIDTHS.items():
            # Joints that only other scenes of a batch have are NaN, and behind the others.
            x, y = (row[array][: min(len(a[array]), len(b[array]))] for row in (a, b))
            if x.tobytes() != y.tobytes():
                column, amount = _largest_difference(x, y)
                who = name if width >= 0 else f"{name}/{joints[name][scene][column]}"
                by = f"{amount:.3g}{_UNITS.get(array, '')}"
                message = f"`{who}` differs from itself in another batch: `{array}` by {by} after {SECONDS:g} s"
                yield Finding("SC867", (who,), scene, amount, message)


def _row(state: AnyState, scene: int) -> dict[str, NDArray[Any]]:
    row = state.scene_idxs.index(scene)
    return {array: np.atleast_1d(getattr(state, array)[row]) for array in state.WIDTHS}


def _largest_difference(x: NDArray[Any], y: NDArray[Any]) -> tuple[int, float]:
    """Returns the column that differs most, and by how much; infinity for a number that only one has."""
    a, b = x.astype(np.float64), y.astype(np.float64)
    is_same = (a == b) | (np.isnan(a) & np.isnan(b))
    apart = np.where(is_same, 0.0, np.nan_to_num(np.abs(a - b), nan=np.inf, posinf=np.inf))
    column = int(apart.argmax())
    return column, float(apart[column])
