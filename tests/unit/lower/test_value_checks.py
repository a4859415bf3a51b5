"""Checks of varying values: errors in the rows of this seed, and warnings about the samples of others."""

from __future__ import annotations

import re
import time
from typing import TYPE_CHECKING, Any

import pytest
from plugins.nightly import assert_took
from plugins.structures import body_of
from unit.lower.scenes import BALL, codes, entity, scene

from scenecc import SceneError, compile_scene, validate

if TYPE_CHECKING:
    from pathlib import Path

DRAWS: dict[str, Any] = {
    "r": {"uniform": [0.1, 0.2]},
    "z": {"uniform": [-1, 1]},
    "n": {"normal": [0, 1]},
    "v": {"uniform": [[0.1, 0.1], [0.2, 0.2]]},
    "die": {"integers": [1, 6]},
    "which": {"choice": ["a", "b"]},
}


def told(body: dict[str, Any], num_scenes: int = 8) -> list[tuple[str, str]]:
    """Codes and messages of what validation says of a body, which reads some of the draws, without scenes and seeds."""
    names = {name: draw for name, draw in DRAWS.items() if name in str(body)}
    found = validate(scene(body, draws=names, num_scenes=num_scenes))
    return [(one.code, _without_sample(one.message)) for one in found if one.code != "SC319"]


def _without_sample(message: str) -> str:
    return re.sub(r"^in scene \d+( with seed \d+|(?= this has no value)|(?=: it |: this expression))[: ]*", "", message)


def box(half_size: Any) -> dict[str, Any]:
    return {"shapes": [{"type": "box", "half_size": half_size}]}


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (box("${r}"), "it gives a number where 3 numbers are needed"),
        (box("${[r, r]}"), "it gives a list that is not 3 numbers"),
        (box("${v}"), "it gives a list that is not 3 numbers"),
        (box("${which}"), "it gives a string where 3 numbers are needed"),
        (box(["${v}", 1, 1]), "it gives a list where one value is needed"),
        ({"pose": {"p": "${scene}"}}, "it gives a number where 3 numbers are needed"),
        ({"mass": "${which}"}, "this expression gives 'b', but a number is needed"),
        ({"mass": "${r > 0.15}"}, "this expression gives true, but a number is needed"),
        ({"gravity": "${die + 1}"}, "it gives 3, which is not valid here"),
        ({"color": "${r}"}, "it gives 0.17967091834200766, which is not valid here"),
        ({"gravity": "${z}"}, "it gives 0.4107852794476545, which is not valid here"),
        ({"solver_position_iterations": "${which}"}, "this expression gives 'b', but an integer is needed"),
        (box("${v * 2}"), "it gives a list that is not 3 numbers"),
    ],
    ids=str,
)
def test_a_value_of_another_kind_is_an_error(body: dict[str, Any], message: str) -> None:
    assert told(body) == [("SC515", message)]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ({"color": "${'#ff0000' if r > 0.15 else 'reddish'}"}, "it gives 'reddish', which is not valid here"),
        ({"color": "${'#ff0000' if which == 'a' else 'reddish'}"}, "it gives 'reddish', which is not valid here"),
        (
            {"color": {"choice": ["#ffffff", "${'red' if r > 1 else 'rot'}"]}},
            "it gives 'rot', which is not valid here",
        ),
        (box("${[r, r, r] if n > 0 else r}"), "it gives a number where 3 numbers are needed"),
        (box("${[die, die, die] if die > 1 else die}"), "it gives a number where 3 numbers are needed"),
    ],
    ids=str,
)
def test_a_value_that_is_of_another_kind_in_a_scene_is_an_error(body: dict[str, Any], message: str) -> None:
    assert told(body) == [("SC515", message)]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ({"color": "${'#ff0000' if r > 0.103 else 'reddish'}"}, "it gives 'reddish', which is not valid here"),
        (box("${[r, r, r] if n > -2 else r}"), "it gives a number where 3 numbers are needed"),
    ],
    ids=str,
)
def test_a_value_that_is_of_another_kind_with_another_seed_is_a_warning(body: dict[str, Any], message: str) -> None:
    assert told(body) == [("SC514", message)]


