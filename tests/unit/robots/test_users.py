"""Faults of robots' files, which are read once: everyone who names the file is told."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc import validate

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic

MAX_CONSTRAINT_ERROR = (
    '<robot name="r">\n<link name="a"/>\n'
    '<joint name="j" type="fixed"><parent link="a"/><child link="c"/></joint></robot>'
)
WHOLE = (
    '<robot name="r"><link name="a"/><link name="b"/>'
    '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint></robot>'
)
PAIRS = '<robot name="r">\n<disable_collisions link1="a" link2="x" reason="Default"/></robot>'


def found(folder: Path, text: str, **files: str) -> list[Diagnostic]:
    for name, content in files.items():
        (folder / name.replace("_", ".")).write_text(content)
    (folder / "scene.yaml").write_text("scenecc: 1\nentities:\n" + text)
    return validate(folder / "scene.yaml")


def notes(finding: Diagnostic) -> list[tuple[Any, ...]]:
    return [(note.message, note.location.line, note.location.column) for note in finding.related]


def test_errors_of_a_robot_file_name_every_entity_that_uses_it(tmp_path: Path) -> None:
    text = "  one: {urdf: r.urdf}\n  two: {urdf: r.urdf}\n  three: {urdf: r.urdf, scale: 2}\n"
    (fault,) = found(tmp_path, text + "  four: {urdf: r.urdf, scale: 2}\n", r_urdf=MAX_CONSTRAINT_ERROR)
    assert (fault.code, fault.line) == ("SC461", 3)
    assert str(fault.file).endswith("r.urdf")
    assert fault.message.endswith("(and in 3 other uses)")
    assert sorted(notes(fault)) == [
        ("used from here", 3, 15),
        ("used from here too", 4, 15),
        ("used from here too", 5, 17),
        ("used from here too", 6, 16),
    ]


def test_ten_users_of_a_file_are_listed_and_repeats_counted(tmp_path: Path) -> None:
    text = "".join(f"  e{i}: {{urdf: r.urdf}}\n" for i in range(20))
    (fault,) = found(tmp_path, text, r_urdf=MAX_CONSTRAINT_ERROR)
    assert fault.message.endswith("(and in 19 other uses)")
    assert [line for _, line, _ in notes(fault)] == list(range(3, 14))
    (fault,) = found(tmp_path, '  e: {repeat: {i: {count: 4}}, pose: ["${i}", 0, 0], urdf: r.urdf}\n')
    assert fault.message.endswith("(and in 3 other uses)")
    assert [line for _, line, _ in notes(fault)] == [3]


def test_warnings_and_mjcf_errors_name_all_users_of_a_file(tmp_path: Path) -> None:
    world = '<worldbody><body><geom type="sphere" size="1"/></body><camera/></worldbody>'
    (doubt,) = found(tmp_path, "  a: {mjcf: r.xml}\n  b: {mjcf: r.xml}\n", r_xml=f"<mujoco>{world}</mujoco>")
    assert (doubt.code, [line for _, line, _ in notes(doubt)]) == ("SC490", [3, 4])


def test_errors_of_an_srdf_refer_to_the_key_that_names_it(tmp_path: Path) -> None:
    text = "  one:\n    urdf: ok.urdf\n    srdf: bad.srdf\n  two:\n    urdf: ok.urdf\n    srdf: bad.srdf\n"
    text += "  three: {urdf: ok.urdf, srdf: none}\n"
    (fault,) = found(tmp_path, text, ok_urdf=WHOLE, bad_srdf=PAIRS)
    assert (fault.code, fault.line, str(fault.file).endswith("bad.srdf")) == ("SC471", 2, True)
    assert notes(fault) == [("used from here", 5, 11), ("used from here too", 8, 11)]
    # Beside the URDF nothing of the scene names it but the URDF does.
    (fault,) = found(tmp_path, "  one: {urdf: bad.urdf}\n", bad_urdf=WHOLE)
    assert (fault.code, notes(fault)) == ("SC471", [("used from here", 3, 15)])
