"""Environment, lights and cameras: what they are lowered to, and where they stand."""

from __future__ import annotations

import struct
from io import StringIO
from math import atan2, pi, radians, sqrt
from pathlib import Path
from shutil import copyfile
from typing import Any

import numpy as np
import pytest

from scenecc import compile_scene, validate
from scenecc.plan import (
    AreaLight,
    Camera,
    CubeMap,
    DirectionalLight,
    Intrinsic,
    Light,
    Mount,
    Orthographic,
    Perspective,
    PointLight,
    ScenePlan,
    SkyMap,
    SpotLight,
    TexturedLight,
    Value,
)
from scenecc.plan.rendering import shadow_parameters

PICTURE = Path(__file__).parents[2] / "scenes" / "good" / "assets" / "checker.png"
FACES = ("px", "nx", "py", "ny", "pz", "nz")


def environment_plan(folder: Path, environment: dict[str, Any], **top: Any) -> ScenePlan:
    # 4 × 2 pixels: a map of all directions is twice as wide as it is high.
    sky = struct.pack("<2sIHHIIiiHHIIiiII", b"BM", 78, 0, 0, 54, 40, 4, 2, 1, 24, 0, 24, 0, 0, 0, 0) + bytes(24)
    for name in ("a", "b"):
        (folder / f"{name}.bmp").write_bytes(sky)
    for name in FACES:
        copyfile(PICTURE, folder / f"{name}.png")
    return compile_scene({"scenecc": 1, "environment": environment, **top}, asset_roots=[folder])


def file(name: str) -> str:
    return f"asset://{name}.png" if name in FACES else f"asset://{name}.bmp"


def names(plan: ScenePlan, value: Value) -> list[str]:
    return [plan.files[index].path.stem for index in value.data.tolist()]


def test_nothing_is_said_of_what_is_left_out(tmp_path: Path) -> None:
    assert compile_scene({"scenecc": 1}).environment is None
    environment = environment_plan(tmp_path, {"map": file("a")}).environment
    assert environment is not None
    assert environment.ambient_light is None


def test_ambient_light_differs_from_scene_to_scene(tmp_path: Path) -> None:
    given = {"ambient_light": {"per_scene": [[0.1, 0.2, 0.3], "#ffffff"]}}
    environment = environment_plan(tmp_path, given, num_scenes=2).environment
    assert environment is not None
    assert environment.ambient_light is not None
    assert environment.ambient_light.data.tolist() == [[0.1, 0.2, 0.3], [1, 1, 1]]
    assert environment.map is None


def test_one_file_is_a_sky_and_may_differ(tmp_path: Path) -> None:
    plan = environment_plan(tmp_path, {"map": {"per_scene": [file("a"), file("b")]}}, num_scenes=2)
    assert plan.environment is not None
    assert isinstance(plan.environment.map, SkyMap)
    assert names(plan, plan.environment.map.file) == ["a", "b"]


def test_six_files_are_a_cube_and_each_may_differ(tmp_path: Path) -> None:
    faces: dict[str, Any] = {face: file(face) for face in FACES}
    faces["ny"] = {"per_scene": [file("px"), file("ny")]}
    plan = environment_plan(tmp_path, {"map": faces}, num_scenes=2)
    assert plan.environment is not None
    found = plan.environment.map
    assert isinstance(found, CubeMap)
    assert [names(plan, getattr(found, face)) for face in FACES] == [
        ["px"],
        ["nx"],
        ["py"],
        ["px", "ny"],
        ["pz"],
        ["nz"],
    ]


