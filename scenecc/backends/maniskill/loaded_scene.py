"""A loaded plan in a `ManiSkillScene`: its objects, constraints and lights, and their initial states.

On the CPU, states are set on the engine's objects. On a GPU they go into ManiSkill's buffers, which ManiSkill applies
at the end of a reset.
"""

from __future__ import annotations

import warnings
from contextlib import contextmanager
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from scenecc.backends.maniskill.builders import camera_configs, hidden_objects
from scenecc.backends.maniskill.compat import Pose, torch
from scenecc.backends.sapien.contacts import ContactReader, Contacts
from scenecc.backends.sapien.drawn_fields import (
    DrawnFieldSet,
    Holder,
    component_holders,
    drawn_names,
    is_visual,
    plan_holders,
)
from scenecc.backends.sapien.objects import (
    ArticulationObjects,
    BodyObjects,
    ComponentBatch,
    DrawnObjects,
    NamedObjects,
    is_dynamic,
    root_is_fixed,
)
from scenecc.backends.sapien.passport import Passport, PassportWriter, Sampled, Start
from scenecc.backends.sapien.preparation import EntityLookup, PreparedArticulation
from scenecc.backends.sapien.properties import to_poses
from scenecc.backends.sapien.reset import ResetSampler
from scenecc.backends.sapien.state import AnyState, ArticulationState, ArticulationStateWriter, EntityState
from scenecc.drawn_values import DrawnRow, DrawnValues
from scenecc.options import check_scene_idxs, check_seeds

if TYPE_CHECKING:
    from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from scenecc.backends.sapien.constraints import ConstraintSet
    from scenecc.backends.sapien.rendering import LightSet
    from scenecc.plan import ScenePlan
    from scenecc.plan.body import Mount
    from scenecc.plan.rendering import Camera
    from scenecc.source.provenance import Provenance


class ManiSkillEntityLookup(EntityLookup):
    """Finds bodies by their mounts, and links by their names in the plan, since ManiSkill's names are longer."""

    def component(self, mount: Mount, number: int) -> Any:
        """Returns the physical component of a mount in the scene of a number. Raises the errors of `EntityLookup`."""
        prepared = self._prepared[mount.entity]
        if not isinstance(prepared, PreparedArticulation) or mount.link is None:
            return super().component(mount, number)
        row = self._row_of[mount.entity][self.scene_idxs[number]]
        (part,) = (part for part in prepared.parts if row in part.numbers)
        names = [link.name for link in part.structure.links]
        return prepared.links[row][names.index(mount.link)]


def write_state_on_cpu(objects: BodyObjects | ArticulationObjects, state: AnyState) -> None:
    """Restores the state of an entity in the scenes of the state. Static bodies do not move."""
    if isinstance(objects, ArticulationObjects):
        assert isinstance(state, ArticulationState)
        placement = ArticulationStateWriter(objects, state)
        for index in state.scene_idxs:
            placement.settle(index)
        return
    assert not isinstance(state, ArticulationState)
    where = to_poses(state.pose)
    for number, row in enumerate(objects.rows_in(state.scene_idxs)):
        component = objects.components[row]
        if not _is_rigid_dynamic(component):
            continue
        objects.objs[row].set_pose(where[number])
        if is_dynamic(component):
            component.set_linear_velocity(state.linear_velocity[number])
            component.set_angular_velocity(state.angular_velocity[number])


def write_state_on_gpu(actors: Sequence[Any], objects: BodyObjects | ArticulationObjects, state: AnyState) -> None:
    """Writes a state to ManiSkill's buffers, by the setters of `Actor`s or `Articulation`s.

    Args:
        actors: the ManiSkill objects with the entity's bodies, in scene order.
        objects: the engine's objects.
        state: of the environments in ManiSkill's reset mask.
    """
    if not isinstance(state, ArticulationState):
        _write_actor(actors[0], state)
        return
    assert isinstance(objects, ArticulationObjects)
    for each in actors:
        own = set(each._scene_idxs.tolist())  # noqa: SLF001
        rows = [row for row, index in enumerate(state.scene_idxs) if index in own]
        if rows:
            _write_articulation(each, state.rows(rows), fixed=root_is_fixed(objects.links[objects.row_of[min(own)]]))