def test_a_warning_names_a_scene_and_a_seed_that_show_it() -> None:
    document = scene({"mass": "${z + 0.99}"}, draws={"z": DRAWS["z"]}, num_scenes=8)
    (found,) = validate(document)
    told = re.fullmatch(r"in scene (\d+) with seed (\d+) this is (-[\d.]+): it must be above 0", found.message)
    assert told is not None
    scene_index, seed, number = told.groups()
    assert found.code == "SC514"
    with pytest.raises(SceneError) as caught:
        compile_scene(document, seed=int(seed))
    messages = [one.message for one in caught.value.diagnostics if one.code == "SC513"]
    assert messages == [f"in scene {scene_index} this is {number}: it must be above 0"]
    fixed = compile_scene(scene({"pose": ["${z + 0.99}", 0, 0]}, draws={"z": DRAWS["z"]}, num_scenes=8), seed=int(seed))
    assert f"{entity(fixed).pose.data[int(scene_index), 0]:g}" == number


@pytest.mark.parametrize(
    ("body", "path"),
    [
        ({"pose": [0, 0, "${z > 0}"]}, "pose[2]"),
        ({"pose": [0, 0, {"cycle": [1, "${z > 0}"]}]}, "pose[2].cycle[1]"),
        ({"color": ["${scene > 0}", 0, 0]}, "color[0]"),
        ({"pose": {"p": [0, 0, 1], "rpy": [0, 0, "${which}"]}}, "pose.rpy[2]"),
    ],
)
def test_a_component_of_another_kind_is_an_error_at_the_component(body: dict[str, Any], path: str) -> None:
    names = {name: draw for name, draw in DRAWS.items() if f"${{{name}" in str(body)}
    (found,) = validate(scene(body, draws=names, num_scenes=4))
    assert (found.code, found.path) == ("SC515", f"entities.body.{path}"), found
    assert "but a number is needed" in found.message


def test_an_expression_beside_a_pose_that_is_not_placed_yet_is_no_certain_fault() -> None:
    table = {"body_type": "static", **box([1, 1, 0.1])}
    body = {"pose": {"relative_to": "cup", "p": [0, 0, "${sqrt(z + 0.9)}"]}}
    entities = {"table": table, "cup": {"place": {"on": "table"}, "shapes": BALL}, "lid": {**body, "shapes": BALL}}
    found = validate({"scenecc": 1, "num_scenes": 2, "draws": {"z": DRAWS["z"]}, "entities": entities})
    assert [one.code for one in found if one.path == "entities.lid.pose.p[2]"] == ["SC516"], found
    assert not any(one.severity == "error" for one in found), found


def test_an_expression_is_judged_in_the_scenes_that_read_it() -> None:
    body = {"pose": ["${1 / (die - 1)}", 0, {"per_scene": {0: 1, "default": "${1 / scene + z}"}}]}
    found = validate(scene(body, draws={name: DRAWS[name] for name in ("die", "z")}, num_scenes=4))
    assert [(one.code, one.path) for one in found] == [("SC202", "entities.body.pose[0]")], found


@pytest.mark.parametrize("index", ["1 // scene", "1 // scene + die // 7"])
def test_a_name_by_expression_is_judged_in_the_scenes_that_read_it(index: str) -> None:
    materials = {name: {"visual": {"roughness": size}} for name, size in (("one", 1), ("two", 0.5), ("three", 0))}
    body = {"material": {"per_scene": {0: "one", "default": f"${{['two', 'three'][{index}]}}"}}}
    draws = {"die": DRAWS["die"]} if "die" in index else {}
    document = scene(body, draws=draws, materials=materials, num_scenes=3)
    assert validate(document) == []
    assert len(compile_scene(document).visual_materials) == 1 + len(materials)


@pytest.mark.parametrize("index", ["4", "4 + die // 7"])
def test_a_name_by_expression_without_a_value_beside_one_that_is_written(index: str) -> None:
    body = {"material": {"per_scene": {0: "one", "default": f"${{['one'][{index}]}}"}}}
    draws = {"die": DRAWS["die"]} if "die" in index else {}
    document = scene(body, draws=draws, materials={"one": {"visual": {"roughness": 1}}}, num_scenes=3)
    assert [one.code for one in validate(document)] == ["SC202"]


def test_a_name_without_a_value_wherever_it_is_read_is_an_error() -> None:
    """In scene 1 the first expression would have a value."""
    names = {0: "${['one'][1 // scene - 1]}", "default": "${['one'][die // 7]}"}
    document = scene({"material": {"per_scene": names}}, draws={"die": DRAWS["die"]}, num_scenes=40)
    found = validate({**document, "materials": {"one": {"visual": {"roughness": 1}}}})
    assert [(one.code, one.severity) for one in found] == [("SC202", "error")], found


