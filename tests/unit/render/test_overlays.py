"""What is drawn over pictures, and from where to where: projections, grids, labels, axes, contacts, legends."""

from __future__ import annotations

from itertools import combinations
from math import radians, tan

import numpy as np
import pytest

from scenecc.geometry.rotation_arrays import looking, rotation_matrix
from scenecc.render.ground import draw_ground
from scenecc.render.legends import add_depth_bar, add_names, depth_colors, depth_range
from scenecc.render.overlays import Overlay
from scenecc.render.projection import Projection
from scenecc.render.recorder import sample_shifts

WIDTH, HEIGHT = 64, 48


def camera(eye: tuple[float, float, float], look_at: tuple[float, float, float]) -> Projection:
    """One with 60 degrees from top to bottom, by the formulas of the pinhole."""
    q, _ = looking(np.array([look_at], float) - eye)
    forward, left, up = rotation_matrix(q[0]).T
    model = np.eye(4)
    model[:3] = np.stack([-left, up, -forward, eye], axis=1)
    f, near, far = 1 / tan(radians(30)), 0.1, 50.0
    lens = np.array(
        [
            [f * HEIGHT / WIDTH, 0, 0, 0],
            [0, -f, 0, 0],
            [0, 0, far / (near - far), near * far / (near - far)],
            [0, 0, -1, 0],
        ]
    )
    return Projection(WIDTH, HEIGHT, model, lens)


def test_points_are_projected_as_by_a_pinhole() -> None:
    seen = camera((-2, 0, 0), (0, 0, 0))
    points = np.array([[0, 0, 0], [0, 0.5, 0.25], [-3, 0, 0]])
    pixels, depth = seen.project(points)
    assert np.allclose(pixels[0], [WIDTH / 2, HEIGHT / 2])
    scale = HEIGHT / 2 / tan(radians(30)) / 2
    assert np.allclose(pixels[1], [WIDTH / 2 - 0.5 * scale, HEIGHT / 2 - 0.25 * scale]), "left and above"
    assert np.isnan(pixels[2]).all(), "behind the camera"
    assert np.allclose(depth, [2, 2, -1])


def test_each_pixel_sees_a_point_of_the_ground_that_projects_to_it() -> None:
    seen = camera((-2, 0.3, 1), (0, 0, 0.8))
    points, depth = seen.plane_points(0.25)
    there = np.isfinite(depth)
    assert 0.3 < there.mean() < 0.9, "not above the horizon"
    assert np.allclose(points[there][:, 2], 0.25)
    pixels, depths = seen.project(points[there])
    rows, columns = np.nonzero(there)
    assert np.allclose(pixels, np.stack([columns, rows], axis=1) + 0.5)
    assert np.allclose(depths, depth[there])
    shifted, _ = seen.plane_points(0.25, (2, 1))
    assert np.allclose(shifted[30, 10], points[29, 8])


def test_a_ground_grid_is_hidden_by_objects_in_front() -> None:
    seen = camera((0, -0.01, 2), (0, 0, 0))
    white = np.full((HEIGHT, WIDTH, 3), 0.9)
    _, away = seen.plane_points(0)
    depth = away[..., None].astype(np.float32)
    depth[:, :20] = 1.0  # something stands there
    found = draw_ground(white, depth, seen, 0.0, 0.4)
    changed = (found != white).any(axis=2)
    assert not changed[:, :20].any()
    points, _ = seen.plane_points(0)
    near_line = (np.abs(points[..., :2] / 0.4 - np.round(points[..., :2] / 0.4)) < 0.3).any(axis=2)
    assert changed[:, 20:].any()
    assert not changed[~near_line].any()
    red = found[..., 0] - found[..., 1]
    assert abs(points[np.unravel_index(red.argmax(), red.shape)][1]) < 0.05, "the x axis is red"
    # Where there is no surface at this height, it is seen as through glass, before what is farther.
    glass = draw_ground(white, np.full_like(depth, 3.0), seen, 0.0, 0.4)
    assert (glass != white).any(axis=2)[:, :20].any()


