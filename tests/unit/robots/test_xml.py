"""XML of robots: places, bounds, and files from strangers."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plugins.nightly import assert_took

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Origin
from scenecc.robots.files import FileReport, read_robot_bytes
from scenecc.robots.xml import SourceElement, XmlBounds, parse_xml

if TYPE_CHECKING:
    from pathlib import Path

SCENE = Origin("scene.yaml", ("entities", "arm", "urdf"))


def parse(data: bytes, bounds: XmlBounds | None = None) -> tuple[SourceElement | None, list[str]]:
    sink = Sink()
    root = parse_xml(data, "r.urdf", FileReport(sink, SCENE), bounds)
    return root, [str(diagnostic) for diagnostic in sink.diagnostics()]


def parsed(data: bytes) -> SourceElement:
    root, found = parse(data)
    assert root is not None, found
    assert not found
    return root


def test_locations_count_lines_and_characters() -> None:
    text = '<?xml version="1.0" encoding="latin-1"?>\r\n<ré a="1"\r\n  bü="x\r\ny" >\r\n é<b x="é" y=\'2 3\'/>t</ré>'
    root = parsed(text.encode())
    assert (root.location.line, root.location.column, root.location.end_column) == (2, 1, 4)
    assert (root.at("a").line, root.at("a").column, root.at("a").end_column) == (2, 8, 9)
    assert (root.at("bü").line, root.at("bü").column, root.at("bü").end_column) == (3, 7, 8)
    inner = root.children[0]
    assert (inner.location.line, inner.location.column) == (5, 3)
    assert (inner.at("y").line, inner.at("y").column, inner.at("y").end_column) == (5, 15, 18)
    assert inner.at("y").text == " é<b x=\"é\" y='2 3'/>t</ré>"
    assert inner.at("z") == inner.location
    assert root.text == "ét"


def test_children_are_found_by_name() -> None:
    root = parsed(b"<a><b n='1'/><c/><b n='2'/></a>")
    assert [child.attributes["n"] for child in root.all("b")] == ["1", "2"]
    found = root.find("b")
    assert found is not None
    assert found.attributes == {"n": "1"}
    assert root.find("d") is None


def test_a_byte_order_mark_and_predefined_entities_are_read() -> None:
    assert parsed(b"\xef\xbb\xbf<a b='&lt;&#65;&amp;'>&gt;</a>").attributes == {"b": "<A&"}


@given(st.lists(st.text("abc é\n\t", max_size=5), min_size=1, max_size=6))
def test_attribute_locations_are_found_on_any_line(gaps: list[str]) -> None:
    blanks = ["".join(c for c in gap if c in " \n\t") or " " for gap in gaps]
    text = (
        "<e"
        + "".join(
            f'{blank}k{i}="{gap.strip() or "v"}>"' for i, (blank, gap) in enumerate(zip(blanks, gaps, strict=True))
        )
        + "/>"
    )
    root = parsed(text.encode())
    lines = text.split("\n")
    for name in root.attributes:
        place = root.at(name)
        assert place.line is not None
        assert place.column is not None
        assert lines[place.line - 1][: place.column - 1].endswith(f'{name}="')


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"", "r.urdf:1:1: error SC450: this is not well-formed XML: no element found"),
        (b"<a>\n<b>", "r.urdf:2:4: error SC450: this is not well-formed XML: the file ends before <b> is closed"),
        (b"<a>\n<b></a>", "r.urdf:2:6: error SC450: this is not well-formed XML: mismatched tag"),
        (b"<a/><a/>", "r.urdf:1:5: error SC450: this is not well-formed XML: junk after document element"),
        (b"<a>&x;</a>", "r.urdf:1:4: error SC450: this is not well-formed XML: undefined entity"),
        (b"<a b='1' b='2'/>", "r.urdf:1:10: error SC450: this is not well-formed XML: duplicate attribute"),
        (b"<a>\n \xff</a>", "r.urdf:2:2: error SC450: this is not UTF-8 text: byte 5 (0xFF) is invalid"),
        (
            b'<?x?>\n <!DOCTYPE a SYSTEM "file:///etc/passwd">\n<a/>',
            "r.urdf:2:2: error SC451: document types are refused: they may declare entities and name files",
        ),
    ],
)
def test_malformed_xml_is_reported_at_its_place(data: bytes, expected: str) -> None:
    root, found = parse(data)
    assert root is None
    assert found == [expected]


LAUGHS = b'<!DOCTYPE r [<!ENTITY a "ha">' + b"".join(
    f'<!ENTITY {chr(98 + i)} "{f"&{chr(97 + i)};" * 10}">'.encode() for i in range(9)
)

HOSTILE: dict[str, tuple[bytes, str | None]] = {
    "laughs": (LAUGHS + b"]><r>&j;</r>", "SC451"),
    "depth": (b"<a>" * 5_000_000, "SC452"),
    "elements": (b"<a>" + b"<a/>" * 4_000_000, "SC452"),
    "attributes": (b"<a " + b"".join(b'a%d="" ' % i for i in range(1_000_000)) + b"/>", "SC452"),
    "bytes": (b"<a>" + b" " * 16 * 2**20, "SC452"),
    "comment": (b"<a><!--" + b"-> " * 5_500_000, "SC450"),
    "value": (b"<a b='" + b"&amp;" * 3_000_000 + b"'/>", None),
    "text": (b"<a>" + b"x\n" * 8_000_000 + b"</a>", None),
    "instructions": (b"<a>" + b"<?a?>" * 3_000_000 + b"</a>", None),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_xml_is_refused_quickly(name: str) -> None:
    data, code = HOSTILE[name]
    start = time.process_time()
    root, found = parse(data)
    assert_took(time.process_time() - start, most=1)
    assert (root is None) == (code is not None)
    assert [code for line in found if f" {code}: " in line] == ([code] if code else [])


def test_the_bounds_of_xml_are_exact() -> None:
    bounds = XmlBounds(size=60, depth=2, elements=3, equals=2)
    assert parse(b"<a><b/><c/></a>", bounds)[0] is not None
    for data in (
        b"<a><b/><c/><d/></a>",
        b"<a><b><c/></b></a>",
        b"<a x='1' y='2' z='3'/>",
        b"<a>" + b" " * 60 + b"</a>",
    ):
        root, found = parse(data, bounds)
        assert root is None
        assert len(found) == 1
        assert "SC452" in found[0]


def test_xml_errors_refer_to_the_scene() -> None:
    sink = Sink()
    assert parse_xml(b"<a>", "r.urdf", FileReport(sink, SCENE)) is None
    (found,) = sink.diagnostics()
    assert found.file == "r.urdf"
    assert [(related.message, related.location.file) for related in found.related] == [("used from here", "scene.yaml")]


def test_an_unreadable_robot_file_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "long").write_bytes(b"x" * 11)
    for name, code in (("none", "SC450"), (".", "SC450"), ("long", "SC452")):
        sink = Sink()
        assert read_robot_bytes(tmp_path / name, name, FileReport(sink), 10) is None
        assert [found.code for found in sink.diagnostics()] == [code]
    assert read_robot_bytes(tmp_path / "long", "long", FileReport(Sink()), 11) == b"x" * 11