@pytest.mark.parametrize(
    "mass", ["${m - 0.5*m}", "${k - k + 1}", "${m*m - 2*m + 1.5}", "${sqrt(k) - k + 0.01}", "${0.1 + k * k}"]
)
def test_an_expression_whose_values_are_in_range_has_no_warning(mass: str) -> None:
    draws = {"m": {"uniform": [0.1, 5]}, "k": {"uniform": [0, 1]}}
    assert codes(scene({"mass": mass}, draws={name: one for name, one in draws.items() if name in mass})) == []


def test_what_is_rarer_than_the_samples_is_an_error_of_the_build() -> None:
    """In scene 1 with seed 1 alone is the draw so small."""
    rare = compile_scene(scene({"pose": ["${u}", 0, 0]}, draws={"u": {"uniform": [0, 1]}}, num_scenes=1), seed=1000)
    limit = float(entity(rare).pose.data[0, 0])
    document = scene({"mass": f"${{0 if u == {limit!r} else 1}}"}, draws={"u": {"uniform": [0, 1]}}, num_scenes=1)
    assert codes(document) == []
    with pytest.raises(SceneError) as caught:
        compile_scene(document, seed=1000)
    (found,) = caught.value.diagnostics
    assert (found.code, found.path) == ("SC513", "entities.body.mass")


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ({"mass": "${z}"}, "in scene 2 this is -0.830322: it must be above 0"),
        ({"mass": "${r - 0.5}"}, "in scene 0 this is -0.320329: it must be above 0"),
        ({"mass": "${-die}"}, "in scene 0 this is -2: it must be above 0"),
        ({"mass": "${die * 0}"}, "in scene 0 this is 0: it must be above 0"),
        (box("${[0.5, 0.5, -r]}"), "in scene 0 this is [0.5, 0.5, -0.179671]: each number must be above 0"),
        (
            {"material": {"physical": {"restitution": "${1 + r}"}}},
            "in scene 0 this is 1.17967: it must be at most 1",
        ),
        ({"mass": "${2 - scene}"}, "in scene 2 this is 0: it must be above 0"),
        ({"mass": "${1 if scene < 7 else -1}"}, "in scene 7 this is -1: it must be above 0"),
    ],
    ids=str,
)
def test_a_number_that_is_out_of_range_in_a_scene_is_an_error(body: dict[str, Any], message: str) -> None:
    assert told(body) == [("SC513", message)]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ({"mass": "${z + 0.99}"}, [("SC514", "this is -0.00222811: it must be above 0")]),
        ({"pose": ["${1 / z}", 0, 0]}, []),
        ({"mass": "${1 / (die - 3) + 9}"}, [("SC516", "this has no value: division by zero")]),
        ({"mass": "${1 + sqrt(z)}"}, [("SC202", "in scene 2: `sqrt` is not defined for -0.8303218561796184")]),
        (
            {"mass": "${[1, 2][die - 1]}"},
            [("SC202", "in scene 1: index 3 is out of range: the list has 2 items")],
        ),
        ({"mass": "${sqrt(r - 1)}"}, [("SC202", "in scene 0: `sqrt` is not defined for -0.8203290816579923")]),
        ({"mass": "${1 / (scene - 3) + 9}"}, [("SC202", "in scene 3: division by zero")]),
        ({"pose": ["${sqrt(5 - scene)}", 0, 0]}, [("SC202", "in scene 6: `sqrt` is not defined for -1")]),
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
    assert codes(scene({"mass": "${1 + twice}"}, draws=draws, num_scenes=8)) == [("SC202", "draws.root")]


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


