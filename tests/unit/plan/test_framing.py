"""How a picture frames a scene: the subject, what stands before it, and whether all of it is in the picture."""

from __future__ import annotations

from math import tan
from typing import Any

import numpy as np
import pytest

from scenecc.geometry.rotation_arrays import rotation_matrix
from scenecc.plan.framing import (
    FRAMING_FOVY,
    VIEWS,
    FramedView,
    Motion,
    Solids,
    Subject,
    View,
    azimuth_of,
    cell_size,
    find_subject,
    frame_subject,
)

STATIC, KINEMATIC, DYNAMIC = Motion
FLOOR = ([-1e4, -1e4, 0], [1e4, 1e4, 0], STATIC)
CUBE = ([0.48, -0.02, 0.7], [0.52, 0.02, 0.74], DYNAMIC)


def solids(*rows: tuple[Any, Any, Motion]) -> Solids:
    """One box a body."""
    boxes = np.array([[low, high] for low, high, _ in rows], np.float64).reshape(-1, 2, 3)
    return Solids(boxes, np.arange(len(rows)), np.array([motion for *_, motion in rows], np.int64))


def corners_in_picture(view: FramedView, subject: Subject, width: int, height: int) -> np.ndarray[Any, Any]:
    """(N, 2) of all corners, -1 to 1 from edge to edge."""
    choice = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)])
    corners = subject.boxes[:, choice, [0, 1, 2]].reshape(-1, 3)
    local = (corners - view.pose[:3]) @ rotation_matrix(view.pose[3:])
    assert (local[:, 0] > view.near).all()
    assert (local[:, 0] < view.far).all()
    up = tan(FRAMING_FOVY / 2)
    return local[:, 1:] / local[:, :1] / (up * width / height, up)


@pytest.mark.parametrize(
    "rows",
    [
        [FLOOR, CUBE],
        [FLOOR, ([-0.05] * 3, [0.05, 0.05, 6], DYNAMIC)],
        [FLOOR, *(([x, y, 0], [x + 0.05, y + 0.05, 0.05], DYNAMIC) for x in range(-2, 3) for y in range(-2, 3))],
        [FLOOR, ([0, 0, 0], [0.002, 0.003, 0.001], DYNAMIC)],
        [FLOOR, ([-25, -25, 0], [25, 25, 4], DYNAMIC)],
        [([0, 0, 0], [1, 2, 3], STATIC), ([4, 0, 0], [5, 1, 1], STATIC)],
    ],
    ids=["cube", "tall", "wide", "tiny", "large", "statics"],
)
@pytest.mark.parametrize(("width", "height"), [(640, 480), (200, 600)])
def test_all_of_the_subject_is_in_the_picture_and_fills_it(rows: list[Any], width: int, height: int) -> None:
    subject = find_subject(solids(*rows))
    view = frame_subject(subject, width, height)
    found = corners_in_picture(view, subject, width, height)
    spans = np.ptp(found, axis=0) / 2
    filled = 0.75 if len(subject.boxes) == 1 else 0.84
    assert spans.max() == pytest.approx(filled, rel=0.25)
    assert np.abs(found).max() < 0.9
    assert np.allclose(found.max(axis=0), -found.min(axis=0), atol=0.06), "about as far from either edge"


def test_the_subject_is_what_moves_and_what_of_its_size_is_beside_it() -> None:
    table = ([-1, -1, 0], [1, 1, 0.7], STATIC)
    goal = ([0.56, 0, 0.7], [0.6, 0.04, 0.7], KINEMATIC)
    far_goal = ([0.9, 0.9, 0.7], [0.94, 0.94, 0.7], KINEMATIC)
    subject = find_subject(solids(FLOOR, table, CUBE, goal, far_goal))
    assert subject.boxes.tolist() == [[*CUBE[:2]], [*goal[:2]]]
    assert subject.ground == pytest.approx(0.7), "the table's top, not the floor"
    assert len(subject.obstacles) == 3


def test_without_anything_that_moves_it_is_all_but_the_floor() -> None:
    slab = ([-5, -5, -0.2], [5, 5, 0], STATIC)
    shelf, crate = ([0, 0, 0], [1, 0.3, 2], STATIC), ([2, 0, 0], [2.5, 0.5, 0.5], STATIC)
    assert find_subject(solids(slab, FLOOR, shelf, crate)).boxes.tolist() == [[*shelf[:2]], [*crate[:2]]]
    assert find_subject(solids(slab, FLOOR)).boxes.tolist() == [[*slab[:2]]]
    assert find_subject(solids()).radius == pytest.approx(3**0.5 / 2)


