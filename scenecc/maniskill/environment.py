"""Scene files as Gymnasium environments."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.maniskill import theirs
from scenecc.maniskill.yaml_env import YamlEnv
from scenecc.plan import ArticulationStructure
from scenecc.scene import compile_scene

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from os import PathLike

    from scenecc.pipeline import Source
    from scenecc.plan import ScenePlan


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
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
    override: bool = False,
) -> type[YamlEnv]:
    """Makes a Gymnasium environment of a scene file, for `gym.make(name)`.

    It is a ManiSkill environment without a task: no rewards, no success, no failure. Observations are those of
    ManiSkill's modes; their states hold position and motion of every object that can move. The file's cameras are its
    sensors, but for one named `render_camera`, which `render()` shows. Where the file brings no lights, ManiSkill's
    shine. `physics` of the file is the environment's.

    Args:
        name: Gymnasium's, as `Desk-v0`.
        scene_yaml: as for `scenecc.validate`, and no stream; read again by every environment.
        max_episode_steps: after which an episode is truncated; None: never.
        robot_uids: ManiSkill's agents, whose actions the environment takes; None: it takes none, and whatever the file
            holds moves by itself. An articulation of the file that has the agent's name (`panda`; of several agents
            `panda-agent-0`, …) is its robot. An agent that the file does not have is built by ManiSkill before
            the file's objects, and starts every episode in its first keyframe.
        control_freq: as for `sim_config`.
        robot_init_qpos_noise: as for `YamlSceneBuilder`; None: its default.
        seed: as for `YamlSceneBuilder`.
        params: as for `load_into`, like those that follow.
        asset_roots: as for `load_into`.
        allow_outside_assets: as for `load_into`.
        limits: as for `load_into`.
        override: take the place of an environment that has the name already.

    Returns:
        The environment's class, to derive a task from.

    Raises:
        SceneError: the scene is at fault.
        TypeError: the source is a stream.
        ValueError: there is such an environment, and it is not to be overridden.
    """
    _refuse_what_cannot_be(name, scene_yaml, override=override)
    options = _options(params, asset_roots, allow_outside_assets=allow_outside_assets, limits=limits)
    made = _environment(
        name,
        compile_scene(scene_yaml, **options),
        scene_yaml=scene_yaml,
        scene_options={"seed": seed, **options, "params": dict(params or {})},
        noise=robot_init_qpos_noise,
        default_robot_uids=_uids(robot_uids),
        asked_control_freq=control_freq,
    )
    theirs.register_env(name, max_episode_steps=max_episode_steps, override=override)(made)
    return made


def _refuse_what_cannot_be(name: str, scene_yaml: Source, *, override: bool) -> None:
    if hasattr(scene_yaml, "read"):
        raise TypeError("an environment reads its scene more than once: give a path or a mapping, not a stream")
    if name in theirs.REGISTERED_ENVS and not override:
        raise ValueError(f"there is an environment '{name}' already; `override=True` takes its place")


def _options(
    params: Mapping[str, Any] | None,
    asset_roots: Iterable[str | PathLike[str]],
    *,
    allow_outside_assets: bool,
    limits: Mapping[str, int] | None,
) -> dict[str, Any]:
    """How the file is read. It is read more than once, and the roots may be an iterator."""
    return {
        "params": params,
        "asset_roots": tuple(asset_roots),
        "allow_outside_assets": allow_outside_assets,
        "limits": limits,
    }


def _environment(name: str, plan: ScenePlan, **attributes: object) -> type[YamlEnv]:
    """The class of a plan's environment. `attributes`: of `YamlEnv`, but for those that the plan tells."""
    robots = (entity.name for entity in plan.entities if isinstance(entity.structures[0], ArticulationStructure))
    told = {"__doc__": plan.description or f"The scene of '{plan.name}'.", "own_robots": frozenset(robots)}
    return type("".join(filter(str.isidentifier, name)) or "SceneEnv", (YamlEnv,), {**told, **attributes})


def _uids(robot_uids: str | Sequence[str] | None) -> str | tuple[str, ...]:
    if robot_uids is None:
        return "none"
    return robot_uids if isinstance(robot_uids, str) else tuple(robot_uids)
