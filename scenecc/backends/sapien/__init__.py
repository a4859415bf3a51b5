"""Builds a plan with SAPIEN: live scenes on PhysX's CPU engine. The engine is loaded by `instantiate`."""

from __future__ import annotations

import re
from importlib import import_module
from typing import TYPE_CHECKING

from scenecc.diagnostics.diagnostic import Location
from scenecc.interrupt import interrupts_wait
from scenecc.options import check_scene_idxs

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from scenecc.backends.sapien.batch import SceneBatch
    from scenecc.backends.sapien.entity_batch import ArticulationBatch, EntityBatch
    from scenecc.backends.sapien.state import ArticulationState, EntityState, SceneState
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan

__all__ = [
    "ArticulationBatch",
    "ArticulationState",
    "EntityBatch",
    "EntityState",
    "SceneBatch",
    "SceneState",
    "instantiate",
]

_CLASS_MODULES = {
    "ArticulationBatch": "entity_batch",
    "ArticulationState": "state",
    "EntityBatch": "entity_batch",
    "EntityState": "state",
    "SceneBatch": "batch",
    "SceneState": "state",
}
"""Modules of the classes."""

INSTALL_HINT = "pip install 'sapien>=3.0.3,<3.1'"


def instantiate(
    plan: ScenePlan,
    sink: Sink,
    *,
    scene_idxs: Sequence[int] | None = None,
    render: bool | None = None,
    audit: bool = True,
    progress: Callable[[int, int], None] | None = None,
) -> SceneBatch | None:
    """Builds the plan's scenes, each with its own PhysX system.

    Args:
        plan: what to build.
        sink: receives errors of the engine and the machine, located at the nodes that cause them.
        scene_idxs: indices of the scenes to build. A scene is the same as in the full batch. Default: all.
        render: True builds visuals, False leaves them out, None builds them if there is a render device.
        audit: compare the engine's counts, order, poses, masses and cooked meshes with the plan afterwards.
        progress: called with (finished scenes, all scenes).

    Returns:
        The live scenes, or None after a failure, which leaves nothing behind.

    Raises:
        ValueError: `scene_idxs` is empty, repeats an index or names one that the plan does not have.
    """
    chosen = _check_selection(plan, scene_idxs)
    problem = _engine_problem()
    if problem is not None:
        message, hint = problem
        sink.report("SC805", message, Location(None), hint=hint)
        return None
    from scenecc.backends.sapien.build import build_sapien_batch

    return build_sapien_batch(plan, sink, chosen, render=render, audit=audit, progress=progress)


def __getattr__(name: str) -> object:
    """Loads the classes of a batch on first use (those of live objects with the engine)."""
    if name not in _CLASS_MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"scenecc.backends.sapien.{_CLASS_MODULES[name]}"), name)


def _check_selection(plan: ScenePlan, scene_idxs: Sequence[int] | None) -> tuple[int, ...]:
    if scene_idxs is None:
        return tuple(range(plan.num_scenes))
    chosen = tuple(sorted(check_scene_idxs(scene_idxs)))
    if not chosen:
        raise ValueError("scene_idxs must name at least one scene")
    if chosen[0] < 0 or chosen[-1] >= plan.num_scenes:
        raise ValueError(f"scene_idxs must be in 0 to {plan.num_scenes - 1}, not {list(scene_idxs)}")
    return chosen


def _engine_problem() -> tuple[str, str] | None:
    """Returns why SAPIEN cannot be used here, as a message and a hint, or None if it can."""
    try:
        # An interrupted import looks as if SAPIEN were missing.
        with interrupts_wait():
            from scenecc.backends.sapien.engine import sapien
    except ImportError as error:
        return f"SAPIEN cannot be imported: {error}", INSTALL_HINT
    found = str(sapien.__version__)
    if not re.match(r"3\.0\.([3-9]|[1-9]\d)", found):
        return f"SAPIEN {found} is installed; scenecc needs 3.0.3 or a later 3.0", INSTALL_HINT
    return None
