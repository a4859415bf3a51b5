"""What was built in a scene of ManiSkill's, and its start anew."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

from scenecc.backends.maniskill.sensors import camera_configs, hidden_objects
from scenecc.backends.maniskill.starting import only, set_on_cpu, set_on_gpu
from scenecc.backends.sapien.selected import scene_indices, seeds_of
from scenecc.backends.sapien.start import Start

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import ArrayLike

    from scenecc.backends.maniskill.fastened import Lights, Ties
    from scenecc.backends.sapien.bodies import Articulations, Bodies
    from scenecc.plan import ScenePlan


class LoadedScene:
    """The objects of a plan in a `ManiSkillScene`.

    Attributes:
        plan: what was built.
        scene: the `ManiSkillScene`.
        actors: entity → `Actor`, in build order; a view by `Actor.merge` where its scenes have different shapes.
        articulations: entity → `Articulation`, in build order; a view by `Articulation.merge` where its scenes have
            different links.
    """

    def __init__(
        self,
        plan: ScenePlan,
        scene: Any,
        actors: Mapping[str, Any],
        articulations: Mapping[str, Any],
        held: Mapping[str, Bodies | Articulations],
        ties: Ties,
        lights: Lights | None,
    ) -> None:
        self.plan = plan
        self.scene = scene
        self.actors = dict(actors)
        self.articulations = dict(articulations)
        self._held = dict(held)
        self._ties = ties
        self._lights = lights

    @property
    def sensor_configs(self) -> list[Any]:
        """A `CameraConfig` for each camera of the plan: what `_default_sensor_configs` of the environment returns."""
        return camera_configs(self.plan, self.actors, self.articulations)

    @property
    def hidden_objects(self) -> list[Any]:
        """The `hidden` entities, for `_hidden_objects` of the environment: sensors do not see them."""
        return hidden_objects(self.plan, self.scene)

    def initialize(
        self,
        env_idx: Iterable[int] | None = None,
        seed: int | Sequence[int] | None = None,
        *,
        draws: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        """Puts every object to its start in some environments, with what a running simulation can change drawn anew.

        Call it in `_initialize_episode`: ManiSkill then hands what is set to the simulation. Poses, velocities, joint
        positions and drive targets are set; static bodies, and the other environments, are not touched.

        Args:
            env_idx: which environments, as `_initialize_episode` is told; None: all.
            seed: of the draws, for all of these environments or one for each; None: the plan's. With
                `scenecc.maniskill.episode_seeds` those of the environment's episodes.
            draws: values of shared draws in place of drawing, name → one row for each of these environments.

        Raises:
            ValueError: something is drawn that has no value, or an argument does not fit.
        """
        count = self.plan.num_scenes
        chosen = tuple(range(count)) if env_idx is None else scene_indices(map(int, env_idx))
        if any(not 0 <= index < count for index in chosen):
            raise ValueError(f"env_idx are in 0 to {count - 1}, not {list(chosen)}")
        seeds = seeds_of(seed, [self.plan.seed] * len(chosen))
        if not chosen:
            return
        batch = self._start.batch(chosen, seeds, draws or {})
        states = self._start.drawn(batch)
        moves = [] if self._lights is None else self._lights.moves(batch)
        pulls = self._ties.again(batch)
        for entity, pose in moves:
            entity.set_pose(pose)
        for component, name, arguments in pulls:
            getattr(component, name)(*arguments)
        if not self.scene.gpu_sim_enabled:
            for name, state in states.items():
                set_on_cpu(self._held[name], state)
            return
        with only(self.scene, chosen):
            for name, state in states.items():
                set_on_gpu(self._objects(name), self._held[name], state)

    def _objects(self, name: str) -> list[Any]:
        """ManiSkill's objects of an entity, in scene order: one, or of articulations that differ one a scene."""
        if name in self.actors:
            return [self.scene.actors[name]]
        if name in self.scene.articulations:
            return [self.scene.articulations[name]]
        return [self.scene.articulations[f"{name}-{index}"] for index in self._held[name].scene_idxs]

    @cached_property
    def _start(self) -> Start:
        return Start(self.plan, tuple(range(self.plan.num_scenes)), self._held)
