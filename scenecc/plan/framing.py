"""Framing of a scene: the subject of a picture, its ground, and a camera pose that shows all of it.

Computes poses from boxes, without an engine or a page. `scenecc render` and the viewer use it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from math import atan, cos, pi, radians, sin, tan
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from scenecc.geometry import rotation_arrays
from scenecc.plan.rendering import FLAT_THICKNESS, FRAMING_DIRECTION, PLANE_HALF_SIZE

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    from numpy.typing import NDArray


FRAMING_FOVY: Final = radians(36)
"""Angle of view of a framing camera: narrow, as for product photos, so that edges stay nearly parallel."""

View = Literal["iso", "front", "back", "left", "right", "top", "bottom"]

VIEWS: Final[dict[View, tuple[float, float, float]]] = {
    "iso": FRAMING_DIRECTION,
    "front": (1, 0, 0),
    "back": (-1, 0, 0),
    "left": (0, 1, 0),
    "right": (0, -1, 0),
    "top": (0, 0, 1),
    "bottom": (0, 0, -1),
}
"""Directions from the subject to a camera, in the world. In `top` and `bottom`, +x is up in the picture."""

_FILLED, _FILLED_BY_ONE = 0.84, 0.75
"""Fraction of the picture's width or height that the subject fills, and the same for a single body."""

_COMPARABLE, _BESIDE = 1.25, 2.0
"""Largest size and distance of a body at rest in the subject, in sizes of the moving bodies together."""

_LARGEST_SUPPORT: Final = 4.0
"""Longest side of a support that counts as furniture, not as a floor [m]."""

_THIN: Final = 0.1
"""Thickness over length of the thickest floor."""

_TURNS: Final = tuple(radians(degrees) for degrees in (0, -45, 45, -90, 90, -135, 135, 180))
_ELEVATIONS: Final = (None, radians(60))
"""Elevations to try if something hides the subject: around it, then higher."""

_MOST_TARGETS: Final = 64

_ROUNDS: Final = 6
"""Iterations that centre the subject along its looser side."""


class Motion(IntEnum):
    """Mobility of a body, in ascending order."""

    STATIC = 0
    KINEMATIC = 1
    DYNAMIC = 2


@dataclass(frozen=True, slots=True, eq=False)
class Solids:
    """The visible shapes of a scene, as axis-aligned boxes in the world.

    Attributes:
        boxes: (S, 2, 3) [m], lowest and highest corner of each shape.
        bodies: (S,) body of each shape, 0 to B - 1.
        motions: (B,) `Motion` of each body; a link of an articulation is dynamic.
        outlines: (S, K, 3) [m] points around each shape, closer than the corners of its box. None: these corners.
    """

    boxes: NDArray[np.float64]
    bodies: NDArray[np.int64]
    motions: NDArray[np.int64]
    outlines: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """The subject of a picture.

    Attributes:
        boxes: (N, 2, 3) [m] of its bodies, N at least 1.
        obstacles: (M, 2, 3) [m] of static shapes outside the subject.
        ground: height of the surface below it [m]; of its lowest point if there is none.
        outline: (P, 3) [m] points around its shapes.
    """

    boxes: NDArray[np.float64]
    obstacles: NDArray[np.float64]
    ground: float
    outline: NDArray[np.float64]

    @property
    def low(self) -> NDArray[np.float64]:
        """(3,) lower corner [m]."""
        return self.boxes[:, 0].min(axis=0)

    @property
    def high(self) -> NDArray[np.float64]:
        """(3,) upper corner [m]."""
        return self.boxes[:, 1].max(axis=0)

    @property
    def center(self) -> NDArray[np.float64]:
        """(3,) centre of its box [m]."""
        return (self.low + self.high) / 2

    @property
    def radius(self) -> float:
        """Half the diagonal of its box [m]."""
        return max(float(np.linalg.norm(self.high - self.low)) / 2, 1e-6)

    def reach(self, visible: float) -> float:
        """Extent of its surroundings from its centre [m]: at least 2.5 of its radii, at most what is `visible` [m]."""
        corners = np.abs(self.obstacles - self.center).max(axis=1) if len(self.obstacles) else np.zeros((0, 3))
        far = float(np.linalg.norm(corners, axis=1).max(initial=0))
        return max(2.5 * self.radius, min(far, visible))


