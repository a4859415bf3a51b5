"""Scenes and environments of ManiSkill's for tests, with SAPIEN's process-wide defaults as they were afterwards.

ManiSkill's environments set these defaults and leave them so, and other tests read them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

CONFIGS = ("scene", "shape", "body", "sdf")


@contextmanager
def engine_as_before() -> Iterator[None]:
    """Puts SAPIEN's process-wide defaults back."""
    from sapien import physx

    before = {kind: getattr(physx, f"get_{kind}_config")() for kind in CONFIGS}
    material = physx.get_default_material()
    try:
        yield
    finally:
        for kind, config in before.items():
            getattr(physx, f"set_{kind}_config")(config)
        physx.set_default_material(material.static_friction, material.dynamic_friction, material.restitution)


def new_scene(num_envs: int = 1, sim_config: Any = None) -> Any:
    """A `ManiSkillScene` as `_load_scene` finds it, on the CPU, without a renderer.

    ManiSkill's own environments have one on the CPU. More of them, each with a simulation of its own, show everything
    that does not need a GPU.
    """
    import numpy as np
    import sapien
    from mani_skill.envs.scene import ManiSkillScene
    from mani_skill.envs.utils.system.backend import parse_sim_and_render_backend
    from mani_skill.utils.structs.types import SimConfig

    config = sim_config or SimConfig()
    given = config.scene_config.dict()
    shape = {name: given.pop(name) for name in ("contact_offset", "rest_offset")}
    names = ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold")
    body = {name: given.pop(name) for name in names}
    sapien.physx.set_shape_config(**shape)
    sapien.physx.set_body_config(**body)
    physx: Any = sapien.physx
    physx.set_scene_config(**(given | {"gravity": np.array(given["gravity"])}))
    sapien.physx.set_default_material(**config.default_materials_config.dict())
    backend = parse_sim_and_render_backend("physx_cpu", "none")
    sub_scenes = [sapien.Scene([sapien.physx.PhysxCpuSystem()]) for _ in range(num_envs)]
    scene = ManiSkillScene(sub_scenes, sim_config=config, device=backend.device, backend=backend)
    for each in sub_scenes:
        each.physx_system.timestep = 1 / config.sim_freq
    return scene


def built_by_hand(build: Callable[[Any], None], num_envs: int = 1) -> Any:
    """A scene that a function has filled with ManiSkill's builders."""
    scene = new_scene(num_envs)
    build(scene)
    return scene
