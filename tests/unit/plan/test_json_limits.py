"""How much a plan may ask for."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from plugins.nightly import assert_took

from scenecc import ScenePlan, compile_scene
from scenecc.diagnostics import Sink
from scenecc.plan.json_codec import plan_from_json, plan_to_json
from scenecc.source.limits import Limits

BALL = {"type": "sphere", "radius": 1}


def codes(data: dict[str, Any], limit: int) -> list[str]:
    sink = Sink()
    plan_from_json(json.dumps(data), base=Path("/"), sink=sink, limits=Limits(objects=limit))
    return [found.code for found in sink.diagnostics()]


def plan(entities: dict[str, Any], num_scenes: int) -> dict[str, Any]:
    scene: ScenePlan = compile_scene({"scenecc": 1, "num_scenes": num_scenes, "entities": entities})
    return json.loads(plan_to_json(scene))


def test_no_scenes_are_listed_beyond_the_limit() -> None:
    data = plan({"a": {"shapes": [BALL]}}, 65_536)
    (entity,) = data["entities"]
    data["entities"] = [entity | {"name": f"e{i}", "scene_idxs": f"{i}:65536"} for i in range(5000)]
    started = time.process_time()
    assert codes(data, 1_000_000) == ["SC712"]
    assert_took(time.process_time() - started, most=3)
