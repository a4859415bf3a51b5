"""Cameras in the plan: defaults, lenses and aims by hand arithmetic, what differs between scenes, and what is wrong."""

from __future__ import annotations

from io import StringIO
from math import atan2, pi, radians, sqrt
from typing import Any

import numpy as np
import pytest

from scenecc import compile_scene, validate
from scenecc.plan import Camera, Intrinsic, Mount, Orthographic, Perspective, ScenePlan, Value

BALL = [{"type": "sphere", "radius": 0.1}]
HALF = sqrt(0.5)


def plan_of(camera: dict[str, Any], **top: Any) -> ScenePlan:
    return compile_scene(
        {"scenecc": 1, "entities": {"ball": {"pose": [1, 2, 3], "shapes": BALL}}, "cameras": {"eye": camera}, **top}
    )


def camera_of(camera: dict[str, Any], **top: Any) -> Camera:
    (found,) = plan_of(camera, **top).cameras
    return found


def rows(value: Value | None) -> list[Any]:
    assert value is not None
    return value.data.tolist()


def aimed(pose: dict[str, Any]) -> list[float]:
    (row,) = rows(camera_of({"pose": pose}).pose)
    return row[3:]


def wrong(text: str) -> list[tuple[str, int | None, str]]:
    """Code, line and path of what is wrong with a file whose third line is `cameras:`."""
    head = "scenecc: 1\nentities: {ball: {scene_idxs: [0], shapes: [{type: sphere, radius: 0.1}]}}\ncameras:\n"
    return [(found.code, found.line, found.path) for found in validate(StringIO(head + text))]


def test_what_is_left_out_is_what_the_language_says() -> None:
    eye = camera_of({})
    assert (eye.name, eye.scene_idxs, eye.width, eye.height) == ("eye", (0,), 640, 480)
    assert isinstance(eye.lens, Perspective)
    assert eye.lens.fovx is None
    assert rows(eye.lens.fovy) == [pi / 3]
    assert (rows(eye.near), rows(eye.far)) == ([0.01], [100.0])
    assert rows(eye.pose) == [[0, 0, 0, 1, 0, 0, 0]]
    assert (eye.mount, eye.shader) == (None, None)


def test_a_lens_is_an_angle_a_matrix_or_an_edge() -> None:
    for key, angle in (("fovy", 0.7), ("fovy_deg", 90), ("fovx", 0.7), ("fovx_deg", 90)):
        lens = camera_of({key: angle}).lens
        assert isinstance(lens, Perspective)
        given, other = (lens.fovx, lens.fovy) if key.startswith("fovx") else (lens.fovy, lens.fovx)
        assert rows(given) == [0.7 if angle == 0.7 else pi / 2]
        assert other is None
    lens = camera_of({"orthographic": {"top": 0.6}}).lens
    assert isinstance(lens, Orthographic)
    assert rows(lens.top) == [0.6]


def test_the_middle_of_the_picture_is_that_of_a_matrix_without_one() -> None:
    lens = camera_of({"width": 64, "height": 49, "intrinsic": {"fx": 50, "fy": 60}}).lens
    assert isinstance(lens, Intrinsic)
    assert [rows(each) for each in (lens.fx, lens.fy, lens.cx, lens.cy, lens.skew)] == [[50], [60], [32], [24.5], [0]]
    lens = camera_of({"intrinsic": {"fx": 50, "fy": 60, "cx": 1, "cy": 2, "skew": 3}}).lens
    assert isinstance(lens, Intrinsic)
    assert [rows(each) for each in (lens.cx, lens.cy, lens.skew)] == [[1], [2], [3]]


@pytest.mark.parametrize(
    ("target", "q"),
    [
        ([5, 0, 0], [1, 0, 0, 0]),
        ([0, 2, 0], [HALF, 0, 0, HALF]),
        ([0, -2, 0], [HALF, 0, 0, -HALF]),
        # To look down, +x is turned about +y; to look back, about +z.
        ([1, 0, -1], [np.cos(pi / 8), 0, np.sin(pi / 8), 0]),
        ([-3, 0, 0], [0, 0, 0, 1]),
    ],
    ids=str,
)
def test_a_camera_is_aimed_along_x_with_z_up(target: list[float], q: list[float]) -> None:
    found = np.array(aimed({"look_at": target}))
    assert min(np.abs(found - q).max(), np.abs(found + q).max()) <= 1e-15


