"""Everything that a value can be, in few words."""

from __future__ import annotations

from typing import Any

import pytest

from scenecc.plan.display import format_color, format_value_bounds
from scenecc.variation.bounds import UNKNOWN, ValueBounds


@pytest.mark.parametrize(
    ("alternatives", "words"),
    [
        ((1, 2.5), "1 | 2.5"),
        ((True, False), "true | false"),
        (((0.1, 0.2), (0.3, 0.4)), "[0.1, 0.2] | [0.3, 0.4]"),
        (range(9), "9 values, 0 … 8"),
        ([(x, 1) for x in range(9)], "9 values, [0 … 8, 1]"),
        ([(x, x) for x in range(9)], "9 values, 0 … 8 each"),
        (("a" * 40, "b" * 40), "2 values"),
        ((1 / 3,), "0.33333"),
    ],
)
def test_alternatives_are_listed_while_they_are_few(alternatives: Any, words: str) -> None:
    assert format_value_bounds(ValueBounds.of(alternatives)) == words


def test_bounds_stand_around_dots() -> None:
    assert format_value_bounds(ValueBounds(None, 0.1, 0.5, True)) == "0.1 … 0.5"
    assert format_value_bounds(ValueBounds(None, (0, 0, 1), (1, 2, 1), True)) == "[0 … 1, 0 … 2, 1]"
    assert format_value_bounds(ValueBounds(None, (0, 0), (1, 1), True)) == "0 … 1 each"
    assert format_value_bounds(UNKNOWN) == "by an expression"


def test_a_colour_that_a_text_gives_is_written_as_in_files() -> None:
    assert format_color((0.6307571363461468, 0, 1, 1)) == "#d000ff"
    assert format_color((208 / 255, 0, 1, 1)) == "[0.81569, 0, 1, 1]"
    assert format_color((0, 0, 0, 128 / 255)) == "#00000080"
    assert format_color((0.5, 0, 0, 1)) == "[0.5, 0, 0, 1]"
    assert format_color((4, 0, 0, 1)) == "[4, 0, 0, 1]"
