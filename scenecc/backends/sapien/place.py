"""Puts bodies where a state says: taken out of the engine's simulation and added again, in build order.

Setting poses and velocities alone would leave the engine's memory of the past behind: contacts of before, with the
impulses that the solver starts from, forces that wait for the next step and targets of kinematic bodies. Who comes in
again is new to the simulation. Three things are still not as in a scene that was just built:

- The engine numbers contacts in the order in which it was given back the numbers of earlier ones, and solves in that
  order. Bodies that touch nothing, or the ground and one another in pairs, move on to the bit as in a new scene; a heap
  may differ in the last bit, and then more and more. A simulation of its own (`place_afresh`) has nothing to give back.
- How long a body has been slow is nowhere to be read: who is awake gets the time that a new body has.
- A pose is that of the entity, while the engine keeps that of the centre of mass: where the two are apart, going from
  one to the other and back may round the last bit, once.
"""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.bodies import Articulations, can_move, is_kinematic
from scenecc.backends.sapien.columns import poses
from scenecc.backends.sapien.engine import physx, sapien
from scenecc.backends.sapien.place_articulation import ArticulationPlacement
from scenecc.backends.sapien.state import ArticulationState, EntityState, resting

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from scenecc.backends.sapien.bodies import Bodies
    from scenecc.backends.sapien.state import AnyState


def read(bodies: Bodies, scene_idxs: Iterable[int]) -> EntityState:
    """The state of an entity in those of the scenes that have it."""
    rows = bodies.rows_in(scene_idxs)
    objs, components = [bodies.objs[row] for row in rows], [bodies.components[row] for row in rows]
    pose = np.array([obj.get_pose().__getstate__() for obj in objs], np.float32).reshape(-1, 7)
    dynamic = np.array([can_move(component) for component in components], np.bool_)
    state = resting(tuple(bodies.scene_idxs[row] for row in rows), pose, dynamic)
    for number in np.flatnonzero(dynamic).tolist():
        component = components[number]
        state.linear_velocity[number] = component.get_linear_velocity()
        state.angular_velocity[number] = component.get_angular_velocity()
        # Outside of a scene the engine calls everything asleep.
        state.asleep[number] = objs[number].get_scene() is not None and component.is_sleeping
    for number in np.flatnonzero(~dynamic).tolist():
        if is_kinematic(components[number]):
            state.kinematic_target[number] = _target(components[number])
    return state


def _target(component: Any) -> Sequence[float]:
    try:
        return component.get_kinematic_target().__getstate__()
    except RuntimeError:  # there is none
        return (np.nan,) * 7


class Placement:
    """One entity's bodies with the state that they are to have; everything is looked up before anything moves."""

    def __init__(self, bodies: Bodies, state: EntityState) -> None:
        self._bodies = bodies
        self._row_of = {index: row for row, index in enumerate(state.scene_idxs)}
        self._poses = poses(state.pose)
        self._linear = list(state.linear_velocity)
        self._angular = list(state.angular_velocity)
        components = [bodies.components[bodies.row_of[index]] for index in state.scene_idxs]
        self._dynamic = list(map(can_move, components))
        self._asleep: list[bool] = (state.asleep & self._dynamic).tolist()
        aims = np.isfinite(state.kinematic_target).all(axis=1)
        self._targets = dict(zip(np.flatnonzero(aims).tolist(), poses(state.kinematic_target[aims]), strict=True))

    def take_out(self, scene: int) -> None:
        """Takes the entity's body out of the simulation of a scene."""
        own = self._bodies.row_of.get(scene)
        if own is not None and (component := self._bodies.components[own]) is not None:
            self._bodies.objs[own].remove_component(component)

    def move(self, scene: int) -> None:
        """Sets where the body is and how it moves, while it is outside of the simulation."""
        own = self._bodies.row_of.get(scene)
        if own is None:
            return
        row, component = self._row_of[scene], self._bodies.components[own]
        self._bodies.objs[own].set_pose(self._poses[row])
        if self._dynamic[row]:
            component.set_linear_velocity(self._linear[row])
            component.set_angular_velocity(self._angular[row])

    def put_in(self, scene: int) -> None:
        """Puts the body into the simulation again."""
        own = self._bodies.row_of.get(scene)
        if own is not None and (component := self._bodies.components[own]) is not None:
            self._bodies.objs[own].add_component(component)

    def settle(self, scene: int) -> None:
        """Lets the body in the simulation rest, wakes it, or tells it where to go."""
        own = self._bodies.row_of.get(scene)
        # Of a body outside of a scene the engine knows no rest, and crashes when it is asked.
        if own is None or self._bodies.objs[own].get_scene() is None:
            return
        row, component = self._row_of[scene], self._bodies.components[own]
        if self._asleep[row]:
            component.put_to_sleep()
        elif self._dynamic[row]:
            component.wake_up()  # and the time that it may be slow before it rests starts again, as for a new body
        elif row in self._targets:
            component.set_kinematic_target(self._targets[row])


def placement_of(held: Bodies | Articulations, state: AnyState) -> Placement | ArticulationPlacement:
    """Of whichever kind it is; the state is of the same."""
    if isinstance(held, Articulations):
        assert isinstance(state, ArticulationState)
        return ArticulationPlacement(held, state)
    assert isinstance(state, EntityState)
    return Placement(held, state)


def place(placements: Sequence[Placement | ArticulationPlacement], scene: int) -> None:
    """Puts the bodies of a scene where their states say. `placements` in build order."""
    for placement in reversed(placements):
        placement.take_out(scene)
    for placement in placements:
        placement.move(scene)
        placement.put_in(scene)
        placement.settle(scene)


def place_afresh(placements: Sequence[Placement | ArticulationPlacement], scene: int, old: Any) -> Any:
    """As `place`, in a new scene whose simulation has no past. It takes over all that the old one held."""
    new: Any = sapien.Scene(_systems_like(old))
    new.set_timestep(old.get_timestep())
    entities = old.entities
    for entity in entities:
        old.remove_entity(entity)
    for placement in placements:
        placement.move(scene)
    for entity in entities:
        new.add_entity(entity)
    for placement in placements:
        placement.settle(scene)
    return new


def _systems_like(scene: Any) -> list[Any]:
    """A new system for the simulation, with the settings of the scene's, and its own one for rendering."""
    present = physx.get_scene_config()
    physx.set_scene_config(scene.physx_system.config)
    try:
        systems = [physx.PhysxCpuSystem()]
    finally:
        physx.set_scene_config(present)
    with suppress(RuntimeError):  # there is none
        systems.append(scene.render_system)
    return systems
