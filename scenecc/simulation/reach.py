"""Reach and gripper of a robot, by its joints as built."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.geometry.rotation_arrays import pose_matrix
from scenecc.geometry.rotations import invert

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity

    Floats = NDArray[np.float64]

_SWEEPS: Final = 3
_STEPS: Final = 36
"""Sweeps over the joints, and positions of each, in the search for the farthest point."""

_FINGER: Final = re.compile(r"finger|gripper|jaw|knuckle", re.IGNORECASE)


def gripper_of(robot: MeasuredEntity) -> dict[str, Any] | None:
    """Returns the link that carries at least two fingers, with their joints and opening; None if there is none.

    Fingers are moving links without moving links below them, whose names say so, or which slide on a link that moves.
    """
    bodies = robot.bodies
    moving = [body for body in bodies if body.joint is not None and body.joint.type != "fixed"]
    parents = {_moving_parent(bodies, body) for body in moving}
    fingers: dict[int | None, list[MeasuredBody]] = {}
    for body in moving:
        assert body.joint is not None
        named = _FINGER.search(f"{body.name} {body.joint.name}")
        if bodies.index(body) not in parents and (named or body.joint.type == "prismatic"):
            fingers.setdefault(_moving_parent(bodies, body), []).append(body)
    for top, found in fingers.items():
        named = [_FINGER.search(f"{body.name} {body.joint.name}") for body in found if body.joint is not None]
        if len(found) < 2 or (hand := found[0].parent) is None or not (all(named) or top is not None):
            continue
        joints = [body.joint for body in found if body.joint is not None]
        slides = all(one.type == "prismatic" and all(map(math.isfinite, one.limits)) for one in joints)
        opening = round(sum(one.limits[1] - one.limits[0] for one in joints), 4) if slides else None
        return {"link": bodies[hand].name, "joints": [one.name for one in joints], "opening_m": opening}
    return None


def _moving_parent(bodies: Sequence[MeasuredBody], body: MeasuredBody) -> int | None:
    """Returns the nearest link above that moves relative to its own parent; None if there is none."""
    number = body.parent
    while number is not None:
        joint = bodies[number].joint
        if joint is not None and joint.type != "fixed":
            return number
        number = bodies[number].parent
    return None


def reach_of(robot: MeasuredEntity, link: str | None) -> float | None:
    """Returns the largest distance [m] that a search finds between the origins of the root and of a link.

    Args:
        robot: the robot.
        link: name of the link; None: that with most moving joints above it.
    """
    chains = [_chain(robot.bodies, number) for number in range(len(robot.bodies))]
    if link is not None:
        chain = next(one for one in chains if one[-1].name == link)
    else:
        chain = max(chains, key=lambda one: sum(body.joint is not None and body.joint.type != "fixed" for body in one))
    links = [body for body in chain if body.joint is not None]
    joints = [body.joint for body in links if body.joint is not None]
    frames = [(pose_matrix(one.pose_in_parent), pose_matrix(invert(one.pose_in_child))) for one in joints]
    ranges = [_positions(body) for body in links]
    free = [number for number, one in enumerate(ranges) if len(one) > 1]
    if not free:
        return None
    best = 0.0
    for start in (0.25, 0.5, 0.75):
        at = [float(one[int(start * (len(one) - 1))]) for one in ranges]
        for _ in range(_SWEEPS):
            for number in free:
                far = [_distance(links, frames, [*at[:number], value, *at[number + 1 :]]) for value in ranges[number]]
                at[number] = float(ranges[number][int(np.argmax(far))])
                best = max(best, *far)
    return round(best, 3)


def _chain(bodies: Sequence[MeasuredBody], number: int | None) -> list[MeasuredBody]:
    """Returns the links from the root to a link."""
    found: list[MeasuredBody] = []
    while number is not None:
        found.insert(0, bodies[number])
        number = bodies[number].parent
    return found


def _positions(body: MeasuredBody) -> Floats:
    """Returns the positions of a joint to try, [m] or [rad]."""
    joint = body.joint
    if joint is None or joint.type == "fixed":
        return np.zeros(1)
    low, high = joint.limits
    if not (math.isfinite(low) and math.isfinite(high)):
        if joint.type == "prismatic":
            return np.array([joint.qpos])
        low, high = -math.pi, math.pi
    return np.linspace(low, high, _STEPS)


def _distance(links: Sequence[MeasuredBody], frames: Sequence[tuple[Floats, Floats]], at: Sequence[float]) -> float:
    frame = np.eye(4)
    for body, (before, after), value in zip(links, frames, at, strict=True):
        move = np.eye(4)
        if body.joint is not None and body.joint.type == "prismatic":
            move[0, 3] = value
        elif body.joint is not None and body.joint.type != "fixed":
            sine, cosine = math.sin(value), math.cos(value)
            move[1:3, 1:3] = [[cosine, -sine], [sine, cosine]]
        frame = frame @ before @ move @ after
    return float(np.linalg.norm(frame[:3, 3]))