@dataclass(frozen=True, slots=True, eq=False)
class FramedView:
    """The pose of a camera.

    Attributes:
        pose: (7,) p [m], then q (wxyz); it looks along x, z is up.
        near, far: clipping distances [m].
        fovy: angle of view [rad].
    """

    pose: NDArray[np.float64]
    near: float
    far: float
    fovy: float

    def visible(self, center: NDArray[np.float64]) -> float:
        """Returns how far from a point (3,) surfaces are clearly visible [m]: 2.5 heights of the picture there."""
        return 5 * tan(self.fovy / 2) * float(np.linalg.norm(center - self.pose[:3]))


def find_subject(solids: Solids, focus: Collection[int] = ()) -> Subject:
    """Finds the subject of a picture: the moving bodies, and bodies of similar size beside them.

    If `focus` names bodies by number, these are the subject. Without dynamic bodies the kinematic ones are, without
    these everything but floors. Much larger bodies (a room, a table under a cube) do not belong to the subject. An
    empty scene has a box of 1 m around its origin.
    """
    boxes = _body_boxes(solids)
    real = np.asarray(np.isfinite(boxes).all(axis=(1, 2)))
    chosen = real & np.isin(np.arange(len(boxes)), list(focus)) if focus else _find_moving(boxes, real, solids.motions)
    if not chosen.any():
        unit = np.array([[[-0.5] * 3, [0.5] * 3]])
        return Subject(unit, np.zeros((0, 2, 3)), -0.5, box_corners(unit).reshape(-1, 3))
    finite, within = np.isfinite(solids.boxes).all(axis=(1, 2)), chosen[solids.bodies]
    points = box_corners(solids.boxes) if solids.outlines is None else solids.outlines
    subject = Subject(boxes[chosen], solids.boxes[~within & finite], 0.0, points[within & finite].reshape(-1, 3))
    return replace(subject, ground=_support(subject))


def find_supported(solids: Solids) -> Subject:
    """Finds the subject with what it stands on, such as a table, and everything else there."""
    subject, boxes = find_subject(solids), _body_boxes(solids)
    margin = 0.05 * subject.radius
    sides = boxes[:, 1] - boxes[:, 0]
    small = (sides.max(axis=1) <= _LARGEST_SUPPORT) & (sides >= 0).all(axis=1)

    def above(low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.bool_]:
        return small & ((boxes[:, 0] <= high) & (boxes[:, 1] >= low))[:, :2].all(axis=1)

    tops = boxes[:, 1, 2]
    under = above(subject.low, subject.high) & (tops <= subject.low[2] + margin)
    if not under.any():
        return subject
    under &= tops >= tops[under].max() - margin
    beside = above(boxes[under, 0].min(axis=0), boxes[under, 1].max(axis=0)) & (boxes[:, 0, 2] >= tops[under].min())
    own = (boxes[:, 0] >= subject.low).all(axis=1) & (boxes[:, 1] <= subject.high).all(axis=1)
    return find_subject(solids, np.flatnonzero(under | beside | own).tolist())


def _body_boxes(solids: Solids) -> NDArray[np.float64]:
    """(B, 2, 3) [m], lowest and highest corner of each body; infinite for a body without shapes."""
    boxes = np.stack([np.full((len(solids.motions), 3), np.inf), np.full((len(solids.motions), 3), -np.inf)], axis=1)
    np.minimum.at(boxes[:, 0], solids.bodies, solids.boxes[:, 0])
    np.maximum.at(boxes[:, 1], solids.bodies, solids.boxes[:, 1])
    return boxes


