"""Nodes over many scenes: what each gives, what is shared, and where it fails."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from scenecc.variation.evaluation import Batch
from scenecc.variation.forms import Template
from scenecc.variation.nodes import (
    Chosen,
    Composed,
    Computed,
    Const,
    Cycled,
    Drawn,
    FromAxisAngle,
    FromMatrix,
    FromRpy,
    Key,
    Looking,
    Node,
    Normalized,
    Pointing,
    Posed,
    Radians,
    RandomRotated,
    Rows,
    Shared,
    Stacked,
)
from scenecc.variation.operations import DrawError, ExpressionError

KEY = Key("entities", "cube", "mass")
SCENES = (3, 0, 7)
IDENTITY = (1.0, 0.0, 0.0, 0.0)
UNIT = Drawn("uniform", (0.0, 1.0), (), Key("draws", "u", ""))


def batch(
    draws: dict[str, Node] | None = None, given: dict[str, Any] | None = None, scenes: Any = SCENES, seed: int = 0
) -> Batch:
    return Batch(np.array(scenes), seed, 8, draws or {}, given or {})


def evaluate(node: Node, **kwargs: Any) -> Any:
    return batch(**kwargs).evaluate(node)


def expression(text: str, shape: tuple[int, ...] | None = (), **reads: str) -> Computed:
    return Computed(Template.parse("${" + text + "}"), shape, tuple(reads.items()))


@pytest.mark.parametrize(
    "node",
    [
        Cycled((Computed(Template.parse("${scene}"), None), 0.5)),
        Chosen((1, Computed(Template.parse("${0.5 * 3}"), None)), None, KEY),
        Rows(tuple(range(8)), (*range(7), Cycled((Const(0.5), 1)))),
    ],
)
def test_what_a_text_says_of_a_scene_does_not_depend_on_the_others(node: Node) -> None:
    draws: dict[str, Node] = {"n": node}
    text = Computed(Template.parse("m${n}"), None)
    together = evaluate(text, draws=draws, scenes=range(8)).tolist()
    assert together == [evaluate(text, draws=draws, scenes=[scene]).tolist()[0] for scene in range(8)]


def test_a_field_takes_integers_and_floats_alike() -> None:
    mixed = Cycled((Const(1), Const(0.5)))
    assert evaluate(Radians(mixed)).dtype == np.float64
    assert evaluate(FromAxisAngle((0.0, 0.0, 1.0), mixed)).dtype == np.float64
    drawn = evaluate(Drawn("uniform", (mixed, 1), (), KEY))
    assert (drawn[1], (drawn <= 1).all()) == (1, True)


@pytest.mark.parametrize(
    ("node", "expected", "dtype"),
    [
        (Const(2), [2, 2, 2], np.int64),
        (Const((1, 2.5)), [[1, 2.5]] * 3, np.float64),
        (Const(True), [True] * 3, np.bool_),
        (Const("a.obj"), ["a.obj"] * 3, np.object_),
        (Const(("a", 1)), [["a", 1]] * 3, np.object_),
        (Rows((0, 3, 5, 7), (10, 13.5, 15, 17)), [13.5, 10, 17], np.float64),
        (Cycled(((0, 1), (2, 3))), [[2, 3], [0, 1], [2, 3]], np.int64),
        (Cycled(("a", "bb", "ccc")), ["a", "a", "bb"], np.object_),
        (Cycled((1, True)), [True, 1, True], np.object_),
        (Cycled((Const(1), Cycled((5, 6, 7)))), [5, 1, 6], np.int64),
        (Cycled((Const(1), Const(0.5))), [0.5, 1, 0.5], np.object_),
        (Cycled((Const("a"), Const((1, 2)))), [[1, 2], "a", [1, 2]], np.object_),
        (Stacked((Cycled((0, 1)), 2, Const(0.5))), [[1, 2, 0.5], [0, 2, 0.5], [1, 2, 0.5]], np.float64),
        (Stacked(((1, 0), (0, Const(1).data))), [[[1, 0], [0, 1]]] * 3, np.int64),
        (Stacked(("a", Cycled((1, 2)))), [["a", 2], ["a", 1], ["a", 2]], np.object_),
        (expression("scene * 2"), [6, 0, 14], np.int64),
        (expression("scene / num_scenes"), [0.375, 0, 0.875], np.float64),
        (expression("1 if scene else 0.5"), [1, 0.5, 1], np.float64),
        (expression("num_scenes"), [8, 8, 8], np.int64),
        (expression("scene > 2"), [True, False, True], np.bool_),
        (expression("[scene, 0.5]", (2,)), [[3, 0.5], [0, 0.5], [7, 0.5]], np.float64),
        (expression("[1, 2]", (2,)), [[1, 2]] * 3, np.float64),
        (expression("[scene, 1]", None), [[3, 1], [0, 1], [7, 1]], np.int64),
        (expression("[scene, 'a']", None), [[3, "a"], [0, "a"], [7, "a"]], np.object_),
        (expression("scene + 2 ** 63", None), [2**63 + 3, 2**63, 2**63 + 7], np.object_),
        (Computed(Template.parse("m${scene}.obj"), ()), ["m3.obj", "m0.obj", "m7.obj"], np.object_),
        (Radians((180, Const(90).data)), [[np.pi, np.pi / 2]] * 3, np.float64),
    ],
)
def test_a_node_gives_a_row_a_scene(node: Node, expected: Any, dtype: Any) -> None:
    found = evaluate(node)
    assert found.tolist() == expected
    assert found.dtype == dtype


@pytest.mark.parametrize("text", ["1 if scene else 0.5", "[2, 1 if scene else 0.5]", "'a' if scene == 7 else 1"])
def test_an_integer_stays_one_whatever_other_scenes_have(text: str) -> None:
    draws: dict[str, Node] = {"a": expression(text, None)}
    together = batch(draws).shared("a").tolist()
    alone = [batch(draws, scenes=(scene,)).shared("a").tolist()[0] for scene in SCENES]
    assert repr(together) == repr(alone)


def test_bounds_may_vary_themselves() -> None:
    node = Drawn("uniform", (Cycled((0.0, 10.0)), Stacked((Cycled((1.0, 11.0)), 20.0))), (2,), KEY)
    found = evaluate(node, scenes=range(50))
    assert (found[::2] >= 0).all()
    assert (found[::2, 0] <= 1).all()
    assert (found[1::2] >= 10).all()
    assert (found[1::2, 0] <= 11).all()


def test_a_shared_draw_is_one_value_a_scene_wherever_it_is_read() -> None:
    draws: dict[str, Node] = {"u": UNIT, "half": expression("u / 2"), "in/u": Const(5)}
    found = batch(draws)
    peg = found.evaluate(Stacked((expression("half"), Shared("half"), 0.1)))
    hole = found.evaluate(expression("half + 0.001"))
    assert (peg[:, 0] == peg[:, 1]).all()
    assert (hole == peg[:, 0] + 0.001).all()
    assert (found.evaluate(Shared("u")) / 2 == peg[:, 0]).all()
    assert found.evaluate(expression("u", u="in/u")).tolist() == [5, 5, 5]


def test_given_values_take_the_place_of_a_draw_by_scene_index() -> None:
    given = {
        "u": np.arange(8, dtype=np.float32) / 2,
        "name": np.array(list("abcdefgh")),
        "v": np.arange(16).reshape(8, 2),
    }
    draws: dict[str, Node] = {"u": UNIT, "name": Const("x"), "v": Const((0, 0)), "w": expression("u + 1")}
    found = batch(draws, given)
    assert found.evaluate(Shared("u")).tolist() == [1.5, 0.0, 3.5]
    assert found.evaluate(Shared("w")).tolist() == [2.5, 1.0, 4.5]
    assert found.evaluate(expression("name + '.obj'")).tolist() == ["d.obj", "a.obj", "h.obj"]
    assert found.evaluate(expression("v[1] * 2")).tolist() == [14, 2, 30]


def test_only_the_branch_and_the_alternative_of_a_scene_are_evaluated() -> None:
    assert evaluate(expression("1 / scene if scene else 0")).tolist() == [1 / 3, 0, 1 / 7]
    fails_in_scene_0 = expression("1 / scene")
    assert evaluate(Rows((0, 3, 7), (5, fails_in_scene_0, fails_in_scene_0))).tolist() == [1 / 3, 5, 1 / 7]


def test_an_expression_computes_as_python_does_in_every_scene() -> None:
    found = evaluate(expression("u ** 0.5 + sin(u) * 3 // 0.1"), draws={"u": UNIT}, scenes=range(200))
    template = Template.parse("${u ** 0.5 + sin(u) * 3 // 0.1}")
    u = batch({"u": UNIT}, scenes=range(200)).evaluate(UNIT)
    assert found.tolist() == [template.evaluate({"u": value}) for value in u.tolist()]


@pytest.mark.parametrize(
    ("node", "message", "scene"),
    [
        (expression("1 / scene"), "division by zero", 0),
        (expression("[1, 2]"), "it gives a list where one value is needed", 3),
        (expression("2 ** 80 if scene == 7 else 1"), "it gives an integer of more than 64 bits", 7),
        (expression("scene", (3,)), "it gives a number where 3 numbers are needed", 3),
        (expression("[1, 2, 3] if scene else [1]", (3,)), "it gives a list that is not 3 numbers", 0),
        (expression("[1, 'a']", (2,)), "it gives a list that is not 2 numbers", 3),
        (expression("[1, true]", (2,)), "it gives a list that is not 2 numbers", 3),
        (Rows((0, 3), (1, 2)), "no value is given for this scene", 7),
        (Drawn("uniform", (expression("scene"), 5), (), KEY), "the lower bound is above the upper one", 7),
        (Drawn("uniform", ((0, 6), 5), (2,), KEY), "the lower bound is above the upper one", 3),
        (Drawn("uniform", ("a", 5), (), KEY), "a bound is not a number", 3),
        (Drawn("uniform", ((1, 2, 3), 5), (2,), KEY), "a bound is not a number or a list of 2 numbers", 3),
        (Drawn("uniform", (-1e308, 1e308), (), KEY), "a bound is beyond 1e300", 3),
        (Drawn("integers", (0, expression("scene + 0.5")), (), KEY), "a bound is not an integer", 3),
        (Drawn("integers", (0, 2**60), (), KEY), "a bound is beyond 9007199254740992", 3),
        (Drawn("integers", (-(2**53), 5), (), KEY), "the bounds contain more than 9007199254740992 integers", 3),
        (Drawn("log_uniform", (expression("scene"), 9), (), KEY), "the lower bound is not positive", 0),
        (Drawn("normal", (0, expression("scene - 1")), (), KEY), "the standard deviation is negative", 0),
        (Drawn("normal", (0, 1, 1, 0), (), KEY), "the lower edge of `clip` is above the upper one", 3),
        (FromAxisAngle(Stacked((0, 0, expression("scene"))), 1), "an axis of length 0 has no direction", 0),
        (FromAxisAngle((0, 0, 1), "a"), "this is not a number", 3),
        (FromRpy((0, 1)), "this is not 3 numbers", 3),
        (Pointing(Stacked((0, 0, expression("scene")))), "a direction of length 0 points nowhere", 0),
        (Normalized((2, 0, 0, 0)), "the quaternion's length is 2, not 1", 3),
        (
            Looking((0, 0, 5), (0, 0, 0)),
            "`look_at` is where the pose itself is, or straight above or below it",
            3,
        ),
        (
            FromMatrix(((2, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))),
            "the matrix is not rigid: it is off by 3",
            3,
        ),
    ],
)
def test_what_has_no_value_names_the_scene_and_the_node(node: Node, message: str, scene: int) -> None:
    with pytest.raises(DrawError) as caught:
        evaluate(node)
    assert (caught.value.message, caught.value.scene) == (message, scene)


def test_a_failure_inside_names_the_inner_node_and_its_expression() -> None:
    inner = expression("1 / scene")
    with pytest.raises(DrawError) as caught:
        evaluate(Stacked((1, Cycled((inner, 2)))), scenes=(4, 0))
    assert caught.value.node is inner
    assert isinstance(caught.value.expression, ExpressionError)
    assert (caught.value.expression.start, caught.value.expression.end) == (2, 11)


def test_poses_are_built_of_their_parts() -> None:
    quarter = FromRpy(Stacked((0, 0, Radians(Cycled((90, 180))))))
    turned = evaluate(Posed((1, 2, 3), quarter), scenes=(0, 1))
    assert turned[0] == pytest.approx([1, 2, 3, np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    assert turned[1] == pytest.approx([1, 2, 3, 0, 0, 0, 1])
    same = evaluate(FromAxisAngle((0, 0, 2), Radians(Cycled((90, 180)))), scenes=(0, 1))
    assert same == pytest.approx(turned[:, 3:])
    child = evaluate(Composed(Posed((1, 2, 3), quarter), (1, 0, 0, *IDENTITY)), scenes=(0, 1))
    assert child[0, :3] == pytest.approx([1, 3, 3])
    assert child[1, :3] == pytest.approx([0, 2, 3])
    quarter_turn = pytest.approx([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    assert evaluate(Looking((0, 5, 0), (0, 0, 0)), scenes=(0,))[0] == quarter_turn
    assert evaluate(Looking((1, 5, 2), (1, 2, 2)), scenes=(0,))[0] == quarter_turn
    matrix = ((0, -1, 0, 4), (1, 0, 0, 5), (0, 0, 1, 6), (0, 0, 0, 1))
    assert evaluate(FromMatrix(matrix), scenes=(0,))[0] == pytest.approx([4, 5, 6, np.sqrt(0.5), 0, 0, np.sqrt(0.5)])


def test_a_quaternion_as_written_is_untouched_or_normalised() -> None:
    close, off = (1 + 5e-6, 0.0, 0.0, 0.0), (0.0, 1.0005, 0.0, 0.0)
    assert evaluate(Normalized(Cycled((close, off))), scenes=(0, 1)).tolist() == [list(close), [0, 1, 0, 0]]


def test_nested_draws_have_keys_of_their_own() -> None:
    inner = Drawn("uniform", (0, 1), (), Key("entities", "cube", "mass.choice[1]"))
    found = evaluate(Chosen((5, inner), None, KEY), scenes=range(100))
    alone = evaluate(inner, scenes=range(100))
    drawn = found != 5
    assert 20 < drawn.sum() < 80
    assert (found[drawn] == alone[drawn]).all()


def test_reading_templates_and_finding_bounds_loads_no_numpy() -> None:
    script = (
        "import sys, scenecc.variation.forms, scenecc.variation.bounds\n"
        "from scenecc.variation.nodes import Drawn, Key\n"
        "from scenecc.variation.node_bounds import BoundsAnalysis\n"
        "BoundsAnalysis({}, 1).bounds(Drawn('uniform', ((0, 1), 2), (2,), Key('draws', 'u', '')))\n"
        "print(sorted({'numpy', 'pydantic', 'sapien'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, timeout=60)
    assert done.stdout == b"[]\n"


def test_random_rotations_are_poses_rotations() -> None:
    found = evaluate(Posed(Drawn("uniform", ((0, 0, 0), 1), (3,), KEY), RandomRotated(KEY)), scenes=range(30))
    assert found.shape == (30, 7)
    assert np.linalg.norm(found[:, 3:], axis=1) == pytest.approx(np.ones(30))
