"""Whether what was placed is as far apart as it must be: found anew, from the final poses alone."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from scenecc.placing.bodies import entity_parts, matrices
from scenecc.placing.distances import are_apart, distances
from scenecc.placing.pairs import core_pairs
from scenecc.plan.body import groups_collide

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import NDArray

    from scenecc.placing.bodies import Part
    from scenecc.plan import ScenePlan
    from scenecc.plan.placement import Placement
    from scenecc.variation.evaluation import Batch

    Floats = NDArray[np.float64]

_TOLERANCE = 2e-6
"""By how much less than asked for a distance may be [m]."""


def find_overlap(plan: ScenePlan, batch: Batch, poses: Mapping[str, Floats]) -> str | None:
    """What is nearer than it may be, in words; None where nothing is.

    Args:
        plan: with its placements.
        batch: the scenes (B,).
        poses: of all its entities in these scenes, in the world (B, 7).
    """
    placed = {member: one for one in plan.placements for member in one.entities}
    world = {
        entity.name: [
            part.moved(matrices(poses[entity.name][:, 3:]), poses[entity.name][:, :3])
            for part in entity_parts(entity, plan.files, batch)
        ]
        for entity in plan.entities
        if entity.name in poses
    }
    for a, b in combinations(world, 2):
        least = _least_distance(a, b, placed)
        if least is None:
            continue
        for distance, number in _too_near(world[a], world[b], least):
            scene = int(batch.scenes[number])
            if distance > 0:
                return f"in scene {scene} `{a}` and `{b}` are {distance:.6g} m apart, less than {least:g} m"
            return f"in scene {scene} `{a}` and `{b}` overlap"
    return None


def _least_distance(a: str, b: str, placed: Mapping[str, Placement]) -> float | None:
    """How far apart two entities must be [m]; None where nothing is said of them."""
    ones = [placed[name] for name in (a, b) if name in placed]
    if not ones or (len(ones) == 2 and ones[0] is ones[1]):
        return None
    for name, other in ((a, b), (b, a)):
        one = placed.get(name)
        if one is not None and (other == one.target.entity or other in one.carrying):
            return 0.0
    return max(one.apart for one in ones)


def _too_near(a: list[Part], b: list[Part], least: float) -> Iterator[tuple[float, int]]:
    """The pairs of parts that are nearer than they may be: their distance [m], and the row of the scene."""
    for one in a:
        for other in b:
            both = one.there & other.there & groups_collide(one.groups.T, other.groups.T)
            if one.is_plane or other.is_plane:
                plane, solid = (one, other) if one.is_plane else (other, one)
                normal = plane.turn[:, :, 0]
                height = -solid.extent(-normal) - np.einsum("ij,ij->i", normal, plane.p)
                for row in np.flatnonzero(both & (height < least - _TOLERANCE)).tolist() if not solid.is_plane else ():
                    yield float(height[row]), row
                continue
            between = np.sqrt(((one.p - other.p) ** 2).sum(axis=1))
            close = both & (between <= one.reach + other.reach + least)
            if not least and close.any():
                # What stands on the other is above it.
                up = np.broadcast_to((0.0, 0.0, 1.0), one.p.shape)
                close &= (-one.extent(-up) <= other.extent(up)) & (-other.extent(-up) <= one.extent(up))
            rows = np.flatnonzero(close)
            if rows.size:
                pair, first, second = core_pairs(one, rows, other, rows, least)
                wanted = np.full(len(pair), max(least - _TOLERANCE, 0.0))
                if not least:
                    # What touches does not overlap.
                    first.p = first.p + np.where(first.p[:, 2] < second.p[:, 2], -1, 1)[:, None] * (
                        0.0,
                        0.0,
                        _TOLERANCE,
                    )
                for number in np.flatnonzero(~are_apart(first, second, wanted)).tolist():
                    some = np.array([number])
                    yield float(distances(first.taken(some), second.taken(some))[0]), int(rows[pair[number]])
