"""Scene files in ManiSkill: in a task's `_load_scene`, as a `SceneBuilder`, or as an environment of their own.

Needs the extra `maniskill` and PyTorch. Importing this loads neither; what is taken from here does.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.backends.maniskill.loaded_scene import LoadedScene
    from scenecc.maniskill.environment import YamlEnv, YamlSceneBuilder, register_env
    from scenecc.maniskill.load import episode_seeds, load_into, sim_config

__all__ = [
    "LoadedScene",
    "YamlEnv",
    "YamlSceneBuilder",
    "episode_seeds",
    "load_into",
    "register_env",
    "sim_config",
]

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


def __getattr__(name: str) -> object:
    """The names above, loaded when somebody asks for them. Raises ImportError where ManiSkill is not installed."""
    if name not in _NAME_MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        return getattr(import_module(_NAME_MODULES[name]), name)
    except ImportError as error:
        message = f"scenecc.maniskill.{name} needs ManiSkill: pip install torch 'scenecc[maniskill]' ({error})"
        raise ImportError(message) from error
