"""Joints that start at a limit, for they cannot start at 0: one warning an entity."""

from __future__ import annotations

from typing import Any

from scenecc import validate

BALL = [{"type": "sphere", "radius": 0.1}]


def leg(name: str) -> dict[str, Any]:
    return {"name": name, "joint": {"name": f"to_{name}", "type": "revolute", "limits": [0.5, 1]}, "shapes": BALL}


def test_several_joints_that_start_at_a_limit_are_one_warning() -> None:
    entities = {
        "spider": {"root": {"name": "base", "shapes": BALL, "children": [leg("a"), leg("b"), leg("c")]}},
        "crab": {"root": {"name": "base", "shapes": BALL, "children": [leg("a"), leg("b")]}, "qpos": {"to_a": 0.6}},
    }
    found = validate({"scenecc": 1, "entities": entities})
    starts = "starts at its limit 0.5, for it cannot start at 0"
    assert [(one.code, one.path, one.message) for one in found] == [
        ("SC518", "entities.spider", f"`to_a` {starts} (and 2 others like it)"),
        ("SC518", "entities.crab.qpos", f"`to_b` {starts}"),
    ]