@contextmanager
def restrict_reset(scene: Any, chosen: Sequence[int]) -> Generator[None]:
    """Restricts ManiSkill's setters to some environments within the block, as during a reset."""
    before = scene._reset_mask  # noqa: SLF001
    mask = torch.zeros_like(before)
    mask[list(chosen)] = True
    scene._reset_mask = mask  # noqa: SLF001
    try:
        yield
    finally:
        scene._reset_mask = before  # noqa: SLF001


def _write_actor(actor: Any, state: EntityState) -> None:
    if actor.px_body_type == "static":
        return
    actor.set_pose(Pose.create(torch.from_numpy(state.pose), device=actor.device))
    if actor.px_body_type == "dynamic":
        actor.set_linear_velocity(state.linear_velocity)
        actor.set_angular_velocity(state.angular_velocity)


def _write_articulation(articulation: Any, state: ArticulationState, *, fixed: bool) -> None:
    articulation.set_pose(Pose.create(torch.from_numpy(state.pose), device=articulation.device))
    dof = articulation.max_dof
    if dof:
        articulation.set_qpos(state.qpos[:, :dof])
        articulation.set_qvel(state.qvel[:, :dof])
        articulation.set_qf(state.qf[:, :dof])
        joints = articulation.active_joints
        articulation.set_joint_drive_targets(state.drive_target[:, :dof], joints)
        articulation.set_joint_drive_velocity_targets(state.drive_velocity_target[:, :dof], joints)
    if not fixed:
        articulation.set_root_linear_velocity(state.linear_velocity)
        articulation.set_root_angular_velocity(state.angular_velocity)


def _warn_of_kept_values(names: Sequence[str]) -> None:
    """Warns of values that a file draws at a reset, but that stay as built on a GPU."""
    if names:
        shown = ", ".join(names[:_SHOWN]) + (", …" if len(names) > _SHOWN else "")
        message = f"a reset draws these again, but on a GPU they stay as built: {shown}"
        warnings.warn(f"{message}. Write `{{once: …}}` around their forms if that is intended", stacklevel=2)


_SHOWN = 10


def _is_rigid_dynamic(component: Any) -> bool:
    return component is not None and hasattr(component, "get_kinematic")


