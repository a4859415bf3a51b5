"""The only module that imports ManiSkill and PyTorch. Others import them from here.

They are untyped: ManiSkill ships no types, and type checks must work without either package.
"""

from __future__ import annotations

import re
from importlib import import_module
from importlib.metadata import version
from typing import Any

from scenecc.extras import EXTRAS, install_hint

_OLDEST, _TOO_NEW = (3, 0, 1), (4,)
"""Versions of ManiSkill: the oldest that is tested, and the first whose builders have moved."""


def check_version(installed: str) -> None:
    """Raises ImportError for a version of ManiSkill that scenecc does not work with."""
    release = re.match(r"\d+(\.\d+)*", installed)
    numbers = tuple(map(int, release[0].split("."))) if release else ()
    if not _OLDEST <= numbers < _TOO_NEW:
        message = f"scenecc works with ManiSkill 3.0.1 to 3.x, and {installed} is installed"
        raise ImportError(f"{message}: pip install 'mani-skill>=3.0.1,<4'")


if lacking := EXTRAS["maniskill"].missing:
    # ManiSkill's files are enough for scenes that name them, so the package may be here alone.
    raise ImportError(f"ManiSkill needs {', '.join(lacking)}, not installed here: {install_hint('maniskill', 'torch')}")
check_version(version("mani-skill"))

_STRUCTS = "mani_skill.utils.structs"

_BUILDING = "mani_skill.utils.building"

_CAMERA: Any = import_module("mani_skill.sensors.camera")

_REGISTRATION: Any = import_module("mani_skill.utils.registration")

gym: Any = import_module("gymnasium")

torch: Any = import_module("torch")

Actor: Any = import_module(f"{_STRUCTS}.actor").Actor

ActorBuilder: Any = import_module(f"{_BUILDING}.actor_builder").ActorBuilder

Articulation: Any = import_module(f"{_STRUCTS}.articulation").Articulation

ArticulationBuilder: Any = import_module(f"{_BUILDING}.articulation_builder").ArticulationBuilder

Pose: Any = import_module(f"{_STRUCTS}.pose").Pose

BaseEnv: Any = import_module("mani_skill.envs.sapien_env").BaseEnv

SceneBuilder: Any = import_module("mani_skill.utils.scene_builder").SceneBuilder

REGISTERED_ENVS: Any = _REGISTRATION.REGISTERED_ENVS

register_env: Any = _REGISTRATION.register_env

agents_by_uid: Any = import_module("mani_skill.agents").REGISTERED_AGENTS

look_at: Any = import_module("mani_skill.utils.sapien_utils").look_at

CameraConfig: Any = _CAMERA.CameraConfig

SHADERS: Any = _CAMERA.PREBUILT_SHADER_CONFIGS

SimConfig: Any = import_module(f"{_STRUCTS}.types").SimConfig

__all__ = [
    "REGISTERED_ENVS",
    "SHADERS",
    "Actor",
    "ActorBuilder",
    "Articulation",
    "ArticulationBuilder",
    "BaseEnv",
    "CameraConfig",
    "Pose",
    "SceneBuilder",
    "SimConfig",
    "agents_by_uid",
    "gym",
    "look_at",
    "register_env",
    "torch",
]

UNSUPPORTED_CODE = "SC811"
"""The code for something that ManiSkill does not support."""