@pytest.mark.parametrize(
    ("text", "code", "line", "path"),
    [
        ("environment:\n  ambient_light: [1, 2]\n", "SC106", 3, "environment.ambient_light"),
        ("environment:\n  ambient_light: [1, 2, -1]\n", "SC104", 3, "environment.ambient_light[2]"),
        ("environment:\n  map: sky.png\n", "SC401", 3, "environment.map"),
        ("environment:\n  map: {px: a.png}\n", "SC102", 3, "environment.map"),
        (
            "num_scenes: 2\nenvironment:\n  map:\n    choice: [a.png, {px: a, nx: a, py: a, ny: a, pz: a, nz: a}]\n",
            "SC321",
            5,
            "environment.map",
        ),
    ],
)
def test_a_mistake_in_the_environment_is_told_at_its_line(text: str, code: str, line: int, path: str) -> None:
    found = [(one.code, one.line, one.path) for one in validate(StringIO("scenecc: 1\n" + text))]
    assert (code, line, path) in found, found


BALL = [{"type": "sphere", "radius": 0.1}]
HALF = sqrt(0.5)
WHITE = {"color": [1, 1, 1]}


def light_plan(light: dict[str, Any], **top: Any) -> ScenePlan:
    document = {"scenecc": 1, "entities": {"ball": {"pose": [1, 2, 3], "shapes": BALL}}, "lights": {"lamp": light}}
    return compile_scene({**document, **top}, allow_outside_assets=True)


def light_of(light: dict[str, Any], **top: Any) -> Light:
    (found,) = light_plan(light, **top).lights
    return found


def rows(value: Value | None) -> list[Any]:
    assert value is not None
    return value.data.tolist()


def wrong_lights(text: str) -> list[tuple[str, int | None, str]]:
    """Code, line and path of what is wrong with a file whose fourth line is the first of a light."""
    head = "scenecc: 1\nentities: {ball: {scene_idxs: [0], shapes: [{type: sphere, radius: 0.1}]}}\nlights:\n"
    return [(found.code, found.line, found.path) for found in validate(StringIO(head + text))]


def test_a_point_stands_where_it_is_said() -> None:
    lamp = light_of({"type": "point", "position": [1, 2, 3], "color": [3, 2.5, 0]})
    assert (lamp.name, lamp.scene_idxs, lamp.mount, lamp.shadow) == ("lamp", (0,), None, None)
    assert isinstance(lamp.light, PointLight)
    assert rows(lamp.pose) == [[1, 2, 3, 1, 0, 0, 0]]
    assert rows(lamp.color) == [[3, 2.5, 0]]


@pytest.mark.parametrize(
    ("direction", "q"),
    [
        ([2, 0, 0], [1, 0, 0, 0]),
        ([0, 3, 0], [HALF, 0, 0, HALF]),
        ([0, 0, -1], [HALF, 0, HALF, 0]),
        ([0, 0, 1], [HALF, 0, -HALF, 0]),
        # (0, 1, 1) / √2 is a quarter of a turn from +x, about (0, -1, 1) / √2.
        ([0, 5, 5], [HALF, 0, -0.5, 0.5]),
    ],
    ids=str,
)
def test_x_turns_to_the_direction_by_the_shortest_way(direction: list[float], q: list[float]) -> None:
    lamp = light_of({"type": "directional", "direction": direction, **WHITE})
    assert isinstance(lamp.light, DirectionalLight)
    (pose,) = rows(lamp.pose)
    assert pose[:3] == [0, 0, 0]
    assert np.abs(np.subtract(pose[3:], q)).max() <= 1e-15


def test_a_direction_may_differ_from_scene_to_scene() -> None:
    direction = {"per_scene": [[1, 0, 0], [0, 1, 0]]}
    color = {"per_scene": [[1, 0, 0], "#ffffff"]}
    light = {"type": "directional", "direction": direction, "color": color, "scene_idxs": [0, 2]}
    lamp = light_of(light, num_scenes=3)
    assert lamp.scene_idxs == (0, 2)
    assert np.abs(np.subtract(rows(lamp.pose), [[0, 0, 0, 1, 0, 0, 0], [0, 0, 0, HALF, 0, 0, HALF]])).max() <= 1e-15
    assert rows(lamp.color) == [[1, 0, 0], [1, 1, 1]]


