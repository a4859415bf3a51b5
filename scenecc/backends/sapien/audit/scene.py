"""The settings of scenes, and of the process while they are built, against the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.audit.difference import Difference, same, shown
from scenecc.backends.sapien.engine import physx

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.backends.sapien.audit.defaults import Defaults
    from scenecc.backends.sapien.audit.sweep import Expected


def scene_differences(defaults: Defaults, scene: Any) -> Iterator[Difference]:
    """What differs in the time step and in the configuration that the scene's system took over."""
    yield from _differences(defaults.scene, scene.physx_system.config)
    if not same(defaults.timestep, scene.timestep):
        yield Difference("timestep", shown(defaults.timestep), shown(scene.timestep))


def cooking_differences(defaults: Defaults) -> Iterator[Difference]:
    """What differs in the settings by which distance fields were cooked; no shape tells them."""
    yield from _differences(defaults.sdf, physx.get_sdf_config())


def _differences(expected: Expected, config: Any) -> Iterator[Difference]:
    for name, value in expected.items():
        if not same(value, found := getattr(config, name)):
            yield Difference(name, shown(value), shown(found))
