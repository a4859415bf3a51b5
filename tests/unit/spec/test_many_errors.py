"""Documents in which nearly everything is wrong."""

from __future__ import annotations

import time
import tracemalloc
from typing import Any

import pytest
from plugins.nightly import assert_took

from scenecc import validate

MANY = 30_000
BALL = {"shapes": [{"type": "sphere", "radius": 1}]}
HOSTILE: dict[str, dict[str, Any]] = {
    "shapes": {"entities": {"a": {"shapes": [1] * MANY}}},
    "entities": {"entities": {f"e{i}": 1 for i in range(MANY)}},
    "keys": {"entities": {"a": {f"k{i}": 1 for i in range(MANY)} | BALL}},
    "lacking": {"entities": {"a": {"shapes": [{"type": "sphere"} | {f"k{i}": 1 for i in range(MANY)}]}}},
    "late": {"entities": {f"e{i}": BALL for i in range(5000)} | {"last": {"shapes": [1] * MANY}}},
    "empty": {"entities": {"a": {"shapes": [{}] * MANY}}},
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_thousand_are_told(name: str) -> None:
    document = {"scenecc": 1, **HOSTILE[name]}
    validate({"scenecc": 1, "entities": {"a": BALL}})
    tracemalloc.start()
    started = time.process_time()
    found = [each.code for each in validate(document)]
    assert_took(time.process_time() - started, most=10)
    assert tracemalloc.get_traced_memory()[1] < 30 * 2**20
    tracemalloc.stop()
    assert len(found) == 1001
    assert found.count("SC016") == 1


def test_no_key_is_told_to_be_missing_that_is_there() -> None:
    shapes = [{**{f"k{i}": 1 for i in range(200)}, "type": "sphere", "radius": 1} for _ in range(100)]
    assert "SC102" not in {each.code for each in validate({"scenecc": 1, "entities": {"a": {"shapes": shapes}}})}


def test_thousands_of_notes_are_no_mistakes() -> None:
    notes = {f"x-{i}": i for i in range(5000)}
    assert validate({"scenecc": 1, "entities": {"a": {**BALL, **notes}}}) == []
    (found,) = validate({"scenecc": 1, "entities": {"a": {**BALL, **notes, "colour": 1}}})
    assert found.path == "entities.a.colour"