def test_labels_do_not_overlap_and_are_inside() -> None:
    ids = np.zeros((240, 320), np.int32)
    ids[100:] = 1
    for number in range(2, 14):
        left = 100 + 9 * (number - 2)
        ids[120:128, left : left + 8] = number
    overlay = Overlay(320, 240)
    overlay.add_labels(ids, {1: "floor", 2: "crate", 3: "crate", **{n: f"thing_{n}" for n in range(4, 14)}})
    boxes = [box for box, _ in overlay.texts]
    for a, b in combinations(boxes, 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
    assert all(box[0] >= 0 and box[1] >= 0 and box[2] <= 320 and box[3] <= 240 for box in boxes)
    names = [text for _, text in overlay.texts]
    assert len(names) == len(set(names)) == 12, "one for both parts of the crate"
    assert overlay.captions == []
    drawn = overlay.draw(np.ones((240, 320, 4), np.float32))
    assert drawn[int(boxes[0][1]) + 2, int(sum(boxes[0][::2]) / 2), 0] < 0.5


def test_labels_without_room_are_counted() -> None:
    overlay = Overlay(60, 40)
    ids = np.repeat(np.arange(1, 13, dtype=np.int32), 200).reshape(40, 60)
    overlay.add_labels(ids, {n: f"a_long_name_{n}" for n in range(1, 13)})
    assert overlay.captions == ["no room for 12 more labels"]


def test_axes_and_forces_are_drawn_where_they_are() -> None:
    seen = camera((-2, 0, 0), (0, 0, 0))
    overlay = Overlay(WIDTH, HEIGHT)
    overlay.add_axes(seen, [np.array([0, 0, 0, 1, 0, 0, 0.0]), np.array([-5, 0, 0, 1, 0, 0, 0.0])], 0.3)
    assert len(overlay.lines) == 3, "not of what is behind the camera"
    assert overlay.lines[1][1][0] < WIDTH / 2, "y to the left"
    assert overlay.lines[2][1][1] < HEIGHT / 2, "z up"
    overlay = Overlay(WIDTH, HEIGHT)
    points, forces = np.array([[0, 0, 0], [0, 0.1, 0]]), np.array([[0, 0, 12.5], [0, 0, 0]])
    overlay.add_contacts(seen, points, forces, 0.4)
    assert len(overlay.dots) == 2
    assert len(overlay.lines) == 3, "an arrow for the one that presses"
    assert overlay.lines[0][1] == pytest.approx(seen.project(np.array([[0, 0, 0.4]]))[0][0])
    assert overlay.captions == ["2 contacts, strongest 12.5 N"]


@pytest.mark.parametrize("count", [1, 2, 4, 16, 256])
def test_samples_are_spread_within_a_pixel_around_its_middle(count: int) -> None:
    shifts = np.array(sample_shifts(count))
    assert shifts.shape == (count, 2)
    assert np.allclose(shifts.mean(axis=0), 0)
    assert np.abs(shifts).max() < 0.75
    if count >= 16:
        assert (np.histogram2d(*shifts.T, bins=2)[0] > count / 8).all()


def test_a_depth_has_a_bar_of_round_metres() -> None:
    depth = np.linspace(0.6, 5.5, 4000, dtype=np.float32).reshape(80, 50, 1)
    depth[0, 0] = 0
    low, high = depth_range([depth])
    assert low == pytest.approx(0.6, abs=1e-2)
    assert 5 < high < 5.5
    colors = depth_colors(depth, low, high)
    assert colors[0, 0].tolist() == [0, 0, 0]
    assert (np.diff(colors[1:, 0].astype(int).sum(axis=1)) <= 0).mean() > 0.9, "darker farther away"
    found = add_depth_bar(np.full((200, 100, 3), 7, np.uint8), low, high)
    assert found.shape[0] == 200
    assert found.shape[1] > 140
    assert (found[:, :100] == 7).all(), "the picture is as it was"
    assert len(np.unique(found[:, 112], axis=0)) > 50
    assert depth_range([np.zeros((2, 2, 1), np.float32)]) == (0.5, 1.0)


def test_a_legend_has_names_beside_colours() -> None:
    picture = np.zeros((40, 30, 3), np.uint8)
    found = add_names(picture, [("#800000", "table"), ("#008000", "crate"), ("#808000", "bowl")])
    assert (found[:, :30] == 0).all()
    beside = found[:, 30:].reshape(-1, 3).tolist()
    for color in ([128, 0, 0], [0, 128, 0], [128, 128, 0]):
        assert color in beside
    assert found.shape[1] > 30 + 2 * 40, "two columns"
    assert add_names(picture, []).shape == picture.shape
