"""Whether what was placed is as far apart as it must be: proved from the final poses alone.

Two convex parts are apart if there is a direction along which one ends before the other begins. Where a direction comes
from does not matter: the sampler's distances suggest some, and are not relied on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.placing.bodies import Part, entity_parts, matrices
from scenecc.placing.distances import Cores, witnesses
from scenecc.plan.body import groups_collide

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotation_arrays import Floats, Indices
    from scenecc.plan import ScenePlan
    from scenecc.plan.placement import Placement
    from scenecc.variation.evaluation import Batch


_TOLERANCE: Final = 2e-6
"""By how much less than asked for a distance may be [m]."""

_UP: Final = np.array((0.0, 0.0, 1.0))

_FAR: Final = 1e300
"""Where the box around a plane ends [m]."""

_CHUNK: Final = 500_000
"""How many pairs of a body and a triangle are looked at together."""


def find_overlap(plan: ScenePlan, batch: Batch, poses: Mapping[str, Floats]) -> str | None:
    """What is not proved to be as far apart as it must be, in words; None where all is.

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
    boxes = {name: _Boxes.around(parts, len(batch.scenes)) for name, parts in world.items()}
    for a, b in _near_entities(boxes, placed):
        least = _least_distance(a, b, placed)
        if least is None:
            continue
        with np.errstate(all="ignore"):
            near = boxes[a].near_pairs(boxes[b], least)
            found = next((bad for i, j, rows in near for bad in _too_near(world[a][i], world[b][j], rows, least)), None)
        if found is not None:
            row, gap = found
            how = f"are {gap:.6g} m apart, less than {least:g} m" if gap > 0 else "overlap"
            return f"in scene {batch.scenes[row]} `{a}` and `{b}` {how}"
    return None


@dataclass(slots=True)
class _Boxes:
    """The boxes around the parts of an entity along the axes of the world (P, B, 3) [m]; inside out where none is."""

    low: Floats
    high: Floats

    @classmethod
    def around(cls, parts: Sequence[Part], count: int) -> _Boxes:
        """The boxes around parts in so many scenes."""
        low, high = (np.full((len(parts), count, 3), end) for end in (np.inf, -np.inf))
        for number, part in enumerate(parts):
            rows = np.flatnonzero(part.there)
            if part.is_plane:
                low[number, rows], high[number, rows] = -_FAR, _FAR
                continue
            pieces = _Pieces(part, rows)
            for axis, direction in enumerate(np.eye(3)):
                each = np.broadcast_to(direction, (len(rows), 3))
                low[number, rows, axis], high[number, rows, axis] = -pieces.end(-each), pieces.end(each)
        return cls(low, high)

    def near_pairs(self, others: _Boxes, least: float) -> Iterator[tuple[int, int, Indices]]:
        """The pairs of parts, and the rows in which no axis shows them to be so far apart."""
        for number, ends in enumerate(zip(self.low, self.high, strict=True)):
            near = _are_near(*ends, others.low, others.high, least)
            for other in np.flatnonzero(near.any(axis=1)).tolist():
                yield number, other, np.flatnonzero(near[other])


def _are_near(low: Floats, high: Floats, lows: Floats, highs: Floats, least: float) -> NDArray[np.bool_]:
    """Whether boxes (n, B, 3) are not shown by an axis to be so far from one (B, 3), (n, B)."""
    near = np.ones(lows.shape[:2], np.bool_)
    for axis in range(3):
        gap = np.maximum(lows[:, :, axis] - high[:, axis], low[:, axis] - highs[:, :, axis])
        # What is no number shows nothing.
        near &= ~(gap >= least - _TOLERANCE)
    return near


def _near_entities(boxes: Mapping[str, _Boxes], placed: Mapping[str, Placement]) -> Iterator[tuple[str, str]]:
    """The pairs of entities, one of them placed, that may be nearer than anything that is placed may be."""
    names = [name for name, one in boxes.items() if len(one.low)]
    most = max((one.apart for one in placed.values()), default=0.0)
    is_placed = np.array([name in placed for name in names])
    with np.errstate(all="ignore"):
        low = np.array([boxes[name].low.min(axis=0) for name in names])
        high = np.array([boxes[name].high.max(axis=0) for name in names])
        for number, name in enumerate(names):
            after = slice(number + 1, None)
            others = np.flatnonzero(is_placed[after] | is_placed[number]) + number + 1
            near = _are_near(low[number], high[number], low[others], high[others], most)
            yield from ((name, names[other]) for other in others[near.any(axis=1)].tolist())


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