def test_an_expression_without_a_value_in_many_places_is_reported_at_each() -> None:
    document = scene({"mass": "${1 / floor(2 * z) + 9}"}, draws={"z": DRAWS["z"]}, num_scenes=4)
    document["entities"] |= {f"e{i}": document["entities"]["body"] for i in range(50)}
    assert {code for code, _ in codes(document)} == {"SC202"}
    assert len(codes(document)) == 51


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("${v / 2}", "`/` does not take a list and a number"),
        ("${-v}", "`-` does not take a list"),
        ("${sqrt(v)}", "`sqrt` takes numbers, not a list"),
        ("${v > 1}", "`>` does not take a list and a number"),
        ("${r[0]}", "a number has no items"),
        ("${len(r)}", "`len` takes a list or a string, not a number"),
        ("${1 if v else 2}", "a condition is a boolean or a number, not a list"),
        ("x_${v}", "a list cannot be part of a longer string"),
    ],
)
def test_what_cannot_be_done_with_kinds_of_values_is_told_of_a_draw(expression: str, message: str) -> None:
    draws = {"v": DRAWS["v"], "r": DRAWS["r"], "h": expression}
    (found,) = [one for one in validate(scene({}, draws=draws)) if one.code != "SC319"]
    assert (found.code, found.message) == ("SC202", f"in scene 0: {message}")
    assert found.path == "draws.h"


def test_a_draw_that_its_scene_decides_is_reported_at_the_part_without_a_value() -> None:
    draws = {"r": DRAWS["r"], "far": "${2 + 1 / (scene - 1)}", "near": "${3 + 1 / (scene - 2)}"}
    entities = {
        # In scene 0, where `far` has a value. That it has none in scene 1 is no matter, since nothing reads it there.
        "one": {"shapes": BALL, "mass": "${r + far}", "scene_idxs": [0]},
        "all": {"shapes": BALL, "mass": "${r + near}"},
    }
    document = {"scenecc": 1, "num_scenes": 4, "draws": draws, "entities": entities}
    (found,) = [one for one in validate(document) if one.code == "SC202"]
    assert found.path == "draws.near"
    assert found.message == "in scene 2: division by zero"


