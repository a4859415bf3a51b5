"""A scene file as one of ManiSkill's scene builders."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.maniskill.compat import SceneBuilder
from scenecc.maniskill.load import episode_seeds, load_into
from scenecc.scene import list_params

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from os import PathLike

    from scenecc.backends.maniskill.loaded_scene import LoadedScene
    from scenecc.pipeline import Source

DEFAULT_QPOS_NOISE = 0.02
"""ManiSkill's, of joint positions at the start [rad]."""

_QPOS_NOISE_PARAM = "robot_init_qpos_noise"


class YamlSceneBuilder(SceneBuilder):
    """Builds a scene file in an environment, and puts it to its start in every episode.

    What is drawn when the scene is built comes from `seed`, or else from the environment's own seed when it is
    (re)configured; what is drawn in every episode comes from the environment's seeds of its episodes. So
    `env.reset(seed=…)` gives the same again, and `env.reset()` gives other episodes.

    Attributes:
        scene_objects: entity → `Actor`, in build order; filled by `build`, as are the others.
        movable_objects: those of them that are dynamic.
        articulations: entity → `Articulation`.
        builds_lighting: whether the file brings lights or surroundings, so that ManiSkill's are not wanted.
        loaded: what `load_into` gave; None before `build`.
    """

    def __init__(
        self,
        env: Any,
        source: Source,
        robot_init_qpos_noise: float = DEFAULT_QPOS_NOISE,
        *,
        seed: int | None = None,
        params: Mapping[str, Any] | None = None,
        asset_roots: Iterable[str | PathLike[str]] = (),
        allow_outside_assets: bool = False,
        limits: Mapping[str, int] | None = None,
    ) -> None:
        """Remembers what to build.

        Args:
            env: the environment, a `mani_skill.envs.sapien_env.BaseEnv`.
            source: as for `scenecc.validate`, and no stream: it is read whenever the environment is configured anew.
            robot_init_qpos_noise: value of the file's parameter of this name, where it has one [rad].
            seed: of what is drawn when the scene is built; None: the environment's.
            params: as for `load_into`, like the others.
            asset_roots: as for `load_into`.
            allow_outside_assets: as for `load_into`.
            limits: as for `load_into`.

        Raises:
            SceneError: the parameters of the file cannot be read.
            TypeError: the source is a stream.
        """
        if hasattr(source, "read"):
            raise TypeError("a scene builder reads its source more than once: give a path or a mapping, not a stream")
        super().__init__(env, robot_init_qpos_noise)  # pyright: ignore[reportUnknownMemberType]
        self._source = source
        self._seed = seed
        self._files: dict[str, Any] = {
            "asset_roots": tuple(asset_roots),
            "allow_outside_assets": allow_outside_assets,
            "limits": limits,
        }
        self._params = dict(params or {})
        # Where the file has no such parameter, a value other than the default is the user's mistake, and told as one.
        if robot_init_qpos_noise != DEFAULT_QPOS_NOISE or _QPOS_NOISE_PARAM in {
            row.name for row in list_params(source, **self._files)
        }:
            self._params.setdefault(_QPOS_NOISE_PARAM, robot_init_qpos_noise)
        self.loaded: LoadedScene | None = None

    def build(self, build_config_idxs: list[int] | None = None) -> None:
        """Builds the scene in every environment; call it in `_load_scene`.

        Raises:
            SceneError: the scene, the engine or the machine is at fault.
            ValueError: `build_config_idxs` are given: a file is one scene, whose differences between environments it
                says itself.
        """
        _refuse_idxs(build_config_idxs)
        seed = episode_seeds(self.env, [0])[0] if self._seed is None else self._seed
        self.loaded = load_into(self.env.scene, self._source, seed=seed, params=self._params, **self._files)
        self.scene_objects = dict(self.loaded.actors)
        self.movable_objects = {
            name: actor for name, actor in self.scene_objects.items() if actor.px_body_type == "dynamic"
        }
        self.articulations = dict(self.loaded.articulations)
        self.builds_lighting = bool(self.loaded.plan.lights) or self.loaded.plan.environment is not None
        if self.env.scene.can_render():
            self.env._hidden_objects = [*self.env._hidden_objects, *self.loaded.hidden_objects]  # noqa: SLF001

    def initialize(self, env_idx: Any, init_config_idxs: list[int] | None = None) -> None:
        """Puts every object to its start in some environments; call it in `_initialize_episode`.

        Args:
            env_idx: which environments.
            init_config_idxs: None, as of `build`.

        Raises:
            RuntimeError: nothing is built yet.
            ValueError: something is drawn that has no value.
        """
        _refuse_idxs(init_config_idxs)
        if self.loaded is None:
            raise RuntimeError("call build, in `_load_scene`, before initialize")
        self.loaded.initialize(env_idx, episode_seeds(self.env, env_idx))

    @property
    def sensor_configs(self) -> list[Any]:
        """A `CameraConfig` for each camera of the file; empty before `build`."""
        return [] if self.loaded is None else self.loaded.sensor_configs


def _refuse_idxs(idxs: list[int] | None) -> None:
    if idxs is not None:
        raise ValueError("a scene file has no configurations to choose from: its draws say how environments differ")
