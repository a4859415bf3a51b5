"""Arrays that take the place of shared draws: of the kind and shape that the file declares."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plugins.structures import body_of
from unit.lower.scenes import compiled, entity, scene

from scenecc import SceneError, compile_scene, validate

HALF = {"half": {"uniform": [0.1, 0.2]}}


def radius(plan: Any, name: str = "body") -> Any:
    geometry: Any = body_of(entity(plan, name)).collisions[0].geometry
    return geometry.radius.data


def ball(size: Any, **keys: Any) -> dict[str, Any]:
    return {"shapes": [{"type": "sphere", "radius": size}], **keys}


DECLARED = {
    "half": {"uniform": [1, 2]},
    "sum": "${half + 1}",
    "corner": {"uniform": [[0, 0, 0], [1, 1, 1]]},
    "twice": "${[half, 2 * half]}",
    "count": {"integers": [0, 500]},
    "flag": {"choice": [True, False]},
    "text": {"choice": ["a", "b"]},
    "either": {"choice": [1, "a"]},
}
READ = "${half + sum + corner[0] + twice[1] + count + (1 if flag and text == 'a' and [either] == [1] else 2)}"


@pytest.mark.parametrize(
    ("name", "given", "wanted"),
    [
        ("half", [0.1], "must be of shape (3,), as the file declares, not (1,)"),
        ("half", np.ones((3, 2)), "must be of shape (3,), as the file declares, not (3, 2)"),
        ("half", np.ones((3, 1)), "must be of shape (3,), as the file declares, not (3, 1)"),
        ("half", 0.5, "must be of shape (3,), as the file declares, not ()"),
        ("half", [[1], [1, 2], [3]], "must have rows of one length"),
        ("half", ["a", "b", "c"], "must be of numbers, as the file declares, not of texts"),
        ("half", [True, False, True], "must be of numbers, as the file declares, not of flags"),
        ("half", [None] * 3, "must be of numbers, not of other objects"),
        ("half", [1, float("nan"), 1], "must be of finite numbers: row 1 is nan"),
        ("sum", np.ones((3, 1)), "must be of shape (3,), as the file declares, not (3, 1)"),
        ("corner", np.ones((3, 2)), "must be of shape (3, 3), as the file declares, not (3, 2)"),
        ("corner", np.ones((3, 4)), "must be of shape (3, 3), as the file declares, not (3, 4)"),
        ("corner", [1, 2, 3], "must be of shape (3, 3), as the file declares, not (3,)"),
        ("twice", np.ones((3, 3)), "must be of shape (3, 2), as the file declares, not (3, 3)"),
        ("count", [0, 1, 1.5], "must be of integers, as the file declares: row 2 is 1.5"),
        ("count", [0, 1, 1e30], "must be of integers, as the file declares: row 2 is 1e+30"),
        ("count", ["1", "2", "3"], "must be of integers, as the file declares, not of texts"),
        ("flag", [1, 0, 1], "must be of flags, as the file declares, not of numbers"),
        ("text", [1, 0, 1], "must be of texts, as the file declares, not of numbers"),
        ("either", np.ones((3, 0)), "must be of shape (3,), as the file declares, not (3, 0)"),
    ],
)
def test_an_array_is_what_its_draw_is_declared_to_be(name: str, given: Any, wanted: str) -> None:
    document = scene({"mass": READ, **ball(1)}, draws=DECLARED, num_scenes=3)
    found = validate(document, draws={name: given})
    assert [(d.code, d.path, d.message) for d in found] == [
        ("SC318", f"draws.{name}", f"the array given for this draw {wanted}")
    ]


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("half", [1, 2, 3]),
        ("half", np.array([1, 2, 3], dtype=object)),
        ("half", np.array([7, 8, 9], dtype=np.float32)),  # outside of what is declared, which is allowed
        ("twice", np.ones((3, 2), dtype=np.uint8)),
        ("count", np.array([3.0, 600.0, 7.0])),
        ("flag", np.array([True, False, True])),
        ("text", ["a", "b", "zzz"]),
        ("either", ["a", "b", "a"]),
    ],
)
def test_an_array_of_the_kind_and_shape_is_taken(name: str, given: Any) -> None:
    compiled({"mass": READ, **ball(1)}, draws=DECLARED, num_scenes=3)
    document = scene({"mass": READ, **ball(1)}, draws=DECLARED, num_scenes=3)
    assert validate(document, draws={name: given}) == []
    assert compile_scene(document, draws={name: given}).num_scenes == 3


def test_given_integers_stand_for_the_floats_that_are_declared() -> None:
    document = scene({"pose": ["${half}", 0, 0], **ball(1)}, draws=HALF, num_scenes=2)
    [(_, node)] = compile_scene(document, draws={"half": [1, 2]}).draws
    assert repr(node.items) == "(1.0, 2.0)"  # pyright: ignore[reportAttributeAccessIssue]


def test_what_is_given_is_judged_by_the_fields_that_read_it() -> None:
    document = scene(ball("${half}"), draws=HALF, num_scenes=3)
    with pytest.raises(SceneError) as caught:
        compile_scene(document, draws={"half": [1, -1, 1]})
    [error] = [found for found in caught.value.diagnostics if found.severity == "error"]
    assert (error.code, error.path) == ("SC513", "entities.body.shapes[0].radius")
    assert "in scene 1 this is -1" in error.message


def test_the_draw_of_a_prefab_is_given_by_its_full_name(tmp_path: Path) -> None:
    (tmp_path / "ball.yaml").write_text(
        "scenecc: 1\ndraws: {half: {uniform: [0.1, 0.2]}}\nentities:\n"
        '  ball: {shapes: [{type: sphere, radius: "${half}"}]}\n'
    )
    (tmp_path / "two.yaml").write_text("scenecc: 1\nentities:\n  ball: {use: ball.yaml}\n")
    top = tmp_path / "scene.yaml"
    top.write_text("scenecc: 1\nnum_scenes: 2\nentities:\n  a: {use: ball.yaml}\n  b: {use: two.yaml}\n")
    plan = compile_scene(top, draws={"a/half": [1, 2], "b/ball/half": [3, 4]})
    assert radius(plan, "a/ball").tolist() == [1, 2]
    assert radius(plan, "b/ball/ball").tolist() == [3, 4]
    found = validate(top, draws={"b/ball/half": [[3, 4], [5, 6]]})
    assert [(d.code, d.message) for d in found] == [
        ("SC318", "the array given for this draw must be of shape (2,), as the file declares, not (2, 2)")
    ]