@dataclass(slots=True)
class _Pieces:
    """A part in the world in some rows (n,) of it; or of a triangle mesh, one triangle (n,) in each."""

    part: Part
    rows: Indices
    triangle: Indices | None = None

    def taken(self, index: Indices, triangle: Indices | None = None) -> _Pieces:
        """Some of them. `triangle`: of each the one; None: as they are."""
        kept = self.triangle if self.triangle is None else self.triangle[index]
        return _Pieces(self.part, self.rows[index], kept if triangle is None else triangle)

    @property
    def is_concave(self) -> bool:
        """Whether only their triangles are convex."""
        return self.part.triangles is not None and self.triangle is None

    @property
    def corners(self) -> Floats:
        """Of the triangles, in the frames of their meshes (n, 3, 3) [m]."""
        assert self.part.points is not None
        assert self.part.triangles is not None
        return self.part.points[self.part.triangles[self.triangle]] * self.part.scale[self.rows][:, None]

    def end(self, direction: Floats) -> Floats:
        """The greatest coordinate along unit directions (n, 3) of all their points (n,) [m]."""
        part, rows = self.part, self.rows
        along = np.einsum("nij,ni->nj", part.turn[rows], direction)
        at = np.einsum("ni,ni->n", part.p[rows], direction)
        if self.triangle is not None:
            return at + np.einsum("nkj,nj->nk", self.corners, along).max(axis=1)
        if part.points is not None:
            return at + ((along * part.scale[rows]) @ part.points.T).max(axis=1)
        across = np.sqrt(along[:, 1] ** 2 + along[:, 2] ** 2)
        return at + (np.abs(along) * part.half[rows]).sum(axis=1) + part.disk[rows] * across + part.margin[rows]

    def cores(self) -> Cores:
        """The same for the distances of the sampler."""
        part, triangle = self.part, self.triangle
        return part.cores(self.rows) if triangle is None else part.triangle_cores(self.rows, triangle)


def _too_near(a: Part, b: Part, rows: Indices, least: float) -> Iterator[tuple[int, float]]:
    """Those of some rows in which two parts may be nearer than they may, and how far apart they are [m]."""
    collide = groups_collide(a.groups[rows].T, b.groups[rows].T)
    rows = rows[a.there[rows] & b.there[rows] & collide]
    if a.is_plane:
        a, b = b, a
    if rows.size and not a.is_plane:
        yield from _unproved(_Pieces(a, rows), _Pieces(b, rows), least)


def _unproved(a: _Pieces, b: _Pieces, least: float) -> Iterator[tuple[int, float]]:
    """The pairs that no direction shows to be so far apart: the row of each, and what the last direction shows [m]."""
    if b.part.is_plane:
        # Nothing but its normal can show it.
        a, b, gap = _left(a, b, b.part.turn[b.rows, :, 0], least)
        yield from zip(a.rows.tolist(), gap.tolist(), strict=True)
        return
    between = a.part.p[a.rows] - b.part.p[b.rows]
    up = np.where(between[:, 2:] < 0, -1.0, 1.0) * _UP
    # What may touch mostly stands on the other.
    a, b, gap = _left(a, b, between if least else up, least)
    if a.rows.size:
        first, second = a.cores(), b.cores()
        if not least:
            # What touches does not overlap.
            first.p = first.p + np.where(first.p[:, 2:] < second.p[:, 2:], -_TOLERANCE, _TOLERANCE) * _UP
        a, b, gap = _left(a, b, witnesses(first, second), least)
    if b.is_concave:
        a, b = b, a
    if not a.is_concave:
        yield from zip(a.rows.tolist(), gap.tolist(), strict=True)
        return
    for index, triangle in _triangles_near(a, b, least):
        yield from _unproved(a.taken(index, triangle), b.taken(index), least)


def _left(a: _Pieces, b: _Pieces, direction: Floats, least: float) -> tuple[_Pieces, _Pieces, Floats]:
    """The pairs that directions (n, 3) from b to a do not show to be so far apart, and what they show [m]."""
    unit = direction / np.abs(direction).max(axis=1, keepdims=True)
    unit /= np.sqrt((unit * unit).sum(axis=1, keepdims=True))
    gap = -a.end(-unit) - b.end(unit)
    # A direction of length 0 gives no number, and shows nothing.
    left = np.flatnonzero(~(gap >= least - _TOLERANCE))
    return a.taken(left), b.taken(left), gap[left]


def _triangles_near(mesh: _Pieces, other: _Pieces, least: float) -> Iterator[tuple[Indices, Indices]]:
    """The pairs, and triangles of their meshes, that the axes of the mesh do not show to be so far apart."""
    part = mesh.part
    assert part.points is not None
    turn, p = part.turn[mesh.rows], part.p[mesh.rows]
    axes = [np.ascontiguousarray(turn[:, :, axis]) for axis in range(3)]
    at = np.einsum("nij,ni->nj", turn, p)
    low = -np.stack([other.end(-axis) for axis in axes], axis=1) - at - least
    high = np.stack([other.end(axis) for axis in axes], axis=1) - at + least
    corners = part.points[part.triangles]
    ends = corners.min(axis=1), corners.max(axis=1)
    chunk = max(1, _CHUNK // len(corners))
    for start in range(0, len(low), chunk):
        some = slice(start, start + chunk)
        scaled = [end * part.scale[mesh.rows[some], None] for end in ends]
        least_, most = np.minimum(*scaled), np.maximum(*scaled)
        near = ((least_ <= high[some, None]) & (most >= low[some, None])).all(axis=2)
        index, triangle = np.nonzero(near)
        yield index + start, triangle
