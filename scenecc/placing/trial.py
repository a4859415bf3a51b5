"""The search for a pose by rejection sampling: the first try that fits. Tries are drawn by (seed, entity, key, scene,
try).
"""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from scenecc.geometry import rotation_arrays
from scenecc.placing.bodies import Part, matrices, point_part, rows_in, rows_of
from scenecc.placing.distances import Cores, are_apart, concatenate_cores, distances
from scenecc.placing.pairs import LIFT, TOLERANCE, core_pair_chunks
from scenecc.placing.placer import PlacingError
from scenecc.placing.regions import (
    about_z,
    drawn_units,
    footprint_polygons,
    headings,
    points_in_regions,
    rectangle_of,
    turn_points,
    unit_vectors,
)
from scenecc.placing.surfaces import SupportSurface, extent, highest_below, is_within
from scenecc.plan.body import groups_collide
from scenecc.variation.evaluation import Batch, to_field_rows

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotation_arrays import Flags, Floats, Indices
    from scenecc.placing.placer import Placer
    from scenecc.plan import Value
    from scenecc.plan.placement import Nearness, NextTo, Placement


_ROWS: Final = 4096
"""Maximum number of tries that are tested together, if there are fewer scenes."""

_FEW_ROWS: Final = 512
"""Number of tries that cost about as much as one."""

_TRIES_TOGETHER: Final = 256
"""Maximum number of tries of one scene that are tested together."""

_MANY_OBSTACLES: Final = 64
"""Number of obstacles from which distant ones are filtered out in advance."""

_OBSTACLES_TOGETHER: Final = 1_000_000
"""Number of try-obstacle pairs that are processed together."""

_DOWN: Final = np.array((0.0, 0.0, -1.0))
_UP: Final = -_DOWN


class _Obstacle(NamedTuple):
    """A part with a final pose, for one of the parts to be placed.

    Attributes:
        name: name of its entity.
        apart: required distance [m]; 0: no overlap.
        there: scenes in which both exist and collide (B,).
        top: its maximum height (B,) [m]; None: not needed.
    """

    name: str
    part: Part
    number: int
    apart: float
    there: Flags
    top: Floats | None


