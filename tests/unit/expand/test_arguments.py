"""Mistakes inside a prefab that come from what it is given."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc import validate

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic

PART = """\
scenecc: 1
params: {size: 1.0, low: 1.0, n: 2}
entities:
  it:
    body_type: static
    shapes:
      - {type: box, half_size: ["${size / 2}", "${size}", 1]}
      - {type: sphere, radius: "${size}"}
      - {type: sphere, radius: {uniform: ["${low}", 2]}}
      - {type: sphere, radius: 1, repeat: {i: {count: "${n}"}}}
"""


def found(folder: Path, given: str) -> list[Diagnostic]:
    (folder / "part.yaml").write_text(PART)
    (folder / "top.yaml").write_text(f"scenecc: 1\nentities:\n  a: {{use: part.yaml, with: {given}}}\n")
    return validate(folder / "top.yaml")


def notes(one: Diagnostic) -> list[tuple[str, int | None]]:
    return [(related.message, related.location.line) for related in one.related]


def test_a_wrong_value_is_told_once_and_where_it_is_given(tmp_path: Path) -> None:
    (one,) = found(tmp_path, "{size: -1}")
    assert (one.code, one.path) == ("SC104", "entities.it.shapes[0].half_size[0]")
    assert notes(one) == [("`size` is given here", 3), ("used from here", 3)]


def test_what_a_prefab_hands_on_is_told_up_to_where_it_is_written(tmp_path: Path) -> None:
    (tmp_path / "part.yaml").write_text(PART)
    middle = "scenecc: 1\nparams: {edge: 1.0, n: 2}\nentities:\n  m:\n    use: part.yaml\n"
    (tmp_path / "middle.yaml").write_text(f'{middle}    with: {{size: "${{2 * edge}}", n: "${{n}}"}}\n')
    top = "scenecc: 1\nentities:\n  a:\n    use: middle.yaml\n    with:\n      edge: -1\n"
    (tmp_path / "top.yaml").write_text(top)
    (one,) = validate(tmp_path / "top.yaml")
    assert notes(one) == [
        ("`size` is given here", 6),
        ("`edge` is given here", 6),
        ("used from here", 5),
        ("used from here", 4),
    ]
    files = [str(related.location.file).rpartition("/")[2] for related in one.related]
    assert files == ["middle.yaml", "top.yaml", "middle.yaml", "top.yaml"]


def test_an_argument_of_an_override_is_given_there(tmp_path: Path) -> None:
    (tmp_path / "part.yaml").write_text(PART)
    (tmp_path / "middle.yaml").write_text("scenecc: 1\nentities:\n  m: {use: part.yaml, with: {size: 2, n: 1}}\n")
    (tmp_path / "outer.yaml").write_text("scenecc: 1\nentities:\n  o: {use: middle.yaml}\n")
    for use, name in (("middle.yaml", "m"), ("outer.yaml", "o/m")):
        override = f"    override:\n      {name}: {{with: {{size: -1}}}}\n"
        (tmp_path / "top.yaml").write_text(f"scenecc: 1\nentities:\n  a:\n    use: {use}\n{override}")
        (one,) = validate(tmp_path / "top.yaml")
        assert one.code == "SC104"
        assert notes(one)[0] == ("`size` is given here", 6)
        assert str(one.related[0].location.file).endswith("top.yaml")


def test_mistakes_of_two_parameters_are_two(tmp_path: Path) -> None:
    codes = [(one.code, one.related[0].message) for one in found(tmp_path, "{size: -1, low: 3}")]
    assert codes == [("SC104", "`size` is given here"), ("SC119", "`low` is given here")]


def test_what_decides_about_structure_names_the_parameter(tmp_path: Path) -> None:
    (one,) = found(tmp_path, "{n: {choice: [1, 2]}}")
    assert one.code == "SC203"
    assert notes(one)[0] == ("`n` is given here", 3)


def test_a_mistake_that_reads_nothing_given_has_no_such_note(tmp_path: Path) -> None:
    (tmp_path / "part.yaml").write_text(PART.replace("radius: 1,", "radius: -1,"))
    (tmp_path / "top.yaml").write_text("scenecc: 1\nentities: {a: {use: part.yaml, with: {size: 2}}}\n")
    (one,) = validate(tmp_path / "top.yaml")
    assert [message for message, _ in notes(one)] == ["used from here"]


def test_what_is_told_of_a_whole_entity_comes_from_no_one_value_in_it(tmp_path: Path) -> None:
    body = "  it:\n    shapes: [{type: plane}]\n    pose: {p: [0, 0, '${height}'], rpy_deg: [0, 0, '${turn}']}\n"
    params = "params: {height: 1.0, turn: 1.0}\n"
    (tmp_path / "part.yaml").write_text(f"scenecc: 1\n{params}entities:\n{body}")
    top = "scenecc: 1\nentities: {a: {use: part.yaml, with: {height: 2, turn: 90}}}\n"
    (tmp_path / "top.yaml").write_text(top)
    (one,) = validate(tmp_path / "top.yaml")
    assert (one.code, [message for message, _ in notes(one)]) == ("SC503", ["used from here"])


def test_what_is_handed_on_inside_a_mapping_is_followed(tmp_path: Path) -> None:
    (tmp_path / "part.yaml").write_text(PART)
    drawn = 'low: {uniform: ["${edge}", 2]}, size: "${edge}"'
    middle = f"scenecc: 1\nparams: {{edge: 1.0}}\nentities:\n  m: {{use: part.yaml, with: {{{drawn}}}}}\n"
    (tmp_path / "middle.yaml").write_text(middle)
    (tmp_path / "top.yaml").write_text("scenecc: 1\nentities: {a: {use: middle.yaml, with: {edge: -1}}}\n")
    told = [message for one in validate(tmp_path / "top.yaml") for message, _ in notes(one)]
    assert "`edge` is given here" in told
