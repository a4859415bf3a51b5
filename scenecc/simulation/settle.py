"""Findings of a simulation: bodies that topple, sink into others, or are thrown away."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.checks.physics import constrained_entities
from scenecc.geometry.rotation_arrays import rotate
from scenecc.simulation.bodies import poses, up_of
from scenecc.simulation.bounds import scenes_in_doubt
from scenecc.simulation.findings import Finding, length_text
from scenecc.simulation.loads import beyond_limits
from scenecc.simulation.start import (
    articulation_names,
    fixed_bodies,
    owner,
    stretched_constraints,
    unsupported_bodies,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import ScenePlan
    from scenecc.simulation.bodies import MovingBody
    from scenecc.simulation.energy import EnergyWatch
    from scenecc.simulation.expect import ExpectationChecker, OverlapRules
    from scenecc.simulation.robots import RobotWatch

    Floats = NDArray[np.float64]

TOPPLED: Final = np.radians(30)
"""[rad] A body that tilts by more has toppled."""

STANDING: Final = np.cos(np.radians(5))
"""A body is upright if one of its axes is this close to vertical. Other bodies may topple."""

SUNK: Final = 0.002
"""[m] How deep a body may overlap another at the end. PhysX lets bodies at rest overlap by tenths of millimetres."""

PRESSED: Final = 0.005
"""[m] The same for a link pressed against an object by its drive: fingers of ManiSkill's tasks reach 2.4 mm."""

_STRIDE: Final = 10
"""Steps between two readings of the velocities."""


def simulate(
    batch: SceneBatch,
    moving: list[MovingBody],
    watches: tuple[EnergyWatch, RobotWatch],
    seconds: float,
    rules: OverlapRules,
    checker: ExpectationChecker | None,
) -> Iterator[Finding]:
    """Simulates a batch after its first step, and yields bodies that topple, sink, fall or are thrown.

    Args:
        batch: a batch after its first step.
        moving: its moving bodies.
        watches: made before the first step.
        seconds: simulated time [s], above 0.
        rules: how deep bodies may overlap.
        checker: checks the expectations, which may need a longer simulation; None: there are none.

    Raises:
        SceneError: a state is not finite (SC820).
    """
    last = 1 + max(round(seconds / batch.timestep), 1)
    start, done = poses(moving), 1
    deep: dict[tuple[int, str, str], float] = {}
    energy, robots = watches
    energy.observe()
    for end in sorted({last, *(checker.steps if checker else ())}):
        while done < end:
            # Overlapping bodies are fastest within the first steps.
            stride = 1 if done <= _STRIDE else min(_STRIDE, end - done)
            if done + stride >= last > done:
                deep = _overlap_depths(batch)
            batch.step(stride, check=True)
            done += stride
            if done <= last:
                energy.observe()
                robots.observe(stride * batch.timestep, late=robots.is_late(done, last))
        if end == last:
            struck = energy.struck()
            unmoved = [(body.scene, body.entity) not in struck for body in moving]
            yield from _find_toppled(batch, seconds, moving, start, unmoved)
            yield from energy.findings()
            yield from robots.findings(seconds)
            yield from _find_sunk(batch, rules, deep)
            yield from beyond_limits(batch, seconds)
            yield from stretched_constraints(batch, seconds)
            yield from _find_fallen(batch, [body for body in moving if not body.moves_at_start], seconds)
        if checker:
            yield from checker.check(end)


def _find_toppled(
    batch: SceneBatch, seconds: float, moving: list[MovingBody], start: Floats, unmoved: list[bool]
) -> Iterator[Finding]:
    """Yields bodies that topple. `unmoved`: whether nothing with an initial velocity may have met each."""
    end, up = poses(moving), up_of(batch.plan)
    if up is None:
        return
    free = {body.entity for body in moving} - _expected_to_move(batch.plan)
    is_checked = [still and body.entity in free for body, still in zip(moving, unmoved, strict=True)]
    tilt, is_upright = tilts(moving, start, end, up), _is_upright(start, up)
    for number, body in enumerate(moving):
        name = body.entity
        if is_checked[number] and is_upright[number] and tilt[number] > TOPPLED:
            yield Finding(
                "SC854",
                (name,),
                body.scene,
                float(tilt[number]),
                f"`{name}` topples: it tilts by {np.degrees(tilt[number]):.0f}° after {seconds:g} s",
            )


