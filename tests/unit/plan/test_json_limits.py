"""How much a plan may ask for."""

from __future__ import annotations

import difflib
import json
import time
from pathlib import Path
from typing import Any

import pytest
from plugins.nightly import assert_took

from scenecc import ScenePlan, compile_scene
from scenecc.diagnostics import Sink
from scenecc.plan.json_codec import plan_from_json, plan_to_json
from scenecc.source.limits import Limits

BALL = {"type": "sphere", "radius": 1}


@pytest.fixture(autouse=True)
def objects_are_those_in_all_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.source.limits._SCENES_PER_OBJECT", 1)


def codes(data: dict[str, Any], limit: int) -> list[str]:
    sink = Sink()
    plan_from_json(json.dumps(data), base=Path("/"), sink=sink, limits=Limits(objects=limit))
    return [found.code for found in sink.diagnostics()]


def plan(entities: dict[str, Any], num_scenes: int) -> dict[str, Any]:
    scene: ScenePlan = compile_scene({"scenecc": 1, "num_scenes": num_scenes, "entities": entities})
    return json.loads(plan_to_json(scene))


@pytest.mark.parametrize(("idxs", "counted"), [(":", 36), ("::3", 12), ([0, 5], 6)], ids=str)
def test_objects_are_counted_as_in_a_scene_file(idxs: Any, counted: int) -> None:
    # A shape of `shapes` is two in a plan: one collides, one is seen.
    shapes = {"shapes": [BALL, BALL], "visuals": [BALL]}
    data = plan({"a": shapes | {"scene_idxs": idxs}}, 12)
    assert codes(data, counted) == []
    assert codes(data, counted - 1) == ["SC712"]


def test_an_entity_of_several_structures_counts_those_that_are_picked() -> None:
    data = plan({"a": {"shapes": [BALL]}}, 3)
    (entity,) = data["entities"]
    (structure,) = entity["structures"]
    entity["structures"] = [structure, structure | {"collisions": structure["collisions"] * 5}]
    entity["pick"] = {"per_scene": [0, 1, 0]}
    assert codes(data, 1 + 5 + 1) == []
    assert codes(data, 1 + 5 + 0) == ["SC712"]


def test_no_scenes_are_listed_beyond_the_limit() -> None:
    data = plan({"a": {"shapes": [BALL]}}, 65_536)
    (entity,) = data["entities"]
    data["entities"] = [entity | {"name": f"e{i}", "scene_idxs": f"{i}:65536"} for i in range(5000)]
    started = time.process_time()
    assert codes(data, 1_000_000) == ["SC712"]
    assert_took(time.process_time() - started, most=3)


def test_no_hints_are_looked_for_beyond_the_most_findings(monkeypatch: pytest.MonkeyPatch) -> None:
    """A file of 16 MiB has a million keys, and to compare them with the known ones took minutes."""
    asked: list[str] = []
    monkeypatch.setattr(difflib, "get_close_matches", lambda key, *_, **__: asked.append(key) or [])
    data = plan({"a": {"shapes": [BALL]}}, 1) | {f"k{i}": 0 for i in range(3000)}
    assert set(codes(data, 100)) == {"SC703", "SC016"}
    assert len(asked) < 1100
