"""Where the parts of a document are written."""

from __future__ import annotations

import time

import pytest
from plugins.diagnostics import TakingSink
from plugins.nightly import assert_took

from scenecc.diagnostics.diagnostic import At, Location, Origin, Path
from scenecc.source import Document, Limits, read_dict, read_text
from scenecc.source.document import written_tree

TEXT = """\
scenecc: 1
x-size: &size [0.1, 0.2, 0.3]  # half
x-base: &base
  body_type: static   # no mass
  shapes: &shapes
    - type: box
      half_size: *size

entities:
  'a b':
    <<: *base
    pose: {p: [1, 2, 3], q: [1, 0, 0, 0]}
  ü: {<<: [*base, {mass: 1}], body_type: "dynamic",
      note: 'x'
      }
  block: |
    text
  list:
  - - 1
    - 2
  -
    x: 1
    y: {}
  alias: *shapes
  long: a string
    over lines
"""

PLACES: dict[tuple[Path, At], tuple[int, int, int]] = {
    (("scenecc",), "value"): (1, 10, 11),
    (("scenecc",), "key"): (1, 1, 8),
    (("x-size",), "value"): (2, 9, 30),
    (("x-size", 1), "value"): (2, 21, 24),
    (("x-size", 1), "key"): (2, 21, 24),
    (("x-base", "body_type"), "value"): (4, 14, 20),
    (("x-base", "shapes", 0), "value"): (6, 7, 16),
    (("x-base", "shapes", 0, "half_size", 2), "value"): (2, 26, 29),
    (("x-base", "shapes", 0, "half_size"), "key"): (7, 7, 16),
    (("entities", "a b"), "key"): (10, 3, 8),
    (("entities", "a b", "body_type"), "value"): (4, 14, 20),
    (("entities", "a b", "body_type"), "key"): (4, 3, 12),
    (("entities", "a b", "shapes", 0, "half_size", 0), "value"): (2, 16, 19),
    (("entities", "a b", "pose"), "value"): (12, 11, 42),
    (("entities", "a b", "pose", "q", 3), "value"): (12, 39, 40),
    (("entities", "alias", 0, "type"), "value"): (6, 13, 16),
    (("entities", "ü"), "value"): (13, 6, 52),
    (("entities", "ü", "mass"), "value"): (13, 26, 27),
    (("entities", "ü", "body_type"), "value"): (13, 42, 51),
    (("entities", "ü", "note"), "key"): (14, 7, 11),
    (("entities", "block"), "value"): (16, 10, 11),
    (("entities", "list"), "value"): (19, 3, 8),
    (("entities", "list", 0), "value"): (19, 5, 8),
    (("entities", "list", 0, 1), "value"): (20, 7, 8),
    (("entities", "list", 1, "x"), "value"): (22, 8, 9),
    (("entities", "list", 1), "value"): (22, 5, 9),
    (("entities", "long"), "value"): (25, 9, 17),
    # What does not exist is shown at the deepest part that does.
    (("entities", "a b", "pose", "p", 7), "value"): (12, 15, 24),
    (("entities", "a b", "mass"), "key"): (10, 3, 8),
    (("scenecc", "x", 1), "value"): (1, 10, 11),
    (("x-size", "x"), "value"): (2, 9, 30),
    ((), "value"): (1, 1, 11),
    (("none",), "key"): (1, 1, 11),
}


@pytest.fixture
def document(sink: TakingSink) -> Document:
    document = read_text(TEXT, "f.yaml", sink)
    assert document is not None
    return document


@pytest.mark.parametrize(("path", "at"), PLACES)
def test_nodes_are_located_by_path(document: Document, path: Path, at: At) -> None:
    place = document.locate(Origin("f.yaml", path), at)
    assert (place.line, place.column, place.end_column) == PLACES[path, at]
    assert place.file == "f.yaml"
    assert place.text == TEXT.split("\n")[(place.line or 0) - 1]


def test_a_dict_has_no_lines(sink: TakingSink) -> None:
    document = read_dict({"a": [1]}, sink)
    assert document is not None
    assert document.locate(Origin(None, ("a", 0)), "value") == Location(None)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_positions_work_with_all_line_ends(end: str, sink: TakingSink) -> None:
    document = read_text(end.join(["a: 1", "", "b: [2]", "c:", "  d: ü 3"]), None, sink)
    assert document is not None
    place = document.locate(Origin(None, ("c", "d")), "value")
    assert place == Location(None, 5, 6, 9, "  d: ü 3")


def test_positions_follow_the_latest_anchor(sink: TakingSink) -> None:
    document = read_text("a: &x k\nb: *x\nc: &x l\nd: *x\n*x : 3\n", None, sink)
    assert document is not None
    assert [document.locate(Origin(None, (key,)), "value").line for key in "abcd"] == [1, 1, 3, 3]
    assert document.locate(Origin(None, ("l",)), "value").line == 5


def test_many_position_lookups_are_fast(sink: TakingSink) -> None:
    document = read_text("\n".join(f"k{i}: [1, {{a: 2}}]" for i in range(10_000)), None, sink)
    assert document is not None
    start = time.process_time()
    for i in range(10_000):
        assert document.locate(Origin(None, (f"k{i}", 1, "a")), "key").line == i + 1
    assert_took(time.process_time() - start, most=2.0)


def test_positions_beyond_the_python_stack_are_handled(sink: TakingSink) -> None:
    deep = "[" * 460 + "1" + "]" * 460
    document = read_text(f"a: 1\nb: {deep}\n", None, sink, Limits(depth=1000))
    assert document is not None
    assert document.locate(Origin(None, ("a",)), "value").line == 1
    assert document.locate(Origin(None, ("b", *[0] * 460)), "value").line is not None


@pytest.mark.parametrize(
    ("text", "whole", "path", "span"),
    [
        ("a:\n  b: 1\n  c: 2\n", True, ("a", "c"), (2, 2, 3)),
        ("a:\n  b: 1\n  c: [1, {d: ", False, ("a", "c"), (2, 2, 3)),
        ("a:\n  b: 1\n  - c\nd: 1\n", False, ("a", "b"), (1, 2, 3)),
        ("a: [{b: 1, c: 2", False, ("a", 0, "b"), (0, 5, 6)),
        ("a: &x {b: *x}\n", True, ("a", "b"), (0, 7, 8)),
        ("a: {<<: {b: 1}}\n", True, ("a", "b"), (0, 9, 10)),
    ],
)
def test_the_tree_of_an_invalid_text_ends_at_the_error(text, whole, path, span) -> None:
    tree = written_tree(text)
    assert tree.is_whole is whole
    node = tree.root
    for step in path[:-1]:
        node = node.entries[step].node if isinstance(step, str) else node.items[step]
    assert node.entries[path[-1]].key == span


def test_the_tree_of_empty_and_too_deep_text_ends_early() -> None:
    assert written_tree("").is_whole
    assert written_tree("").root.entries == {}
    deep = written_tree("a: 1\nb: " + "[" * 5000)
    assert not deep.is_whole
    assert deep.root.entries["a"].node.text == "1"
