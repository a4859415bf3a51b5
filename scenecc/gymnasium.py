"""A batch of scenes as a vector environment of Gymnasium. Needs the extra `gymnasium`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

try:
    from gymnasium import spaces
    from gymnasium.error import ResetNeeded
    from gymnasium.utils import seeding
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space, iterate
except ImportError as missing:
    from scenecc.extras import install_hint

    message = f"scenecc.gymnasium needs Gymnasium 1.1 or newer: {install_hint('gymnasium')} ({missing})"
    raise ImportError(message) from missing
import numpy as np

from scenecc.diagnostics.messages import index_ranges
from scenecc.options import integer

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import ArrayLike, NDArray

    from scenecc.backends.sapien import SceneBatch

__all__ = ["SceneVectorEnv"]

_SEEDS = 2**31
"""Random seeds are below this value; evaluations can use those from here on."""


class SceneVectorEnv(VectorEnv[Any, Any, Any]):
    """A vector environment with one environment per scene of a batch. Callbacks give observations, rewards and
    terminations.

    An environment that ends is reset within the same step (`AutoresetMode.SAME_STEP`): `step` returns the first
    observation of its next episode, and `infos["final_obs"]` has the last one of the ended episode. Rows follow
    `batch.scene_idxs`. An episode with seed s equals what `batch.reset(seed=s)` draws in this scene. If `reset` gets no
    seed, and after an episode ends, the environment's generator draws the next seed.

    When episodes begin, `infos["passport"]` has their passports: `str` of one gives the text from which `scenecc
    replay` rebuilds the initial state. `infos["draws"]` has a mapping for each of them, from names to what was drawn,
    as in `batch.drawn()`. Both are computed only on access.

    Attributes:
        batch: the scenes; `close` closes them.
    """

    metadata: ClassVar[dict[str, Any]] = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}  # pyright: ignore[reportIncompatibleVariableOverride]

    observation_space: spaces.Space[Any]
    action_space: spaces.Space[Any]
    single_observation_space: spaces.Space[Any]
    single_action_space: spaces.Space[Any]

    def __init__(
        self,
        batch: SceneBatch,
        *,
        observation: Callable[[SceneBatch], Any],
        reward: Callable[[SceneBatch], ArrayLike],
        terminated: Callable[[SceneBatch], ArrayLike],
        act: Callable[[SceneBatch, NDArray[Any]], object],
        action_space: spaces.Space[Any],
        observation_space: spaces.Space[Any] | None = None,
        info: Callable[[SceneBatch], Mapping[str, ArrayLike]] | None = None,
        steps_per_action: int = 1,
        max_episode_steps: int | None = None,
        check: bool = False,
    ) -> None:
        """Sets the spaces. The batch does not change until the first `reset`.

        Args:
            batch: the scenes, N of them.
            observation: returns (N, …), or whatever fits `observation_space`.
            reward: returns (N,), after each action.
            terminated: returns (N,) bool: which episodes end, by success or failure.
            act: applies actions (N, …), for example to `drive_target`. The batch is stepped after it.
            action_space: action space of one environment.
            observation_space: observation space of one environment; default: an unbounded box with the shape of
                `observation`.
            info: returns further entries of `infos`: name → (N, …).
            steps_per_action: time steps per action.
            max_episode_steps: number of actions after which an episode is truncated; None: never.
            check: raise a SceneError if the simulation diverges, as `batch.step(check=True)` does.

        Raises:
            TypeError: a number is not an integer.
            ValueError: a number is not positive, or `observation` does not return one row per scene.
        """
        for name, number in {"steps_per_action": steps_per_action, "max_episode_steps": max_episode_steps}.items():
            if number is not None:
                integer(number, name, 1)
        self.batch = batch
        self.num_envs = len(batch)
        self._observation, self._reward, self._terminated, self._act = observation, reward, terminated, act
        self._info, self._check = info, check
        self._steps_per_action, self._max_episode_steps = steps_per_action, max_episode_steps
        self._elapsed = np.full(self.num_envs, -1)
        self._generators = [seeding.np_random()[0] for _ in range(self.num_envs)]
        self.single_action_space = action_space
        self.action_space = batch_space(action_space, self.num_envs)
        if observation_space is None:
            first = np.asarray(observation(batch))
            if first.dtype == object:
                raise ValueError("`observation` returns no array of numbers: it needs an `observation_space`")
            self._check_rows("observation", first.shape[:1])
            observation_space = spaces.Box(-np.inf, np.inf, first.shape[1:], first.dtype.type)
        self._dtype: Any = None
        if isinstance(observation_space, spaces.Box):
            self._dtype = observation_space.dtype  # pyright: ignore[reportUnknownMemberType]
        self.single_observation_space = observation_space
        self.observation_space = batch_space(observation_space, self.num_envs)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins new episodes, in all environments or in those of a mask.

        Args:
            seed: seed of the episodes, for all or one per environment; scenes with the same seed differ. None: new
                seeds.
            options: `reset_mask`: (N,) bool, the environments to reset.

        Returns:
            Observations and infos of all environments.

        Raises:
            TypeError: a seed is not an integer.
            ValueError: seeds or mask have the wrong shape, an option is unknown, or a draw has no value.
        """
        options = options or {}
        if options.keys() - {"reset_mask"}:
            raise ValueError(f"the only option is reset_mask; found {sorted(options)}")
        mask = np.asarray(options.get("reset_mask", np.ones(self.num_envs, np.bool_)))
        if mask.dtype != np.bool_ or mask.shape != (self.num_envs,) or not mask.any():
            raise ValueError(f"reset_mask must be ({self.num_envs},) bool with at least one True, not {mask!r}")
        if seed is not None:
            given: Any = seed if isinstance(seed, (list, tuple, np.ndarray)) else [seed] * self.num_envs
            seed = [None if one is None else integer(one, "seed", 0) for one in given]
            if len(seed) != self.num_envs:
                raise ValueError(f"{len(seed)} seeds for {self.num_envs} environments")
        for row in np.flatnonzero(mask).tolist():
            if seed is not None and seed[row] is not None:
                self._generators[row] = seeding.np_random(seed[row])[0]
        begun = self._begin(mask, seed)
        return self._observe(), begun | self._inform()

    def step(self, actions: Any) -> tuple[Any, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Applies actions, steps the batch, and resets the environments that end.

        Args:
            actions: (N, …), in `action_space`.

        Returns:
            Observations, rewards (N,) float64, terminated and truncated (N,) bool, infos. If an episode ended, infos
                have `final_obs` and `final_info`, with the masks `_final_obs` and `_final_info`.

        Raises:
            ResetNeeded: an environment was never reset.
            SceneError: the simulation diverges, with `check`.
            ValueError: the actions have the wrong shape, or a callback does not return one value per scene, or returns
                NaN as a reward or observation.
        """
        if (self._elapsed < 0).any():
            raise ResetNeeded("call reset() before the first step()")
        if self.action_space.shape is not None and np.shape(actions) != self.action_space.shape:
            raise ValueError(f"actions must have the shape {self.action_space.shape}, not {np.shape(actions)}")
        self._act(self.batch, actions)
        self.batch.step(self._steps_per_action, check=self._check)
        self._elapsed += 1
        observed = self._observe()
        rewards = np.array(self._reward(self.batch), np.float64)
        terminated = np.array(self._terminated(self.batch))
        self._check_rows("reward", rewards.shape)
        self._check_numbers("reward", rewards)
        self._check_rows("terminated", terminated.shape)
        if terminated.dtype != np.bool_:
            raise ValueError(f"`terminated` must return bool, not {terminated.dtype}")
        truncated = np.zeros(self.num_envs, np.bool_)
        if self._max_episode_steps is not None:
            truncated = self._elapsed >= self._max_episode_steps
        infos = self._inform()
        ended = terminated | truncated
        if ended.any():
            finals: dict[str, Any] = {}
            for row, final in enumerate(iterate(self.observation_space, observed)):
                if ended[row]:
                    told = {name: values[row] for name, values in infos.items() if name[0] != "_"}
                    finals = self._add_info(finals, {"final_obs": final, "final_info": told}, row)
            begun = self._begin(ended, None)
            observed, infos = self._observe(), begun | self._inform() | finals
        return observed, rewards, terminated, truncated, infos

    def close_extras(self) -> None:
        """Closes the batch."""
        self.batch.close()

    def _begin(self, mask: NDArray[np.bool_], seeds: Sequence[int | None] | None) -> dict[str, Any]:
        """Resets the environments of a mask with the given or generated seeds, and returns the infos of their start."""
        rows: list[int] = np.flatnonzero(mask).tolist()
        chosen = [None if seeds is None else seeds[row] for row in rows]
        drawn = [
            int(self._generators[row].integers(_SEEDS)) if seed is None else seed
            for row, seed in zip(rows, chosen, strict=True)
        ]
        scene_idxs = [self.batch.scene_idxs[row] for row in rows]
        self.batch.reset(seed=drawn, scene_idxs=scene_idxs)
        self._elapsed[mask] = 0
        passports = np.full(self.num_envs, None, object)
        passports[rows] = self.batch.passports(scene_idxs)
        draws = np.full(self.num_envs, None, object)
        for row, drawn in zip(rows, self.batch.drawn_rows(scene_idxs), strict=True):
            draws[row] = drawn
        return {"passport": passports, "_passport": mask.copy(), "draws": draws, "_draws": mask.copy()}

    def _observe(self) -> Any:
        found = self._observation(self.batch)
        if self._dtype is None:
            return found
        rows: NDArray[Any] = np.array(found, self._dtype)  # a copy, because the user's function may reuse its array
        self._check_rows("observation", rows.shape[:1])
        if rows.shape != self.observation_space.shape:
            raise ValueError(f"`observation` must return the shape {self.observation_space.shape}, not {rows.shape}")
        self._check_numbers("observation", rows)
        return rows

    def _inform(self) -> dict[str, Any]:
        """Returns what `info` gives, with the mask of each entry."""
        infos: dict[str, Any] = {}
        found: Mapping[str, Any] = {} if self._info is None else self._info(self.batch)
        for name, values in found.items():
            infos[name] = np.array(values)
            self._check_rows(f"info['{name}']", infos[name].shape[:1])
            infos[f"_{name}"] = np.ones(self.num_envs, np.bool_)
        return infos

    def _check_numbers(self, name: str, rows: NDArray[Any]) -> None:
        if rows.dtype.kind == "f" and np.isnan(rows).any():
            missing = np.flatnonzero(np.isnan(rows).reshape(self.num_envs, -1).any(axis=1)).tolist()
            scenes = index_ranges([self.batch.scene_idxs[row] for row in missing])
            raise ValueError(f"`{name}` is NaN in scene {scenes}")

    def _check_rows(self, name: str, shape: tuple[int, ...]) -> None:
        if shape != (self.num_envs,):
            raise ValueError(f"`{name}` must return one row for each of {self.num_envs} scenes, not the shape {shape}")