class Trial:
    """The search for the pose of one placement.

    Attributes:
        placement: the placement.
    """

    def __init__(self, placer: Placer, placement: Placement) -> None:
        self._placer, self.placement = placer, placement
        self._batch = placer.batch
        self._rows, self._there = rows_in(placement.scene_idxs, self._batch.scenes)
        self._parts = [
            part.moved(matrices(placer.local[member][:, 3:]), placer.local[member][:, :3])
            for member in placement.entities
            for part in placer.own_parts(member)
        ]
        for part in self._parts:
            part.there = part.there & self._there
        bare = self._there & ~np.any([part.there for part in self._parts], axis=0)
        if bare.any():
            # An entity without collision shapes is placed by its origin.
            self._parts.append(point_part(bare))
        self._why: Counter[str] = Counter()
        self._blocked: dict[str, Flags] | None = None
        self._target = placer.target_parts(placement.target)
        if not self._target:
            message = f"`{placement.target}` has no collision shape"
            raise PlacingError(placement.name, self._batch.scenes[self._there].tolist(), message)
        self._top = extent(self._target, _repeat(_UP, self._rows))
        self._surfaces = self._find_supports()
        self._outline = None if placement.kind == "on" else footprint_polygons(self._target)
        frame = placer.pose_of(placement.target) if placement.frame is None else self._value(placement.frame)
        self._origin, self._heading = frame[:, :3], headings(frame[:, 3:])
        where = (placement.at, placement.low, placement.center, placement.next_to)
        self._rectangle = self._top_rectangle() if where == (None,) * 4 else None
        self._obstacles = [
            # Only its possible supports are often below it.
            _Obstacle(
                name,
                part,
                number,
                apart,
                there,
                None if apart or part.is_plane else part.extent(_repeat(_UP, self._rows)),
            )
            for name, part, apart in placer.obstacles(placement)
            for number, mine in enumerate(self._parts)
            if (both := mine.there & part.there & self._is_settled(name)).any()
            and (there := both & groups_collide(mine.groups.T, part.groups.T)).any()
        ]

    def poses(self) -> tuple[Floats, Indices]:
        """Returns the poses (B, 7), the identity where it does not exist, and the rows in which no try fits."""
        found: Any = np.zeros((len(self._rows), 7))
        found[:, 3] = 1.0
        left, done = np.flatnonzero(self._there), 0
        while left.size:
            # Doubled each time: most scenes need few tries, and tries after the first fit are wasted.
            rows_together = min(_ROWS, max(_FEW_ROWS, 2 * done * len(left)))
            count = min(max(1, rows_together // len(left)), _TRIES_TOGETHER, self.placement.tries - done)
            if not count:
                break
            rows = np.repeat(left, count)
            tries = done + np.tile(np.arange(count), len(left))
            pose, fits = self._try_poses(rows, tries)
            fits, pose = fits.reshape(-1, count), pose.reshape(-1, count, 7)
            first, settled = fits.argmax(axis=1), fits.any(axis=1)
            found[left[settled]] = pose[np.flatnonzero(settled), first[settled]]
            left, done = left[~settled], done + count
        return found, left

    def reason(self, row: int) -> str:
        """Returns the most frequent reasons for which the last tries in a row of the batch do not fit."""
        self._why.clear()
        done = self.placement.tries
        few = min(_TRIES_TOGETHER, done)
        self._try_poses(np.full(few, row), np.arange(done - few, done))
        reasons = [f"{count} of {few} are {reason}" for reason, count in self._why.most_common(3) if count]
        return f"of the last tries in scene {self._batch.scenes[row]}, " + ", ".join(reasons)

    def blocked(self, rows: Indices, tries: NDArray[np.int64]) -> tuple[Floats, Flags, dict[str, Flags]]:
        """Returns the poses (M, 7) of some tries, which of them would fit if nothing were in the way, and the entities
        that are in the way of each.
        """
        pose, parts, fits = self._supported_poses(rows, tries)
        kept = np.flatnonzero(fits)
        self._blocked = {}
        if kept.size:
            kept_parts = [part.taken(kept) for part in parts]
            self._is_free(kept_parts, rows[kept])
            for near in self.placement.near:
                fits[kept] &= self._is_near(kept_parts, rows[kept], near)
        found: dict[str, Flags] = {}
        for name, flags in self._blocked.items():
            found[name] = np.zeros(len(rows), np.bool_)
            found[name][kept] = flags
        self._blocked = None
        return pose, fits, found

    def _is_settled(self, name: str) -> Flags | np.bool_:
        """Returns in which scenes an entity is not to be placed again."""
        lifted = self._placer.lifted.get(name)
        return np.True_ if lifted is None else ~lifted

    def _value(self, value: Value, rows: Indices | None = None, batch: Batch | None = None) -> Floats:
        """Returns a value of the placement in some rows of the batch; in all rows, as drawn, if none are given."""
        if value.recipe is None:
            return np.asarray(rows_of(value, self._rows if rows is None else self._rows[rows]), np.float64)
        drawn = (self._batch if batch is None else batch).evaluate(value.recipe)
        return np.asarray(to_field_rows(drawn), np.float64)

    def _find_supports(self) -> list[SupportSurface]:
        placer, placement = self._placer, self.placement
        if placement.kind == "above":
            return []
        if placement.kind == "on":
            return placer.surfaces(placement.target)
        from scenecc.plan import Mount  # noqa: PLC0415 - few placements use `inside`

        return [
            SupportSurface(one.there & (one.z + placement.gap < self._top) & self._is_settled(name), one.z, one.corners)
            for name in placer.bodies
            if name not in placement.entities
            for one in placer.surfaces(placement.target if name == placement.target.entity else Mount(name))
        ]

    def _top_rectangle(self) -> Floats:
        """Returns the rectangle (B, 4) around the target's top in its axes: minimum x and y, then maximum [m]."""
        if self._outline is not None:
            return rectangle_of([(self._outline, np.ones(len(self._rows), np.bool_))], self._origin, self._heading)
        tops = [(one.corners, one.there) for one in self._surfaces if one.corners is not None]
        return rectangle_of(tops, self._origin, self._heading)

    def _try_poses(self, rows: Indices, tries: NDArray[np.int64]) -> tuple[Floats, Flags]:
        """Returns the poses (M, 7) of some tries, and which of them fit."""
        pose, parts, fits = self._supported_poses(rows, tries)
        self._why[f"not completely {self.placement.kind} `{self.placement.target}`"] += int((~fits).sum())
        kept = np.flatnonzero(fits)
        if kept.size:
            fits[kept] = self._is_free([part.taken(kept) for part in parts], rows[kept])
            kept = np.flatnonzero(fits)
            for near in self.placement.near:
                if kept.size:
                    fits[kept] = self._is_near([part.taken(kept) for part in parts], rows[kept], near)
                    self._why[f"not at the distance of `near` from `{near.entity}`"] += int((~fits[kept]).sum())
                    kept = np.flatnonzero(fits)
        return pose, fits

    def _supported_poses(self, rows: Indices, tries: NDArray[np.int64]) -> tuple[Floats, list[Part], Flags]:
        """Returns the poses (M, 7) of some tries, the parts there, and which of them are supported."""
        batch = self._batch.only(rows) if not tries.any() else self._batch.tried(rows, tries)
        pose = self._poses_at_height_zero(rows, batch)
        turn = matrices(pose[:, 3:])
        parts = [part.taken(rows).moved(turn, pose[:, :3]) for part in self._parts]
        pose[:, 2] = self._heights(parts, rows, batch)
        fits = np.isfinite(pose[:, 2])
        if fits.any():
            for part in parts:
                part.p[:, 2] += np.where(fits, pose[:, 2], 0.0)
        return pose, parts, fits

    def _poses_at_height_zero(self, rows: Indices, batch: Batch) -> Floats:
        """Returns poses (M, 7) in the world at height 0."""
        placement, heading = self.placement, self._heading[rows]
        pose: Any = np.zeros((len(rows), 7))
        axes = about_z(heading)
        pose[:, 3:] = axes
        if placement.rotation is not None:
            pose[:, 3:] = rotation_arrays.multiply_quaternions(axes, self._value(placement.rotation, rows, batch))
        if placement.next_to is not None:
            pose[:, :2] = self._points_next_to(placement.next_to, pose[:, 3:], rows)
            return pose
        point = points_in_regions(placement, self._rectangle, rows, batch, lambda v: self._value(v, rows, batch))
        pose[:, :2] = self._origin[rows, :2] + turn_points(point, heading)
        towards: Floats | None = None
        if placement.facing is not None:
            towards = self._placer.pose_of(placement.facing)[rows, :2]
        elif placement.facing_point is not None:
            towards = self._origin[rows, :2] + turn_points(self._value(placement.facing_point, rows, batch), heading)
        if towards is not None:
            away = towards - pose[:, :2]
            pose[:, 3:] = about_z(np.array([math.atan2(y, x) for x, y in away.tolist()]))
        return pose

    def _points_next_to(self, next_to: NextTo, q: Floats, rows: Indices) -> Floats:
        """Returns positions (M, 2) in the world beside an entity, for rotations (M, 4)."""
        x = unit_vectors(self._heading[rows])
        y = np.stack([-x[:, 1], x[:, 0]], axis=1)
        out, along = {"front": (x, y), "back": (-x, y), "left": (y, x), "right": (-y, x)}[next_to.side]
        out, along = (np.concatenate([one, np.zeros((len(rows), 1))], axis=1) for one in (out, along))
        other = [part.taken(rows) for part in self._placer.target_parts(next_to.mount)]
        turn, zero = matrices(q), np.zeros((len(rows), 3))
        own = [part.taken(rows).moved(turn, zero) for part in self._parts]
        # Rounding must not make touching boxes overlap.
        away = extent(other, out) + max(next_to.gap, LIFT) + extent(own, -out)
        # Lower and upper ends of the other box, relative to those of the own one.
        low, high = extent(own, -along) - extent(other, -along), extent(other, along) - extent(own, along)
        shift = {"min": low, "center": (low + high) / 2, "max": high}[next_to.align]
        return (away[:, None] * out + shift[:, None] * along)[:, :2]

    def _heights(self, parts: list[Part], rows: Indices, batch: Batch) -> Floats:
        """Returns the height of the origin (M,) [m]; not finite if there is none. `parts`: at height 0."""
        placement = self.placement
        lowest = -extent(parts, _repeat(_DOWN, rows))
        within = np.ones(len(rows), np.bool_)
        if self._outline is not None:
            within = is_within(parts, self._outline[rows])
        if placement.height is not None:
            low, high = np.sort(self._value(placement.height, rows, batch), axis=1).T
            u = drawn_units(batch, placement.name, "place.height", 1)[:, 0]
            base = self._top[rows] + np.minimum(np.maximum(low + (high - low) * u, low), high)
        else:
            levels = None
            if placement.low is not None and placement.high is not None:
                ends = [self._value(end, rows, batch)[:, 2] for end in (placement.low, placement.high)]
                levels = np.sort(np.stack(ends, axis=1), axis=1) + self._origin[rows, 2:]
            base = highest_below(parts, [one.taken(rows) for one in self._surfaces], levels) + placement.gap
        return np.where(within, base - lowest, np.nan)

    def _is_free(self, parts: list[Part], rows: Indices) -> Flags:
        """Returns whether parts in some rows of the batch have the required distance from all others."""
        free = np.ones(len(rows), np.bool_)
        mine: list[Cores] = []
        others: list[Cores] = []
        least: list[Floats] = []
        whose: list[Indices] = []
        names: list[str] = []
        for name, part, number, apart, there, top in self._obstacles_near(parts, rows):
            own = parts[number]
            wanted = apart - TOLERANCE if apart else 0.0
            if part.is_plane:
                normal = part.turn[rows, :, 0]
                height = -own.extent(-normal) - np.einsum("ij,ij->i", normal, part.p[rows])
                self._reject(free, np.flatnonzero(there[rows] & ~(height >= (wanted or -LIFT))), name)
                continue
            between = own.p - part.p[rows]
            reach = own.reach + part.reach[rows] + apart
            maybe = there[rows] & (np.einsum("ij,ij->i", between, between) < reach * reach)
            if top is not None:
                maybe &= -own.extent(_repeat(_DOWN, rows)) <= top[rows]
            close = np.flatnonzero(maybe)
            if close.size and not (own.triangles is part.triangles is None):
                # If the hulls are apart, so are the triangles, of which there may be millions of pairs.
                least_ = np.full(len(close), wanted)
                close = close[~are_apart(own.cores(close), part.cores(rows[close]), least_)]
                self._reject(free, self._find_colliding(own, close, part, rows[close], wanted), name)
            elif close.size:
                mine.append(own.cores(close))
                others.append(part.cores(rows[close]))
                least.append(np.full(len(close), wanted))
                whose.append(close)
                names.append(name)
                if not apart:
                    # Touching is not overlap.
                    mine[-1].p = mine[-1].p - LIFT * _DOWN
        if whose:
            apart_ = are_apart(concatenate_cores(mine), concatenate_cores(others), np.concatenate(least))
            ends = np.cumsum([len(one) for one in whose])[:-1]
            for name, index, far in zip(names, whose, np.split(apart_, ends), strict=True):
                self._reject(free, index[~far], name)
        return free

    def _obstacles_near(self, parts: list[Part], rows: Indices) -> Sequence[_Obstacle]:
        """Returns the obstacles that are close to any of some tries."""
        if len(self._obstacles) < _MANY_OBSTACLES:
            return self._obstacles
        found: list[_Obstacle] = []
        chunk = max(1, _OBSTACLES_TOGETHER // len(rows))
        for start in range(0, len(self._obstacles), chunk):
            some = self._obstacles[start : start + chunk]
            near = np.zeros(len(some), np.bool_)
            for number, own in enumerate(parts):
                index = [i for i, one in enumerate(some) if one.number == number]
                if index:
                    between = np.stack([some[i].part.p[rows] for i in index]) - own.p
                    reach = np.stack([some[i].part.reach[rows] + some[i].apart for i in index]) + own.reach
                    near[index] = ((between**2).sum(axis=2) <= 1.000001 * reach**2).any(axis=1)
            found += [one for one, is_near in zip(some, near, strict=True) if is_near or one.part.is_plane]
        return found

    def _find_colliding(self, own: Part, close: Indices, part: Part, rows: Indices, wanted: float) -> Indices:
        """Returns the rows `close` of a part in which its triangles, or those of another, overlap or are too close."""
        meet = np.zeros(len(close), np.bool_)
        for pair, first, second in core_pair_chunks(own, close, part, rows, wanted):
            if meet[pair].all():
                continue
            if not wanted:
                # Touching is not overlap.
                first.p = first.p - LIFT * _DOWN
            meet[pair[~are_apart(first, second, np.full(len(pair), wanted))]] = True
        return close[meet]

    def _reject(self, free: Flags, index: Indices, name: str) -> None:
        """Records that some tries do not fit, because they are too close to an entity."""
        free[index] = False
        if len(index):
            self._why[f"too close to `{name}`"] += len(index)
            if self._blocked is not None:
                self._blocked.setdefault(name, np.zeros(len(free), np.bool_))[index] = True

    def _is_near(self, parts: list[Part], rows: Indices, near: Nearness) -> Flags:
        """Returns whether parts in some rows of the batch are within a range of distances from an entity."""
        closest = np.full(len(rows), np.inf)
        for other in self._placer.bodies[near.entity]:
            for own in parts:
                there = np.flatnonzero(own.there & other.there[rows])
                if there.size and not other.is_plane:
                    for pair, first, second in core_pair_chunks(own, there, other, rows[there], near.most):
                        np.minimum.at(closest, there[pair], distances(first, second))
        return (closest >= near.least - TOLERANCE) & (closest <= near.most + TOLERANCE)


def _repeat(direction: Floats, rows: Indices) -> Floats:
    """Returns a direction repeated for some rows (n, 3)."""
    return np.broadcast_to(direction, (len(rows), 3))
