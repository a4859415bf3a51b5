"""Scene files as ManiSkill environments: a scene builder, and an environment defined by only a file."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np

from scenecc.backends.maniskill import compat
from scenecc.backends.maniskill.compat import BaseEnv, CameraConfig, SceneBuilder, agents_by_uid, gym, look_at, torch
from scenecc.backends.sapien.engine import release_renderer
from scenecc.diagnostics import Sink
from scenecc.maniskill.load import episode_seeds, load_into, sim_config
from scenecc.options import Options
from scenecc.pipeline import compile_or_raise
from scenecc.plan import ArticulationStructure
from scenecc.scene import list_params

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from os import PathLike

    from scenecc.backends.maniskill.loaded_scene import LoadedScene
    from scenecc.pipeline import Source
    from scenecc.plan import ScenePlan

DEFAULT_QPOS_NOISE = 0.02
"""ManiSkill's noise of initial joint positions [rad]."""

_QPOS_NOISE_PARAM = "robot_init_qpos_noise"


class YamlSceneBuilder(SceneBuilder):
    """Builds a scene file in an environment, and resets it in every episode.

    Values drawn at build time come from `seed`, or else from the environment's own seed when it is (re)configured.
    Values drawn in every episode come from the environment's episode seeds. So `env.reset(seed=…)` always gives the
    same episode, and `env.reset()` gives different ones.

    Attributes:
        scene_objects: entity → `Actor`, in build order. `build` fills this and the others.
        movable_objects: those of them that are dynamic.
        articulations: entity → `Articulation`.
        builds_lighting: whether the file has lights or an environment, so that ManiSkill's lights are not needed.
        loaded: the result of `load_into`; None before `build`.
    """

    def __init__(
        self,
        env: Any,
        source: Source,
        robot_init_qpos_noise: float = DEFAULT_QPOS_NOISE,
        *,
        seed: int | None = None,
        params: Mapping[str, Any] | None = None,
        starts: str | PathLike[str] | None = None,
        asset_roots: Iterable[str | PathLike[str]] = (),
        allow_outside_assets: bool = False,
        limits: Mapping[str, int] | None = None,
    ) -> None:
        """Stores what to build.

        Args:
            env: the environment, a `mani_skill.envs.sapien_env.BaseEnv`.
            source: as for `scenecc.validate`, but not a stream: it is read again whenever the environment is
                reconfigured.
            robot_init_qpos_noise: value of the file's parameter of this name, if it has one [rad].
            seed: seed of the values drawn at build time. None: that of the environment.
            params: as for `scenecc.CompileOptions`, like the following.
            starts: as for `scenecc.CompileOptions`; made with as many scenes as there are environments.
            asset_roots: as for `scenecc.CompileOptions`.
            allow_outside_assets: as for `scenecc.CompileOptions`.
            limits: as for `scenecc.CompileOptions`.

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
        self._starts = starts
        # If the file has no such parameter, a value other than the default is an error of the user, and is reported.
        if robot_init_qpos_noise != DEFAULT_QPOS_NOISE or _QPOS_NOISE_PARAM in {
            row.name for row in list_params(source, **self._files)
        }:
            self._params.setdefault(_QPOS_NOISE_PARAM, robot_init_qpos_noise)
        self.loaded: LoadedScene | None = None

    def build(self, build_config_idxs: list[int] | None = None) -> None:
        """Builds the scene in every environment. Call it in `_load_scene`.

        Raises:
            SceneError: the scene is invalid, or the engine or the machine cannot build it.
            ValueError: `build_config_idxs` is given: a file is one scene and defines the differences between
                environments itself.
        """
        _refuse_idxs(build_config_idxs)
        seed = episode_seeds(self.env, [0])[0] if self._seed is None else self._seed
        chosen = {"seed": seed, "params": self._params, "starts": self._starts}
        self.loaded = load_into(self.env.scene, self._source, **chosen, **self._files)
        self.scene_objects = dict(self.loaded.actors)
        self.movable_objects = {
            name: actor for name, actor in self.scene_objects.items() if actor.px_body_type == "dynamic"
        }
        self.articulations = dict(self.loaded.articulations)
        self.builds_lighting = bool(self.loaded.plan.lights) or self.loaded.plan.environment is not None
        if self.env.scene.can_render():
            self.env._hidden_objects = [*self.env._hidden_objects, *self.loaded.hidden_objects]  # noqa: SLF001

    def initialize(self, env_idx: Any, init_config_idxs: list[int] | None = None) -> None:
        """Resets every object to its start in some environments. Call it in `_initialize_episode`.

        Args:
            env_idx: the environments.
            init_config_idxs: must be None, as for `build`.

        Raises:
            RuntimeError: nothing is built yet.
            ValueError: a drawn value is undefined.
        """
        _refuse_idxs(init_config_idxs)
        if self.loaded is None:
            raise RuntimeError("call build, in `_load_scene`, before initialize")
        self.loaded.initialize(env_idx, episode_seeds(self.env, env_idx))

    @property
    def sensor_configs(self) -> list[Any]:
        """Returns a `CameraConfig` for each camera of the file; empty before `build`."""
        return [] if self.loaded is None else self.loaded.sensor_configs


def _refuse_idxs(idxs: list[int] | None) -> None:
    if idxs is not None:
        raise ValueError("a scene file has no configurations to choose from: its draws define how environments differ")


_RENDER_CAMERA = "render_camera"
"""Name of the camera that renders the environment for people, as in ManiSkill's own tasks."""