def tilts(moving: list[MovingBody], start: Floats, end: Floats, up: Floats) -> Floats:
    """Returns the tilt (N,) of each body since the start [rad]: of its axis for a round body, zero for a ball.

    `up` (3,): the direction against gravity.
    """
    own = rotate(start[:, 3:] * (1.0, -1.0, -1.0, -1.0), np.broadcast_to(up, (len(moving), 3)))
    is_round = np.zeros(len(moving), np.bool_)
    for number, body in enumerate(moving):
        if body.axis is not None:
            own[number], is_round[number] = body.axis, True
    cosine = np.einsum("ij,ij->i", rotate(start[:, 3:], own), rotate(end[:, 3:], own))
    # A round body may be upside down, and the rotation of a ball is invisible.
    cosine = np.where(is_round, np.where(own.any(axis=1), np.abs(cosine), 1.0), cosine)
    return np.arccos(np.clip(cosine, -1.0, 1.0))


def _expected_to_move(plan: ScenePlan) -> set[str]:
    """Returns entities that start above a support in order to fall, and those that a constraint holds."""
    placed = {name for one in plan.placements if one.kind == "above" for name in one.entities}
    return placed | constrained_entities(plan)


def _is_upright(start: Floats, up: Floats) -> NDArray[np.bool_]:
    """Returns whether one of the axes of each body is nearly vertical (N,)."""
    own = rotate(start[:, 3:] * (1.0, -1.0, -1.0, -1.0), np.broadcast_to(up, (len(start), 3)))
    return np.abs(own).max(axis=1, initial=0.0) > STANDING


def _overlap_depths(batch: SceneBatch) -> dict[tuple[int, str, str], float]:
    """Returns the depth of overlapping bodies, links included [m]: (scene, name, name) → depth."""
    contacts = batch.contacts(scene_idxs=scenes_in_doubt(batch, SUNK))
    deepest: dict[tuple[int, str, str], float] = {}
    for number in np.flatnonzero(contacts.separation < -SUNK).tolist():
        key = int(contacts.scene[number]), str(contacts.a[number]), str(contacts.b[number])
        deepest[key] = max(deepest.get(key, 0.0), -float(contacts.separation[number]))
    return deepest


def _find_sunk(batch: SceneBatch, rules: OverlapRules, before: dict[tuple[int, str, str], float]) -> Iterator[Finding]:
    """Yields bodies that overlap at the end. `before`: depths shortly before; other pairs collide only now."""
    bodies, fixed = set(batch.entities), fixed_bodies(batch.plan)
    articulations = articulation_names(batch.plan)
    for (scene, a, b), deep in _overlap_depths(batch).items():
        depth = min(deep, before.get((scene, a, b), before.get((scene, b, a), 0.0)))
        if depth < SUNK or (depth < PRESSED and not {a, b} <= bodies) or {a, b} <= fixed:
            continue
        if rules.excuses((a, owner(a, articulations)), (b, owner(b, articulations))):
            continue
        first, second = (b, a) if a in fixed & bodies else (a, b)
        message = f"`{first}` and `{second}` penetrate each other by {length_text(depth)} after the simulation"
        yield Finding("SC855", (first, second), scene, depth, message)


def _find_fallen(batch: SceneBatch, moving: list[MovingBody], seconds: float) -> Iterator[Finding]:
    """Yields bodies that lost their support. Bodies without support at the start are reported separately."""
    for found in unsupported_bodies(batch, moving):
        message = f"nothing is below `{found.names[0]}` after {seconds:g} s: it falls forever"
        hint = "it rolls or slides off its support, or passes through it"
        yield replace(found, message=message, amount=-math.inf, hint=hint)