def box_corners(boxes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns the corners (…, 8, 3) of boxes (…, 2, 3)."""
    choice = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)])
    return boxes[..., choice, [0, 1, 2]]


def _find_moving(boxes: NDArray[np.float64], real: NDArray[np.bool_], motions: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which bodies move, or could, and which bodies of similar size are beside them."""
    standing = real & ~_are_floors(boxes, real)
    levels = (real & (motions == Motion.DYNAMIC), standing & (motions == Motion.KINEMATIC), standing)
    bounded = real & ((boxes[:, 1] - boxes[:, 0]).max(axis=1) < PLANE_HALF_SIZE)
    chosen = next((level for level in levels if level.any()), bounded)
    if not chosen.any():
        return chosen
    low, high = boxes[chosen, 0].min(axis=0), boxes[chosen, 1].max(axis=0)
    size = float((high - low).max())
    reach = _BESIDE * size
    beside = ((boxes[:, 0] <= high + reach) & (boxes[:, 1] >= low - reach)).all(axis=1)
    return chosen | (real & beside & ((boxes[:, 1] - boxes[:, 0]).max(axis=1) <= _COMPARABLE * size))


def _are_floors(boxes: NDArray[np.float64], real: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which boxes are floors: flat, or thin, below everything that is not thin, and wider."""
    sides = boxes[:, 1] - boxes[:, 0]
    flat = sides.min(axis=1) <= FLAT_THICKNESS
    thin = sides[:, 2] <= _THIN * sides.max(axis=1)
    rest = boxes[real & ~flat & ~thin]
    if not len(rest):
        return flat
    low, high = rest[:, 0].min(axis=0), rest[:, 1].max(axis=0)
    below = boxes[:, 1, 2] <= low[2] + sides[:, 2]
    covers = (boxes[:, 0, :2] <= low[:2]).all(axis=1) & (boxes[:, 1, :2] >= high[:2]).all(axis=1)
    return flat | (thin & below & covers)


def _support(subject: Subject) -> float:
    """The highest top of an obstacle under the subject's centre, or else the subject's lowest height."""
    bottom, (x, y, _) = float(subject.low[2]), subject.center
    under = (
        (subject.obstacles[:, 0, :2] <= (x, y)).all(axis=1)
        & (subject.obstacles[:, 1, :2] >= (x, y)).all(axis=1)
        & (subject.obstacles[:, 1, 2] <= bottom + 0.05 * subject.radius)
    )
    return float(subject.obstacles[under, 1, 2].max(initial=-np.inf)) if under.any() else bottom


def frame_subject(
    subject: Subject,
    width: int,
    height: int,
    *,
    eye: Sequence[float] | None = None,
    look_at: Sequence[float] | None = None,
    view: View | None = None,
    zoom: float = 1.0,
) -> FramedView:
    """A camera pose that shows all of a subject.

    Without `eye` and `view`, it looks along `FRAMING_DIRECTION`, or from another side if an obstacle hides the subject.

    Args:
        subject: the subject.
        width: of the picture [px].
        height: of the picture [px].
        eye: (3,) [m], a fixed camera position; None: computed.
        look_at: (3,) [m], the point at the centre of the picture; None: the centre of the subject.
        view: the side to look from, whatever is in the way.
        zoom: magnification about the middle of the picture: of the lens above 1 or with an `eye`, otherwise the camera
            is farther away.
    """
    slope = tan(FRAMING_FOVY / 2) * min(zoom, 1) * (_FILLED if len(subject.boxes) > 1 else _FILLED_BY_ONE)
    slopes = (slope * width / height, slope)
    target = None if look_at is None else np.asarray(look_at, np.float64)
    if eye is not None:
        place = np.asarray(eye, np.float64)
        forward = (subject.center if target is None else target) - place
        inside = float(np.linalg.norm(forward)) < 1e-9 * subject.radius
        return _view(subject, place, -_direction(0, None) if inside else forward, zoom)
    best: tuple[float, FramedView] | None = None
    for back in _directions(view):
        place = _fit(subject, back, slopes, target)
        found = _view(subject, place, -back * float(np.linalg.norm(subject.center - place)), max(zoom, 1))
        hidden = hidden_share(subject, found.pose[:3])
        if best is None or hidden < best[0]:
            best = (hidden, found)
        if not hidden:
            break
    assert best is not None
    return best[1]


def _view(subject: Subject, place: NDArray[np.float64], forward: NDArray[np.float64], zoom: float) -> FramedView:
    length = float(np.linalg.norm(forward))
    reach = max(length, float(np.linalg.norm(subject.center - place)) + subject.radius)
    pose, fovy = np.concatenate([place, _looking(forward)]), 2 * atan(tan(FRAMING_FOVY / 2) / zoom)
    return FramedView(pose, 0.01 * min(length, reach), 100 * reach, fovy)


def _looking(forward: NDArray[np.float64]) -> NDArray[np.float64]:
    """(4,) rotation of a camera that looks along a vector; straight down or up, the top of the picture is +x."""
    q, known = rotation_arrays.looking(forward[None])
    if not known[0]:
        tilt = np.array([np.copysign(1e-4, -forward[2]), 0, 0]) * float(np.linalg.norm(forward))
        q, _ = rotation_arrays.looking(forward[None] + tilt)
    return q[0]


def _directions(view: View | None) -> Iterator[NDArray[np.float64]]:
    """Yields unit vectors (3,) from the subject to the cameras to try."""
    if view is not None:
        yield np.array(VIEWS[view]) / np.linalg.norm(VIEWS[view])
        return
    for elevation in _ELEVATIONS:
        for turn in _TURNS:
            yield _direction(turn, elevation)


def _direction(turn: float, elevation: float | None) -> NDArray[np.float64]:
    """(3,) unit vector from the subject to the camera."""
    back = np.array(FRAMING_DIRECTION) / np.linalg.norm(FRAMING_DIRECTION)
    azimuth = np.arctan2(back[1], back[0]) + turn
    return toward(float(azimuth), float(np.arcsin(back[2])) if elevation is None else elevation)


def _fit(
    subject: Subject, back: NDArray[np.float64], slopes: tuple[float, float], target: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """(3,) the nearest position from which all corners are in the picture, with equal margins on opposite sides.

    In the camera frame, a corner at depth d and offset s is in the picture of a camera at depth -D and offset S if
    |s - S| <= (d + D) · slope.
    """
    axes = rotation_arrays.rotation_matrix(_looking(-back))  # columns: forward, left, up
    corners = subject.outline @ axes
    depth, distance, offsets = corners[:, 0], -np.inf, [0.0, 0.0]
    for axis, slope in enumerate(slopes):
        side = corners[:, 1 + axis]
        if target is None:
            most, least = (side - depth * slope).max(), (side + depth * slope).min()
            offsets[axis] = float(most + least) / 2
            distance = max(distance, float(most - least) / (2 * slope))
        else:
            offsets[axis] = float(target @ axes[:, 1 + axis])
            distance = max(distance, float((np.abs(side - offsets[axis]) / slope - depth).max()))
    distance = max(distance, 1e-6 - float(depth.min()))
    for axis in (0, 1) if target is None else ():
        side = corners[:, 1 + axis]
        for _ in range(_ROUNDS):
            seen = (side - offsets[axis]) / (depth + distance)
            nearest = min(depth[seen.argmax()], depth[seen.argmin()]) + distance
            offsets[axis] += float(seen.max() + seen.min()) / 2 * float(nearest)
    return axes @ np.array([-distance, *offsets])


def hidden_share(subject: Subject, eye: NDArray[np.float64]) -> float:
    """Fraction of bodies whose centre is behind an obstacle, 0 to 1. One body inside of the other hides nothing."""
    bodies, boxes = subject.boxes, subject.obstacles
    if len(bodies) > _MOST_TARGETS:
        bodies = bodies[:: len(bodies) // _MOST_TARGETS + 1]
    hidden, middles = 0, boxes.mean(axis=1)
    for low, high in bodies:
        target = (low + high) / 2
        around = ((boxes[:, 0] <= target) & (boxes[:, 1] >= target)).all(axis=1)
        around |= ((low <= middles) & (middles <= high)).all(axis=1)
        way = np.where(np.abs(target - eye) < 1e-12, 1e-12, target - eye)
        first, second = (boxes[:, 0] - eye) / way, (boxes[:, 1] - eye) / way
        enters = np.minimum(first, second).max(axis=1).clip(min=0)
        leaves = np.maximum(first, second).min(axis=1).clip(max=0.99)
        hidden += bool(((enters < leaves) & ~around).any())
    return hidden / len(bodies)


def cell_size(subject: Subject) -> float:
    """Cell size of a ground grid that shows a subject's scale [m]: 1, 2 or 5 times a power of ten."""
    rough = subject.radius / 3
    power = 10.0 ** np.floor(np.log10(rough))
    return float(next(step * power for step in (5, 2, 1) if step * power <= rough * (1 + 1e-9)))


def toward(azimuth: float, elevation: float) -> NDArray[np.float64]:
    """(3,) unit vector at an azimuth around z from +x and an elevation [rad]."""
    return np.array([cos(elevation) * cos(azimuth), cos(elevation) * sin(azimuth), sin(elevation)])


def azimuth_of(place: NDArray[np.float64], subject: Subject) -> float:
    """The azimuth of a camera from a subject, around z from +x [rad]; the framing's azimuth if it is directly above."""
    x, y = (place - subject.center)[:2]
    if np.hypot(x, y) < 1e-6 * subject.radius:
        x, y, _ = FRAMING_DIRECTION
    return float(np.arctan2(y, x)) % (2 * pi)
