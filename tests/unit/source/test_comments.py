"""`# scenecc: ignore`: where it holds, and where it is only text."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from scenecc import open_scene, validate
from scenecc.source.comments import find_xml_silencings, find_yaml_silencings
from scenecc.source.text import TextLines

SCENE = """scenecc: 1
entities:
  door:
    mass: 1
    {above}
    pose: {{p: [0, 0, 1], rpy: [0, 0, 90]}} {beside}
    shapes: [{{type: box, half_size: [0.1, 0.1, 1]}}]
"""
ROBOT = """<robot name="r">
  <link name="a"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  {above}
  <link name="b" colour="red"/> {beside}
  <joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
</robot>
"""


def found_in(above: str = "", beside: str = "") -> list[str]:
    text = SCENE.format(above=above, beside=beside)
    return [found.code for found in validate(io.StringIO(text))]


@pytest.mark.parametrize(
    ("above", "beside", "codes"),
    [
        ("", "", ["SC526"]),
        ("", "# scenecc: ignore SC526", []),
        ("", "#scenecc: ignore SC526 -- two, on purpose", []),
        ("# scenecc: ignore SC526 -- on purpose", "", []),
        ("", "# see below # scenecc: ignore SC526", []),
        ("", "# scenecc: ignore SC101", ["SC526", "SC018"]),
        ("", "# scenecc: ignore SC313, SC526", ["SC018"]),
        ("", "# scenecc: ignore SC998", ["SC526", "SC018"]),
        ("", "# scenecc: ignore", ["SC526", "SC018"]),
        ("# scenecc: ignore SC313\n    # scenecc: ignore SC526", "", ["SC018"]),
        ("body_type: dynamic  # scenecc: ignore SC526", "", ["SC018", "SC526"]),
    ],
)
def test_a_comment_silences_its_line_or_the_next_one(above: str, beside: str, codes: list[str]) -> None:
    assert sorted(found_in(above, beside)) == sorted(codes)


@pytest.mark.parametrize(
    "text",
    [
        "a: '# scenecc: ignore SC526'",
        'a: "x\n  # scenecc: ignore SC526\n  y"',
        "a: |\n  # scenecc: ignore SC526\n\n  # scenecc: ignore SC526\n",
        "a: >-\n   x\n   # scenecc: ignore SC526\n",
        "a: x#scenecc: ignore SC526",
    ],
)
def test_the_marker_in_a_string_is_text(text: str) -> None:
    assert find_yaml_silencings(TextLines("a", text)) == []


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("a: |  # scenecc: ignore SC526\n  x\n", 1),
        ("a: |\n  x\n\n# scenecc: ignore SC526\nb: 1\n", 5),
        ("a: >\n  x\n# scenecc: ignore SC526\nb: 1\n", 4),
        ("a: '#'  # scenecc: ignore SC526\n", 1),
        ("a: [1,   # scenecc: ignore SC526\r\n  2]", 1),
        ("a: '# scenecc: ignore SC1'  # scenecc: ignore SC526", 1),
    ],
)
def test_the_marker_after_a_string_is_a_comment(text: str, line: int) -> None:
    (found,) = find_yaml_silencings(TextLines("a", text))
    assert (found.codes, found.line) == (("SC526",), line)


def test_a_reason_in_xml_follows_one_hyphen() -> None:
    text = "<a>\n<!-- scenecc: ignore SC454, SC526 - a reason -->\n<b/> <!-- scenecc: ignore SC454 -->\n</a>"
    found = find_xml_silencings(TextLines("a", text))
    assert [(one.codes, one.line) for one in found] == [(("SC454", "SC526"), 3), (("SC454",), 3)]


@pytest.mark.parametrize(
    ("above", "beside", "codes"),
    [
        ("", "", ["SC454"]),
        ("<!-- scenecc: ignore SC454 - a note for people -->", "", []),
        ("", "<!-- scenecc: ignore SC454 -->", []),
        ("<!-- scenecc: ignore SC468 -->", "", ["SC454"]),  # a robot's file is not the one that is checked
    ],
)
def test_a_comment_in_a_robot_file_silences_its_findings(
    tmp_path: Path, above: str, beside: str, codes: list[str]
) -> None:
    (tmp_path / "r.urdf").write_text(ROBOT.format(above=above, beside=beside))
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities:\n  r: {urdf: r.urdf, fix_root_link: true}\n")
    assert [found.code for found in validate(scene)] == codes
    assert [found.code for found in open_scene(scene).diagnostics] == codes


def test_a_comment_in_an_included_file_silences_its_findings(tmp_path: Path) -> None:
    part = tmp_path / "part.yaml"
    part.write_text(SCENE.format(above="", beside="# scenecc: ignore SC526, SC313"))
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\ninclude: [part.yaml]\n")
    assert validate(scene) == []
    assert [found.code for found in validate(part)] == ["SC018"]


@pytest.mark.parametrize(
    ("first", "second", "codes"),
    [
        ("# scenecc: ignore SC454 -- of the wheel", "# scenecc: ignore SC454", []),
        ("# scenecc: ignore SC454", "", ["SC454"]),
        ("# scenecc: ignore SC454, SC469", "# scenecc: ignore SC454", ["SC018"]),
    ],
)
def test_a_comment_where_a_scene_names_a_robot_file_silences_its_findings(
    tmp_path: Path, first: str, second: str, codes: list[str]
) -> None:
    (tmp_path / "robot.urdf").write_text(ROBOT.format(above="", beside=""))
    scene = tmp_path / "scene.yaml"
    lines = f"  r:\n    urdf: robot.urdf  {first}\n  s:\n    {second}\n    urdf: robot.urdf\n"
    scene.write_text(f"scenecc: 1\nentities:\n{lines}")
    assert sorted(one.code for one in validate(scene)) == codes


def test_a_comment_at_the_mjcf_silences_findings_in_the_files_that_it_includes(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    (tmp_path / "robot.xml").write_text('<mujoco><include file="body.xml"/></mujoco>')
    (tmp_path / "body.xml").write_text(
        '<mujoco><worldbody><light/><body><joint/><geom size="1"/></body></worldbody></mujoco>'
    )
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities:\n  r: {mjcf: robot.xml}  # scenecc: ignore SC490\n")
    assert validate(scene) == []
