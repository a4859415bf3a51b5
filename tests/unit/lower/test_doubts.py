"""What is told of expressions before anything is drawn: what cannot be is an error, what may be is a warning."""

from __future__ import annotations

from typing import Any

import pytest
from unit.lower.scenes import BALL, codes, scene

from scenecc import compile_scene, validate

DRAWS: dict[str, Any] = {
    "r": {"uniform": [0.1, 0.2]},
    "z": {"uniform": [-1, 1]},
    "n": {"normal": [0, 1]},
    "v": {"uniform": [[0.1, 0.1], [0.2, 0.2]]},
    "die": {"integers": [1, 6]},
    "which": {"choice": ["a", "b"]},
}


def told(body: dict[str, Any], num_scenes: int = 8) -> list[tuple[str, str]]:
    """Codes and messages of what validation says of a body, which reads some of the draws."""
    names = {name: draw for name, draw in DRAWS.items() if name in str(body)}
    found = validate(scene(body, draws=names, num_scenes=num_scenes))
    return [(one.code, one.message) for one in found if one.code != "SC319"]


def box(half_size: Any) -> dict[str, Any]:
    return {"shapes": [{"type": "box", "half_size": half_size}]}


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (box("${r}"), "it gives a number where 3 numbers are wanted"),
        (box("${[r, r]}"), "it gives a list that is not 3 numbers"),
        (box("${v}"), "it gives a list that is not 3 numbers"),
        (box("${which}"), "it gives a string where 3 numbers are wanted"),
        (box(["${v}", 1, 1]), "it gives a list where one value is wanted"),
        (box("${[die, die, die] if die > 1 else die}"), "it gives a number where 3 numbers are wanted"),
        ({"pose": {"p": "${scene}"}}, "in scene 0: it gives a number where 3 numbers are wanted"),
        ({"mass": "${which}"}, "this expression gives 'a', and a number is wanted"),
        ({"mass": "${r > 0.15}"}, "this expression gives false, and a number is wanted"),
        ({"gravity": "${die + 1}"}, "it gives 2, which means nothing here"),
        (
            {"color": "${'#ff0000' if which == 'a' else 'reddish'}"},
            "it gives 'reddish', which means nothing here",
        ),
        (
            {"color": {"choice": ["#ffffff", "${'red' if r > 1 else 'rot'}"]}},
            "it gives 'rot', which means nothing here",
        ),
    ],
    ids=str,
)
def test_a_value_of_another_kind_is_an_error(body: dict[str, Any], message: str) -> None:
    assert told(body) == [("SC515", message)]


def test_a_value_that_may_be_of_another_kind_is_a_warning() -> None:
    body = {"color": "${'#ff0000' if r > 0.15 else 'reddish'}"}
    assert told(body) == [("SC514", "in some scene it gives 'reddish', which means nothing here")]
    assert told(box("${[r, r, r] if n > 0 else r}")) == []


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ({"mass": "${r - 0.5}"}, "this expression gives at most -0.3, and it must be above 0"),
        ({"mass": "${-die}"}, "this expression gives at most -1, and it must be above 0"),
        ({"mass": "${die * 0}"}, "this expression gives 0, and it must be above 0"),
        (box("${[r, r, -r]}"), "this expression gives at most -0.1, and it must be above 0"),
        (
            {"material": {"physical": {"restitution": "${1 + r}"}}},
            "this expression gives at least 1.1, and it must be at most 1",
        ),
        ({"mass": "${2 - scene}"}, "in scene 2 this is 0: it must be above 0"),
        ({"mass": "${1 if scene < 7 else -1}"}, "in scene 7 this is -1: it must be above 0"),
    ],
    ids=str,
)
def test_numbers_that_are_all_out_of_range_are_an_error(body: dict[str, Any], message: str) -> None:
    assert told(body) == [("SC513", message)]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ({"mass": "${1 / z}"}, [("SC516", "this may have no value: division by zero")]),
        ({"pose": ["${1 / z}", 0, 0]}, [("SC516", "this may have no value: division by zero")]),
        ({"mass": "${1 / (die - 3) + 9}"}, [("SC516", "this may have no value: division by zero")]),
        ({"mass": "${1 + sqrt(z)}"}, [("SC516", "this may have no value: a negative number has no root")]),
        (
            {"mass": "${[1, 2][die - 1]}"},
            [("SC516", "this may have no value: index 2 is out of range: the list has 2 items")],
        ),
        (
            {"mass": "${sqrt(r - 1)}"},
            [("SC202", "this has no value, whatever is drawn: a negative number has no root")],
        ),
        ({"mass": "${1 / (scene - 3) + 9}"}, [("SC202", "in scene 3: division by zero")]),
        ({"pose": ["${sqrt(5 - scene)}", 0, 0]}, [("SC202", "in scene 6: `sqrt` has no value for -1")]),
        ({"mass": "${1 / (scene - 8) + 9}"}, []),
        ({"mass": "${1 / z + 9 if z > 0.5 else 1}"}, []),
        ({"mass": "${z + 0.1 if z > 0 else 0.1}"}, []),
        ({"mass": "${0.1 + z * z}"}, []),
        ({"mass": "${1 + scene % 2}"}, []),
    ],
    ids=str,
)
def test_what_may_have_no_value(body: dict[str, Any], expected: list[tuple[str, str]]) -> None:
    assert told(body) == expected


def test_a_draw_that_may_have_no_value_is_told_where_it_stands() -> None:
    draws = {"z": {"uniform": [-1, 1]}, "root": "${sqrt(z)}", "twice": "${2 * root}"}
    assert codes(scene({"mass": "${1 + twice}"}, draws=draws)) == [("SC516", "draws.root")]


def test_a_draw_that_its_scene_decides_is_told_where_it_is_read() -> None:
    draws = {"inverse": "${1 / scene}", "twice": "${2 * inverse}"}
    document = scene({"pose": ["${twice}", 0, 0]}, draws=draws, num_scenes=4)
    assert codes(document) == [("SC202", "draws.inverse")]
    document["entities"]["body"]["scene_idxs"] = [1, 2, 3]
    assert codes(document) == []
    assert compile_scene(document).num_scenes == 4


def test_variants_are_picked_by_the_scene() -> None:
    variants: list[Any] = [{"shapes": BALL}, {"shapes": BALL, "mass": 2}]
    document = {"scenecc": 1, "num_scenes": 200, "entities": {"e": {"pick": "${scene % 2}", "variants": variants}}}
    assert codes(document) == []
    document["entities"] = {"e": {"pick": "${scene}", "variants": variants}}
    assert codes(document) == [("SC513", "entities.e.pick")]


def test_one_expression_in_many_places_is_looked_into_once() -> None:
    document = scene({"mass": "${1 / z + 9}"}, draws={"z": DRAWS["z"]}, num_scenes=4)
    document["entities"] |= {f"e{i}": document["entities"]["body"] for i in range(50)}
    assert {code for code, _ in codes(document)} == {"SC516"}
    assert len(codes(document)) == 51
