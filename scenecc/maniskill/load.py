"""Scene files in an environment of your own: `load_into` builds one, `sim_config` gives its physics, `episode_seeds`
its seeds.

Loads no ManiSkill before a scene has been checked.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from typing_extensions import Unpack

from scenecc.backends import maniskill
from scenecc.diagnostics import Sink
from scenecc.errors import SceneError
from scenecc.options import EnvironmentOptions, Options, check_types
from scenecc.pipeline import BUILD_TYPES, Source, compile_or_raise
from scenecc.scene import build_into

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from os import PathLike

    from scenecc.backends.maniskill import ManiSkillScene
    from scenecc.backends.maniskill.loaded_scene import LoadedScene


def load_into(
    scene: ManiSkillScene,
    source: Source,
    *,
    audit: bool = True,
    **options: Unpack[EnvironmentOptions],
) -> LoadedScene:
    """Builds a scene file in a `ManiSkillScene`, one of its scenes in each environment. Call it in `_load_scene`.

    Actors and articulations are made by ManiSkill's own builders, stand in `scene.actors` and `scene.articulations`
    under their names in the file, and belong to the environment's state. Where they start is set by `initialize` of
    what is returned, in `_initialize_episode`.

    Args:
        scene: of the environment, `self.scene`.
        source: as for `scenecc.validate`; its `num_scenes` gives way to the number of environments.
        audit: as for `scenecc.load_scene`.
        options: those of `scenecc.CompileOptions`, except `num_scenes`.

    Raises:
        SceneError: the scene, the engine or the machine is at fault.
        TypeError: `scene` is no environment's, or another argument is of another type.
        ValueError: an argument is out of its range.
    """
    asked = Options.of_call(load_into, options, EnvironmentOptions)
    check_types(load_into, {"audit": audit}, BUILD_TYPES)
    return build_into(scene, source, asked, audit=audit)


def sim_config(
    source: Source,
    *,
    control_freq: int | None = None,
    params: Mapping[str, Any] | None = None,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
) -> Any:
    """The `mani_skill.utils.structs.types.SimConfig` with what a file says under `physics`.

    What the file leaves out is ManiSkill's default. Give it to `gym.make(…, sim_config=…)`, or return it from an
    environment's `_default_sim_config`. `sdf` has no place in it; `load_into` sets that while it builds.

    Args:
        source: as for `scenecc.validate`.
        control_freq: actions a second, which divides the steps a second; None: ManiSkill's 20, or the next less that
            does.
        params: as for `scenecc.validate`, like the others.
        asset_roots: as for `scenecc.validate`.
        allow_outside_assets: as for `scenecc.validate`.
        limits: as for `scenecc.validate`.

    Raises:
        SceneError: the scene is at fault, its time step is no whole part of a second, or ManiSkill is not installed.
        ValueError: `control_freq` does not divide the steps a second.
    """
    sink = Sink()
    given = {"asset_roots": asset_roots, "allow_outside_assets": allow_outside_assets, "limits": limits}
    options = Options.of_call(sim_config, {"params": params, **given})
    config = maniskill.plan_sim_config(compile_or_raise(source, options, sink).plan, sink, control_freq)
    if config is None:
        raise SceneError(sink.diagnostics())
    return config


_SEED_COUNT = 2**31


def episode_seeds(env: Any, env_idx: Iterable[int] | None = None) -> list[int]:
    """One seed for each of some environments, from the generators that ManiSkill has for their episodes.

    After `env.reset(seed=…)` they are the same every time; after `env.reset()` they go on, so that every episode is
    another. Each call takes one number of each of these generators, `env._batched_episode_rng`.

    Args:
        env: a `mani_skill.envs.sapien_env.BaseEnv`.
        env_idx: which environments, as `_initialize_episode` is told; None: all.
    """
    chosen = range(env.num_envs) if env_idx is None else [int(index) for index in env_idx]
    # One by one, as the generator of one environment gives a number and no array.
    return [int(env._batched_episode_rng[index].randint(_SEED_COUNT)) for index in chosen]  # noqa: SLF001
