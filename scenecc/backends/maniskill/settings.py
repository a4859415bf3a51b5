"""A plan's settings against those of an environment, which has its simulation before a scene is loaded into it."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.maniskill.theirs import SimConfig
from scenecc.backends.sapien.engine import physx
from scenecc.diagnostics import Location
from scenecc.plan.physics import process_wide_settings

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Origin, Sink
    from scenecc.plan import Friction, GpuMemory, Physics

CODE = "SC810"

_HINT = "make the environment with `sim_config=scenecc.maniskill.sim_config(…)` of this file, or leave the key out"

_ACTIONS = 20
"""ManiSkill's, a second."""

_MOST_STEPS = 1_000_000
"""A second: what is finer is no time step of a simulation."""


def contradictions(physics: Physics, scene: Any, sink: Sink) -> bool:
    """Reports every key that says something else than the environment has; whether there are any."""
    found = False
    for path, said, present in _pairs(physics, scene):
        if not np.array_equal(np.asarray(said, np.float32), np.asarray(present, np.float32)):
            message = f"`{'.'.join(path)}` is {_shown(said)} here, and the environment has {_shown(present)}"
            sink.report(CODE, message, _place(physics.origin, *path), hint=_HINT)
            found = True
    return found


def sim_config(physics: Physics, sink: Sink, control_freq: int | None = None) -> Any:
    """ManiSkill's `SimConfig` with what a plan says, and ManiSkill's defaults for the rest.

    Args:
        physics: of the plan. `sdf` is no part of ManiSkill's configuration: it is set while a scene is loaded.
        sink: told a time step that ManiSkill cannot have.
        control_freq: actions a second; None: ManiSkill's 20, or the next less that divides the steps a second.

    Returns:
        None after an error.

    Raises:
        ValueError: `control_freq` is not positive, or does not divide the steps a second.
    """
    config = SimConfig()
    if physics.timestep is not None:
        steps = round(1 / physics.timestep)
        if not 1 <= steps <= _MOST_STEPS or np.float32(1 / steps) != np.float32(physics.timestep):
            count = f"{1 / physics.timestep:.6g}"
            message = f"ManiSkill takes whole steps a second, and of {physics.timestep} s there are {count}"
            sink.report(CODE, message, _place(physics.origin, "timestep"), hint="as with 0.01, 0.005 or 0.002 s")
            return None
        config.sim_freq = steps
    config.control_freq = _control_freq(config.sim_freq, control_freq)
    given = process_wide_settings(physics)
    for name, value in {**given["scene"], **given["shape"], **given["body"]}.items():
        setattr(config.scene_config, name, value)
    if physics.gravity is not None:
        config.scene_config.gravity = list(physics.gravity)
    if physics.cpu_workers is not None:
        config.scene_config.cpu_workers = physics.cpu_workers
    if physics.scene_spacing is not None:
        config.spacing = physics.scene_spacing
    for name, value in _said(physics.default_material):
        setattr(config.default_materials_config, name, value)
    for name, value in _said(physics.gpu_memory):
        setattr(config.gpu_memory_config, name, value)
    return config


def _control_freq(sim_freq: int, asked: int | None) -> int:
    if asked is None:
        return next(each for each in range(min(_ACTIONS, sim_freq), 0, -1) if sim_freq % each == 0)
    if asked < 1 or sim_freq % asked:
        raise ValueError(f"control_freq divides the {sim_freq} steps a second, and {asked} does not")
    return asked


def _pairs(physics: Physics, scene: Any) -> Iterator[tuple[tuple[str, ...], Any, Any]]:
    """Each key that is said, with its value and the environment's."""
    if physics.timestep is not None:
        yield ("timestep",), physics.timestep, scene.px.timestep
    given = process_wide_settings(physics)
    held = {"scene": scene.px.config, "shape": physx.get_shape_config(), "body": physx.get_body_config()}
    for kind, present in held.items():
        for name, value in given[kind].items():
            yield (name,), value, getattr(present, name)
    config = scene.sim_config
    if physics.cpu_workers is not None:
        yield ("cpu_workers",), physics.cpu_workers, config.scene_config.cpu_workers
    material = physx.get_default_material()
    for name, value in _said(physics.default_material):
        yield ("default_material", name), value, getattr(material, name)
    if physics.scene_spacing is not None:
        yield ("scene_spacing",), physics.scene_spacing, config.spacing
    for name, value in _said(physics.gpu_memory):
        yield ("gpu_memory", name), value, getattr(config.gpu_memory_config, name)


def _said(group: Friction | GpuMemory | None) -> Iterator[tuple[str, Any]]:
    if group is None:
        return
    for each in fields(group):
        if (value := getattr(group, each.name)) is not None:
            yield each.name, value


def _place(origin: Origin | None, *path: str) -> Origin | Location:
    return Location(None) if origin is None else origin.child(*path)


def _shown(value: Any) -> str:
    """With as many digits as the engine keeps."""
    if isinstance(value, bool | int):
        return str(value).lower()
    numbers = [float(str(np.float32(number))) for number in np.ravel(value)]
    return str(numbers if np.ndim(value) else numbers[0])