def test_where_it_looks_is_told_from_where_it_stands() -> None:
    """From (1, 1, 3) to (4, 5, 3 - 5): a turn of atan2(4, 3) to the left, then 45 degrees down."""
    yaw, pitch = atan2(4, 3) / 2, pi / 8
    found = np.array(aimed({"p": [1, 1, 3], "look_at": [4, 5, -2]}))
    q = [
        np.cos(yaw) * np.cos(pitch),
        -np.sin(yaw) * np.sin(pitch),
        np.cos(yaw) * np.sin(pitch),
        np.sin(yaw) * np.cos(pitch),
    ]
    assert np.abs(found - q).max() <= 1e-15


def test_values_differ_from_scene_to_scene() -> None:
    camera = {
        "scene_idxs": [0, 2],
        "pose": [{"per_scene": [1, 2]}, 0, 0],
        "fovy_deg": {"per_scene": [60, 90]},
        "near": {"per_scene": [0.1, 0.2]},
        "far": 5,
    }
    eye = camera_of(camera, num_scenes=3)
    assert eye.scene_idxs == (0, 2)
    assert rows(eye.pose) == [[1, 0, 0, 1, 0, 0, 0], [2, 0, 0, 1, 0, 0, 0]]
    assert isinstance(eye.lens, Perspective)
    assert rows(eye.lens.fovy) == [radians(60), radians(90)]
    assert (rows(eye.near), rows(eye.far)) == ([0.1, 0.2], [5])
    matrix = {"fx": {"per_scene": [40, 50, 60]}, "fy": 30, "cx": {"per_scene": [1, 2, 3]}}
    lens = camera_of({"intrinsic": matrix}, num_scenes=3).lens
    assert isinstance(lens, Intrinsic)
    assert (rows(lens.fx), rows(lens.cx)) == ([40, 50, 60], [1, 2, 3])


def test_a_camera_stands_beside_a_body_or_is_mounted_on_it() -> None:
    assert rows(camera_of({"pose": {"p": [-1, 0, 0], "relative_to": "ball"}}).pose) == [[0, 2, 3, 1, 0, 0, 0]]
    eye = camera_of({"pose": {"p": [-1, 0, 0]}, "mount": "ball"})
    assert eye.mount == Mount("ball")
    assert rows(eye.pose) == [[-1, 0, 0, 1, 0, 0, 0]]


def test_cameras_are_repeated() -> None:
    camera = {"repeat": {"i": {"count": 3}}, "name": "eye${i}", "pose": ["${i}", 0, 0]}
    found = plan_of(camera).cameras
    assert [(each.name, each.pose.data[0, 0]) for each in found] == [("eye0", 0), ("eye1", 1), ("eye2", 2)]


@pytest.mark.parametrize(
    ("text", "code", "line", "path"),
    [
        ("  eye:\n    fovy: 1\n    fovx: 1\n", "SC111", 6, "cameras.eye.fovx"),
        ("  eye:\n    fovy: 1\n    orthographic: {top: 1}\n", "SC111", 6, "cameras.eye.orthographic"),
        ("  eye:\n    fovx: 1\n    fovx_deg: 1\n", "SC111", 6, "cameras.eye.fovx_deg"),
        ("  eye:\n    mount: bal\n", "SC330", 5, "cameras.eye.mount"),
        ("  eye:\n    mount: ball/hand\n", "SC331", 5, "cameras.eye.mount"),
        ("  eye:\n    mount: ball\n    pose: {relative_to: ball}\n", "SC115", 6, "cameras.eye.pose.relative_to"),
        ("  eye:\n    near: 0\n", "SC104", 5, "cameras.eye.near"),
        ("  eye:\n    fovy_deg: 180\n", "SC104", 5, "cameras.eye.fovy_deg"),
        ("  eye:\n    shader: raytraced\n", "SC105", 5, "cameras.eye.shader"),
        ("  ball:\n    width: 8\n", "SC305", 4, "cameras.ball"),
    ],
)
def test_a_mistake_is_told_at_its_line(text: str, code: str, line: int, path: str) -> None:
    assert (code, line, path) in wrong(text)


def test_what_it_is_mounted_on_is_in_its_scenes() -> None:
    (found,) = wrong("  eye: {mount: ball}\nnum_scenes: 2\n")
    assert found == ("SC311", 4, "cameras.eye.mount")
