"""Bodies that are faster than the energy of their surroundings allows: what pushes them is an error of the simulation.

Bodies that may meet, or that constraints connect, exchange energy. Together they have at most the kinetic energy of the
start, what each weight has released on its way down, and what springs of constraints have stored at the start. What a
weight takes back on its way up is not subtracted: PhysX lets constraints drift, and a rope gains a little by that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.checks.physics import constrained_entities
from scenecc.geometry.rotations import IDENTITY_POSE, relative_pose, to_pose
from scenecc.plan import ArticulationStructure
from scenecc.plan.constraint import Distance, Drive
from scenecc.simulation.bodies import gravity_of
from scenecc.simulation.findings import Finding

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import Constraint, Entity

    Floats = NDArray[np.float64]

_Tie = tuple[set[str], float]
"""The entities that a constraint connects, and the energy that its springs store at the start [J]."""

THROWN: Final = 2.0
"""[m/s] Maximum speed beyond that of the energy. Overlapping bodies are pushed apart this fast."""

_MET: Final = 1e-4
"""[m], [rad] A spring that is stretched by less is at rest. Stiff ones would store much in an error of rounding."""

_MARGIN: Final = 0.02
"""[m] Bodies this close to each other's way may touch: twice the default `contact_offset`."""


@dataclass(frozen=True, slots=True)
class _Part:
    """A dynamic body, or a link, in one scene.

    Attributes:
        scene: index of the scene.
        entity: name of the entity.
        component: the engine's component.
        driven: whether drives do work on its articulation.
        is_judged: whether its speed is judged. Of a driven articulation, only that of a free root is.
    """

    scene: int
    entity: str
    component: Any
    driven: bool
    is_judged: bool


