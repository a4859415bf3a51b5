"""SAPIEN's process-wide defaults: set for a build where the plan names them, put back after it."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from scenecc.backends.sapien.engine import physx

if TYPE_CHECKING:
    from collections.abc import Generator

    from scenecc.plan import Physics, SdfConfig

SCENE = (
    "gravity",
    "bounce_threshold",
    "enable_pcm",
    "enable_tgs",
    "enable_ccd",
    "enable_enhanced_determinism",
    "enable_friction_every_iteration",
)
_SHAPE = ("contact_offset", "rest_offset")
_BODY = ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold")
_SDF = {
    "spacing": "spacing",
    "subgrid_size": "subgridSize",
    "num_threads_for_construction": "num_threads_for_construction",
}
"""The plan's names and those of SAPIEN's configuration object."""


@contextmanager
def engine_settings(physics: Physics) -> Generator[None]:
    """Sets SAPIEN's defaults to what the plan names and restores all of them, also after an error.

    The default material is not among them: a build hands its own to the shapes that name none. Nor
    is the GPU memory, which only a GPU simulation reads and which SAPIEN lets nobody read back.
    """
    scene, shape = physx.get_scene_config(), physx.get_shape_config()
    body, sdf = physx.get_body_config(), physx.get_sdf_config()
    try:
        _set_scene(physics)
        _set_shape(physics)
        _set_body(physics)
        if physics.sdf is not None:
            _set_sdf(physics.sdf)
        yield
    finally:
        # The objects hold everything, also the number of workers, which has no property to read.
        physx.set_scene_config(scene)
        physx.set_shape_config(shape)
        physx.set_body_config(body)
        physx.set_sdf_config(sdf)


def _set_scene(physics: Physics) -> None:
    config = physx.get_scene_config()
    given = {name: value for name in SCENE if (value := getattr(physics, name)) is not None}
    if physics.cpu_workers is not None:
        present = {name: getattr(config, name) for name in SCENE}
        physx.set_scene_config(**(present | given), cpu_workers=physics.cpu_workers)
    elif given:
        for name, value in given.items():
            setattr(config, name, value)
        physx.set_scene_config(config)


def _set_shape(physics: Physics) -> None:
    given = {name: value for name in _SHAPE if (value := getattr(physics, name)) is not None}
    if given:
        config = physx.get_shape_config()
        for name, value in given.items():
            setattr(config, name, value)
        physx.set_shape_config(config)


def _set_body(physics: Physics) -> None:
    given = {name: value for name in _BODY if (value := getattr(physics, name)) is not None}
    if given:
        config = physx.get_body_config()
        for name, value in given.items():
            setattr(config, name, value)
        physx.set_body_config(config)


def _set_sdf(sdf: SdfConfig) -> None:
    config = physx.get_sdf_config()
    for name, theirs in _SDF.items():
        if (value := getattr(sdf, name)) is not None:
            setattr(config, theirs, value)
    physx.set_sdf_config(config)
