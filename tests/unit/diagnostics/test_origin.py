"""A part of a scalar, found in the line where the scalar is written."""

from __future__ import annotations

import pytest

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Origin
from scenecc.source import make_limits, read_text

CASES = [
    ("a: ab${x}c", "x"),
    ('a: "ab${x}c"', "x"),
    ("a: 'it''s ${x}'", "x"),
    (r'a: "\u0024\x7b\t${x}"', "x"),
    ("a: &name !!str ${x}", "x"),
    ("{b: 1, a: '${x}'}", "x"),
    ('a: "${x}"  # "${y}"', "x"),
]


@pytest.mark.parametrize(("text", "part"), CASES)
def test_the_given_part_of_a_scalar_is_underlined(text: str, part: str) -> None:
    sink = Sink()
    document = read_text(text, "a.yaml", sink, make_limits(), None)
    assert document is not None
    sink.locate = document.locate
    start = document.data["a"].index("{x}") + 1
    sink.report("SC118", "wrong", Origin("a.yaml", ("a",)), span=(start, start + len(part)))
    (found,) = sink.diagnostics()
    line = found.location.text or ""
    assert line[(found.column or 0) - 1 : (found.location.end_column or 0) - 1] == part
    assert (found.column or 0) - 1 == line.index("{x}") + 1


@pytest.mark.parametrize("text", ["a: >-\n  ${x}\n", 'a: "first line\n  ${x}"\n', "a: first line\n  ${x}\n"])
def test_a_part_beyond_the_first_line_underlines_the_scalar(text: str) -> None:
    sink = Sink()
    document = read_text(text, "a.yaml", sink, make_limits(), None)
    assert document is not None
    sink.locate = document.locate
    start = document.data["a"].index("{x}") + 1
    sink.report("SC118", "wrong", Origin("a.yaml", ("a",)), span=(start, start + 1))
    (found,) = sink.diagnostics()
    assert (found.line, found.column) == (1, 4)


def test_an_origin_in_a_dict_has_no_line() -> None:
    sink = Sink()
    sink.report("SC118", "wrong", Origin(None, ("a",)), span=(3, 4))
    assert sink.diagnostics()[0].line is None