def test_the_part_without_a_value_is_underlined(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(
        'scenecc: 1\nnum_scenes: 4\ndraws:\n  r: {uniform: [1, 2]}\n  near: "${3 + 1 / (scene - 2)}"\n'
        'entities: {ball: {shapes: [{type: sphere, radius: "${r + near}"}]}}\n'
    )
    found = validate(file)[0]
    assert found.code == "SC202"
    line = file.read_text().split("\n")[4]
    assert found.location.column is not None
    assert found.location.end_column is not None
    assert line[found.location.column - 1 : found.location.end_column - 1] == "1 / (scene - 2)"


def test_the_hint_of_bounds_that_may_cross_says_how_to_keep_them_in_range() -> None:
    (found,) = validate(scene({"mass": {"uniform": [{"uniform": [1, 3]}, 2.9]}}))
    hint = "a build with `--seed 3` shows it; `min` and `max` keep a bound in its range"
    assert (found.code, found.hint) == ("SC516", hint)


CROSSED = "the lower bound is above the upper one"


@pytest.mark.parametrize(
    ("draw", "expected"),
    [
        ({"uniform": ["${scene}", 2]}, ("SC515", f"in scene 3: {CROSSED}")),
        ({"uniform": [{"cycle": [1, 3]}, 2]}, ("SC515", f"in scene 1: {CROSSED}")),
        (
            {"uniform": [{"per_scene": {0: 3, "default": "${which}"}}, 4]},
            ("SC515", "in scene 1: a bound is not a number"),
        ),
        ({"uniform": [{"uniform": [0, 1]}, 0.5]}, ("SC515", CROSSED)),
        ({"uniform": ["${z}", 0.5]}, ("SC515", CROSSED)),
        ({"uniform": ["${z}", -2]}, ("SC515", f"in scene 0: {CROSSED}")),
        ({"uniform": ["${v}", [1, 0.15]]}, ("SC515", CROSSED)),
        ({"uniform": ["${die}", 3]}, ("SC515", CROSSED)),
        ({"uniform": ["${die + 6}", 3]}, ("SC515", f"in scene 0: {CROSSED}")),
        ({"integers": ["${z}", 2]}, ("SC515", "in scene 0: a bound is not an integer")),
        ({"integers": ["${floor(9 * z)}", 2]}, ("SC515", CROSSED)),
        ({"log_uniform": ["${z}", 2]}, ("SC515", "the lower bound is not positive")),
        ({"log_uniform": ["${z - 1}", 2]}, ("SC515", "in scene 0: the lower bound is not positive")),
        ({"normal": [0, "${z}"]}, ("SC515", "the standard deviation is negative")),
        ({"beta": ["${z / 10000}", 2], "range": [0, 1]}, ("SC515", "in scene 0: `a` is below 0.001")),
        ({"normal": [0, 1], "clip": ["${z}", 0]}, ("SC515", "the lower edge of `clip` is above the upper one")),
        ({"uniform": ["${which}", 1]}, ("SC515", "in scene 0: a bound is not a number")),
        ({"uniform": [{"choice": ["a", 0]}, 1]}, ("SC515", "a bound is not a number")),
    ],
    ids=str,
)
@pytest.mark.parametrize("body", [{}, {"pose": ["${h}", 0, 0]}])
def test_bounds_that_are_none_are_told_of_the_draw(draw: Any, expected: tuple[str, str], body: dict[str, Any]) -> None:
    """Whether anything reads it or not."""
    draws = {name: one for name, one in DRAWS.items() if f"${{{name}" in str(draw) or name in str(draw)}
    found = [one for one in validate(scene(body, draws={**draws, "h": draw}, num_scenes=4)) if one.code != "SC319"]
    told = [one for one in found if one.path == "draws.h"]
    code, message = expected
    assert [one.code for one in told if one.code == code] == [code]
    assert told[0].message == message or re.fullmatch(rf"in scene \d: {message}", told[0].message)


@pytest.mark.parametrize(
    "draw",
    [
        {"uniform": ["${z - 0.1}", "${z + 0.1}"]},
        {"uniform": ["${2 * z - r}", "${z + z + r}"]},
        {"uniform": ["${-(r / 2)}", "${r / 2 + 1}"]},
        {"uniform": ["${die}", "${die + 1}"]},
        {"integers": ["${die}", "${die * 2}"]},
        {"integers": [0, "${floor(r * 100)}"]},
        {"uniform": ["${scene}", "${num_scenes}"]},
        {"uniform": [{"uniform": [0, 1]}, {"uniform": [1, 2]}]},
        {"normal": ["${n}", "${r}"]},
        {"log_uniform": ["${r}", 1]},
    ],
    ids=str,
)
def test_bounds_that_keep_their_order_are_let_be(draw: Any) -> None:
    document = scene({"pose": ["${h}", 0, 0]}, draws={**DRAWS, "h": draw}, num_scenes=4)
    assert {code for code, _ in codes(document)} <= {"SC319"}
    for seed in range(8):
        assert compile_scene(document, seed=seed).num_scenes == 4


def test_the_bounds_of_an_argument_are_judged_in_the_scenes_of_its_instance() -> None:
    cube = {"use": "scenecc:cube", "with": {"half_size": {"uniform": ["${0.1 + scene}", 2]}}}
    document = {"scenecc": 1, "num_scenes": 4, "entities": {"cube": cube}}
    assert [code for code, _ in codes(document)] == ["SC515"]
    cube["scene_idxs"] = [0, 1]
    assert codes(document) == []


def test_a_draw_that_nothing_reads_is_judged_in_every_scene() -> None:
    assert ("SC202", "draws.h") in codes(scene({}, draws={"h": "${1 / scene}"}, num_scenes=4))


@pytest.mark.parametrize("draws", [{}, {"sum": "${h + z}"}])
def test_a_draw_without_a_value_in_some_scene_is_told_beside_one_that_is_random(draws: dict[str, Any]) -> None:
    body = {"pose": ["${sum}" if draws else "${h + z}", 0, 0]}
    document = scene(body, draws={"z": DRAWS["z"], "h": "${1 / scene}", **draws}, num_scenes=4)
    assert codes(document) == [("SC202", "draws.h")]


def drawn(document: dict[str, Any]) -> list[tuple[str, str]]:
    """Codes and paths of what compiling reports."""
    with pytest.raises(SceneError) as caught:
        compile_scene(document)
    return [(diagnostic.code, diagnostic.path) for diagnostic in caught.value.diagnostics]


@pytest.mark.parametrize("given", ["${scene}", "${[scene, 1]}", "${[[scene], 1, 2]}", "${'a'}", "${scene > 1}"])
@pytest.mark.parametrize("key", ["p", "rpy", "look_at", "q"])
def test_a_value_that_is_no_vector_is_told_scene_by_scene(given: str, key: str) -> None:
    pose = {"p": [0, 0, 1], key: given}
    document = scene({"pose": pose}, num_scenes=2, draws={"unread": 1})
    assert {code for code, _ in drawn(document)} & {"SC515", "SC103", "SC105"}


def test_a_pose_that_is_a_number() -> None:
    assert drawn(scene({"pose": "${scene}"}, num_scenes=3)) == [("SC515", "entities.body.pose")]


@pytest.mark.parametrize("texture", ["${scene}", "${u}"])
def test_a_texture_that_is_a_number(texture: str) -> None:
    visual = {"base_color_texture": texture}
    shape = {"type": "sphere", "radius": 1, "material": {"visual": visual}}
    document = scene({"shapes": [shape]}, num_scenes=2, draws={"u": {"uniform": [0, 1]}})
    path = "entities.body.shapes[0].material.visual.base_color_texture"
    assert ("SC317", path) in codes(document)


@pytest.mark.parametrize(
    ("draw", "count"),
    [
        ({"uniform": [0.1, [1]]}, 1),
        ({"uniform": [[0.1, 0.2], 1]}, 2),
        ({"normal": [[0.5, 0.6], 0], "clip": [0.1, [1, 1]]}, 2),
        ({"normal": [0.5, 0], "clip": [0.1, [1, 1, 1]]}, 3),
        ({"choice": [{"uniform": [[0.1], [0.2]]}, {"uniform": [0.1, [1]]}]}, 1),
    ],
    ids=str,
)
def test_a_number_bounds_every_component(draw: dict[str, Any], count: int) -> None:
    document = scene({"mass": f"${{u[{count - 1}] + len(u)}}"}, draws={"u": draw}, num_scenes=4)
    assert codes(document) == []
    mass = body_of(entity(compile_scene(document))).mass
    assert mass is not None
    assert ((mass.data >= count + 0.1) & (mass.data <= count + 1)).all()


def test_a_draw_of_numbers_here_and_lists_there() -> None:
    draws = {"u": {"cycle": [{"uniform": [1, 2]}, {"uniform": [[3, 3], 4]}]}}
    document = scene({"mass": "${u if scene % 2 == 0 else u[1]}"}, draws=draws, num_scenes=4)
    mass = body_of(entity(compile_scene(document))).mass
    assert mass is not None
    assert (mass.data > 3).tolist() == [False, True, False, True]


def test_what_an_expression_may_give_is_said_plainly() -> None:
    draws = {"u": {"uniform": [-1, 1]}, "n": {"normal": [0, 1]}}
    shapes = [{"type": "sphere", "radius": "${u}"}, {"type": "sphere", "radius": "${n + u}"}]
    found = validate(scene({"shapes": shapes}, draws=draws, num_scenes=4))
    assert [diagnostic.message for diagnostic in found] == [
        "in scene 0 this is -0.443823: it must be above 0",
        "in scene 0 this is -0.13542: it must be above 0",
    ]
    # That the body would weigh less than nothing is not reported as well.
    assert {diagnostic.code for diagnostic in found} == {"SC513"}


def test_a_matrix_is_given_whole_or_by_rows() -> None:
    rows: list[Any] = [[1, 0, 0, "${scene}"], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    whole = "${[[1, 0, 0, scene], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}"
    by_rows = ["${[1, 0, 0, scene]}", *rows[1:]]
    for matrix in (whole, by_rows, rows):
        plan = compile_scene(scene({"pose": {"matrix": matrix}}, num_scenes=3))
        assert entity(plan).pose.data[:, 0].tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        ("${scene}", "in scene 0: it gives a number where 4 lists of 4 numbers are needed"),
        ("${[[scene]]}", "in scene 0: it gives a list that is not 4 lists of 4 numbers"),
        (
            ["${scene}", [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
            "in scene 0: it gives a number where 4 numbers are needed",
        ),
    ],
    ids=str,
)
def test_what_is_no_matrix_is_told(matrix: Any, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        compile_scene(scene({"pose": {"matrix": matrix}}, num_scenes=2))
    assert [diagnostic.message for diagnostic in caught.value.diagnostics] == [message]


@pytest.mark.parametrize("key", ["offset", "normal"])
@pytest.mark.parametrize("given", ["${'a' if scene else 'b'}", "${scene > 1}", "${[scene]}"])
def test_a_plane_that_lies_nowhere(key: str, given: str) -> None:
    shape = {"type": "plane", key: given}
    document = scene({"body_type": "static", "shapes": [shape]}, num_scenes=2)
    assert drawn(document) == [("SC515", f"entities.body.shapes[0].{key}")]
    shape["normal"] = [0, 0, given]  # type: ignore[index]
    assert drawn(document)[0][0] == "SC515"


def test_too_many_maps_by_scene() -> None:
    document = scene({"mass": {"per_scene": [{"per_scene": {0: 1}}, 180]}}, num_scenes=3)
    assert [code for code, _ in codes(document)] == ["SC314", "SC315"]


def test_a_draw_may_be_an_integer_in_one_scene_and_a_float_in_another() -> None:
    materials = {name: {"physical": {"density": 2}} for name in ("m1.0", "m2")}
    draws = {"k": {"cycle": [1.0, "${scene + 1}"]}}
    document = scene({"material": "m${k}", "mass": "${k}"}, draws=draws, materials=materials, num_scenes=2)
    body = body_of(entity(compile_scene(document)))
    assert body.mass.data.tolist() == [1, 2]  # type: ignore[union-attr]
    document["num_scenes"] = 1
    document["materials"].pop("m2")
    document["entities"]["body"]["mass"] = 1
    assert codes(document) == []


MANY = list(range(1, 20_001))


def repeated(count: int, **keys: Any) -> dict[str, Any]:
    return {"scenecc": 1, "entities": {"a": {"repeat": {"i": {"count": count}}, "shapes": BALL, **keys}}}


@pytest.mark.parametrize(
    "document",
    [
        {**repeated(300, mass="${u + i}"), "draws": {"u": {"choice": MANY}}, "num_scenes": 4},
        {**repeated(20, mass={"cycle": [1, 2]}, pose=[{"cycle": [0, 1]}, 0, 0]), "num_scenes": 65_536},
        {**repeated(20, mass={"per_scene": {0: 1, "default": 2}}), "num_scenes": 65_536},
    ],
    ids=["many alternatives", "many scenes", "a map of many scenes"],
)
def test_what_is_common_is_looked_at_once(document: dict[str, Any]) -> None:
    start = time.process_time()
    assert codes(document) == []
    assert_took(time.process_time() - start, most=6)


def test_a_long_chain_of_poses_that_vary() -> None:
    frames: dict[str, Any] = {"f0": {"pose": [0, 0, 0]}}
    for i in range(1, 400):
        frames[f"f{i}"] = {"pose": {"p": [{"cycle": [0, 1]}, 0, 0], "relative_to": f"f{i - 1}"}}
    start = time.process_time()
    document = scene({"pose": {"p": [0, 0, 0], "relative_to": "f399"}}, frames=frames, num_scenes=3)
    assert codes(document) == []
    assert_took(time.process_time() - start, most=15)


def test_what_instances_select_is_bounded() -> None:
    inner = {"use": "scenecc:cube", "repeat": {"i": {"count": 3000}}, "scene_idxs": "${i}:"}
    document = {"scenecc": 1, "num_scenes": 60_000, "entities": {"a": inner}}
    assert [code for code, _ in codes(document, limits={"objects": 100_000})] == ["SC604"]


def test_a_draw_beyond_the_limit_is_reported_as_such() -> None:
    draws = {"u": {"uniform": [0, 1]}, "long": "${[u] * 9000}"}
    found = codes(scene({"mass": "${long[0] + 1}"}, draws=draws, num_scenes=2), limits={"objects": 100})
    assert found == [("SC604", "draws.long")]


def test_an_exceeded_limit_is_reported_once() -> None:
    materials = {"m0": {"physical": {"restitution": 0.2}}, "m1": {"physical": {"restitution": 0.1}}}
    document = scene(num_scenes=40, draws={"u": {"uniform": [0, 1]}}, materials=materials)
    for i in range(10, 40):
        document["entities"][f"e{i}"] = {"material": f"${{'m0' if u > 0.{i} else 'm1'}}", "shapes": BALL}
    assert codes(document, limits={"objects": 100}) == [("SC604", "entities.e13.material")]


def test_an_error_replaces_the_warning_of_other_scenes_at_its_place() -> None:
    first, second = ({"scene_idxs": scenes, "material": "m", "shapes": BALL} for scenes in ([0], [1, 2]))
    document = scene(num_scenes=4, seed=3, draws={"u": {"uniform": [0, 1]}})
    document |= {"materials": {"m": {"physical": {"restitution": "${1.1 * u}"}}}, "entities": {"a": first}}
    assert codes(document) == [("SC514", "materials.m.physical.restitution")]
    document["entities"]["b"] = second
    assert codes(document) == [("SC513", "materials.m.physical.restitution")]
