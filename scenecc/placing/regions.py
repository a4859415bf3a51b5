"""Sampling of the origins of placed entities, and rotation of axes about z."""

from __future__ import annotations

import cmath
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.placing.bodies import Part, matrices
from scenecc.placing.surfaces import footprint, hull_order
from scenecc.plan.scene import placing_draw_name
from scenecc.variation.evaluation import Batch, key_units
from scenecc.variation.nodes import Key

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotation_arrays import Floats, Indices
    from scenecc.plan import Value
    from scenecc.plan.placement import Placement


def headings(q: Floats) -> Floats:
    """Returns the rotation of x axes about z for rotations (B, 4), (B,) [rad]; of y axes if x is vertical."""
    m = matrices(q)
    upright = np.hypot(m[:, 0, 0], m[:, 1, 0]) < 1e-9
    x, y = np.where(upright, m[:, 1, 1], m[:, 0, 0]), np.where(upright, -m[:, 0, 1], m[:, 1, 0])
    if len(x) > 1 and (x == x[0]).all() and (y == y[0]).all():
        return np.full(len(x), math.atan2(float(y[0]), float(x[0])))
    return np.array([math.atan2(b, a) for a, b in zip(x.tolist(), y.tolist(), strict=True)])


def unit_vectors(angle: Floats) -> Floats:
    """Returns the directions (B, 2) of angles (B,) [rad], computed by the C library as everywhere else."""
    same = len(angle) > 1 and bool((angle == angle[0]).all())
    unit = [cmath.rect(1.0, one) for one in (angle[:1] if same else angle).tolist()]
    found = np.array([(one.real, one.imag) for one in unit]).reshape(-1, 2)
    return np.broadcast_to(found, (len(angle), 2)) if same else found


def about_z(angle: Floats) -> Floats:
    """Returns the quaternions (B, 4) of rotations about z (B,) [rad]."""
    found = np.zeros((len(angle), 4))
    found[:, 0], found[:, 3] = unit_vectors(angle / 2).T
    return found


def turn_points(points: Floats, angle: Floats) -> Floats:
    """Returns points (B, 2) rotated about z by angles (B,) [rad]."""
    c, s = unit_vectors(angle).T
    return np.stack([c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]], axis=1)


def drawn_units(batch: Batch, name: str, path: str, count: int) -> Floats:
    """Returns random numbers in [0, 1) for a key of `place`, (B, count)."""
    chosen: Any = batch.draws.get(placing_draw_name(name, path))
    return key_units(batch, Key("entities", name, path) if chosen is None else chosen.key, 0, count)


def points_in_regions(
    placement: Placement,
    rectangle: Floats | None,
    rows: Indices,
    batch: Batch,
    value: Callable[[Value], Floats],
) -> Floats:
    """Returns points (M, 2) in the axes of a placement, uniformly distributed by area [m].

    Args:
        placement: the placement.
        rectangle: minimum x and y, then maximum (B, 4), used if the placement gives no region [m].
        rows: rows of the batch of all scenes (M,).
        batch: batch of the tries.
        value: evaluates a value of the placement in them.
    """
    if placement.at is not None:
        return value(placement.at)
    u = drawn_units(batch, placement.name, "place.region", 2)
    if placement.center is not None and placement.radius is not None:
        radius = value(placement.radius) * np.sqrt(u[:, 0])
        return value(placement.center) + radius[:, None] * unit_vectors(2.0 * math.pi * u[:, 1])
    if placement.low is not None and placement.high is not None:
        low, high = value(placement.low)[:, :2], value(placement.high)[:, :2]
    else:
        assert rectangle is not None
        low, high = rectangle[rows, :2], rectangle[rows, 2:]
    low, high = np.minimum(low, high), np.maximum(low, high)
    return np.minimum(low + (high - low) * u, high)


def rectangle_of(polygons: Sequence[tuple[Any, NDArray[np.bool_]]], origin: Floats, heading: Floats) -> Floats:
    """Returns the rectangle (B, 4) around polygons in rotated axes: minimum x and y, then maximum [m].

    Args:
        polygons: corners in the world (B, k, 2), and the scenes that have them (B,).
        origin: origin of the axes (B, 3).
        heading: their rotation about z (B,) [rad].
    """
    low, high = np.full((len(origin), 2), np.inf), np.full((len(origin), 2), -np.inf)
    for corners, there in polygons:
        for number in range(corners.shape[1]):
            local = turn_points(corners[:, number] - origin[:, :2], -heading)
            low = np.where(there[:, None], np.minimum(low, local), low)
            high = np.where(there[:, None], np.maximum(high, local), high)
    return np.concatenate([low, high], axis=1)


def footprint_polygons(parts: Sequence[Part]) -> Floats:
    """Returns the convex hulls of parts' footprints, (B, k, 2) counterclockwise; the last corner is repeated [m]."""
    count = len(parts[0].there)
    state = np.concatenate(
        [np.concatenate([part.turn.reshape(count, 9), part.p, part.half, part.scale, part.there[:, None],
                         part.disk[:, None], part.margin[:, None]], axis=1) for part in parts], axis=1
    )  # fmt: skip
    _, first, same = np.unique(state, axis=0, return_index=True, return_inverse=True)
    hulls: list[Floats] = []
    for row in first.tolist():
        points = footprint(parts, row)
        hulls.append(points[hull_order(points)])
    widest = max(map(len, hulls))
    padded = np.stack([np.concatenate([hull, np.repeat(hull[-1:], widest - len(hull), axis=0)]) for hull in hulls])
    return padded[same.reshape(-1)]
