"""Distances between convex parts, for many pairs at once, by the Gilbert–Johnson–Keerthi algorithm."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotation_arrays import Floats, Indices


_TOLERANCE: Final = 1e-8
"""Maximum gap between the two bounds of a distance [m]."""

_TOUCHING: Final = 1e-9

_SURE: Final = 1e-5
"""Gap between boxes from which, up or down, rounding and almost parallel edges change no decision [m]."""

_PARALLEL: Final = 1e-6
"""Sine of the angle between two edges that count as parallel."""

_NEXT, _LAST = [1, 2, 0], [2, 0, 1]
"""The other two axes of each axis."""

_ITERATIONS: Final = 64

_FLAT: Final = 1e-12
"""Maximum area or volume, relative to its edges, of a degenerate triangle or tetrahedron."""


class _Features(NamedTuple):
    """The features of a simplex: its edges, its triangles, and the corners of every feature; the corners come first."""

    edges: NDArray[np.intp]
    faces: NDArray[np.intp]
    corners: NDArray[np.bool_]


def _features(corners: int) -> _Features:
    edges, faces = list(combinations(range(corners), 2)), list(combinations(range(corners), 3))
    parts = [*((corner,) for corner in range(corners)), *edges, *faces]
    needed = np.array([[corner in part for corner in range(4)] for part in parts])
    return _Features(np.array(edges), np.array(faces).reshape(-1, 3), needed)


_FEATURES_OF: Final = {corners: _features(corners) for corners in (2, 3, 4)}


@dataclass(slots=True)
class Cores:
    """Convex parts in their poses, one per row. A part is all points within `margin` of its core.

    The core of a box is the box, of a sphere its centre, of a capsule its segment, of a cylinder a disk swept along x,
    and of any other shape the hull of its points.

    Attributes:
        half: half lengths of the core along its own axes (n, 3) [m].
        disk: radius about its own x (n,) [m].
        margin: (n,) [m].
        turn: rotation matrices (n, 3, 3).
        p: origins (n, 3) [m].
        cloud: index of each core's points in `clouds` (n,); -1: it has none.
        scale: scale of these points (n, 3).
        clouds: points (k, 3) [m].
        corners: corners of triangles (n, 3, 3) [m]; rows of zeros are no triangles. None: there are no triangles.
    """

    half: Floats
    disk: Floats
    margin: Floats
    turn: Floats
    p: Floats
    cloud: Indices
    scale: Floats
    clouds: tuple[Floats, ...]
    corners: Floats | None = None

    def taken(self, rows: Indices) -> Cores:
        """Returns some of the cores."""
        corners = None if self.corners is None else self.corners[rows]
        return Cores(
            self.half[rows], self.disk[rows], self.margin[rows], self.turn[rows], self.p[rows],
            self.cloud[rows], self.scale[rows], self.clouds, corners,
        )  # fmt: skip

    def support(self, rows: Indices, direction: Floats) -> Floats:
        """Returns the farthest points (m, 3) of some cores in directions (m, 3) of any length."""
        turn = self.turn[rows]
        local = np.matmul(direction[:, None, :], turn)[:, 0]
        found = np.where(local >= 0, self.half[rows], -self.half[rows])
        disk = self.disk[rows]
        if disk.any():
            across = np.hypot(local[:, 1], local[:, 2])
            found[:, 1:] += (disk / np.where(across > 0, across, 1.0))[:, None] * local[:, 1:]
        cloud = self.cloud[rows]
        for number, points in enumerate(self.clouds):
            mine = np.flatnonzero(cloud == number)
            if mine.size:
                scale = self.scale[rows[mine]]
                found[mine] = scale * points[((local[mine] * scale) @ points.T).argmax(axis=1)]
        if self.corners is not None:
            corners = self.corners[rows]
            farthest = np.matmul(corners, local[:, :, None])[:, :, 0].argmax(axis=1)
            found += corners[np.arange(len(rows)), farthest]
        return np.matmul(turn, found[:, :, None])[:, :, 0] + self.p[rows]


def concatenate_cores(parts: Sequence[Cores]) -> Cores:
    """Concatenates several sets of cores."""
    clouds: list[Floats] = []
    numbers: list[Indices] = []
    for part in parts:
        numbers.append(np.where(part.cloud < 0, -1, part.cloud + len(clouds)))
        clouds += part.clouds

    def together(name: str) -> Floats:
        return np.concatenate([getattr(part, name) for part in parts])

    half, disk, margin, turn, p, scale = map(together, ("half", "disk", "margin", "turn", "p", "scale"))
    corners: Floats | None = None
    if any(part.corners is not None for part in parts):
        corners = np.concatenate(
            [np.zeros((len(part.p), 3, 3)) if part.corners is None else part.corners for part in parts]
        )
    return Cores(half, disk, margin, turn, p, np.concatenate(numbers), scale, tuple(clouds), corners)


def are_apart(a: Cores, b: Cores, least: Floats) -> NDArray[np.bool_]:
    """Returns whether each pair (n,) has at least a distance (n,) [m]; for 0 or less, whether it does not overlap."""
    # Touching cores overlap.
    wanted = np.maximum(a.margin + b.margin + least, _TOUCHING)
    gap = _box_gaps(a, b)
    apart = gap >= wanted + _SURE
    rows = np.flatnonzero(~(apart | (gap < -_SURE)))
    if rows.size:
        lower, upper, _ = _bounds(a.taken(rows), b.taken(rows), wanted[rows])
        far = wanted[rows]
        apart[rows] = (lower >= far) | ((upper - lower <= _TOLERANCE) & (upper >= far))
    return apart


def _box_gaps(a: Cores, b: Cores) -> Floats:
    """Returns the largest gap (n,) between two boxes along the normals of their faces and the normals of two edges [m];
    nan for other cores.

    It is a lower bound of their distance, and they overlap if it is negative (S. Gottschalk, M. C. Lin and D. Manocha,
    "OBBTree", 1996).
    """
    found = np.full(len(a.p), np.nan)
    if a.corners is not None or b.corners is not None:
        return found
    rows = np.flatnonzero((a.disk == 0) & (b.disk == 0) & (a.cloud < 0) & (b.cloud < 0))
    a, b = a.taken(rows), b.taken(rows)
    to_a = a.turn.transpose(0, 2, 1)
    turn = np.matmul(to_a, b.turn)
    between = np.matmul(to_a, (b.p - a.p)[:, :, None])[:, :, 0]
    size = np.abs(turn)
    gaps = [np.abs(between) - a.half - np.matmul(size, b.half[:, :, None])[:, :, 0]]
    gaps.append(np.abs(np.matmul(between[:, None], turn)[:, 0]) - b.half - np.matmul(a.half[:, None], size)[:, 0])
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        away = np.abs(between[:, k, None] * turn[:, j] - between[:, j, None] * turn[:, k])
        reach = a.half[:, j, None] * size[:, k] + a.half[:, k, None] * size[:, j]
        reach += b.half[:, _NEXT] * size[:, i][:, _LAST] + b.half[:, _LAST] * size[:, i][:, _NEXT]
        length = np.sqrt(np.maximum(1 - turn[:, i] ** 2, 0))
        gaps.append(np.where(length > _PARALLEL, (away - reach) / np.maximum(length, _PARALLEL), -np.inf))
    found[rows] = np.concatenate(gaps, axis=1).max(axis=1)
    return found


def distances(a: Cores, b: Cores) -> Floats:
    """Returns the distance of each pair (n,) [m]; 0 if it overlaps."""
    _, upper, _ = _bounds(a, b, None)
    return np.maximum(upper - a.margin - b.margin, 0.0)


def witnesses(a: Cores, b: Cores) -> Floats:
    """Returns vectors (n, 3) from the second core to the first, between their nearest points [m]; 0 if they overlap."""
    return _bounds(a, b, None)[2]


def _bounds(a: Cores, b: Cores, wanted: Floats | None) -> tuple[Floats, Floats, Floats]:
    """Returns lower and upper bounds of the distances of core pairs (n,) [m], and vectors (n, 3) of that length.

    `wanted`: distances (n,); a pair is finished once its distance is known to be above or below. None: exact.
    """
    count = len(a.p)
    lower, upper = np.zeros(count), np.full(count, np.inf)
    nearest = a.p - b.p
    nearest[~nearest.any(axis=1)] = (1.0, 0.0, 0.0)
    simplex, used = np.zeros((count, 4, 3)), np.zeros((count, 4), np.bool_)
    rows = np.arange(count)
    for _ in range(_ITERATIONS):
        towards = nearest[rows]
        length = np.sqrt(np.einsum("ij,ij->i", towards, towards))
        corner = a.support(rows, -towards) - b.support(rows, towards)
        lower[rows] = np.maximum(lower[rows], np.einsum("ij,ij->i", towards, corner) / length)
        done = upper[rows] - lower[rows] <= _TOLERANCE
        if wanted is not None:
            done |= lower[rows] >= wanted[rows]
        rows, corner = rows[~done], corner[~done]
        if not rows.size:
            break
        free = used[rows].argmin(axis=1)
        simplex[rows, free], used[rows, free] = corner, True
        nearest[rows], simplex[rows], used[rows] = _nearest(simplex[rows], used[rows])
        upper[rows] = np.sqrt(np.einsum("ij,ij->i", nearest[rows], nearest[rows]))
        inside = upper[rows] <= _TOLERANCE
        upper[rows[inside]] = 0.0
        if wanted is not None:
            inside |= upper[rows] < wanted[rows]
        rows = rows[~inside]
        if not rows.size:
            break
    return lower, upper, nearest


def _nearest(simplex: Floats, used: NDArray[np.bool_]) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Returns the point of each simplex (n, 4, 3) nearest to the origin, and the corners that span it.

    Returns:
        The points (n, 3), the simplices with the used corners first, and which of these each point needs.
    """
    order = np.argsort(~used, axis=1, kind="stable")
    simplex = np.take_along_axis(simplex, order[:, :, None], axis=1)
    size = used.sum(axis=1)
    nearest, needed = simplex[:, 0].copy(), np.zeros((len(simplex), 4), np.bool_)
    needed[:, 0] = True
    for corners in (2, 3, 4):
        rows = np.flatnonzero(size == corners)
        if rows.size:
            nearest[rows], needed[rows] = _nearest_of(simplex[rows], corners)
    return nearest, simplex, needed


