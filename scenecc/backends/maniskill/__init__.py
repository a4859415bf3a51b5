"""Builds a plan in a ManiSkill scene: its actors and articulations, with its names and in its registries.

Importing this loads neither ManiSkill nor PyTorch; calling its functions does.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol

from scenecc.diagnostics.diagnostic import Location
from scenecc.extras import install_hint

if TYPE_CHECKING:
    from scenecc.backends.maniskill.loaded_scene import LoadedScene
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan
    from scenecc.plan.scene import Physics

__all__ = ["LoadedScene", "ManiSkillScene", "instantiate", "plan_sim_config"]

INSTALL_HINT = install_hint("maniskill", "torch")


class ManiSkillScene(Protocol):
    """A `mani_skill.envs.scene.ManiSkillScene`, for type checks without the package."""

    @property
    def num_envs(self) -> int:
        """Number of environments."""
        ...


def instantiate(plan: ScenePlan, scene: ManiSkillScene, sink: Sink, *, audit: bool = True) -> LoadedScene | None:
    """Builds the plan in a `ManiSkillScene`, one scene of the plan in each sub-scene.

    Args:
        plan: has as many scenes as `scene` has environments.
        scene: a `mani_skill.envs.scene.ManiSkillScene` before its simulation is set up, as in `_load_scene`.
        sink: receives errors, located at the nodes that cause them.
        audit: compare counts, order, poses and masses with the plan afterwards.

    Returns:
        What was built, or None after a failure.
    """
    if not _check_installed(sink):
        return None
    from scenecc.backends.maniskill.build import build_plan

    return build_plan(plan, scene, sink, audit=audit)


def plan_sim_config(plan: ScenePlan, sink: Sink, control_freq: int | None = None) -> Any:
    """Returns ManiSkill's configuration with the plan's physics settings, or None after a failure, which is reported.

    Raises:
        ValueError: `control_freq` does not divide the steps per second.
    """
    if not _check_installed(sink):
        return None
    from scenecc.backends.maniskill import build

    physics: Physics = plan.physics
    return build.physics_sim_config(physics, sink, control_freq)


def __getattr__(name: str) -> object:
    """Loads the class of the result on first use."""
    if name != "LoadedScene":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("scenecc.backends.maniskill.loaded_scene"), name)


def _check_installed(sink: Sink) -> bool:
    """Returns whether ManiSkill can be used here; reports why not."""
    try:
        for name in ("mani_skill", "torch", "scenecc.backends.maniskill.compat"):
            import_module(name)
    except ImportError as error:
        message = f"ManiSkill cannot be used: {error}"
        sink.report("SC805", message, Location(None), hint=INSTALL_HINT)
        return False
    return True
