"""The settings of one scene against the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.audit.difference import Difference, same, shown
from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.settings import SCENE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.plan import ScenePlan

TIMESTEP = 0.01
"""SAPIEN's [s]."""


def scene_differences(plan: ScenePlan, scene: Any) -> Iterator[Difference]:
    """What differs in the time step and in the configuration that the scene's system took over."""
    present, physics = physx.get_scene_config(), plan.physics
    expected = {name: getattr(present, name) if (value := getattr(physics, name)) is None else value for name in SCENE}
    for name, value in expected.items():
        if not same(value, found := getattr(scene.physx_system.config, name)):
            yield Difference(name, shown(value), shown(found), physics.origin)
    timestep = TIMESTEP if physics.timestep is None else physics.timestep
    if not same(timestep, scene.timestep):
        yield Difference("timestep", shown(timestep), shown(scene.timestep), physics.origin)
