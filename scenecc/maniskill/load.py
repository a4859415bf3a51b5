"""Scene files in your own environment: `load_into` builds one, `sim_config` returns its physics, `episode_seeds` its
seeds.

ManiSkill is not loaded before a scene has been checked.
"""

from __future__ import annotations

from dataclasses import replace
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

    ManiSkill's own builders make actors and articulations. These are in `scene.actors` and `scene.articulations` under
    their names in the file, and in the environment's state. Set their start in `_initialize_episode` with `initialize`
    of the result.

    Args:
        scene: of the environment, `self.scene`.
        source: as for `scenecc.validate`. The number of environments overrides its `num_scenes`.
        audit: as for `scenecc.load_scene`.
        options: those of `scenecc.CompileOptions`, except `num_scenes`.

    Raises:
        SceneError: the scene is invalid, or the engine or the machine cannot build it.
        TypeError: `scene` is not that of an environment, or another argument has a wrong type.
        ValueError: an argument is out of range.
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
    """Returns a `mani_skill.utils.structs.types.SimConfig` with a file's `physics`.

    Settings that the file omits are ManiSkill's defaults. Pass it to `gym.make(…, sim_config=…)`, or return it from an
    environment's `_default_sim_config`. It cannot contain `sdf`, which `load_into` sets during the build.

    Args:
        source: as for `scenecc.validate`.
        control_freq: actions per second, a divisor of the steps per second. None: ManiSkill's 20, or the next lower
            divisor.
        params: as for `scenecc.validate`, like the following.
        asset_roots: as for `scenecc.validate`.
        allow_outside_assets: as for `scenecc.validate`.
        limits: as for `scenecc.validate`.

    Raises:
        SceneError: the scene is invalid, a second is not a multiple of its time step, or ManiSkill is not installed.
        ValueError: `control_freq` does not divide the steps per second.
    """
    sink = Sink()
    given = {"asset_roots": asset_roots, "allow_outside_assets": allow_outside_assets, "limits": limits}
    # The file's own number of scenes does not matter here, so its starts may be for another one.
    options = replace(Options.of_call(sim_config, {"params": params, **given}), at_starts=False)
    config = maniskill.plan_sim_config(compile_or_raise(source, options, sink).plan, sink, control_freq)
    if config is None:
        raise SceneError(sink.diagnostics())
    return config


_SEED_COUNT = 2**31


def episode_seeds(env: Any, env_idx: Iterable[int] | None = None) -> list[int]:
    """Returns one seed for each of some environments, from ManiSkill's generators of their episodes.

    They are the same after each `env.reset(seed=…)`. After `env.reset()` the sequence continues, so that every episode
    differs. Each call takes one number from each of these generators, `env._batched_episode_rng`.

    Args:
        env: a `mani_skill.envs.sapien_env.BaseEnv`.
        env_idx: environments, as passed to `_initialize_episode`. None: all.
    """
    chosen = range(env.num_envs) if env_idx is None else [int(index) for index in env_idx]
    # One at a time, because the generator of one environment returns a number, not an array.
    return [int(env._batched_episode_rng[index].randint(_SEED_COUNT)) for index in chosen]  # noqa: SLF001
