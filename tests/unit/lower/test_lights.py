"""Lights in the plan: defaults and directions by hand arithmetic, what differs between scenes, and what is wrong."""

from __future__ import annotations

from io import StringIO
from math import pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenecc import compile_scene, validate
from scenecc.plan import (
    AreaLight,
    DirectionalLight,
    Light,
    Mount,
    PointLight,
    ScenePlan,
    SpotLight,
    TexturedLight,
    Value,
)
from scenecc.plan.shadows import shadow_numbers

BALL = [{"type": "sphere", "radius": 0.1}]
PICTURE = Path(__file__).parents[2] / "scenes" / "good" / "assets" / "checker.png"
HALF = sqrt(0.5)
WHITE = {"color": [1, 1, 1]}


def plan_of(light: dict[str, Any], **top: Any) -> ScenePlan:
    document = {"scenecc": 1, "entities": {"ball": {"pose": [1, 2, 3], "shapes": BALL}}, "lights": {"lamp": light}}
    return compile_scene({**document, **top}, allow_outside_assets=True)


def light_of(light: dict[str, Any], **top: Any) -> Light:
    (found,) = plan_of(light, **top).lights
    return found


def rows(value: Value | None) -> list[Any]:
    assert value is not None
    return value.data.tolist()


def wrong(text: str) -> list[tuple[str, int | None, str]]:
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


def test_digits_of_a_colour_are_divided_by_255() -> None:
    assert rows(light_of({"type": "point", "position": [0, 0, 1], "color": "#ff8033"}).color) == [[1, 128 / 255, 0.2]]


def test_cones_are_in_radians_or_degrees() -> None:
    cone = {"position": [0, 0, 1], "direction": [1, 0, 0], "inner_fov": 0.4, "outer_fov_deg": 90, **WHITE}
    lamp = light_of({"type": "spot", **cone})
    assert isinstance(lamp.light, SpotLight)
    assert (rows(lamp.light.inner_fov), rows(lamp.light.outer_fov)) == ([0.4], [pi / 2])
    plan = plan_of({"type": "textured", "texture": str(PICTURE), **cone})
    film = plan.lights[0].light
    assert isinstance(film, TexturedLight)
    assert (rows(film.inner_fov), rows(film.outer_fov)) == ([0.4], [pi / 2])
    assert plan.files[rows(film.texture.file)[0]].path == PICTURE


def test_an_area_has_edges() -> None:
    lamp = light_of({"type": "area", "pose": [0, 0, 2], "half_width": 0.5, "half_height": 0.25, **WHITE})
    assert isinstance(lamp.light, AreaLight)
    assert (rows(lamp.light.half_width), rows(lamp.light.half_height)) == ([0.5], [0.25])
    assert shadow_numbers(lamp) == {}


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
    assert [rows(value) for value in shadow_numbers(light_of({**light, **WHITE})).values()] == [
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
def test_a_mistake_is_told_at_its_line(text: str, code: str, line: int, path: str) -> None:
    assert (code, line, path) in wrong(text)


def test_what_it_is_mounted_on_is_in_its_scenes() -> None:
    assert wrong("  lamp: {type: point, color: [1, 1, 1], mount: ball}\nnum_scenes: 2\n") == [
        ("SC311", 4, "lights.lamp.mount")
    ]