def test_digits_of_a_colour_are_srgb() -> None:
    color = light_of({"type": "point", "position": [0, 0, 1], "color": "#ff8033"}).color
    assert rows(color) == [pytest.approx([1, 0.21586050, 0.033104767])]


def test_cones_are_in_radians_or_degrees() -> None:
    cone = {"position": [0, 0, 1], "direction": [1, 0, 0], "inner_fov": 0.4, "outer_fov_deg": 90, **WHITE}
    lamp = light_of({"type": "spot", **cone})
    assert isinstance(lamp.light, SpotLight)
    assert (rows(lamp.light.inner_fov), rows(lamp.light.outer_fov)) == ([0.4], [pi / 2])
    plan = light_plan({"type": "textured", "texture": str(PICTURE), **cone})
    film = plan.lights[0].light
    assert isinstance(film, TexturedLight)
    assert (rows(film.inner_fov), rows(film.outer_fov)) == ([0.4], [pi / 2])
    assert plan.files[rows(film.texture.file)[0]].path == PICTURE


def test_an_area_has_edges() -> None:
    lamp = light_of({"type": "area", "pose": [0, 0, 2], "half_width": 0.5, "half_height": 0.25, **WHITE})
    assert isinstance(lamp.light, AreaLight)
    assert (rows(lamp.light.half_width), rows(lamp.light.half_height)) == ([0.5], [0.25])
    assert shadow_parameters(lamp) == {}


SHADOW = {"shadow": True, "shadow_near": 0.5, "shadow_far": 4, "shadow_map_size": 256}


@pytest.mark.parametrize(
    ("light", "numbers"),
    [
        ({"type": "point", "position": [0, 0, 1]}, [0, 0.1, 10, 2048]),
        ({"type": "point", "position": [0, 0, 1], "shadow": True}, [1, 0.1, 10, 2048]),
        ({"type": "point", "position": [0, 0, 1], **SHADOW}, [1, 0.5, 4, 256]),
        ({"type": "directional", "direction": [1, 0, 0]}, [0, -10, 10, 10, 2048]),
        ({"type": "directional", "direction": [1, 0, 0], "shadow": True}, [1, -10, 10, 10, 2048]),
        ({"type": "directional", "direction": [1, 0, 0], **SHADOW, "shadow_scale": 3}, [1, 0.5, 4, 3, 256]),
    ],
)
def test_shadows_are_those_of_sapien_unless_said(light: dict[str, Any], numbers: list[float]) -> None:
    assert [rows(value) for value in shadow_parameters(light_of({**light, **WHITE})).values()] == [
        [one] for one in numbers
    ]


def test_a_shadow_may_differ_from_scene_to_scene() -> None:
    light = {"type": "point", "position": [0, 0, 1], "shadow": {"per_scene": [True, False]}, **WHITE}
    lamp = light_of({**light, "shadow_far": {"per_scene": [3, 4]}}, num_scenes=2)
    assert lamp.shadow is not None
    assert (rows(lamp.shadow.on), rows(lamp.shadow.far)) == ([True, False], [3, 4])


def test_a_light_is_mounted_or_stands_beside() -> None:
    lamp = light_of({"type": "spot", "mount": "ball", "direction": [0, 1, 0], "inner_fov": 1, "outer_fov": 1, **WHITE})
    assert lamp.mount == Mount("ball")
    assert rows(lamp.pose)[0][:3] == [0, 0, 0]
    lamp = light_of({"type": "point", "pose": {"p": [0, 0, 1], "relative_to": "ball"}, **WHITE})
    assert rows(lamp.pose) == [[1, 2, 4, 1, 0, 0, 0]]
    assert lamp.mount is None


SPOT = "type: spot, color: [1, 1, 1], position: [0, 0, 1], direction: [1, 0, 0]"


