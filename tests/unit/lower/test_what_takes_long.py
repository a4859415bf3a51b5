"""Files that are small to read and would be long to think about: what is done for one thing is not done for each."""

from __future__ import annotations

import time
from typing import Any

import pytest
from unit.lower.scenes import BALL, codes, scene

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
    assert time.process_time() - start < 6


def test_a_long_chain_of_poses_that_vary() -> None:
    frames: dict[str, Any] = {"f0": {"pose": [0, 0, 0]}}
    for i in range(1, 400):
        frames[f"f{i}"] = {"pose": {"p": [{"cycle": [0, 1]}, 0, 0], "relative_to": f"f{i - 1}"}}
    start = time.process_time()
    document = scene({"pose": {"p": [0, 0, 0], "relative_to": "f399"}}, frames=frames, num_scenes=3)
    assert codes(document) == []
    assert time.process_time() - start < 15


def test_what_instances_select_is_bounded() -> None:
    inner = {"use": "scenecc:cube", "repeat": {"i": {"count": 3000}}, "scene_idxs": "${i}:"}
    document = {"scenecc": 1, "num_scenes": 60_000, "entities": {"a": inner}}
    assert [code for code, _ in codes(document, limits={"objects_times_scenes": 200_000})] == ["SC606"]
