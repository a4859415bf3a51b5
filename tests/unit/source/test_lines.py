"""Lines and columns of a text."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenecc.diagnostics.diagnostic import Location
from scenecc.source.text import TextLines

TEXTS = st.text(st.sampled_from("ab \n\r\tü\U0001f600\x0b\u2028"), max_size=300)


@given(TEXTS, st.data())
def test_a_position_points_to_its_character(text: str, data: st.DataObject) -> None:
    offset = data.draw(st.integers(0, len(text)))
    lines = TextLines(None, text)
    line, column = lines.position(offset)
    found = (lines.line(line) + "\n")[column]
    expected = text[offset] if offset < len(text) else "\n"
    assert found == ("\n" if expected in "\r\n" else expected)


@given(TEXTS, st.lists(st.integers(0, 320), max_size=8))
def test_lines_can_be_read_in_any_order(text: str, asked: list[int]) -> None:
    parts = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    lines = TextLines(None, text)
    assert [lines.line(i) for i in asked] == [parts[i] if i < len(parts) else "" for i in asked]
    assert [lines.is_last(i) for i in asked] == [not "".join(parts[i + 1 :]).strip() for i in asked]


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        ((1, 3), (2, 4)),
        ((1, None), (2, 5)),
        ((1, 99), (2, 6)),
        ((2, 2), (3, 4)),
        ((5, None), (6, 7)),
        ((9, 9), (10, 11)),
    ],
)
def test_a_location_underlines_the_right_columns(columns: tuple[int, int | None], expected: tuple[int, int]) -> None:
    assert TextLines("f", "x\nabcd \n").location(1, *columns) == Location("f", 2, *expected, "abcd ")