def _nearest_of(simplex: Floats, corners: int) -> tuple[Floats, NDArray[np.bool_]]:
    """Returns the nearest points of simplices with 2, 3 or 4 corners."""
    features = _FEATURES_OF[corners]
    edge_points, on_edge = _edge_points(simplex, features.edges)
    points, fits = [simplex[:, :corners], edge_points], [np.ones((len(simplex), corners), np.bool_), on_edge]
    if corners > 2:
        face_points, on_face = _face_points(simplex, features.faces)
        points.append(face_points)
        fits.append(on_face)
    every = np.concatenate(points, axis=1)
    squares = np.where(np.concatenate(fits, axis=1), np.einsum("nij,nij->ni", every, every), np.inf)
    best = squares.argmin(axis=1)
    nearest, needed = every[np.arange(len(simplex)), best], features.corners[best]
    if corners > 3:
        inside = _contains_origin(simplex)
        nearest[inside], needed[inside] = 0.0, True
    return nearest, needed


def _edge_points(simplex: Floats, edges: Indices) -> tuple[Floats, NDArray[np.bool_]]:
    """Returns the points of lines through edges nearest to the origin, and whether they are on the edges."""
    start = simplex[:, edges[:, 0]]
    along = simplex[:, edges[:, 1]] - start
    length = np.einsum("nij,nij->ni", along, along)
    share = -np.einsum("nij,nij->ni", start, along) / np.where(length > 0, length, 1.0)
    return start + share[:, :, None] * along, (length > 0) & (share > 0) & (share < 1)


