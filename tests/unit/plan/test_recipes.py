"""Recipes in a plan's JSON: what is wrong is told at its place, and what is right can be reset."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from plugins.sample_plans import ROOT, SAMPLES

from scenecc import compile_scene, plan_text, validate
from scenecc.diagnostics import Sink
from scenecc.plan import ScenePlan
from scenecc.plan.json_codec import plan_from_json, plan_to_json
from scenecc.plan.recipes import MAX_RECIPE_DEPTH

KEY = {"section": "entities", "name": "crate", "path": "pose.p"}
POSE: dict[str, Any] = {"type": "const", "data": [0, 0, 0, 1, 0, 0, 0]}
IDENTITY = [1, 0, 0, 0]


def read(data: dict[str, Any]) -> tuple[ScenePlan | None, list[tuple[str, str]]]:
    sink = Sink()
    plan = plan_from_json(json.dumps(data), base=ROOT, sink=sink)
    return plan, [(found.code, found.path) for found in sink.diagnostics()]


def with_recipe(recipe: Any, **more: Any) -> dict[str, Any]:
    data = json.loads(plan_to_json(SAMPLES["drawn"]()))
    data["entities"][1]["pose"]["recipe"] = recipe
    return data | more


def posed(p: Any, q: Any = IDENTITY) -> dict[str, Any]:
    return {"type": "posed", "p": p, "q": q}


def drawn(**more: Any) -> dict[str, Any]:
    return {"type": "drawn", "kind": "uniform", "low": 0, "high": 1, "shape": [3], "key": KEY, **more}


def computed(text: str, **more: Any) -> dict[str, Any]:
    return {"type": "computed", "template": {"text": text, **more}, "shape": []}


def nested(depth: int) -> Any:
    item: Any = [0, 0, 0]
    for _ in range(depth):
        item = {"type": "cycled", "items": [item]}
    return item


@pytest.mark.parametrize(
    ("recipe", "where"),
    [
        ([], ""),
        ({}, "type"),
        ({"type": "pose"}, "type"),
        ({"type": ["posed"]}, "type"),
        ({"type": "const"}, ""),
        ({**POSE, "x": 1}, "x"),
        ({"type": "const", "data": None}, "data"),
        ({"type": "const", "data": [1e999]}, "data[0]"),
        ({"type": "const", "data": [2**63]}, "data[0]"),
        ({"type": "const", "data": [0, 0, 0]}, ""),
        ({"type": "const", "data": [0, 0, 0, 1, 0, 0, "0"]}, ""),
        ({"type": "const", "data": [0, 0, 0, 1, 0, 0, [0]]}, ""),
        ({"type": "cycled", "items": []}, "items"),
        ({"type": "cycled", "items": POSE}, "items"),
        ({"type": "cycled", "items": [POSE, [0, 0, 0]]}, ""),
        ({"type": "stacked", "items": [0, [0, 0]]}, ""),
        ({"type": "rows", "scene_idxs": [0, 1], "items": [POSE]}, "items"),
        ({"type": "rows", "scene_idxs": [1, 0], "items": [POSE, POSE]}, "scene_idxs"),
        ({"type": "rows", "scene_idxs": [0.5], "items": [POSE]}, "scene_idxs"),
        ({"type": "chosen", "items": [POSE], "key": KEY, "weights": [1, 2]}, "weights"),
        ({"type": "chosen", "items": [POSE], "key": KEY, "weights": [0]}, "weights"),
        ({"type": "chosen", "items": [POSE], "key": KEY, "weights": [-1]}, "weights"),
        ({"type": "chosen", "items": [POSE], "key": {**KEY, "section": "sky"}}, "key.section"),
        ({"type": "chosen", "items": [POSE], "key": {"name": "x", "path": ""}}, "key"),
        ({"type": "chosen", "items": [POSE], "key": KEY, "word": -1}, "word"),
        ({"type": "chosen", "items": [POSE], "key": KEY, "word": True}, "word"),
        (posed([0, 0]), ""),
        (posed([0, 0, 0], {"type": "from_rpy", "angles": [0]}), ""),
        (posed(drawn(kind="gauss")), "p.kind"),
        (posed(drawn(shape=[2])), ""),
        (posed(drawn(shape=[0])), "p.shape"),
        (posed(drawn(shape=[10**9])), "p.shape"),
        (posed(drawn(low=[0, 0])), ""),
        (posed(drawn(kind="normal", clip=[0])), "p.clip"),
        (posed({"type": "shared", "name": "nobody"}), "p.name"),
        (posed({"type": "shared", "name": "u"}), ""),
        (posed([computed("${")] * 3), "p[0].template.text"),
        (posed([computed("${x}")] * 3), "p[0].template"),
        (posed([computed("${u.__class__}")] * 3), "p[0].template.text"),
        (posed([{**computed("${x}"), "reads": [["x"]]}] * 3), "p[0].reads"),
        (posed([{**computed("${x}"), "reads": [["x", "nobody"]]}] * 3), "p[0].template"),
        (posed([computed("${a}", constants=[1])] * 3), "p[0].template.constants"),
        (posed(nested(MAX_RECIPE_DEPTH)), None),
    ],
)
def test_what_is_invalid_is_reported_at_its_place(recipe: Any, where: str | None) -> None:
    plan, found = read(with_recipe(recipe))
    assert plan is None
    ((code, path),) = found
    assert code == "SC701"
    expected = f"entities[1].pose.recipe.{where}" if where else "entities[1].pose.recipe"
    assert path.startswith("entities[1].pose.recipe")
    assert expected.startswith(path) or path.startswith(expected)


@pytest.mark.parametrize(
    "recipe",
    [
        POSE,
        posed(drawn(kind="normal", low=[0, 0, 0], clip=[-1, [1, 1, 1]])),
        posed([computed("${u + k}", constants={"k": 0.5}), computed("${scene / num_scenes}"), 0]),
        posed([{**computed("${x}"), "reads": [["x", "u"]]}, 0, 0], {"type": "random_rotated", "key": KEY}),
        posed(nested(MAX_RECIPE_DEPTH // 2 - 2)),
    ],
)
def test_what_is_right_is_read_and_written_alike(recipe: Any) -> None:
    plan, found = read(with_recipe(recipe))
    assert plan is not None, found
    again, _ = read(json.loads(plan_to_json(plan)))
    assert again == plan


def test_only_what_a_reset_changes_has_a_recipe() -> None:
    data = with_recipe(POSE)
    body = data["entities"][1]["structures"][0]
    body["sleep_threshold"] = {"value": 1.0, "recipe": {"type": "const", "data": 1.0}}
    assert read(data) == (None, [("SC701", "entities[1].structures[0].sleep_threshold.recipe")])


def test_the_wrong_count_of_rows_is_told_beside_a_recipe_too() -> None:
    data = with_recipe(POSE)
    data["entities"][1]["pose"]["per_scene"].pop()
    assert read(data) == (None, [("SC701", "entities[1].pose.per_scene")])
    data["entities"][1]["pose"] = {"value": [0, 0, 0], "recipe": POSE}
    assert read(data) == (None, [("SC701", "entities[1].pose")])
    data["entities"][1]["pose"] = {"recipe": POSE}
    assert read(data) == (None, [("SC701", "entities[1].pose")])


@pytest.mark.parametrize(
    ("draws", "where"),
    [
        ([], "draws"),
        ({"u": 1}, "draws.u"),
        ({"u": {"type": "shared", "name": "u"}}, "draws.u.name"),
        ({"u": {"type": "shared", "name": "w"}, "w": {"type": "const", "data": 1}}, "draws.u.name"),
    ],
)
def test_a_shared_draw_reads_those_before_it(draws: Any, where: str) -> None:
    plan, found = read(with_recipe(POSE, draws=draws))
    assert plan is None
    ((code, path),) = found
    assert code == "SC701"
    assert path.startswith("draws")
    assert where.startswith(path) or path.startswith(where)


def test_many_shared_draws_of_one_another_are_read_in_no_time() -> None:
    first = {"type": "const", "data": 1.0}
    draws: dict[str, Any] = {"d0": first}
    for index in range(1, 60):
        before = {"type": "shared", "name": f"d{index - 1}"}
        draws[f"d{index}"] = {"type": "cycled", "items": [before, before]}
    data = json.loads(plan_to_json(SAMPLES["drawn"]()))
    data["draws"] |= draws
    plan, found = read(data)
    assert plan is not None, found


def test_a_stack_of_stacks_is_read_in_no_time() -> None:
    item: Any = 1.0
    for _ in range(MAX_RECIPE_DEPTH // 2 - 3):
        item = {"type": "stacked", "items": [item]}
    _, found = read(with_recipe(item))
    assert found == [("SC701", "entities[1].pose.recipe")]


def test_a_plan_from_json_is_reset_as_the_plan_that_was_written() -> None:
    pytest.importorskip("sapien")
    from scenecc.backends.sapien import instantiate

    plan = SAMPLES["drawn"]()
    again, _ = read(json.loads(plan_to_json(plan, base=ROOT)))
    assert again is not None
    assert again == plan
    batches = [instantiate(one, Sink(), render=False) for one in (plan, again)]
    poses: list[list[Any]] = []
    for batch in batches:
        assert batch is not None
        seen: list[Any] = []
        for seed in (None, 5, 5, 11):
            batch.reset(seed)
            seen.append(np.stack([scene.entities[1].pose.p for scene in batch.scenes]))
        batch.close()
        poses.append(seen)
    for first, second in zip(*poses, strict=True):
        np.testing.assert_array_equal(first, second)
    assert (poses[0][1] == poses[0][2]).all()
    assert (poses[0][0] == poses[0][3]).all()
    assert (poses[0][0] != poses[0][1]).any()


def test_a_plan_has_every_draw_that_its_recipes_read() -> None:
    ball = {"pose": [{"uniform": ["${b}", 5]}, 0, 1], "shapes": [{"type": "sphere", "radius": 0.1}]}
    document = {"scenecc": 1, "num_scenes": 3, "draws": {"a": "${scene}", "b": "${a}"}, "entities": {"ball": ball}}
    plan = compile_scene(document)
    assert [name for name, _ in plan.draws] == ["a", "b"]
    assert validate(plan_text(plan)) == []
