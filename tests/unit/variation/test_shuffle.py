"""`shuffle`: a random order of a list, one a scene, as docs/reference/draws.md has it."""

from __future__ import annotations

import io
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


@pytest.mark.parametrize("count", [1, 2, 3, 7, 8, 40])
def test_it_is_the_order_of_the_words_of_the_items(count: int) -> None:
    values = [float(i) for i in range(count)]
    plan = compiled(
        f"num_scenes: 50\ndraws: {{xs: {{shuffle: {values}}}}}\nentities:\n"
        f'  b: {{repeat: {{i: {{count: {count}}}}}, pose: ["${{xs[i]}}", 0, 0], {BALL}}}\n',
        seed=11,
    )
    found = np.stack([np.broadcast_to(entity.pose.data[:, 0], 50) for entity in plan.entities], axis=1)
    u = units(words(11, Key("draws", "xs", ""), np.arange(50), 0, count)).tolist()
    assert found.tolist() == [sorted(values, key=lambda value, row=row: row[int(value)]) for row in u]


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
        (str([1] * 10_001), "SC106"),
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


@pytest.mark.parametrize("count", [3, 12])
def test_texts_of_a_long_list_can_name_materials(count: int) -> None:
    names = [f"m{i}" for i in range(count)]
    materials = ", ".join(f"{name}: {{visual: {{base_color: [{i / count}, 0, 0]}}}}" for i, name in enumerate(names))
    plan = compiled(
        f"num_scenes: 20\nmaterials: {{{materials}}}\ndraws: {{order: {{shuffle: {names}}}}}\nentities:\n"
        f'  b: {{repeat: {{i: {{count: {count}}}}}, pose: ["${{i}}", 0, 0], material: "${{order[i]}}", {BALL}}}\n'
    )
    rows = np.stack(
        [np.broadcast_to(next(iter(entity.bodies)).visuals[0].material.data, 20) for entity in plan.entities], axis=1
    )
    assert (np.sort(rows, axis=1) == np.arange(count)).all()
    assert compile_scene(io.StringIO(plan_to_json(plan))) == plan


def test_a_color_keeps_its_alpha_and_a_plan_takes_plain_values_alone() -> None:
    plan = compiled(f"num_scenes: 9\nentities: {{b: {{color: {{shuffle: [0.1, 0.5, 0.9]}}, {BALL}}}}}\n")
    rows = plan.visual_materials[0].base_color.data
    assert (np.sort(rows[:, :3], axis=1) == [0.1, 0.5, 0.9]).all()
    assert (rows[:, 3] == 1).all()
    text = plan_to_json(plan)
    assert '"shuffled"' in text
    broken = text.replace('"items": [0.1', '"items": [{"type": "const", "data": 1}')
    assert broken != text
    with pytest.raises(SceneError, match="SC701"):
        compile_scene(io.StringIO(broken))


def test_what_is_above_the_orders_that_there_can_be_is_an_error() -> None:
    values = [1, 2, 3, 4, 5, 6, 7, 8, -9]
    with pytest.raises(SceneError, match="SC"):
        compiled(f'draws: {{xs: {{shuffle: {values}}}}}\nentities: {{b: {{mass: "${{xs[0] - 100}}", {BALL}}}}}\n')
