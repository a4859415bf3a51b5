"""The bodies that the simulation moves: dynamic bodies and articulations with a free root, in each of their scenes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.geometry.rotations import IDENTITY_POSE, rotate, to_pose
from scenecc.plan import BodyStructure
from scenecc.plan.geometry import Capsule, Cylinder, Sphere

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import Entity, ScenePlan
    from scenecc.plan.articulation import ArticulationStructure

    Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class MovingBody:
    """A dynamic body, or the root of a free articulation, in one scene.

    Attributes:
        scene: index of the scene.
        entity: name of the entity.
        obj: the `sapien.Entity`.
        component: the body's component, or the root link.
        moves_at_start: whether it has an initial velocity.
        axis: axis of rotational symmetry in its own frame (3,). Zero: every axis, as for a ball; None: no axis.
    """

    scene: int
    entity: str
    obj: Any
    component: Any
    moves_at_start: bool
    axis: Floats | None


def moving_bodies(batch: SceneBatch) -> list[MovingBody]:
    """Returns all moving bodies of a batch, entity by entity in build order."""
    there = set(batch.scene_idxs)
    found = (
        _moving_body(batch, entity, row, index)
        for entity in batch.plan.entities
        for row, index in enumerate(entity.scene_idxs)
        if index in there
    )
    return [body for body in found if body is not None]


def gravity_of(plan: ScenePlan) -> Floats:
    """Returns gravity in the world frame (3,) [m/s²]; SAPIEN's default if the plan sets none."""
    return np.array(plan.physics.gravity or (0.0, 0.0, -9.81))


def up_of(plan: ScenePlan) -> Floats | None:
    """Returns the direction against gravity (3,), of unit length; None without gravity."""
    gravity = gravity_of(plan)
    strength = float(np.linalg.norm(gravity))
    return -gravity / strength if strength else None


def poses(bodies: list[MovingBody]) -> Floats:
    """Returns poses (N, 7) in the world of their scenes, p [m] then q (wxyz)."""
    return np.array([body.obj.get_pose().__getstate__() for body in bodies], np.float64).reshape(-1, 7)


def velocities(bodies: list[MovingBody]) -> Floats:
    """Returns velocities (N, 6) in the world frame, linear [m/s] then angular [rad/s]."""
    linear = np.array([body.component.get_linear_velocity() for body in bodies], np.float64).reshape(-1, 3)
    angular = np.array([body.component.get_angular_velocity() for body in bodies], np.float64).reshape(-1, 3)
    return np.hstack([linear, angular])


def _moving_body(batch: SceneBatch, entity: Entity, row: int, index: int) -> MovingBody | None:
    structure = entity.structure(row)
    moves = any(_moves(structure, row))
    if isinstance(structure, BodyStructure):
        if structure.body_type != "dynamic":
            return None
        bodies = batch.entities[entity.name]
        obj = bodies.objs[bodies.scene_idxs.index(index)]
        component = next(each for each in obj.get_components() if hasattr(each, "get_cmass_local_pose"))
        return MovingBody(index, entity.name, obj, component, moves, _round_axis(structure, row))
    if structure.fix_root_link:
        return None
    robots = batch.articulations[entity.name]
    root = robots.links[structure.links[0].name][robots.scene_idxs.index(index)]
    return MovingBody(index, entity.name, root.get_entity(), root, moves, None)


def _moves(structure: BodyStructure | ArticulationStructure, row: int) -> Iterator[bool]:
    for value in (structure.linear_velocity, structure.angular_velocity):
        yield value is not None and bool(np.any(value.row(row)))


def _round_axis(structure: BodyStructure, row: int) -> Floats | None:
    """Returns the axis of a body with one collision shape. SAPIEN's cylinders and capsules are along their x axis."""
    if len(structure.collisions) != 1:
        return None
    shape = structure.collisions[0]
    if isinstance(shape.geometry, Sphere):
        return np.zeros(3)
    if not isinstance(shape.geometry, Cylinder | Capsule):
        return None
    pose = IDENTITY_POSE if shape.pose is None else to_pose(shape.pose.row(row))
    return np.array(rotate(pose[3:], (1.0, 0.0, 0.0)))
