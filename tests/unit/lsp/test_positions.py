"""Columns as clients count them, and paths of URIs."""

import pytest
from lsprotocol import types
from plugins.editor import Editor

from scenecc.lsp.analysis import SceneText
from scenecc.lsp.findings import findings_in, to_client
from scenecc.lsp.positions import Columns, path_of

LINE = "aé€😀b"

UNITS = {"utf-8": [0, 1, 3, 6, 10, 11], "utf-16": [0, 1, 2, 3, 5, 6], "utf-32": [0, 1, 2, 3, 4, 5]}


@pytest.mark.parametrize("encoding", UNITS)
def test_columns_convert_both_ways(encoding):
    columns = Columns(encoding)
    assert [columns.to_client(LINE, column) for column in range(6)] == UNITS[encoding]
    assert [columns.from_client(LINE, units) for units in UNITS[encoding]] == [*range(6)]
    assert columns.from_client(LINE, 10**9) == len(LINE)


def test_a_position_inside_a_character_is_after_it():
    assert Columns("utf-16").from_client("😀b", 1) == 1


def test_positions_past_the_end_are_at_the_end(tmp_path):
    text, columns = SceneText(tmp_path, "ab\r\ncd"), Columns()
    assert text.lines == ["ab", "cd"]
    assert columns.place(text, types.Position(0, 99)) == (0, 2)
    assert columns.place(text, types.Position(2**31 - 1, 7)) == (2**31 - 1, 0)


def test_file_uris_are_converted_to_paths(tmp_path):
    path = tmp_path / "a b é#?.yaml"
    assert path_of(path.as_uri()) == str(path)
    assert path_of("untitled:Untitled-1") is None
    assert path_of("https://example.org/a.yaml") is None
    assert path_of("file://[::1/a.yaml") is None


def test_line_breaks_are_those_of_yaml(tmp_path):
    """Not those of `str.splitlines`, of which there are more."""
    text = SceneText(tmp_path, "b: 1\rc: 2\r\nd: 3")
    assert text.key_span(("d",)) == (2, 0, 1)
    assert text.line(2) == "d: 3"
    # These are refused in scenes, and the parser counts them as ends of lines.
    assert SceneText(tmp_path, "a: 'x\u2028y'\nb: 1").leaves == []


def test_a_text_with_a_lone_surrogate_has_no_nodes(tmp_path):
    assert SceneText(tmp_path, "a: '\ud83d'\nb: 1").leaves == []


PREFAB = "scenecc: 1\nparams: {mass: {type: number, default: 1}}\nentities:\n  a:\n    mass: ${mass}\n"
BOX = "    shapes: [{type: box, half_size: [1, 1, 1]}]\n"


def test_an_error_in_a_prefab_is_shown_at_its_use(tmp_path):
    prefab = (PREFAB + BOX).replace("${mass}", '"${mass}"')
    text = "scenecc: 1\nentities:\n  b: {use: part.yaml, with: {mass: -1}}\n"
    editor = Editor(tmp_path, {"a.yaml": text}, {"part.yaml": prefab})
    view, path = editor.view, tmp_path / "a.yaml"
    (one,) = findings_in(view, path)
    found = to_client(view, view.texts[path], one, Columns())
    assert found.range.start.line == 2
    places = [one.location for one in found.related_information or ()]
    assert (tmp_path / "part.yaml").as_uri() in {place.uri for place in places}
    # An editor that has the prefab open shows it there too.
    editor = Editor(tmp_path, {"a.yaml": text, "part.yaml": prefab})
    view = editor.view
    (inside,) = findings_in(view, tmp_path / "part.yaml")
    assert (inside.line, inside.code) == (5, "SC104")


CUBES = """\
entities:
  table: {body_type: static, shapes: [{type: box}]}

  # the cube
  "the cube":
    shapes:
      - type: box
cameras:
"""


@pytest.mark.parametrize(
    ("line", "column", "path"),
    [
        (0, 0, ("entities",)),
        (1, 0, ("entities", "table")),
        (1, 9, ("entities", "table")),
        (1, 16, ("entities", "table", "body_type")),
        (1, 99, ("entities", "table", "shapes", 0, "type")),
        (3, 5, ("entities", "table", "shapes", 0, "type")),
        (4, 0, ("entities", "the cube")),
        (6, 12, ("entities", "the cube", "shapes", 0, "type")),
        (7, 0, ("cameras",)),
        (99, 99, ("cameras",)),
    ],
)
def test_a_position_gives_the_path_of_its_node(tmp_path, line, column, path):
    assert SceneText(tmp_path, CUBES).path_at(line, column) == path


def test_a_position_before_all_nodes_has_an_empty_path(tmp_path):
    assert SceneText(tmp_path, "# note\na: 1").path_at(0, 3) == ()
    assert SceneText(tmp_path, "").path_at(0, 0) == ()


def test_a_missing_node_has_no_span(tmp_path):
    text = SceneText(tmp_path, CUBES)
    assert text.key_span(("entities", "table")) == (1, 2, 7)
    for path in ((), ("entities", -1), ("entities", "table", "shapes", -1), ("entities", "table", "shapes", 1), (0, 0)):
        assert text.key_span(path) is None