class EnergyWatch:
    """Compares speeds with the energy that there is, at each reading.

    Args:
        batch: a batch near its start.
    """

    def __init__(self, batch: SceneBatch) -> None:
        self._batch = batch
        self._parts = [part for entity in batch.plan.entities for part in _parts_of(batch, entity)]
        components = [part.component for part in self._parts]
        self._mass = np.array([float(each.mass) for each in components])
        falls = np.array([not each.disable_gravity for each in components], np.bool_)
        self._weight = self._mass[:, None] * falls[:, None] * gravity_of(batch.plan)
        self._start = self._positions()
        spin = np.array([_spin_energy(each) for each in components])
        self._kinetic = 0.5 * self._mass * (self._speeds() ** 2) + spin
        self._radius = np.array([_radius(each) for each in components]) + _MARGIN
        self._released = np.zeros(len(components))
        self._low, self._high = self._start.copy(), self._start.copy()
        self._excess = np.zeros(len(components))
        self._fastest = np.zeros(len(components))
        self._scenes = np.array([part.scene for part in self._parts], np.int64)
        self._ties = self._find_ties()

    def observe(self) -> None:
        """Reads the speeds. Called often enough, it sees every body on its way."""
        if not self._parts:
            return
        here, speeds = self._positions(), self._speeds()
        self._low, self._high = np.minimum(self._low, here), np.maximum(self._high, here)
        self._released = np.maximum(self._released, ((here - self._start) * self._weight).sum(axis=1))
        budget = self._kinetic + self._released
        judged = np.array([part.is_judged for part in self._parts], np.bool_)
        suspect = judged & (speeds - _speed(budget, self._mass) > THROWN)
        for scene in np.unique(self._scenes[suspect]).tolist():
            inside = np.flatnonzero(self._scenes == scene)
            for island, stored in self._islands(inside, scene):
                allowed = _speed(np.full(len(island), budget[island].sum() + stored), self._mass[island])
                driven = [int(number) for number in island if self._parts[int(number)].driven]
                if driven:
                    # The work of the drives is unknown, so what they push may be as fast as after a fall of its way.
                    # What they strike may be four times as fast as a link's centre: the end of a link that turns moves
                    # twice as fast, and an elastic impact on a light body doubles that.
                    way = np.linalg.norm(here[island] - self._start[island], axis=1)
                    fall = np.sqrt(2 * np.linalg.norm(gravity_of(self._batch.plan)) * way)
                    allowed = np.maximum(allowed, np.maximum(fall, 4 * speeds[driven].max()))
                excess = np.where(suspect[island], speeds[island] - allowed, 0.0)
                self._fastest[island] = np.where(excess > self._excess[island], speeds[island], self._fastest[island])
                self._excess[island] = np.maximum(self._excess[island], excess)

    def struck(self) -> set[tuple[int, str]]:
        """Returns scenes and names of all that bodies with an initial velocity may have met."""
        found: set[tuple[int, str]] = set()
        for scene in np.unique(self._scenes[self._kinetic > 0]).tolist():
            for island, _ in self._islands(np.flatnonzero(self._scenes == scene), scene):
                if self._kinetic[island].any():
                    found |= {(scene, self._parts[int(number)].entity) for number in island}
        return found

    def findings(self) -> Iterator[Finding]:
        """Yields the bodies that were too fast; of those that constraints connect, the worst."""
        worst: dict[tuple[int, Any], int] = {}
        tied = constrained_entities(self._batch.plan)
        groups = self._tied_groups()
        for number in np.flatnonzero(self._excess > THROWN).tolist():
            part = self._parts[number]
            key = part.scene, groups[number] if part.entity in tied else part.entity
            if key not in worst or self._excess[number] > self._excess[worst[key]]:
                worst[key] = number
        for number in worst.values():
            part, excess = self._parts[number], float(self._excess[number])
            is_tied = part.entity in tied
            others = "what it touches and is attached to" if is_tied else "what it touches"
            hint = (
                "lower `timestep`, raise `solver_position_iterations`, replace a `connection` with a `ball`, or give a "
                "constraint frames that are nearer to its bodies"
            )
            yield Finding(
                "SC856", (part.entity,), part.scene, excess,
                f"`{part.entity}` is thrown: it reaches {self._fastest[number]:.3g} m/s, {excess:.3g} m/s more than "
                f"its fall and {others} can give it",
                hint if is_tied else None,
            )  # fmt: skip

    def _positions(self) -> Floats:
        """Returns the centres of mass (N, 3) in their worlds [m]."""
        poses = [part.component.entity_pose * part.component.cmass_local_pose for part in self._parts]
        return np.array([pose.p for pose in poses], np.float64).reshape(-1, 3)

    def _speeds(self) -> Floats:
        """Returns the speeds (N,) of the centres of mass [m/s]."""
        linear = [part.component.get_linear_velocity() for part in self._parts]
        return np.linalg.norm(np.array(linear, np.float64).reshape(-1, 3), axis=1)

    def _find_ties(self) -> dict[int, list[_Tie]]:
        """Returns the constraints of each scene."""
        ties: dict[int, list[_Tie]] = {}
        for constraint in self._batch.plan.constraints:
            if constraint.name not in self._batch.constraints:
                continue
            built = self._batch.constraints[constraint.name]
            row_of = {index: row for row, index in enumerate(constraint.scene_idxs)}
            names = {mount.entity for mount in (constraint.child, constraint.parent) if mount is not None}
            for scene, component in zip(built.scene_idxs, built.objs, strict=True):
                stored = _stored_energy(constraint, row_of[scene], component, float(self._mass.sum()))
                ties.setdefault(scene, []).append((names, stored))
        return ties

    def _islands(self, inside: NDArray[np.intp], scene: int) -> Iterator[tuple[NDArray[np.intp], float]]:
        """Yields the parts of a scene that may exchange energy, with the energy that their constraints stored [J]."""
        low, high = self._low[inside] - self._radius[inside, None], self._high[inside] + self._radius[inside, None]
        meet: NDArray[np.bool_] = np.all((low[:, None] <= high[None]) & (high[:, None] >= low[None]), axis=2)
        groups = _joined([self._parts[int(number)].entity for number in inside], self._ties.get(scene, ()), meet)
        for group in np.unique(groups).tolist():
            island = inside[groups == group]
            names = {self._parts[int(number)].entity for number in island}
            stored = sum(energy for tied, energy in self._ties.get(scene, ()) if tied & names)
            yield island, stored

    def _tied_groups(self) -> NDArray[np.intp]:
        """Returns a number per part (N,), equal for parts of a scene that constraints connect."""
        groups = np.zeros(len(self._parts), np.intp)
        for scene in np.unique(self._scenes).tolist():
            inside = np.flatnonzero(self._scenes == scene)
            names = [self._parts[int(number)].entity for number in inside]
            groups[inside] = _joined(names, self._ties.get(scene, ()), np.eye(len(inside), dtype=np.bool_))
        return groups