class LoadedScene:
    """The objects of a plan in a `ManiSkillScene`.

    Attributes:
        plan: what was built.
        scene: the `ManiSkillScene`.
        actors: entity → `Actor`, in build order; a view by `Actor.merge` if its shapes differ between scenes.
        articulations: entity → `Articulation`, in build order; a view by `Articulation.merge` if its links differ
            between scenes.
    """

    def __init__(
        self,
        plan: ScenePlan,
        scene: Any,
        actors: Mapping[str, Any],
        articulations: Mapping[str, Any],
        objects: Mapping[str, BodyObjects | ArticulationObjects],
        drawn: DrawnObjects,
        constraints: ConstraintSet,
        lights: LightSet | None,
    ) -> None:
        self.plan = plan
        self.scene = scene
        self.actors = NamedObjects(actors, "actor")
        self.articulations = NamedObjects(articulations, "articulation")
        self._engine_objects = dict(objects)
        self._drawn_objects = drawn
        self._constraints = constraints
        self._lights = lights
        self._passports = PassportWriter(plan)

    @property
    def sensor_configs(self) -> list[Any]:
        """Returns a `CameraConfig` for each camera of the plan, for `_default_sensor_configs` of the environment."""
        return camera_configs(self.plan, self.actors, self.articulations, on_gpu=self.scene.gpu_sim_enabled)

    @property
    def hidden_objects(self) -> list[Any]:
        """Returns the `hidden` entities, for `_hidden_objects` of the environment: they are hidden from sensors."""
        return hidden_objects(self.plan, self.scene)

    def contacts(self, a: str | None = None, b: str | None = None) -> Contacts:
        """Returns the contacts of the last step, with the names of the plan, like `SceneBatch.contacts`.

        Right after a reset they are still those from before it. The agent's robot has the names of its links.

        Raises:
            KeyError: the plan has no such entity or link.
            RuntimeError: the simulation runs on a GPU, where PhysX does not report contact points.
        """
        return self._contact_reader.read(self._stepped_scenes(), a, b)

    def net_contact_force(self, name: str) -> NDArray[np.float32]:
        """Returns (B, 3) [N] for the environments that have the entity, like `SceneBatch.net_contact_force`.

        Raises the errors of `contacts`.
        """
        return self._contact_reader.net_force(self._stepped_scenes(), name, self.scene.timestep)

    @cached_property
    def _contact_reader(self) -> ContactReader:
        return ContactReader(self._engine_objects)

    def _stepped_scenes(self) -> Iterable[tuple[int, Any]]:
        if self.scene.gpu_sim_enabled:
            message = "PhysX does not report contact points on a GPU: use get_net_contact_forces of an actor"
            raise RuntimeError(f"{message} or link, or get_pairwise_contact_forces of the scene")
        scenes: list[Any] = self.scene.sub_scenes
        return enumerate(scenes)

    def initialize(
        self,
        env_idx: Iterable[int] | None = None,
        seed: int | Sequence[int] | None = None,
        *,
        draws: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        """Resets every object to its initial state in some environments, and redraws values.

        Call it in `_initialize_episode`; ManiSkill then passes the values to the simulation. It sets poses, velocities,
        joint positions, drive targets, and other values that the plan draws and a simulation can change. Static bodies
        and other environments are not touched. On a GPU, cameras and physical parameters (masses, gains, frictions)
        stay as built.

        Args:
            env_idx: environments, as passed to `_initialize_episode`. None: all.
            seed: seed of the draws, for all of these environments or one for each. None: the plan's.
                `scenecc.maniskill.episode_seeds` returns those of the environment's episodes.
            draws: values of shared draws to use instead of drawing: name → one row for each of these environments.

        Raises:
            ValueError: a drawn value is undefined, or an argument is invalid.
        """
        chosen = self._environments(env_idx)
        seeds = check_seeds(seed, [self.plan.seed] * len(chosen))
        if not chosen:
            return
        batch = self._start.batch(chosen, seeds, draws or {})
        states = self._start.drawn(batch)
        drawn = self._drawn_fields.draw(batch)
        targets = self._constraints.sample_targets(batch)
        self._drawn_fields.apply(drawn)
        self._passports.note_reset(chosen, seeds, draws, Sampled(states, drawn, batch))
        for _, camera in self._cameras():
            # ManiSkill caches what it has read of a camera.
            camera._cached_local_pose = camera._cached_intrinsic_matrix = None  # noqa: SLF001
        for component, name, arguments in targets:
            getattr(component, name)(*arguments)
        if not self.scene.gpu_sim_enabled:
            for name, state in states.items():
                write_state_on_cpu(self._engine_objects[name], state)
            return
        with restrict_reset(self.scene, chosen):
            for name, state in states.items():
                write_state_on_gpu(self._objects(name), self._engine_objects[name], state)

    def drawn(self, env_idx: Iterable[int] | None = None) -> dict[str, NDArray[Any]]:
        """Like `SceneBatch.drawn`, for some environments. Default: all. On a GPU, what stays as built is as built."""
        chosen = self._environments(env_idx)
        return self._drawn_values.read(chosen, self._passports.drawings(chosen))

    def drawn_rows(self, env_idx: Iterable[int] | None = None) -> list[DrawnRow]:
        """Returns the same for each of these environments: name → value. It is read when it is first used."""
        chosen = self._environments(env_idx)
        drawings = self._passports.drawings(chosen)
        read = self._drawn_values.read
        return [DrawnRow(partial(read, [one], [drawing])) for one, drawing in zip(chosen, drawings, strict=True)]

    def _environments(self, env_idx: Iterable[int] | None) -> tuple[int, ...]:
        """Returns the indices of some environments. Raises ValueError for one that does not exist."""
        count = self.plan.num_scenes
        chosen = tuple(range(count)) if env_idx is None else check_scene_idxs(map(int, env_idx))
        if any(not 0 <= index < count for index in chosen):
            raise ValueError(f"env_idx must be in 0 to {count - 1}, not {list(chosen)}")
        return chosen

    def passport(self, scene: int) -> str:
        """Like `SceneBatch.passport`, for an environment. A replay lacks an agent's robot that is not in the file."""
        return str(self.passports([scene])[0])

    def passports(self, env_idx: Iterable[int] | None = None) -> list[Passport]:
        """Like `SceneBatch.passports`, for some environments. Default: all."""
        chosen = range(self.plan.num_scenes) if env_idx is None else map(int, env_idx)
        return [Passport(partial(self._write_passport, index, self._passports.start(index))) for index in chosen]

    def _write_passport(self, index: int, start: Start) -> str:
        return self._passports.text(index, start, self._start, self._drawn_fields)

    def attach_provenance(self, provenance: Provenance | None) -> None:
        """Registers what it was built from. Called by the functions that build."""
        self._passports.provenance = provenance

    def _objects(self, name: str) -> list[Any]:
        """Returns ManiSkill's objects of an entity in scene order: one, or one for each scene if links differ."""
        if name in self.actors:
            return [self.scene.actors[name]]
        if name in self.scene.articulations:
            return [self.scene.articulations[name]]
        return [self.scene.articulations[f"{name}-{index}"] for index in self._engine_objects[name].scene_idxs]

    @cached_property
    def _drawn_values(self) -> DrawnValues:
        return DrawnValues(self.plan, self._kept)

    @cached_property
    def _kept(self) -> Sequence[str]:
        """The fields that the plan draws at a reset, but that stay as built on a GPU."""
        if not self.scene.gpu_sim_enabled:
            return ()
        cameras = [
            holder
            for camera in self.plan.cameras
            for holder in component_holders("cameras", camera, ComponentBatch(camera.name, (), []))
        ]
        return drawn_names([*(one for one in self._holders() if not is_visual(one)), *cameras])

    @cached_property
    def _drawn_fields(self) -> DrawnFieldSet:
        if self.scene.gpu_sim_enabled:
            # The buffers hold these numbers on a GPU, and SAPIEN's setters do not reach all of them.
            _warn_of_kept_values(self._kept)
            holders = filter(is_visual, self._holders())
        else:
            holders = (*self._holders(), *self._camera_holders())
        return DrawnFieldSet(holders, self._drawn_objects, rendered=self._lights is not None)

    def _holders(self) -> Iterator[Holder]:
        """Yields everything but cameras that has fields that a reset may redraw."""
        every_scene = tuple(range(self.plan.num_scenes))
        components: dict[str, ComponentBatch] = {}
        systems: dict[int, Any] = {}
        if self._lights is not None:
            components = {f"lights/{name}": one for name, one in self._lights.lights.items()}
            systems = self._lights.render_systems
        components |= {f"constraints/{name}": one for name, one in self._constraints.batches.items()}
        return plan_holders(self.plan, every_scene, self._engine_objects, self._drawn_objects, components, systems)

    def _cameras(self) -> Iterator[tuple[Camera, Any]]:
        """Yields the cameras of the plan that the environment has as sensors or human cameras, with ManiSkill's."""
        for present in (self.scene.sensors, self.scene.human_render_cameras):
            for camera in self.plan.cameras:
                if camera.name in present:
                    yield camera, present[camera.name].camera

    def _camera_holders(self) -> Iterator[Holder]:
        every_scene = tuple(range(self.plan.num_scenes))
        for camera, made in self._cameras():
            batch = ComponentBatch(camera.name, every_scene, made._render_cameras)  # noqa: SLF001
            for holder in component_holders("cameras", camera, batch):
                yield holder._replace(local=True)

    @cached_property
    def _start(self) -> ResetSampler:
        return ResetSampler(self.plan, tuple(range(self.plan.num_scenes)), self._engine_objects)
