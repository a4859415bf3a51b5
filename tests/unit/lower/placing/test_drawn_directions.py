"""A direction of length 0 is none; a deviation from a direction, and the end of a range of them, may be 0."""

from __future__ import annotations

from typing import Any

import pytest

from scenecc import SceneError, compile_scene, validate

FORMS = [
    {"normal": [[1, 0, 0], 0]},
    {"normal": [[1, 0, 0], [0, 0, 0]]},
    {"normal": [[1, 0, 0], 0.1], "clip": [[0, 0, 0], [1, 1, 1]]},
    {"uniform": [[0, 0, 0], [1, 1, 1]]},
]


def scenes(direction: Any) -> list[dict[str, Any]]:
    light = {"type": "directional", "color": [1, 1, 1], "direction": direction}
    shape = {"type": "sphere", "radius": 1}
    turned = {"pose": {"axis_angle": {"axis": direction, "angle": 1}}, "shapes": [shape]}
    joint = {"type": "continuous", "axis": direction}
    arm = {"root": {"name": "base", "shapes": [shape], "children": [{"name": "l", "joint": joint, "shapes": [shape]}]}}
    return [
        {"scenecc": 1, "lights": {"sun": light}},
        {"scenecc": 1, "entities": {"ball": turned}},
        {"scenecc": 1, "entities": {"arm": arm}},
    ]


@pytest.mark.parametrize("form", FORMS, ids=str)
def test_bounds_may_be_zero(form: dict[str, Any]) -> None:
    for scene in scenes(form):
        assert validate(scene) == []
        compile_scene(scene)


def test_a_range_of_nothing_but_zero_is_none() -> None:
    for scene in scenes({"uniform": [[0, 0, 0], [0, 0, 0]]}):
        with pytest.raises(SceneError, match="length 0"):
            compile_scene(scene)