def _joined(names: list[str], ties: Sequence[_Tie], meet: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Returns the group of each part (N,): parts of one entity, of tied entities, and that meet (N, N) are in one."""
    of_entity = np.array(names)
    near = meet | (of_entity[:, None] == of_entity[None])
    for tied, _ in ties:
        is_tied = np.isin(of_entity, sorted(tied))
        near |= is_tied[:, None] & is_tied[None]
    groups, before = np.arange(len(names)), np.full(len(names), -1)
    while (groups != before).any():
        before, groups = groups, np.where(near, groups[None], len(names)).min(axis=1)
        groups = groups[groups]
    return groups


def _speed(energy: Floats, mass: Floats) -> Floats:
    """Returns the speed of a mass [kg] that has an energy [J]."""
    return np.sqrt(2 * np.maximum(energy, 0.0) / mass)


def _parts_of(batch: SceneBatch, entity: Entity) -> Iterator[_Part]:
    there = set(batch.scene_idxs)
    for row, index in enumerate(entity.scene_idxs):
        if index not in there:
            continue
        structure = entity.structure(row)
        if not isinstance(structure, ArticulationStructure):
            if structure.body_type == "dynamic":
                bodies = batch.entities[entity.name]
                components = bodies.objs[bodies.scene_idxs.index(index)].get_components()
                component = next(each for each in components if hasattr(each, "get_cmass_local_pose"))
                yield _Part(index, entity.name, component, driven=False, is_judged=True)
            continue
        robots = batch.articulations[entity.name]
        at = robots.scene_idxs.index(index)
        driven = bool(structure.mimics) or any(
            joint.stiffness or joint.damping for joint in robots.objs[at].get_active_joints()
        )
        for number, link in enumerate(robots.objs[at].links):
            is_root = number == 0
            if not (is_root and structure.fix_root_link):
                yield _Part(index, entity.name, link, driven, is_judged=is_root or not driven)


def _spin_energy(component: Any) -> float:
    """Returns at least the energy of rotation [J]."""
    return 0.5 * float(np.max(component.inertia)) * float(np.sum(np.square(component.get_angular_velocity())))


def _radius(component: Any) -> float:
    if not component.collision_shapes:
        return 0.0
    low, high = np.array(component.get_global_aabb_fast(), np.float64)
    centre = (component.entity_pose * component.cmass_local_pose).p
    return float(np.linalg.norm(np.maximum(high - centre, centre - low)))


def _stored_energy(constraint: Constraint, row: int, component: Any, mass: float) -> float:
    """Returns at least the energy [J] that the springs of a constraint can release, from its pose now.

    Infinite for a drive with a target velocity. `mass`: of all bodies [kg], for drives of accelerations.
    """
    joint = constraint.joint
    if isinstance(joint, Distance) and joint.stiffness is not None:
        low, high = map(float, joint.limits.row(row))
        excess = max(low - component.distance, component.distance - high, 0.0)
        return 0.5 * float(joint.stiffness.row(row)) * excess**2
    if not isinstance(joint, Drive):
        return 0.0
    velocities = (joint.linear_velocity_target, joint.angular_velocity_target)
    if any(value is not None and np.any(value.row(row)) for value in velocities):
        return math.inf
    target = IDENTITY_POSE if joint.target is None else to_pose(joint.target.row(row))
    pose = to_pose((*component.relative_pose.p, *component.relative_pose.q))
    ways = {axis: abs(pose[number] - target[number]) for number, axis in enumerate("xyz")}
    w, *vector = relative_pose(target, pose)[3:]
    turn = 2 * math.atan2(math.hypot(*vector), abs(w))
    limits = ((each.axis, each.stiffness, 1.0) for each in joint.limits if each.stiffness is not None)
    drives = ((each.axis, each.stiffness, mass if each.mode == "acceleration" else 1.0) for each in joint.drives)
    stored = 0.0
    for axis, stiffness, scale in (*limits, *drives):
        way = ways.get(axis, turn)
        stored += 0.5 * scale * float(stiffness.row(row)) * way**2 if way > _MET else 0.0
    return stored
