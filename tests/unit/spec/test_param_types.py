"""Types of parameters."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from scenecc.spec.params import ParamType, is_color
from scenecc.spec.shapes import ColorText
from scenecc.variation.conversions import read_color


@pytest.mark.parametrize(
    ("text", "good"),
    [
        ("#12aBcD", True),
        ("#12aBcD80", True),
        ("#12aBcD8", False),
        ("#12aBc", False),
        ("12aBcD", False),
        ("#12aBcG", False),
        ("#12aBcD\n", False),
        ("#１2aBcD", False),
        ("", False),
    ],
)
def test_a_colour_is_the_same_text_everywhere(text: str, good: bool) -> None:
    assert is_color(text) is good
    assert (read_color(text) is not None) is good
    try:
        TypeAdapter(ColorText).validate_python(text)
    except ValidationError:
        assert not good
    else:
        assert good


@pytest.mark.parametrize(
    ("wanted", "value", "good"),
    [
        (ParamType("n", "integer"), 2.0, True),
        (ParamType("n", "integer"), 2.5, False),
        (ParamType("n", "integer", high=1), 2.0, False),
        (ParamType("n", "choice", options=(1, "a")), 1.0, True),
        (ParamType("n", "choice", options=(True, "a")), 1.0, False),
        (ParamType("n", "vector", components=2), [0.0, 1.0], True),
        (ParamType("n", "vector", components=2), [0.0], False),
    ],
)
def test_drawn_numbers_are_floats_however_they_are_written(wanted: ParamType, value: Any, good: bool) -> None:
    assert (wanted.drawn_misfit(value) is None) is good