def _face_points(simplex: Floats, faces: Indices) -> tuple[Floats, NDArray[np.bool_]]:
    """Returns the points of planes through faces nearest to the origin, and whether they are in the faces."""
    start = simplex[:, faces[:, 0]]
    u, v = simplex[:, faces[:, 1]] - start, simplex[:, faces[:, 2]] - start
    uu, uv, vv = (np.einsum("nij,nij->ni", x, y) for x, y in ((u, u), (u, v), (v, v)))
    su, sv = -np.einsum("nij,nij->ni", start, u), -np.einsum("nij,nij->ni", start, v)
    area = uu * vv - uv * uv
    flat = area <= _FLAT * uu * vv
    area = np.where(flat, 1.0, area)
    s, t = (vv * su - uv * sv) / area, (uu * sv - uv * su) / area
    return start + s[:, :, None] * u + t[:, :, None] * v, ~flat & (s > 0) & (t > 0) & (s + t < 1)


def _contains_origin(simplex: Floats) -> NDArray[np.bool_]:
    """Returns whether tetrahedra (n, 4, 3) contain the origin, (n,)."""
    start = simplex[:, 0]
    u, v, w = (simplex[:, corner] - start for corner in (1, 2, 3))
    across = np.cross(v, w), np.cross(w, u), np.cross(u, v)
    volume = np.einsum("ij,ij->i", u, across[0])
    sizes = [np.einsum("ij,ij->i", one, one) for one in (u, v, w)]
    flat = np.abs(volume) <= _FLAT * np.sqrt(sizes[0] * sizes[1] * sizes[2])
    shares = np.stack([-np.einsum("ij,ij->i", start, one) for one in across], axis=1)
    shares /= np.where(flat, 1.0, volume)[:, None]
    return ~flat & (shares > 0).all(axis=1) & (shares.sum(axis=1) < 1)
