"""Findings of a simulation: bodies that topple, sink into others, or move beyond all measure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.geometry.rotation_arrays import rotate
from scenecc.simulation.bodies import moving_bodies, poses, velocities
from scenecc.simulation.findings import Finding, length_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import ScenePlan
    from scenecc.simulation.bodies import MovingBody

    Floats = NDArray[np.float64]

TOPPLED: Final = np.radians(30)
"""[rad] A body that has turned its up by more has not stayed upright."""

STANDING: Final = np.cos(np.radians(5))
"""A body stands where one of its axes is this near to vertical; of one that lies anyhow nothing is expected."""

SUNK: Final = 0.002
"""[m] How deep a body may stand in another at the end. PhysX lets bodies at rest penetrate by tenths of millimetres."""

THROWN: Final = 2.0
"""[m/s] By how much a body may be faster than by falling: what overlaps is pushed apart as fast as that and faster."""

_STRIDE: Final = 10
"""Steps from one look at the velocities to the next."""


def simulate(batch: SceneBatch, seconds: float) -> Iterator[Finding]:
    """Simulates a batch that was stepped once, and yields what does not stay as it was.

    Args:
        batch: after its first step.
        seconds: how long.

    Raises:
        SceneError: a state is not finite (SC820).
    """
    moving = moving_bodies(batch)
    steps = max(round(seconds / batch.timestep), 1)
    start, fastest = poses(moving), np.zeros(len(moving))
    for done in range(0, steps, _STRIDE):
        batch.step(min(_STRIDE, steps - done), check=True)
        if moving:
            fastest = np.maximum(fastest, np.linalg.norm(velocities(moving)[:, :3], axis=1))
    end = poses(moving)
    free = {body.entity for body in moving} - _moved_on_purpose(batch.plan)
    judged = [not body.moves_at_start and body.entity in free for body in moving]
    tilt, stands = tilts(moving, start, end), _stands(start)
    gravity = batch.plan.physics.gravity or (0.0, 0.0, -9.81)
    falling = float(np.linalg.norm(gravity)) * seconds
    for number, body in enumerate(moving):
        name = body.entity
        if judged[number] and stands[number] and tilt[number] > TOPPLED:
            yield Finding(
                "SC854",
                (name,),
                body.scene,
                float(tilt[number]),
                f"`{name}` topples: it is turned by {np.degrees(tilt[number]):.0f}° after {seconds:g} s",
            )
        if judged[number] and fastest[number] > falling + THROWN:
            yield Finding(
                "SC856",
                (name,),
                body.scene,
                float(fastest[number]),
                f"`{name}` is thrown: it reaches {fastest[number]:.3g} m/s within {seconds:g} s",
            )
    yield from _sunk(batch)


def tilts(moving: list[MovingBody], start: Floats, end: Floats) -> Floats:
    """(N,) [rad] how far each has turned its up since the start; of what is round the axis, of a ball nothing."""
    up = np.zeros((len(moving), 3))
    up[:, 2] = 1.0
    own = rotate(start[:, 3:] * (1.0, -1.0, -1.0, -1.0), up)
    is_round = np.zeros(len(moving), np.bool_)
    for number, body in enumerate(moving):
        if body.axis is not None:
            own[number], is_round[number] = body.axis, True
    cosine = np.einsum("ij,ij->i", rotate(start[:, 3:], own), rotate(end[:, 3:], own))
    # A round body is the same upside down, and of a ball, which has no axis, nothing is seen.
    cosine = np.where(is_round, np.where(own.any(axis=1), np.abs(cosine), 1.0), cosine)
    return np.arccos(np.clip(cosine, -1.0, 1.0))


def _moved_on_purpose(plan: ScenePlan) -> set[str]:
    """Entities that are placed above something, to fall, and those that hang on a constraint."""
    placed = {name for one in plan.placements if one.kind == "above" for name in one.entities}
    return placed | {mount.entity for one in plan.constraints for mount in (one.child, one.parent) if mount is not None}


def _stands(start: Floats) -> NDArray[np.bool_]:
    """(N,) whether one of the axes of each is about vertical."""
    w, x, y, z = start[:, 3:].T
    up = np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)
    return np.abs(up).max(axis=1, initial=0.0) > STANDING


def _sunk(batch: SceneBatch) -> Iterator[Finding]:
    """Bodies that penetrate each other at the end; links are pressed against what they hold by their drives."""
    contacts, bodies = batch.contacts(), set(batch.entities)
    for number in np.flatnonzero(contacts.separation < -SUNK).tolist():
        a, b = str(contacts.a[number]), str(contacts.b[number])
        if not {a, b} <= bodies:
            continue
        depth = -float(contacts.separation[number])
        yield Finding(
            "SC855",
            (a, b),
            int(contacts.scene[number]),
            depth,
            f"`{a}` and `{b}` penetrate each other by {length_text(depth)} after the simulation",
        )