def test_a_focus_is_framed_alone_and_the_rest_may_hide_it() -> None:
    other = ([0, 0, 0], [0.1, 0.1, 0.1], DYNAMIC)
    subject = find_subject(solids(FLOOR, CUBE, other), [2])
    assert subject.boxes.tolist() == [[*other[:2]]]
    assert len(subject.obstacles) == 2


def test_a_camera_does_not_look_at_the_back_of_a_wall() -> None:
    free = frame_subject(find_subject(solids(FLOOR, CUBE)), 640, 480)
    wall = ([0.54, -3, 0], [0.56, 3, 3], STATIC)
    subject = find_subject(solids(FLOOR, CUBE, wall))
    view = frame_subject(subject, 640, 480)
    assert free.pose[0] > 0.57
    # Nearer than the wall, or on the other side.
    assert view.pose[0] < 0.54
    assert np.abs(corners_in_picture(view, subject, 640, 480)).max() < 0.9
    room = ([-3, -3, 0], [3, 3, 3], STATIC)
    inside = frame_subject(find_subject(solids(FLOOR, CUBE, room)), 640, 480)
    assert np.array_equal(inside.pose, free.pose), "what surrounds it may be a room"


def test_a_view_is_from_its_side_and_a_zoom_magnifies() -> None:
    subject = find_subject(solids(FLOOR, CUBE))
    for view, direction in VIEWS.items():
        pose = frame_subject(subject, 640, 480, view=view).pose
        unit = np.array(direction) / np.linalg.norm(direction)
        assert np.allclose(rotation_matrix(pose[3:])[:, 0], -unit, atol=1e-3), view
    ups: list[tuple[View, list[float]]] = [("top", [1, 0, 0]), ("bottom", [1, 0, 0]), ("front", [0, 0, 1])]
    for view, up in ups:
        pose = frame_subject(subject, 640, 480, view=view).pose
        assert np.allclose(rotation_matrix(pose[3:])[:, 2], up, atol=1e-3), view
    whole, near, far = (frame_subject(subject, 640, 480, zoom=zoom) for zoom in (1, 4, 0.25))
    assert np.array_equal(near.pose, whole.pose)
    assert tan(near.fovy / 2) == pytest.approx(tan(FRAMING_FOVY / 2) / 4)
    assert far.fovy == whole.fovy == pytest.approx(FRAMING_FOVY)
    assert np.ptp(corners_in_picture(far, subject, 640, 480), axis=0).max() == pytest.approx(2 * 0.75 / 4)


def test_an_eye_and_a_point_are_taken_as_they_are() -> None:
    subject = find_subject(solids(FLOOR, CUBE))
    view = frame_subject(subject, 640, 480, eye=(3, 1, 2), look_at=(0, 1, 2))
    assert view.pose[:3].tolist() == [3, 1, 2]
    assert np.allclose(rotation_matrix(view.pose[3:])[:, 0], [-1, 0, 0])
    assert np.allclose(rotation_matrix(view.pose[3:])[:, 2], [0, 0, 1])
    above = frame_subject(subject, 640, 480, eye=(0.5, 0, 5))
    assert np.allclose(rotation_matrix(above.pose[3:])[:, 0], [0, 0, -1], atol=1e-3), "straight down"
    within = frame_subject(subject, 640, 480, eye=subject.center.tolist())
    assert np.isfinite(within.pose).all()
    aside = frame_subject(subject, 640, 480, look_at=(0.6, 0, 0.7))
    found = corners_in_picture(aside, subject, 640, 480)
    assert np.abs(found).max() == pytest.approx(0.75)


def test_the_cells_of_a_ground_grid_are_round_and_about_six_a_subject() -> None:
    for size in (0.003, 0.04, 0.7, 1, 2.5, 50):
        cell = cell_size(find_subject(solids(([0, 0, 0], [size, size, size], DYNAMIC))))
        digits = cell / 10 ** np.floor(np.log10(cell) + 1e-9)
        assert min(abs(digits - one) for one in (1, 2, 5)) < 1e-6
        assert 1.7 < size / cell < 9


def test_the_lights_know_where_the_camera_is() -> None:
    subject = find_subject(solids(CUBE))
    assert azimuth_of(subject.center + np.array([0, 2, 1]), subject) == pytest.approx(np.pi / 2)
    assert azimuth_of(subject.center + np.array([0, 0, 1]), subject) == pytest.approx(np.arctan2(0.75, 1))
