"""Convex pairs of two parts that may be close to each other; for a non-convex mesh, its triangles."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.placing.distances import Cores, are_apart, distances
from scenecc.plan.body import groups_collide

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.geometry.rotation_arrays import Flags, Floats, Indices
    from scenecc.placing.bodies import Part


TOLERANCE: Final = 1e-7
"""Tolerance of a required distance [m], because positions are rounded."""

LIFT: Final = 1e-6
"""Height by which an object is lifted for the test [m], so that touching is not overlap."""

_LOT: Final = 500_000
"""Maximum number of pairs that are processed together."""

_SLACK: Final = 1e-6
"""[m] Added to a bound; much larger than its rounding error."""


def core_pair_chunks(
    a: Part, a_rows: Indices, b: Part, b_rows: Indices, within: float
) -> Iterator[tuple[Indices, Cores, Cores]]:
    """Yields `core_pairs` in chunks that need little memory.

    Args:
        a: first part; not a plane.
        a_rows: its rows (n,).
        b: second part; not a plane.
        b_rows: its rows (n,).
        within: triangles that are farther away are skipped [m].
    """
    if a.triangles is None or b.triangles is None:
        size = max(len(one.triangles) if one.triangles is not None else 1 for one in (a, b))
        rows = max(1, _LOT // size)
        for start in range(0, len(a_rows), rows):
            some = slice(start, start + rows)
            pair, first, second = core_pairs(a, a_rows[some], b, b_rows[some], within)
            yield pair + start, first, second
        return
    for index in range(len(a_rows)):
        row, other = a_rows[index : index + 1], b_rows[index : index + 1]
        _, near = b.triangles_near(other, a.p[row], a.reach[row] + within)
        size = max(1, _LOT // len(a.triangles))
        for start in range(0, len(near), size):
            some = near[start : start + size]
            pair, first, second = _triangle_pairs(
                a, np.repeat(row, len(some)), b.triangle_cores(np.repeat(other, len(some)), some), within
            )
            yield np.full(len(pair), index), first, second


def _triangle_pairs(a: Part, rows: Indices, theirs: Cores, within: float) -> tuple[Indices, Cores, Cores]:
    """Returns the triangles of a part in rows (n,) that may be close to triangles (n,) of another, with their pair
    indices.
    """
    assert theirs.corners is not None
    middle = theirs.corners.mean(axis=1)
    reach = np.sqrt(((theirs.corners - middle[:, None]) ** 2).sum(axis=2).max(axis=1))
    world = np.matmul(theirs.turn, middle[:, :, None])[:, :, 0] + theirs.p
    again, own = a.triangles_near(rows, world, reach + within)
    return again, a.triangle_cores(rows[again], own), theirs.taken(again)


def core_pairs(a: Part, a_rows: Indices, b: Part, b_rows: Indices, within: float) -> tuple[Indices, Cores, Cores]:
    """Returns pairs of cores (k,), and the index of the row pair of each.

    Args:
        a: first part; not a plane.
        a_rows: its rows (n,).
        b: second part; not a plane.
        b_rows: its rows (n,).
        within: triangles that are farther away are skipped [m].
    """
    if b.triangles is None and a.triangles is None:
        return np.arange(len(a_rows)), a.cores(a_rows), b.cores(b_rows)
    if b.triangles is None:
        pair, second, first = core_pairs(b, b_rows, a, a_rows, within)
        return pair, first, second
    pair, triangle = b.triangles_near(b_rows, a.p[a_rows], a.reach[a_rows] + within)
    theirs = b.triangle_cores(b_rows[pair], triangle)
    if a.triangles is None:
        return pair, a.cores(a_rows[pair]), theirs
    again, first, second = _triangle_pairs(a, a_rows[pair], theirs, within)
    return pair[again], first, second


def are_too_near(a: Part, b: Part, least: float) -> Flags:
    """Returns the scenes (B,) in which two parts collide, and overlap or are closer than a distance.

    Args:
        a: first part, in the world.
        b: second part, in the world.
        least: minimum distance [m]; 0: they may touch.
    """
    near = a.there & b.there & groups_collide(a.groups.T, b.groups.T)
    wanted = least - TOLERANCE if least else 0.0
    if a.is_plane or b.is_plane:
        plane, other = (a, b) if a.is_plane else (b, a)
        return near & ~(_heights_above(plane, other) >= (wanted or -LIFT)) & (not other.is_plane)
    between, reach = a.p - b.p, a.reach + b.reach + least
    rows = np.flatnonzero(near & (np.einsum("ij,ij->i", between, between) < reach * reach))
    # If the hulls are apart, so are the triangles.
    rows = rows[~are_apart(a.cores(rows), b.cores(rows), np.full(len(rows), wanted))]
    near = np.zeros(len(near), np.bool_)
    for pair, first, second in core_pair_chunks(a, rows, b, rows, wanted):
        if not least:
            first.p = first.p.copy()
            first.p[:, 2] += np.where(first.p[:, 2] < second.p[:, 2], -LIFT, LIFT)
        near[rows[pair[~are_apart(first, second, np.full(len(pair), wanted))]]] = True
    return near


def _heights_above(plane: Part, other: Part) -> Floats:
    """Returns the height of another part's lowest point above a plane (B,) [m]."""
    normal = plane.turn[:, :, 0]
    return -other.extent(-normal) - np.einsum("ij,ij->i", normal, plane.p)


def part_distances(a: Part, b: Part) -> Floats:
    """Returns the distance of two parts in each scene (B,) [m]: 0 if they overlap, infinite if one is missing.

    For a triangle mesh, the surface counts: an object deep inside has a positive distance.
    """
    found = np.full(len(a.p), np.inf)
    rows = np.flatnonzero(a.there & b.there)
    if not rows.size:
        return found
    if a.is_plane or b.is_plane:
        plane, other = (a, b) if a.is_plane else (b, a)
        found[rows] = 0.0 if other.is_plane else np.maximum(_heights_above(plane, other)[rows], 0.0)
        return found
    near = _point_near(b, _point_near(a, b.p))
    within = float(np.linalg.norm(near - _point_near(a, near), axis=1)[rows].max()) + _SLACK
    for pair, first, second in core_pair_chunks(a, rows, b, rows, within):
        np.minimum.at(found, rows[pair], distances(first, second))
    return found


def _point_near(part: Part, target: Floats) -> Floats:
    """Returns a point (B, 3) of a part near targets (B, 3); for a mesh, the nearest vertex."""
    if part.points is None:
        return part.p
    local = np.matmul((target - part.p)[:, None], part.turn)[:, 0]
    nearest = [
        points[((points - one) ** 2).sum(axis=1).argmin()]
        for one, points in zip(local, part.points * part.scale[:, None], strict=True)
    ]
    return np.matmul(part.turn, np.array(nearest)[:, :, None])[:, :, 0] + part.p
