"""`once`: a form whose value is drawn when the scenes are built, and by no reset."""

from __future__ import annotations

import io
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np
import pytest

import scenecc
from scenecc import compile_scene, load_scene, validate
from scenecc.plan.json_codec import plan_to_json

BALL = "shapes: [{type: sphere, radius: 0.1}]"

SCENE = f"""
scenecc: 1
num_scenes: 6
draws:
  half: ONCE{{uniform: [0.5, 1]}}END
  twice: "${{2 * half}}"
  mixed: {{uniform: [ONCE{{uniform: [0, 1]}}END, 2]}}
entities:
  a:
    mass: ONCE{{uniform: [1, 2]}}END
    linear_damping: "${{twice}}"
    angular_damping: "${{mixed}}"
    color: ONCE{{choice: ["#ff0000", "#00ff00"]}}END
    pose: {{p: [ONCE{{uniform: [0, 1]}}END, {{uniform: [0, 1]}}, ONCE"${{mixed}}"END], q: ONCEuniformEND}}
    {BALL}
  b:
    pose: ONCE{{choice: [[0, 0, 3], {{p: [0, 0, {{uniform: [4, 5]}}], rpy: [0, 0, {{uniform: [0, 1]}}]}}]}}END
    linear_velocity: {{choice: [ONCE{{uniform: [[0, 0, 0], [1, 1, 1]]}}END, [2, 2, 2]]}}
    {BALL}
"""
ONCE = SCENE.replace("ONCE", "{once: ").replace("END", "}")


def compiled(text: str, **options: Any) -> Any:
    return compile_scene(io.StringIO(text), **options)


def test_a_build_draws_what_the_form_alone_draws() -> None:
    with_once, without = (compiled(text, seed=5) for text in (ONCE, SCENE.replace("ONCE", "").replace("END", "")))
    for one, other in zip(with_once.entities, without.entities, strict=True):
        assert one.pose.data.tobytes() == other.pose.data.tobytes()
        for field in ("mass", "linear_damping", "angular_damping", "linear_velocity"):
            ours, theirs = getattr(one.structures[0], field), getattr(other.structures[0], field)
            assert ours == theirs or ours.data.tobytes() == theirs.data.tobytes()
    assert [one.base_color.data.tolist() for one in with_once.visual_materials] == [
        one.base_color.data.tolist() for one in without.visual_materials
    ]


def test_a_reset_keeps_it_and_draws_the_rest() -> None:
    plan = compiled(ONCE)
    assert compile_scene(io.StringIO(plan_to_json(plan))) == plan
    a = plan.entities[0].structures[0]
    assert {field: getattr(a, field).recipe is None for field in ("mass", "linear_damping", "angular_damping")} == {
        "mass": True, "linear_damping": True, "angular_damping": True,
    }  # fmt: skip
    with load_scene(plan, render=False) as batch:
        before = {name: one.pose for name, one in batch.entities.items()}
        speeds = batch.entities["b"].linear_velocity
        batch.reset(seed=8)
        a, b = batch.entities["a"].pose, batch.entities["b"].pose
        assert np.array_equal(b, before["b"])
        assert (a != before["a"]).any(axis=0).tolist() == [False, True, False, *[False] * 4]
        # Which of them is drawn anew; the first is what it was.
        same = (batch.entities["b"].linear_velocity == speeds).all(axis=1)
        again = (batch.entities["b"].linear_velocity == 2).all(axis=1)
        assert not same.all()
        assert (same | again | (speeds == 2).all(axis=1)).all()
        with pytest.raises(ValueError, match="a reset cannot change the shared draw 'half'"):
            batch.reset(draws={"half": np.ones(6)})


@pytest.mark.parametrize(
    "given", ["{once: {uniform: [1, 2]}}", "{once: {per_scene: [{uniform: [1, 2]}, 5]}}", '"${size}"']
)
def test_a_prefab_is_given_it(given: str, tmp_path: Path) -> None:
    (tmp_path / "thing.yaml").write_text(
        f'scenecc: 1\nparams: {{m: 1}}\nentities: {{it: {{mass: "${{m}}", {BALL}}}}}\n'
    )
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "scenecc: 1\nnum_scenes: 3\ndraws: {size: {once: {uniform: [1, 2]}}}\n"
        f'entities:\n  x: {{scene_idxs: "1:", use: thing.yaml, with: {{m: {given}}}}}\n'
        f'  y: {{mass: "${{size}}", {BALL}}}\n'
    )
    [body] = compile_scene(scene).entities[0].bodies
    mass = body.mass
    assert mass is not None
    assert mass.may_vary
    assert mass.recipe is None


def test_what_is_placed_keeps_the_keys_under_once() -> None:
    place = "{on: table, region: [[-0.4, -0.3], [-0.2, 0.3]], yaw: {once: {uniform: [0, 3]}}}"
    text = f"""
scenecc: 1
num_scenes: 8
entities:
  table: {{body_type: static, shapes: [{{type: box, half_size: [0.5, 0.5, 0.1]}}]}}
  a: {{place: {place}, shapes: [{{type: box, half_size: [0.1, 0.02, 0.02]}}]}}
  b: {{place: {{on: table, at: {{once: {{uniform: [[0, 0], [0.3, 0.3]]}}}}}}, shapes: [{{type: sphere, radius: 0.02}}]}}
"""
    with scenecc.load_scene(io.StringIO(text), render=False) as batch:
        a, b = (batch.entities[name].pose for name in "ab")
        batch.reset(seed=5)
        assert np.allclose(batch.entities["a"].pose[:, 3:], a[:, 3:])
        assert not np.allclose(batch.entities["a"].pose[:, :2], a[:, :2])
        assert np.array_equal(batch.entities["b"].pose, b)


def test_a_constant_that_an_expression_gives_needs_no_other_file() -> None:
    plan = compiled(f'scenecc: 1\nparams: {{m: 2}}\nentities: {{a: {{mass: {{once: "${{m}}"}}, {BALL}}}}}\n')
    assert plan.entities[0].structures[0].mass.data.tolist() == [2]


@pytest.mark.parametrize(
    ("written", "code"),
    [
        ("{once: 3}", "SC117"),
        ("{once: [1, 2]}", "SC103"),
        ("{once: {once: {uniform: [1, 2]}}}", "SC117"),
        ("{once: {choice: [1, {once: {uniform: [1, 2]}}]}}", "SC117"),
        ("{once: {uniform: [1, 2]}, weights: [1]}", "SC117"),
        ("{once: {uniform: [1, 2]}, choice: [1]}", "SC111"),
        ("{once: {uniform: [-1, 2]}}", "SC104"),
        ("{once: {unifrom: [1, 2]}}", "SC103"),
    ],
)
def test_what_stands_in_no_once(written: str, code: str) -> None:
    text = f"scenecc: 1\nentities:\n  a:\n    mass: {written}\n{indent(BALL, '    ')}\n"
    assert [one.code for one in validate(io.StringIO(text))] == [code]
