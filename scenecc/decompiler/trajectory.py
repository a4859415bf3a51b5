"""Where everything is, step by step, to the bit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from scenecc.decompiler.reading import articulations


@dataclass(frozen=True)
class Trajectory:
    """What a scene did.

    Attributes:
        entities: names of the scene's entities, in their order.
        articulations: names of its articulations and their degrees of freedom, by their root links.
        poses: (steps + 1, entities, 7) float32: p, then q; the first row is before the first step.
        velocities: (steps + 1, entities, 6) float32: linear, then angular; zero for what has none.
        qpos: (steps + 1, sum of the degrees of freedom) float32.
        qvel: the same.
    """

    entities: tuple[str, ...]
    articulations: tuple[tuple[str, int], ...]
    poses: np.ndarray
    velocities: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray


def trajectory(scene: Any, steps: int) -> Trajectory:
    """Steps a scene and records every entity and joint.

    A step is `scene.step()` of SAPIEN, one time step of the engine: no controller runs, no drive target is set, and
    what a drive holds is what it was given before.

    Args:
        scene: a `sapien.Scene`; it is left where the last step put it.
        steps: how many.
    """
    entities, robots = list(scene.entities), articulations(scene)
    bodies = [_moving(entity) for entity in entities]
    rows = [_row(entities, bodies, robots)]
    for _ in range(steps):
        scene.step()
        rows.append(_row(entities, bodies, robots))
    poses, velocities, qpos, qvel = (np.stack(column) for column in zip(*rows, strict=True))
    return Trajectory(
        tuple(entity.name for entity in entities),
        tuple((robot.name, robot.dof) for robot in robots),
        poses,
        velocities,
        qpos,
        qvel,
    )


def first_difference(a: Trajectory, b: Trajectory) -> str | None:
    """The earliest step at which two trajectories differ by a bit, and how far apart they end; None if they do not.

    0.0 and -0.0 are equal. Names are not compared: what is built is compared elsewhere.
    """
    if a.poses.shape != b.poses.shape or a.qpos.shape != b.qpos.shape:
        return f"{_size(a)} against {_size(b)}"
    quantities = [
        ("pose", a.poses, b.poses, a.entities),
        ("velocity", a.velocities, b.velocities, a.entities),
        ("qpos", a.qpos, b.qpos, _joints(a)),
        ("qvel", a.qvel, b.qvel, _joints(a)),
    ]
    found = [line for line in (_first(*quantity) for quantity in quantities) if line is not None]
    return min(found)[1] if found else None


def _first(name: str, a: np.ndarray, b: np.ndarray, owners: tuple[str, ...]) -> tuple[int, str] | None:
    unequal = ~((a == b) | (np.isnan(a) & np.isnan(b)))
    if not unequal.any():
        return None
    where = tuple(int(axis[0]) for axis in unequal.nonzero())
    moved = {owners[int(column)] for column in unequal.nonzero()[1]}
    most = np.nanmax(np.abs(a - b))
    return where[0], (
        f"step {where[0]}: {name} of {owners[where[1]]}{list(where[2:]) or ''} is {a[where]} against {b[where]}; "
        f"{len(moved)} of {len(owners)} differ in the end, by up to {most:.3g}"
    )


def _joints(a: Trajectory) -> tuple[str, ...]:
    return tuple(f"{name}[{index}]" for name, dof in a.articulations for index in range(dof))


def _size(a: Trajectory) -> str:
    return f"{a.poses.shape[0] - 1} steps of {len(a.entities)} entities and {a.qpos.shape[1]} joints"


def _moving(entity: Any) -> Any:
    return next((component for component in entity.components if hasattr(component, "linear_velocity")), None)


def _row(entities: list[Any], bodies: list[Any], robots: list[Any]) -> tuple[np.ndarray, ...]:
    poses = np.array([[*entity.pose.p, *entity.pose.q] for entity in entities], dtype=np.float32).reshape(-1, 7)
    velocities = np.zeros((len(bodies), 6), dtype=np.float32)
    for row, body in zip(velocities, bodies, strict=True):
        if body is not None:
            row[:3], row[3:] = body.linear_velocity, body.angular_velocity
    none = np.zeros(0, dtype=np.float32)
    qpos = np.concatenate([none, *(robot.qpos for robot in robots)])
    return poses, velocities, qpos, np.concatenate([none, *(robot.qvel for robot in robots)])