@pytest.mark.parametrize(
    ("text", "code", "line", "path"),
    [
        ("  lamp: {type: point, color: [1, 1, 1]}\n", "SC102", 4, "lights.lamp"),
        ("  lamp: {type: directional, color: [1, 1, 1], position: [0, 0, 1]}\n", "SC102", 4, "lights.lamp"),
        ("  lamp: {type: area, color: [1, 1, 1], half_width: 1, half_height: 1}\n", "SC102", 4, "lights.lamp"),
        (f"  lamp: {{{SPOT}, inner_fov: 1}}\n", "SC102", 4, "lights.lamp"),
        (
            f"  lamp:\n    {{{SPOT}, inner_fov: 1, outer_fov: 1,\n    outer_fov_deg: 9}}\n",
            "SC111",
            6,
            "lights.lamp.outer_fov_deg",
        ),
        (
            "  lamp:\n    type: point\n    color: [1, 1, 1]\n    pose: [0, 0, 1]\n    position: [0, 0, 1]\n",
            "SC111",
            8,
            "lights.lamp.position",
        ),
        (
            "  lamp:\n    {type: point, color: [1, 1, 1], position: [0, 0, 1],\n    shadow_far: 3}\n",
            "SC115",
            6,
            "lights.lamp.shadow_far",
        ),
        (
            "  lamp:\n    {type: directional, color: [1, 1, 1],\n    direction: [0, 0, 0]}\n",
            "SC114",
            6,
            "lights.lamp.direction",
        ),
        ("  lamp: {type: point, color: [1, 1, 1],\n    mount: bal}\n", "SC330", 5, "lights.lamp.mount"),
        ("  lamp: {type: point, color: [1, 1, 1],\n    mount: ball/hand}\n", "SC331", 5, "lights.lamp.mount"),
        (
            "  lamp:\n    {type: point, color: [1, 1, 1], mount: ball,\n    pose: {relative_to: ball}}\n",
            "SC115",
            6,
            "lights.lamp.pose.relative_to",
        ),
        ("  lamp: {type: point, position: [0, 0, 1], color: [-1, 0, 0]}\n", "SC104", 4, "lights.lamp.color[0]"),
        ("  lamp: {type: area, color: [1, 1, 1], pose: [0, 0, 1], half_width: 1}\n", "SC102", 4, "lights.lamp"),
        ("  lamp: {type: lantern, color: [1, 1, 1]}\n", "SC105", 4, "lights.lamp.type"),
    ],
)
def test_a_mistake_in_a_light_is_told_at_its_line(text: str, code: str, line: int, path: str) -> None:
    assert (code, line, path) in wrong_lights(text)


def test_what_a_light_is_mounted_on_is_in_its_scenes() -> None:
    assert wrong_lights("  lamp: {type: point, color: [1, 1, 1], mount: ball}\nnum_scenes: 2\n") == [
        ("SC311", 4, "lights.lamp.mount")
    ]


def camera_plan(camera: dict[str, Any], **top: Any) -> ScenePlan:
    return compile_scene(
        {"scenecc": 1, "entities": {"ball": {"pose": [1, 2, 3], "shapes": BALL}}, "cameras": {"eye": camera}, **top}
    )


def camera_of(camera: dict[str, Any], **top: Any) -> Camera:
    (found,) = camera_plan(camera, **top).cameras
    return found


def aimed(pose: dict[str, Any]) -> list[float]:
    (row,) = rows(camera_of({"pose": pose}).pose)
    return row[3:]


def wrong_cameras(text: str) -> list[tuple[str, int | None, str]]:
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
    found = camera_plan(camera).cameras
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
def test_a_mistake_in_a_camera_is_told_at_its_line(text: str, code: str, line: int, path: str) -> None:
    assert (code, line, path) in wrong_cameras(text)


def test_what_a_camera_is_mounted_on_is_in_its_scenes() -> None:
    (found,) = wrong_cameras("  eye: {mount: ball}\nnum_scenes: 2\n")
    assert found == ("SC311", 4, "cameras.eye.mount")