class YamlEnv(BaseEnv):
    """A ManiSkill environment whose scene is a file, and which has no task.

    Attributes:
        scene_yaml, scene_options, noise, default_robot_uids, asked_control_freq: the arguments of `register_env`.
        own_robots: articulations of the file.
        scene_builder: the builder of the scene.
    """

    SUPPORTED_REWARD_MODES = ("none",)

    scene_yaml: ClassVar[Source]
    scene_options: ClassVar[dict[str, Any]]
    noise: ClassVar[float | None]
    default_robot_uids: ClassVar[str | tuple[str, ...]]
    asked_control_freq: ClassVar[int | None]
    own_robots: ClassVar[frozenset[str]]
    scene_builder: YamlSceneBuilder
    agent: Any
    robot_uids: Any
    scene: Any

    def __init__(self, *args: Any, robot_uids: Any = None, **kwargs: Any) -> None:
        noise = DEFAULT_QPOS_NOISE if self.noise is None else self.noise
        self.scene_builder = YamlSceneBuilder(self, self.scene_yaml, noise, **self.scene_options)
        uids = robot_uids or self.default_robot_uids
        self._warn_of_lone_robots(uids)
        release_renderer()
        super().__init__(*args, robot_uids=uids, **kwargs)  # pyright: ignore[reportUnknownMemberType]
        if self.agent is None:
            nothing = gym.spaces.Box(-1.0, 1.0, (0,), np.float32)
            self.single_action_space = self._orig_single_action_space = nothing
            self.action_space = nothing if self.num_envs == 1 else gym.vector.utils.batch_space(nothing, self.num_envs)

    def reset(self, seed: Any = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        """Resets like `BaseEnv.reset`.

        `info["passport"]` has the passports of all episodes; use `str` for the text. `info["draws"]` has a mapping for
        each of them, from names to what was drawn, as in `LoadedScene.drawn`.
        """
        observed, info = cast("Any", super().reset(seed=seed, options=options))  # pyright: ignore[reportUnknownMemberType]
        loaded = self.scene_builder.loaded
        assert loaded is not None
        passports, draws = (np.full(self.num_envs, None, object) for _ in range(2))
        passports[:] = loaded.passports()
        for index, drawn in enumerate(loaded.drawn_rows()):
            draws[index] = drawn
        return observed, {**info, "passport": passports, "draws": draws}

    @property
    def _default_sim_config(self) -> Any:
        options = {name: value for name, value in self.scene_options.items() if name not in {"seed", "starts"}}
        return sim_config(self.scene_yaml, control_freq=self.asked_control_freq, **options)

    @property
    def _default_sensor_configs(self) -> list[Any]:
        return [config for config in self.scene_builder.sensor_configs if config.uid != _RENDER_CAMERA]

    @property
    def _default_human_render_camera_configs(self) -> list[Any]:
        shown = [config for config in self.scene_builder.sensor_configs if config.uid == _RENDER_CAMERA]
        for config in shown:
            config.shader_pack, config.shader_config = "default", None
            config.__post_init__()
        return shown or [_front()]

    def _load_agent(self, options: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        """Loads the agents, each with the file's robot of its name or one of ManiSkill's own."""
        self.scene_builder.loaded = None
        uids: Any = self.robot_uids
        listed, names = _agents_of(uids)
        if self.own_robots.isdisjoint(names):
            super()._load_agent(options, *args, **kwargs)  # pyright: ignore[reportUnknownMemberType]
            return
        self.scene_builder.build()
        robots = self.scene_builder.articulations
        self.robot_uids = tuple(
            _with_robot(agents_by_uid[uid].agent_cls, robots[name]) if name in robots else uid
            for uid, name in zip(listed, names, strict=True)
        )
        try:
            super()._load_agent(options, *args, **kwargs)  # pyright: ignore[reportUnknownMemberType]
        finally:
            self.robot_uids = uids

    def _load_scene(self, options: dict[str, Any]) -> None:
        del options
        if self.scene_builder.loaded is None:
            self.scene_builder.build()

    def _warn_of_lone_robots(self, uids: Any) -> None:
        """Warns if the file has robots that agents could control, but the requested agents bring their own."""
        listed, names = _agents_of(uids)
        lone = sorted(self.own_robots & agents_by_uid.keys())
        if not lone or listed in ([], ["none"]) or not self.own_robots.isdisjoint(names):
            return
        robots, requested = (", ".join(f"'{name}'" for name in found) for found in (lone, names))
        warnings.warn(
            f"no agent controls the robots of the scene ({robots}): ManiSkill builds {requested} in addition;"
            " leave them out of the scene, or pass their names as `robot_uids`",
            stacklevel=3,
        )

    def _load_lighting(self, options: dict[str, Any]) -> None:
        if not self.scene_builder.builds_lighting:
            super()._load_lighting(options)  # pyright: ignore[reportUnknownMemberType]

    def _initialize_episode(self, env_idx: Any, options: dict[str, Any]) -> None:
        del options
        for agent in self._agents():
            if agent.robot.name not in self.scene_builder.articulations and agent.keyframes:
                start = next(iter(agent.keyframes.values()))
                agent.robot.set_pose(start.pose)
                if start.qpos is not None:
                    agent.reset(start.qpos)
        self.scene_builder.initialize(env_idx)

    def _step_action(self, action: Any) -> Any:
        taken = None if self.agent is None else action
        return super()._step_action(taken)  # pyright: ignore[reportUnknownMemberType, reportUnknownVariableType]

    def _get_obs_agent(self) -> dict[str, Any]:
        if self.agent is None:
            return {}
        return super()._get_obs_agent()  # pyright: ignore[reportUnknownMemberType, reportUnknownVariableType]

    def _get_obs_extra(self, info: dict[str, Any]) -> dict[str, Any]:
        """Returns pose and velocity of every movable object: 13 numbers, and the joint states of an articulation."""
        del info
        if not self.obs_mode_struct.use_state:
            return {}
        controlled = {agent.robot.name for agent in self._agents()}
        objects = {**self.scene_builder.scene_objects, **self.scene_builder.articulations}
        return {
            name: self._spread_rows(each, each.get_state())
            for name, each in objects.items()
            if name not in controlled and getattr(each, "px_body_type", None) != "static"
        }

    def get_state_dict(self) -> dict[str, Any]:
        """Returns the simulation's state, and that of the controllers if there are any."""
        if self.agent is None:
            return {"actors": {}, "articulations": {}} | self.scene.get_sim_state()
        return super().get_state_dict()  # pyright: ignore[reportUnknownMemberType, reportUnknownVariableType]

    def _agents(self) -> list[Any]:
        return [] if self.agent is None else list(getattr(self.agent, "agents", [self.agent]))

    def _spread_rows(self, each: Any, rows: Any) -> Any:
        """Returns a row for every environment, with zeros where the object is missing."""
        if len(rows) == self.num_envs:
            return rows
        found = torch.zeros((self.num_envs, rows.shape[1]), dtype=rows.dtype, device=rows.device)
        found[each._scene_idxs.long()] = rows  # noqa: SLF001
        return found


def _agents_of(uids: Any) -> tuple[list[Any], list[str]]:
    """Returns the requested agents, and ManiSkill's names of their robots."""
    listed: list[Any] = [*uids] if isinstance(uids, tuple) else [uids]  # pyright: ignore[reportUnknownVariableType]
    return listed, [uid if len(listed) == 1 else f"{uid}-agent-{number}" for number, uid in enumerate(listed)]


def _with_robot(agent: Any, robot: Any) -> Any:
    """Returns an agent's class for a robot that exists already."""

    def adopt(self: Any, initial_pose: object = None) -> None:
        del initial_pose  # the file has it
        self.robot = robot
        self.robot_link_names = [link.name for link in robot.get_links()]

    return type(agent.__name__, (agent,), {"_load_articulation": adopt, "__module__": agent.__module__})


def _front() -> Any:
    """Returns a camera in front of the origin, for files without a camera for people."""
    return CameraConfig(uid=_RENDER_CAMERA, pose=look_at([1.2, 1.0, 1.0], [0, 0, 0.2]), width=512, height=512, fov=1.0)


def register_env(
    name: str,
    scene_yaml: Source,
    *,
    max_episode_steps: int | None = None,
    robot_uids: str | Sequence[str] | None = None,
    control_freq: int | None = None,
    robot_init_qpos_noise: float | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    starts: str | PathLike[str] | None = None,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
    override: bool = False,
) -> type[YamlEnv]:
    """Registers a scene file as a Gymnasium environment, for `gym.make(name)`.

    It is a ManiSkill environment without a task: no rewards, success or failure. Observations are those of ManiSkill's
    modes. Their states contain position and motion of every movable object. The file's cameras are its sensors, except
    one named `render_camera`, which `render()` uses. A file without lights gets ManiSkill's. The file's `physics`
    applies to the environment.

    Args:
        name: for Gymnasium, such as `Desk-v0`.
        scene_yaml: as for `scenecc.validate`, but not a stream: every environment reads it again.
        max_episode_steps: number of steps after which an episode is truncated. None: never.
        robot_uids: ManiSkill's agents, whose actions the environment takes. None: it takes none, and all objects of the
            file move by themselves. An articulation of the file with the agent's name (`panda`; with several agents
            `panda-agent-0`, …) is its robot. If the file has none, ManiSkill builds the agent before the file's
            objects, and it starts every episode in its first keyframe.
        control_freq: as for `sim_config`.
        robot_init_qpos_noise: as for `YamlSceneBuilder`. None: its default.
        seed: as for `YamlSceneBuilder`.
        params: as for `scenecc.CompileOptions`, like the following.
        starts: as for `YamlSceneBuilder`.
        asset_roots: as for `scenecc.CompileOptions`.
        allow_outside_assets: as for `scenecc.CompileOptions`.
        limits: as for `scenecc.CompileOptions`.
        override: replace an environment of the same name.

    Returns:
        The environment's class, from which a task can be derived.

    Raises:
        SceneError: the scene is invalid.
        TypeError: the source is a stream.
        ValueError: an environment of this name exists, and `override` is False.
    """
    _check_registration(name, scene_yaml, override=override)
    # The file is read several times, and the roots may be an iterator.
    options: dict[str, Any] = {"params": params, "asset_roots": tuple(asset_roots)}
    options |= {"allow_outside_assets": allow_outside_assets, "limits": limits}
    # Starts are for as many scenes as there are environments, which is not known yet.
    plan = compile_or_raise(scene_yaml, replace(Options.of(**options), at_starts=False), Sink()).plan
    chosen = {"seed": seed, "starts": starts, **options, "params": dict(params or {})}
    scene = {"scene_yaml": scene_yaml, "scene_options": chosen}
    robot = {"default_robot_uids": _normalize_uids(robot_uids), "noise": robot_init_qpos_noise}
    made = _make_environment_class(name, plan, **scene, **robot, asked_control_freq=control_freq)
    compat.register_env(name, max_episode_steps=max_episode_steps, override=override)(made)
    return made


def _check_registration(name: str, scene_yaml: Source, *, override: bool) -> None:
    if hasattr(scene_yaml, "read"):
        raise TypeError("an environment reads its scene more than once: give a path or a mapping, not a stream")
    if name in compat.REGISTERED_ENVS and not override:
        raise ValueError(f"an environment '{name}' already exists; `override=True` replaces it")


def _make_environment_class(name: str, plan: ScenePlan, **attributes: object) -> type[YamlEnv]:
    """Makes the class of a plan's environment. `attributes`: those of `YamlEnv` that do not follow from the plan."""
    robots = (entity.name for entity in plan.entities if isinstance(entity.structures[0], ArticulationStructure))
    own = {"__doc__": plan.description or f"The scene of '{plan.name}'.", "own_robots": frozenset(robots)}
    return type("".join(filter(str.isidentifier, name)) or "SceneEnv", (YamlEnv,), {**own, **attributes})


def _normalize_uids(robot_uids: str | Sequence[str] | None) -> str | tuple[str, ...]:
    if robot_uids is None:
        return "none"
    return robot_uids if isinstance(robot_uids, str) else tuple(robot_uids)
