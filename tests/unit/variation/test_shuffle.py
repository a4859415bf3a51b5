"""`shuffle`: a random order of a list, one a scene, as docs/draws.md has it."""

from __future__ import annotations

import io
from itertools import permutations
from math import factorial
from typing import Any

import numpy as np
import pytest

from scenecc import SceneError, compile_scene, load_scene, validate
from scenecc.plan.json_codec import plan_to_json
from scenecc.variation.evaluation import units, words
from scenecc.variation.nodes import Key

BALL = "shapes: [{type: sphere, radius: 0.1}]"


def compiled(text: str, **options: Any) -> Any:
    return compile_scene(io.StringIO("scenecc: 1\n" + text), **options)


@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_it_is_the_order_that_the_draw_of_a_scene_names(count: int) -> None:
    values = [float(i) for i in range(count)]
    plan = compiled(
        f"num_scenes: 50\ndraws: {{xs: {{shuffle: {values}}}}}\nentities:\n"
        f'  b: {{repeat: {{i: {{count: {count}}}}}, pose: ["${{xs[i]}}", 0, 0], {BALL}}}\n',
        seed=11,
    )
    found = np.stack([np.broadcast_to(entity.pose.data[:, 0], 50) for entity in plan.entities], axis=1)
    u = units(words(11, Key("draws", "xs", ""), np.arange(50), 0, 1))[:, 0]
    orders = list(permutations(values))
    assert found.tolist() == [list(orders[int(one * factorial(count))]) for one in u]


def test_every_order_is_alike_likely() -> None:
    plan = compiled(f"num_scenes: 6000\nentities:\n  b: {{pose: {{p: {{shuffle: [1, 2, 3]}}}}, {BALL}}}\n")
    _, counts = np.unique(plan.entities[0].pose.data[:, :3], axis=0, return_counts=True)
    assert len(counts) == 6
    assert ((counts - 1000.0) ** 2 / 1000.0).sum() < 20.5  # 1 in 1000, of five degrees of freedom


def test_texts_are_shuffled_and_a_reset_draws_another_order() -> None:
    text = (
        'num_scenes: 8\nparams: {third: "#0000ff"}\n'
        'draws: {colors: {shuffle: ["#ff0000", "#00ff00", "${third}"]}, xs: {shuffle: [0, 1]}}\nentities:\n'
        f'  b: {{repeat: {{i: {{count: 2}}}}, color: "${{colors[i]}}", pose: ["${{xs[i]}}", "${{i}}", 1], {BALL}}}\n'
    )
    plan = compiled(text)
    assert compile_scene(io.StringIO(plan_to_json(plan))) == plan
    assert {material.base_color.numbers() for material in plan.visual_materials}
    with load_scene(plan, render=False) as batch:
        batch.reset(seed=3)
        fresh = compiled(text, seed=3)
        for entity, other in zip(batch.entities.values(), fresh.entities, strict=True):
            assert np.array_equal(entity.pose[:, 0], other.pose.data[:, 0])
        assert (batch.entities["b_0"].pose[:, 0] + batch.entities["b_1"].pose[:, 0] == 1).all()


@pytest.mark.parametrize(
    ("written", "code"),
    [
        ("[]", "SC106"),
        ("[1, 2, 3, 4, 5, 6, 7, 8]", "SC106"),
        ("3", "SC103"),
        ("[1, a]", "SC103"),
        ("[1, {uniform: [0, 1]}]", "SC116"),
        ('[1, "${scene}"]', "SC116"),
        ("[1, 2], weights: [1, 1]", "SC117"),
    ],
)
def test_what_cannot_be_shuffled(written: str, code: str) -> None:
    text = f'scenecc: 1\ndraws: {{xs: {{shuffle: {written}}}}}\nentities: {{b: {{mass: "${{xs[0]}}", {BALL}}}}}\n'
    assert [one.code for one in validate(io.StringIO(text))] == [code]


def test_a_vector_takes_its_own_number_of_values() -> None:
    with pytest.raises(SceneError, match="SC106"):
        compiled(f"entities: {{b: {{pose: {{p: {{shuffle: [1, 2]}}}}, {BALL}}}}}\n")
