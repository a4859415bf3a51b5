"""The upward surfaces of parts, and tests whether a footprint is completely on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotation_arrays import Flags, Floats
    from scenecc.placing.bodies import Part


LEVEL: Final = 0.9998
"""Minimum z of the unit normal of a supporting surface: level within about a degree."""

COPLANAR: Final = 0.001
"""Maximum height difference of coplanar surfaces [m]."""

_SIDES: Final = 64
"""Number of corners of the polygon of a round top."""

_TOLERANCE: Final = 1e-9

_SAME_CORNER: Final = 1e-7
"""Maximum distance of equal corners [m]: the direction of an edge between them would be unreliable."""

_SAME_HEIGHT: Final = 1e-6
"""Maximum height difference of mesh vertices in one level [m]."""

_BOX: Final = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], np.float64)
_CIRCLE: Final = np.stack(
    [np.cos(np.arange(_SIDES) * (2 * np.pi / _SIDES)), np.sin(np.arange(_SIDES) * (2 * np.pi / _SIDES))], axis=1
)


@dataclass(slots=True)
class SupportSurface:
    """A level convex polygon over the scenes of a batch.

    Attributes:
        there: whether it exists in each scene (B,).
        z: height (B,) [m].
        corners: in the world, counterclockwise from above (B, k, 2) [m]; None: it is infinite.
    """

    there: Flags
    z: Floats
    corners: Floats | None

    def taken(self, rows: NDArray[np.intp]) -> SupportSurface:
        """Returns some of its rows, in any order."""
        return SupportSurface(self.there[rows], self.z[rows], None if self.corners is None else self.corners[rows])


def upward_surfaces(part: Part) -> list[SupportSurface]:
    """Returns the level upward surfaces of a part in the world."""
    up = part.turn[:, 2]
    if part.is_plane:
        return [SupportSurface(part.there & (up[:, 0] > LEVEL), part.p[:, 2], None)]
    if part.points is not None:
        return _mesh_surfaces(part)
    if part.margin.any():
        return []
    if part.disk.any():
        there = part.there & (np.abs(up[:, 0]) > LEVEL)
        return [_face(part, there, 0, part.disk[:, None, None] * _CIRCLE)] if there.any() else []
    found: list[SupportSurface] = []
    steepest = np.abs(up).argmax(axis=1)
    for axis in range(3):
        there = part.there & (steepest == axis) & (np.abs(up[:, axis]) > LEVEL)
        if there.any():
            across = part.half[:, [(axis + 1) % 3, (axis + 2) % 3]]
            found.append(_face(part, there, axis, across[:, None] * _BOX))
    return found


def _face(part: Part, there: Flags, axis: int, flat: Floats) -> SupportSurface:
    """Returns the upper one of a part's two faces across an axis. `flat`: its corners (B, k, 2) along the other two
    axes.
    """
    side = np.where(part.turn[:, 2, axis] > 0, 1.0, -1.0)
    local = np.empty((*flat.shape[:2], 3))
    local[:, :, axis] = (side * part.half[:, axis])[:, None]
    local[:, :, (axis + 1) % 3] = flat[:, :, 0]
    # From the other side, the corners are in the opposite order.
    local[:, :, (axis + 2) % 3] = flat[:, :, 1] * side[:, None]
    corners = np.matmul(local, part.turn.transpose(0, 2, 1)) + part.p[:, None]
    return SupportSurface(there, corners[:, :, 2].max(axis=1), corners[:, :, :2])


def _mesh_surfaces(part: Part) -> list[SupportSurface]:
    """Returns the level tops of a hull, or the level triangles of a mesh; triangles of a convex polygon are merged."""
    assert part.points is not None
    state = np.concatenate([part.turn.reshape(-1, 9), part.scale], axis=1)
    _, first, same = np.unique(state, axis=0, return_index=True, return_inverse=True)
    same = same.reshape(-1)
    each = [
        _level_polygons((part.points * part.scale[row]) @ part.turn[row].T, part.triangles) for row in first.tolist()
    ]
    found: list[SupportSurface] = []
    for number in range(max(map(len, each))):
        widest = max(len(polygons[number][1]) for polygons in each if len(polygons) > number)
        z, corners = np.zeros(len(each)), np.zeros((len(each), widest, 2))
        for row, polygons in enumerate(each):
            if len(polygons) > number:
                z[row], polygon = polygons[number]
                corners[row, : len(polygon)], corners[row, len(polygon) :] = polygon, polygon[-1]
        there = part.there & np.array([len(polygons) > number for polygons in each])[same]
        found.append(SupportSurface(there, z[same] + part.p[:, 2], corners[same] + part.p[:, None, :2]))
    return found


def _level_polygons(points: Floats, triangles: Any) -> list[tuple[float, Floats]]:
    """Returns the heights and corners of the level upward polygons of a mesh."""
    if triangles is None:
        top = points[points[:, 2] > points[:, 2].max() - _SAME_HEIGHT]
        order = hull_order(top[:, :2])
        return [(float(top[:, 2].max()), top[order][:, :2])] if len(order) > 2 else []
    level = _level_of(points, triangles)
    if not len(level):
        return []
    found: list[tuple[float, Floats]] = []
    heights: Floats = np.round(np.asarray(level[:, :, 2].max(axis=1), np.float64) / _SAME_HEIGHT)
    distinct: list[float] = np.unique(heights).tolist()
    order = np.argsort(heights, kind="stable")
    for height, rows in zip(distinct, np.split(order, np.searchsorted(heights[order], distinct[1:])), strict=True):
        flat = level[rows][:, :, :2]
        whole = flat.reshape(-1, 2)
        whole = whole[hull_order(whole)]
        first, second = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
        area = float(np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum()) / 2
        polygons = [whole] if abs(area_of(whole) - area) <= 1e-9 * area else list(flat)
        found += [(height * _SAME_HEIGHT, polygon) for polygon in polygons]
    return found


def _level_of(points: Floats, triangles: Any) -> Floats:
    corners = points[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.sqrt((normal**2).sum(axis=1))
    return corners[(length > 0) & (normal[:, 2] > LEVEL * length)]


def hull_order(points: Floats) -> list[int]:
    """Returns the indices of the convex hull of points (n, 2), counterclockwise."""
    order, listed = np.lexsort((points[:, 1], points[:, 0])).tolist(), points.tolist()

    def half(indices: Sequence[int]) -> list[int]:
        kept: list[int] = []
        for index in indices:
            while len(kept) > 1 and _turn(listed[kept[-2]], listed[kept[-1]], listed[index]) <= 0:
                kept.pop()
            kept.append(index)
        return kept[:-1]

    return half(order) + half(order[::-1])


def _turn(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def extent(parts: Sequence[Part], direction: Floats) -> Floats:
    """Returns the combined extent of parts in directions (B, 3), as a coordinate along them (B,) [m]."""
    found = np.full(len(direction), -np.inf)
    for part in parts:
        found = np.where(part.there, np.maximum(found, part.extent(direction)), found)
    return found


def is_within(parts: Sequence[Part], corners: Floats) -> Flags:
    """Returns whether the footprint of parts is within a convex polygon (B,). `corners`: (B, k, 2) [m]."""
    fits = np.ones(len(corners), np.bool_)
    edges = np.roll(corners, -1, axis=1) - corners
    for number in range(corners.shape[1]):
        edge = edges[:, number]
        length = np.hypot(edge[:, 0], edge[:, 1])
        outward = np.zeros((len(corners), 3))
        ends = length < _SAME_CORNER
        safe = np.where(ends, 1.0, length)
        outward[:, 0], outward[:, 1] = edge[:, 1] / safe, -edge[:, 0] / safe
        limit = np.einsum("ij,ij->i", outward[:, :2], corners[:, number]) + _TOLERANCE
        fits &= ends | (extent(parts, outward) <= limit)
    return fits


def highest_below(parts: Sequence[Part], surfaces: Sequence[SupportSurface], levels: Floats | None) -> Floats:
    """Returns the height of the highest surface below the whole footprint of parts (B,) [m]; -inf if there is none.

    Args:
        parts: parts of the placed object, at any height.
        surfaces: possible supports.
        levels: minimum and maximum height of the surface (B, 2) [m]; None: any.
    """
    count = len(parts[0].there)
    best = np.full(count, -np.inf)
    for surface in surfaces:
        open_ = surface.there & (surface.z > best)
        if levels is not None:
            open_ &= (surface.z >= levels[:, 0] - _TOLERANCE) & (surface.z <= levels[:, 1] + _TOLERANCE)
        if surface.corners is not None and open_.any():
            rows = np.flatnonzero(open_)
            fits = np.zeros(count, np.bool_)
            fits[rows] = is_within([part.taken(rows) for part in parts], surface.corners[rows])
            open_ &= fits
        best = np.where(open_, surface.z, best)
    return _highest_joined(parts, surfaces, levels, best)


def _highest_joined(
    parts: Sequence[Part], surfaces: Sequence[SupportSurface], levels: Floats | None, best: Floats
) -> Floats:
    """Returns the result of `highest_below` for supports made of several coplanar surfaces."""
    ended = [surface for surface in surfaces if surface.corners is not None]
    if len(ended) < 2:
        return best
    z = np.stack([np.where(one.there, one.z, -np.inf) for one in ended], axis=1)
    if levels is not None:
        z = np.where((z >= levels[:, :1] - _TOLERANCE) & (z <= levels[:, 1:] + _TOLERANCE), z, -np.inf)
    ranked = np.sort(z, axis=1)
    with np.errstate(invalid="ignore"):
        near = (ranked[:, 1:] - ranked[:, :-1] <= COPLANAR) & (ranked[:, 1:] > best[:, None])
    found = best.copy()
    over = np.stack([_are_over(parts, one.corners) for one in ended if one.corners is not None], axis=-1)
    absent = ~np.stack([part.there for part in parts])
    for row in np.flatnonzero(near.any(axis=1)).tolist():
        outline: Floats | None = None
        for top in sorted({level for level in z[row].tolist() if level > best[row]}, reverse=True):
            is_level = (z[row] <= top) & (z[row] >= top - COPLANAR)
            if is_level.sum() < 2 or not (absent[:, row] | over[:, row, is_level].any(axis=1)).all():
                continue
            outline = footprint(parts, row) if outline is None else outline
            polygons = [
                one.corners[row]
                for one, level in zip(ended, is_level, strict=True)
                if level and one.corners is not None
            ]
            if is_covered(outline, polygons):
                found[row] = top
                break
    return found


def _are_over(parts: Sequence[Part], corners: Floats) -> Flags:
    """Returns whether the middle of each part is above a convex polygon, (parts, B). `corners`: (B, k, 2)."""
    found: list[Flags] = []
    edges = np.roll(corners, -1, axis=1) - corners
    for part in parts:
        middle = 0.0 if part.points is None else part.points.mean(axis=0) * part.scale
        middle = np.matmul(part.turn, np.broadcast_to(middle, part.p.shape)[:, :, None])[:, :, 0] + part.p
        off = middle[:, None, :2] - corners
        found.append((edges[..., 0] * off[..., 1] - edges[..., 1] * off[..., 0] >= -_TOLERANCE).all(axis=1))
    return np.stack(found)


def footprint(parts: Sequence[Part], row: int) -> Floats:
    """Returns the footprint of parts in a scene, (k, 2) counterclockwise; round shapes get a polygon around them."""
    directions = np.concatenate([_CIRCLE, np.zeros((_SIDES, 1))], axis=1)
    found: list[Floats] = []
    for part in parts:
        if not part.there[row]:
            continue
        if part.points is not None:
            found.append(((part.points * part.scale[row]) @ part.turn[row].T + part.p[row])[:, :2])
        elif not part.margin[row] and not part.disk[row]:
            signs = np.array(np.meshgrid((-1, 1), (-1, 1), (-1, 1))).reshape(3, 8).T
            found.append(((signs * part.half[row]) @ part.turn[row].T + part.p[row])[:, :2])
        else:
            reach = part.taken(np.full(_SIDES, row)).extent(directions)
            following = np.roll(reach, -1)
            turn = 2 * np.pi / _SIDES
            along = (following - reach * np.cos(turn)) / np.sin(turn)
            found.append(reach[:, None] * _CIRCLE + along[:, None] * np.stack([-_CIRCLE[:, 1], _CIRCLE[:, 0]], axis=1))
    points = np.concatenate(found)
    return points[hull_order(points)]


def is_covered(polygon: Floats, by: Sequence[Floats]) -> bool:
    """Returns whether convex polygons together cover another one; all (k, 2), counterclockwise."""
    rest: list[list[Any]] = [polygon.tolist()]
    for cover in by:
        rest = [piece for one in rest for piece in _subtract(one, cover.tolist())]
    return sum(area_of(np.array(one)) for one in rest) <= 1e-9 * area_of(polygon)


def _subtract(polygon: list[Any], cover: list[Any]) -> list[list[Any]]:
    """Returns the convex pieces of a polygon outside another one, as lists of points."""
    pieces: list[list[Any]] = []
    inside = polygon
    for start, end in zip(cover, [*cover[1:], cover[0]], strict=True):
        beyond = _clip(inside, end, start)
        if len(beyond) > 2:
            pieces.append(beyond)
        inside = _clip(inside, start, end)
        if len(inside) < 3:
            break
    return pieces


def _clip(polygon: list[Any], start: Sequence[float], end: Sequence[float]) -> list[Any]:
    """Returns the part of a convex polygon to the left of a line."""
    along = end[0] - start[0], end[1] - start[1]
    side = [along[0] * (y - start[1]) - along[1] * (x - start[0]) for x, y in polygon]
    kept: list[Any] = []
    for here, (x, y) in enumerate(polygon):
        there = (here + 1) % len(polygon)
        if side[here] >= 0:
            kept.append((x, y))
        if side[here] * side[there] < 0:
            share = side[here] / (side[here] - side[there])
            kept.append((x + share * (polygon[there][0] - x), y + share * (polygon[there][1] - y)))
    return kept


def area_of(polygon: Floats) -> float:
    """Returns the area of a polygon (k, 2) [m²]."""
    if len(polygon) < 3:
        return 0.0
    x, y = polygon.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2
