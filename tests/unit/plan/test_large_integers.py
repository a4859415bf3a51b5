"""Integers that expressions may hold and arrays may not."""

from __future__ import annotations

import pytest

from scenecc import compile_scene, plan_text


@pytest.mark.parametrize("number", [2**63, -(2**63) - 1, 10**30, 2**255])
def test_a_constant_of_an_expression_comes_back(number: int) -> None:
    plan = compile_scene(
        {
            "scenecc": 1,
            "params": {"n": number},
            "draws": {"u": {"uniform": [0, 1]}},
            "entities": {"a": {"pose": ["${u + n % 7}", 0, 0], "shapes": [{"type": "sphere", "radius": 1}]}},
        }
    )
    assert compile_scene(plan_text(plan)) == plan
