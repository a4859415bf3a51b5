"""Forms whose parts are of odd kinds and sizes."""

from __future__ import annotations

from typing import Any

import pytest

from scenecc import validate

HUGE = 10**30
BALL: dict[str, Any] = {"type": "sphere", "radius": 1}


def found(document: dict[str, Any]) -> list[tuple[str, str]]:
    return [(diagnostic.code, diagnostic.path) for diagnostic in validate({"scenecc": 1, **document})]


@pytest.mark.parametrize(
    ("pick", "path"),
    [
        (HUGE, ""),
        ({"cycle": [0, HUGE]}, ".cycle[1]"),
        ({"integers": [0, HUGE]}, ".integers[1]"),
        ({"per_scene": {0: 0, "default": HUGE}}, ".per_scene.default"),
    ],
    ids=str,
)
def test_an_index_of_more_than_64_bits(pick: Any, path: str) -> None:
    assert found({"entities": {"a": {"pick": pick, "variants": [{"shapes": [BALL]}]}}}) == [
        ("SC104", f"entities.a.pick{path}")
    ]


@pytest.mark.parametrize("scene", ["1" * 30, "9" * 5000, "01", "-1", "١"])
def test_what_is_no_scene_of_a_map(scene: str) -> None:
    entity = {"shapes": [BALL], "mass": {"per_scene": {scene: 1, "default": 2}}}
    assert [code for code, _ in found({"entities": {"a": entity}})] == ["SC117"]


@pytest.mark.parametrize(
    ("draw", "expected"),
    [
        ({"uniform": [[1, 2], [1, 2, 3]]}, ("SC106", "draws.u.uniform")),
        ({"uniform": [["${scene}", 2], [1, 2, 3]]}, ("SC106", "draws.u.uniform")),
        ({"normal": [[1, 2], [1, 2, 3]]}, ("SC106", "draws.u.normal")),
        ({"normal": [[1, 2], 1], "clip": [[0], [1]]}, ("SC106", "draws.u.normal")),
        ({"integers": [0, HUGE]}, ("SC104", "draws.u.integers[1]")),
    ],
    ids=str,
)
def test_bounds_that_cannot_be_drawn_between(draw: Any, expected: tuple[str, str]) -> None:
    assert found({"draws": {"u": draw}}) == [expected]


@pytest.mark.parametrize("axis", [{"type": "number"}, {"count": 2, "repeat": 1}, {"choice": [1, "a"]}, {}, 3])
def test_a_repeat_that_is_no_list(axis: Any) -> None:
    shape = {**BALL, "repeat": {"n": axis}}
    assert {code for code, _ in found({"entities": {"a": {"shapes": [shape]}}})} <= {"SC101", "SC102", "SC103", "SC116"}
    entity = {"shapes": [BALL], "repeat": {"n": axis}}
    assert {code for code, _ in found({"entities": {"a": entity}})} <= {"SC101", "SC102", "SC103", "SC116"}
