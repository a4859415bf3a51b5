"""The plan in a scene of ManiSkill's: its actors and articulations, under its names and in its registries.

Importing this loads neither ManiSkill nor PyTorch; what is called does.
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
    """A `mani_skill.envs.scene.ManiSkillScene`, for types; the package need not be there to check them."""

    @property
    def num_envs(self) -> int:
        """How many environments it has."""
        ...


def instantiate(plan: ScenePlan, scene: ManiSkillScene, sink: Sink, *, audit: bool = True) -> LoadedScene | None:
    """Builds the plan in a `ManiSkillScene`, a row of the plan in each of its sub-scenes.

    Args:
        plan: of as many scenes as `scene` has environments.
        scene: a `mani_skill.envs.scene.ManiSkillScene` before its simulation is set up, as in `_load_scene`.
        sink: told what cannot be built, at the node that asked.
        audit: whether counts, order, poses and masses are then compared with the plan.

    Returns:
        What was built, or None after a failure.
    """
    if not _check_installed(sink):
        return None
    from scenecc.backends.maniskill.build import build_plan

    return build_plan(plan, scene, sink, audit=audit)


def plan_sim_config(plan: ScenePlan, sink: Sink, control_freq: int | None = None) -> Any:
    """ManiSkill's configuration with what the plan says of physics; None after a failure, which the sink is told.

    Raises:
        ValueError: `control_freq` does not divide the steps a second.
    """
    if not _check_installed(sink):
        return None
    from scenecc.backends.maniskill import build

    physics: Physics = plan.physics
    return build.physics_sim_config(physics, sink, control_freq)


def __getattr__(name: str) -> object:
    """The class of what was built, loaded when somebody asks for it."""
    if name != "LoadedScene":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("scenecc.backends.maniskill.loaded_scene"), name)


def _check_installed(sink: Sink) -> bool:
    """Whether ManiSkill can be used here; the sink is told why not."""
    try:
        for name in ("mani_skill", "torch", "scenecc.backends.maniskill.compat"):
            import_module(name)
    except ImportError as error:
        message = f"ManiSkill cannot be used: {error}"
        sink.report("SC805", message, Location(None), hint=INSTALL_HINT)
        return False
    return True
