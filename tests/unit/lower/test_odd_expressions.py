"""Expressions and draws that give another kind of value than is wanted: told, whatever they give."""

from __future__ import annotations

from typing import Any

import pytest
from plugins.structures import body_of
from unit.lower.scenes import codes, entity, scene

from scenecc import SceneError, compile_scene, validate


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
        "this expression may give -1, and it must be above 0",
        "this expression may give numbers of any size, and it must be above 0",
    ]
    # Only rows can tell: that a body may weigh less than nothing is no error before it is drawn.
    assert {diagnostic.code for diagnostic in found} == {"SC514"}


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
        ("${scene}", "in scene 0: it gives a number where 4 lists of 4 numbers are wanted"),
        ("${[[scene]]}", "in scene 0: it gives a list that is not 4 lists of 4 numbers"),
        (
            ["${scene}", [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
            "in scene 0: it gives a number where 4 numbers are wanted",
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
