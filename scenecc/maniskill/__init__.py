"""Scene files in ManiSkill: in a task's `_load_scene`, as a `SceneBuilder`, or as a separate environment.

Needs the extra `maniskill` and PyTorch. Importing this loads neither; using its names does.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.backends.maniskill.loaded_scene import LoadedScene as LoadedScene
    from scenecc.maniskill.environment import YamlEnv as YamlEnv
    from scenecc.maniskill.environment import YamlSceneBuilder as YamlSceneBuilder
    from scenecc.maniskill.environment import register_env as register_env
    from scenecc.maniskill.load import episode_seeds as episode_seeds
    from scenecc.maniskill.load import load_into as load_into
    from scenecc.maniskill.load import sim_config as sim_config

_NAME_MODULES = {
    "LoadedScene": "scenecc.backends.maniskill",
    "YamlEnv": "scenecc.maniskill.environment",
    "YamlSceneBuilder": "scenecc.maniskill.environment",
    "episode_seeds": "scenecc.maniskill.load",
    "load_into": "scenecc.maniskill.load",
    "register_env": "scenecc.maniskill.environment",
    "sim_config": "scenecc.maniskill.load",
}
"""Modules of the names."""

__all__ = [*_NAME_MODULES]  # noqa: PLE0604  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> object:
    """Loads the names above on first use. Raises ImportError if ManiSkill is not installed."""
    if name not in _NAME_MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        return getattr(import_module(_NAME_MODULES[name]), name)
    except ImportError as error:
        raise ImportError(f"scenecc.maniskill.{name} cannot be used: {error}") from error
