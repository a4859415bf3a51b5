"""Distances between convex parts, for many pairs at once: the algorithm of Gilbert, Johnson and Keerthi."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

_TOLERANCE: Final = 1e-8
"""How near the two bounds of a distance come to one another [m]."""

_TOUCHING: Final = 1e-9

_ITERATIONS: Final = 64

_EDGES: Final = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])
_FACES: Final = np.array([(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)])
_FEATURES: Final = np.array(
    [[corner in feature for corner in range(4)] for feature in ((0,), (1,), (2,), (3,), *_EDGES, *_FACES, range(4))]
)
"""Corners, edges, triangles and the whole of a tetrahedron: which corners each has."""


@dataclass(slots=True)
class Cores:
    """Convex parts where they stand, one a row. A part is all points within `margin` of its core.

    The core of a box is itself, of a sphere its centre, of a capsule its segment, of a cylinder a disk that is swept
    along x, and of anything else the hull of its points.

    Attributes:
        half: half the lengths of the core along its own axes (n, 3) [m].
        disk: radius about its own x (n,) [m].
        margin: (n,) [m].
        turn: rotation matrices (n, 3, 3).
        p: origins (n, 3) [m].
        cloud: the number in `clouds` of each one's points (n,); -1: it has none.
        scale: of these points (n, 3).
        clouds: points (k, 3) [m].
        corners: of triangles (n, 3, 3) [m]; a row that is all 0 is none. None: there are none at all.
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
        """Some of them."""
        corners = None if self.corners is None else self.corners[rows]
        return Cores(
            self.half[rows], self.disk[rows], self.margin[rows], self.turn[rows], self.p[rows],
            self.cloud[rows], self.scale[rows], self.clouds, corners,
        )  # fmt: skip

    def support(self, rows: Indices, direction: Floats) -> Floats:
        """The farthest points (m, 3) of some cores in directions (m, 3) of any length."""
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


def joined(parts: Sequence[Cores]) -> Cores:
    """Several lots of cores as one."""
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
    """Whether each pair (n,) has at least a distance (n,) [m]; of 0 or less: whether it does not overlap."""
    # Cores that touch overlap.
    wanted = np.maximum(a.margin + b.margin + least, _TOUCHING)
    lower, upper = _bounds(a, b, wanted)
    return (lower >= wanted) | ((upper - lower <= _TOLERANCE) & (upper >= wanted))


def distances(a: Cores, b: Cores) -> Floats:
    """The distance of each pair (n,) [m]; 0 where it overlaps."""
    _, upper = _bounds(a, b, None)
    return np.maximum(upper - a.margin - b.margin, 0.0)


def _bounds(a: Cores, b: Cores, wanted: Floats | None) -> tuple[Floats, Floats]:
    """The least and the greatest that the distance of each pair's cores can be (n,) [m].

    Args:
        a: the ones.
        b: the others.
        wanted: distances (n,) above or below which nothing more need be known; None: none.
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
        nearest[rows], used[rows] = _nearest(simplex[rows], used[rows])
        upper[rows] = np.sqrt(np.einsum("ij,ij->i", nearest[rows], nearest[rows]))
        inside = upper[rows] <= _TOLERANCE
        upper[rows[inside]] = 0.0
        if wanted is not None:
            inside |= upper[rows] < wanted[rows]
        rows = rows[~inside]
        if not rows.size:
            break
    return lower, upper


def _nearest(simplex: Floats, used: NDArray[np.bool_]) -> tuple[Floats, NDArray[np.bool_]]:
    """The point of each simplex (n, 4, 3) nearest to the origin, and the corners that it lies between."""
    count = len(simplex)
    points, squares = np.empty((count, 15, 3)), np.full((count, 15), np.inf)
    points[:, :4] = simplex
    squares[:, :4] = np.where(used, np.einsum("nij,nij->ni", simplex, simplex), np.inf)
    deep = used.sum(axis=1)
    _fill_edges(simplex, used, points, squares)
    if (deep > 2).any():
        _fill_faces(simplex, used, points, squares)
    if (deep > 3).any():
        _fill_whole(simplex, used, points, squares)
    best = squares.argmin(axis=1)
    return points[np.arange(count), best], _FEATURES[best]


def _fill_edges(simplex: Floats, used: NDArray[np.bool_], points: Floats, squares: Floats) -> None:
    start = simplex[:, _EDGES[:, 0]]
    along = simplex[:, _EDGES[:, 1]] - start
    length = np.einsum("nij,nij->ni", along, along)
    share = -np.einsum("nij,nij->ni", start, along) / np.where(length > 0, length, 1.0)
    points[:, 4:10] = start + share[:, :, None] * along
    fits = used[:, _EDGES].all(axis=2) & (length > 0) & (share > 0) & (share < 1)
    squares[:, 4:10] = np.where(fits, np.einsum("nij,nij->ni", points[:, 4:10], points[:, 4:10]), np.inf)


def _fill_faces(simplex: Floats, used: NDArray[np.bool_], points: Floats, squares: Floats) -> None:
    start = simplex[:, _FACES[:, 0]]
    u, v = simplex[:, _FACES[:, 1]] - start, simplex[:, _FACES[:, 2]] - start
    uu, uv, vv = (np.einsum("nij,nij->ni", x, y) for x, y in ((u, u), (u, v), (v, v)))
    su, sv = -np.einsum("nij,nij->ni", start, u), -np.einsum("nij,nij->ni", start, v)
    area = uu * vv - uv * uv
    flat = area <= 1e-12 * uu * vv
    area = np.where(flat, 1.0, area)
    s, t = (vv * su - uv * sv) / area, (uu * sv - uv * su) / area
    points[:, 10:14] = start + s[:, :, None] * u + t[:, :, None] * v
    fits = used[:, _FACES].all(axis=2) & ~flat & (s > 0) & (t > 0) & (s + t < 1)
    squares[:, 10:14] = np.where(fits, np.einsum("nij,nij->ni", points[:, 10:14], points[:, 10:14]), np.inf)


def _fill_whole(simplex: Floats, used: NDArray[np.bool_], points: Floats, squares: Floats) -> None:
    start = simplex[:, 0]
    u, v, w = (simplex[:, corner] - start for corner in (1, 2, 3))
    volume = np.einsum("ij,ij->i", u, np.cross(v, w))
    flat = np.abs(volume) <= 1e-12 * np.sqrt(
        np.einsum("ij,ij->i", u, u) * np.einsum("ij,ij->i", v, v) * np.einsum("ij,ij->i", w, w)
    )
    volume = np.where(flat, 1.0, volume)
    shares = np.stack(
        [
            -np.einsum("ij,ij->i", start, np.cross(v, w)),
            -np.einsum("ij,ij->i", start, np.cross(w, u)),
            -np.einsum("ij,ij->i", start, np.cross(u, v)),
        ],
        axis=1,
    )
    shares /= volume[:, None]
    fits = used.all(axis=1) & ~flat & (shares > 0).all(axis=1) & (shares.sum(axis=1) < 1)
    points[:, 14] = 0.0
    squares[fits, 14] = 0.0
