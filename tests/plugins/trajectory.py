"""What a scene does, step by step, to the bit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from scenecc.decompiler.reading import articulations


@dataclass(frozen=True)
class Trajectory:
    """Poses, velocities and joint positions of a scene.

    Attributes:
        states: (steps + 1, numbers) float32; the first row is before the first step.
        labels: what each column is, by the names of the scene.
    """

    states: np.ndarray
    labels: tuple[str, ...]


def trajectory(scene: Any, steps: int) -> Trajectory:
    """Steps a `sapien.Scene` by `scene.step()`: no controller runs, and drives hold what they were given before."""
    quantities = [
        *((entity, "pose", lambda entity: [*entity.pose.p, *entity.pose.q]) for entity in scene.entities),
        *(
            (component, "velocity", lambda body: [*body.linear_velocity, *body.angular_velocity])
            for entity in scene.entities
            for component in entity.components
            if hasattr(component, "linear_velocity")
        ),
        *((robot, "qpos", lambda robot: robot.qpos) for robot in articulations(scene)),
        *((robot, "qvel", lambda robot: robot.qvel) for robot in articulations(scene)),
    ]
    labels = (f"{what} of {of.name}[{i}]" for of, what, read in quantities for i in range(len(read(of))))
    rows: list[list[float]] = []
    for step in range(steps + 1):
        if step:
            scene.step()
        rows.append([number for of, _, read in quantities for number in read(of)])
    return Trajectory(np.array(rows, np.float32), tuple(labels))


def first_difference(a: Trajectory, b: Trajectory) -> str | None:
    """The earliest step at which two trajectories differ by a bit; None if none does.

    0.0 and -0.0 are equal. Names are not compared: what is built is compared elsewhere.
    """
    if a.states.shape != b.states.shape:
        return f"(steps + 1, numbers) are {a.states.shape} against {b.states.shape}"
    unequal = np.argwhere(~((a.states == b.states) | (np.isnan(a.states) & np.isnan(b.states))))
    if not len(unequal):
        return None
    step, column = (int(index) for index in unequal[0])
    kind = a.labels[column].partition(" of ")[0]
    alike = [index for index, label in enumerate(a.labels) if label.startswith(f"{kind} of ")]
    owners = {a.labels[index].rpartition("[")[0] for index in alike}
    moved = {a.labels[index].rpartition("[")[0] for index in {*alike} & {*unequal[:, 1].tolist()}}
    most = np.nanmax(np.abs(a.states - b.states)[:, alike])
    return (
        f"step {step}: {a.labels[column]} is {a.states[step, column]} against {b.states[step, column]}; "
        f"{len(moved)} of {len(owners)} differ in the end, by up to {most:.3g}"
    )
