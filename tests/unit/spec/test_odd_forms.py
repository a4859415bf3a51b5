"""Forms whose parts are of odd kinds and sizes."""

from __future__ import annotations

from typing import Any

import pytest

from scenecc import compile_scene, plan_text, validate

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


@pytest.mark.parametrize("form", ["uniform", "integers", "log_uniform", "normal"])
@pytest.mark.parametrize("place", [0, 1])
def test_a_text_is_no_bound_of_a_draw(form: str, place: int) -> None:
    bounds: list[Any] = [1, 1]
    bounds[place] = "abc"
    assert ("SC103", f"draws.u.{form}[{place}]") in found({"draws": {"u": {form: bounds}}})
    clip = {"normal": [0, 1], "clip": bounds}
    assert ("SC103", f"draws.u.clip[{place}]") in found({"draws": {"u": clip}})


@pytest.mark.parametrize(
    ("color", "expected"),
    [
        ({"integers": ["#457b9d", "#457b9d"]}, ["SC104"] * 6),
        ({"integers": ["#ff0000", "#ffffff"]}, []),
        ({"uniform": ["#ffffff", "#000000"]}, ["SC119"]),
        ({"uniform": ["#000000", "#ffffff80"]}, ["SC119"]),
        ({"uniform": ["#00000080", "#ffffff"]}, []),
        ({"log_uniform": ["#000000", "#ffffff"]}, ["SC104"]),
        ({"uniform": ["#000000", [1, 1, 1]]}, []),
    ],
    ids=str,
)
def test_colours_are_bounds_as_their_numbers_are(color: Any, expected: list[str]) -> None:
    document = {"entities": {"a": {"color": color, "shapes": [BALL]}}}
    assert [code for code, _ in found(document)] == expected
    if not expected:
        assert plan_text(compile_scene({"scenecc": 1, **document}))


@pytest.mark.parametrize(
    ("axis", "expected"),
    [({"uniform": ["x", "y"]}, ["SC119"]), ({"log_uniform": ["x", "x"]}, ["SC104"] * 2), ({"uniform": ["x", "x"]}, [])],
    ids=str,
)
def test_axes_are_bounds_as_their_numbers_are(axis: Any, expected: list[str]) -> None:
    pose = {"axis_angle": {"axis": axis, "angle": 1}}
    assert [code for code, _ in found({"entities": {"a": {"pose": pose, "shapes": [BALL]}}})] == expected


def test_integers_are_among_fewer_than_a_float_can_tell_apart() -> None:
    assert found({"draws": {"u": {"integers": [-(2**53), 2**53]}}}) == [("SC104", "draws.u.integers")]
