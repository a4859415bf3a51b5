"""Seeds of draws from those of an environment's episodes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable

_SEEDS = 2**31


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
    return [int(env._batched_episode_rng[index].randint(_SEEDS)) for index in chosen]  # noqa: SLF001
