"""The trees of scenes: good files give nothing, bad ones exactly what they state, and dicts the same as files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from plugins.expectations import BAD, GOOD, ROOT, expectations, file_id, scene_files

from scenecc import check_scene, compile_scene, validate
from scenecc.cli.checking import Parts
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.diagnostic import MARKER
from scenecc.source import make_limits, read_text
from scenecc.source.text import decode_text, read_bytes

# Those of ManiSkill's tasks need its files: tests/maniskill/test_corpus.py and test_checked.py.
MANISKILL = ROOT / "scenes" / "maniskill"
SHIPPED_FILES = [file for file in scene_files(ROOT / "scenes") if MANISKILL not in file.parents]
GOOD_FILES = [*scene_files(GOOD), *SHIPPED_FILES]
BAD_FILES = scene_files(BAD)
CHECKED_FILES = scene_files(ROOT / "tests/scenes/check")
"""Those in which `validate` finds nothing, and `check` finds what they state; in the folder `settled` once they are
simulated."""

NO_FILE = {
    "SC001": "tests/unit/source/test_hostile.py",
    "SC015": "tests/unit/source/test_values.py",
    "SC016": "tests/unit/source/test_hostile.py",
    "SC019": "tests/unit/source/test_pack.py",
    "SC250": "tests/unit/expand/test_params.py",
    "SC318": "tests/unit/lower/test_draws.py",
    "SC354": "tests/unit/placing/test_place.py",
    "SC356": "tests/unit/placing/test_place.py",
    "SC357": "tests/unit/placing/test_place.py",
    "SC358": "tests/unit/placing/test_place.py",
    "SC407": "tests/unit/source/test_paths.py",
    "SC422": "tests/unit/test_plan_files.py",
    "SC428": "tests/unit/test_pack.py",
    "SC429": "tests/unit/test_pack.py",
    "SC430": "tests/unit/importers/test_sdf.py",
    "SC431": "tests/unit/importers/test_sdf.py",
    "SC432": "tests/unit/importers/test_sdf.py",
    "SC433": "tests/unit/importers/test_sdf.py",
    "SC434": "tests/unit/checks/test_mesh_quality.py",
    "SC435": "tests/unit/checks/test_mesh_quality.py",
    "SC436": "tests/unit/checks/test_mesh_quality.py",
    "SC437": "tests/unit/checks/test_mesh_quality.py",
    "SC438": "tests/unit/checks/test_mesh_quality.py",
    "SC439": "tests/unit/checks/test_mesh_quality.py",
    "SC440": "tests/unit/checks/test_mesh_quality.py",
    "SC442": "tests/unit/checks/test_mesh_quality.py",
    "SC443": "tests/unit/checks/test_mesh_quality.py",
    "SC452": "tests/unit/robots/test_urdf.py",
    "SC457": "tests/unit/robots/test_mujoco_hostile.py",
    "SC458": "tests/unit/robots/test_mujoco_hostile.py",
    "SC473": "tests/unit/robots/test_srdf.py",
    "SC477": "tests/unit/robots/test_urdf.py",
    "SC513": "tests/unit/lower/test_draws.py",
}
"""Codes that no file in a repository can give: the file is missing or unreadable, changes meanwhile, is a Python
object, is no scene, is a mesh that a test makes, holds a thousand errors or links, is given what it does not have, or
is drawn first. The test that gives them instead."""


def data_of(file: Path) -> dict[str, Any] | None:
    """The plain data of a file; None where it cannot be read."""
    sink, limits = Sink(), make_limits()
    content = read_bytes(str(file), sink, limits)
    text = None if content is None else decode_text(content, str(file), sink, limits)
    document = None if text is None else read_text(text, str(file), sink, limits, file)
    return None if document is None or sink.failed else document.data


def shown(diagnostics: list[Diagnostic]) -> str:
    return "\n".join(str(diagnostic) for diagnostic in diagnostics) or "nothing"


@pytest.mark.parametrize("file", GOOD_FILES, ids=file_id)
def test_good_files_give_nothing_but_the_warnings_they_state(file: Path) -> None:
    found = validate(file)
    assert [(d.line, d.column, d.code) for d in found] == expectations(file), shown(found)
    assert all(d.severity != "error" for d in found)


@pytest.mark.parametrize("file", BAD_FILES, ids=file_id)
def test_bad_files_give_exactly_what_they_state(file: Path) -> None:
    expected = expectations(file)
    assert expected, "a bad file states what is wrong with it"
    found = validate(file)
    assert sorted((d.line or 0, d.column or 0, d.code) for d in found) == expected, shown(found)
    assert any(d.severity == "error" for d in found) or all(CODES[code].severity != "error" for *_, code in expected)


@pytest.mark.parametrize("file", CHECKED_FILES, ids=file_id)
def test_a_check_finds_exactly_what_a_file_states(file: Path) -> None:
    found = check_scene(file, settle=float(file.parent.name == "settled"))
    assert sorted((d.line or 0, d.column or 0, d.code) for d in found) == expectations(file), shown(found)
    assert not validate(file)


@pytest.mark.parametrize("file", SHIPPED_FILES, ids=file_id)
def test_a_check_of_a_shipped_scene_finds_no_fault(file: Path) -> None:
    """Simulated for a second. Parts are judged as parts; notes are no faults."""
    found = Parts([str(each) for each in SHIPPED_FILES]).without_lacks(str(file), check_scene(file))
    assert not [d for d in found if d.severity != "note"], shown(found)


def silences(file: Path) -> bool:
    """Whether a file has comments that silence findings, as a dict cannot."""
    return MARKER.encode() in file.read_bytes()


@pytest.mark.parametrize(
    "file",
    [file for file in [*GOOD_FILES, *BAD_FILES] if data_of(file) is not None and not silences(file)],
    ids=file_id,
)
def test_a_dict_gives_what_its_file_gives(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = data_of(file)
    assert data is not None
    # A scene that comes as a dict names its files from the current folder.
    monkeypatch.chdir(file.parent)
    by_file, by_dict = validate(file), validate(data)
    of_file = [(d.code, d.path, d.message.replace(file.name, "<dict>")) for d in by_file]
    assert sorted(of_file) == sorted((d.code, d.path, d.message) for d in by_dict)
    # What a scene uses are files in any case.
    assert [d.file for d in by_dict].count(None) == [d.file for d in by_file].count(str(file))
    assert all((d.line, d.column) == (None, None) for d in by_dict if d.file is None)


@pytest.mark.parametrize("file", GOOD_FILES, ids=file_id)
def test_a_dict_gives_the_plan_of_its_file(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(file.parent)
    data = data_of(file)
    assert data is not None
    by_file, by_dict = compile_scene(file), compile_scene(data)
    # A dict has no file whose name could name it.
    assert replace(by_dict, name=by_file.name) == by_file
    assert by_dict.name == data.get("name", "scene")


def test_every_code_of_the_compiler_has_a_bad_file() -> None:
    stated = {code for file in [*BAD_FILES, *GOOD_FILES, *CHECKED_FILES] for *_, code in expectations(file)}
    compiler = {code for code in CODES if code[2] in "012345"}
    assert compiler - stated == set(NO_FILE)


@pytest.mark.parametrize(("code", "test"), NO_FILE.items(), ids=str)
def test_codes_without_a_bad_file_have_a_test(code: str, test: str) -> None:
    assert code in (ROOT / test).read_text(encoding="utf-8")


SILENT = [
    ("a mesh file that is missing", "SC401", "assets/missing.yaml", "file:"),
    ("a mesh that cannot be cooked", "SC412", "assets/broken.yaml", "file:"),
    ("a negative size", "SC104", "language/out_of_range.yaml", "half_size: [0.1, -0.1, 0]"),
    ("a size of zero", "SC104", "language/out_of_range.yaml", "{type: sphere, radius: 0}"),
    ("a size that is no number", "SC104", "language/out_of_range.yaml", "{type: sphere, radius: .nan}"),
    ("a negative density", "SC104", "language/out_of_range.yaml", "density: -1"),
    ("a quaternion of zeros", "SC112", "language/quaternions.yaml", "q: [0, 0, 0, 0]"),
    ("a quaternion not of unit length", "SC112", "language/quaternions.yaml", "q: [1, 1, 0, 0]"),
    ("a plane on a dynamic body", "SC503", "physics/moving_planes.yaml", "{type: plane}"),
    ("an actor with no shape at all", "SC501", "physics/no_shapes.yaml", "empty: {}"),
    ("the same name twice", "SC004", "reading/duplicate_keys.yaml", "  ball:"),
    ("the same name for a frame and an entity", "SC305", "names/taken_twice.yaml", "cube:"),
    ("a mass on a kinematic body", "SC115", "physics/does_nothing.yaml", "body_type: kinematic, mass: 1"),
    ("an inertia on a kinematic body", "SC115", "physics/does_nothing.yaml", "inertial: {mass: 1"),
    ("a trigger", "SC110", "language/left_out.yaml", "is_trigger: true"),
    ("a misspelt key", "SC101", "language/unknown_keys.yaml", "inital_pose"),
    ("dynamic friction above static friction", "SC504", "physics/friction.yaml", "slides:"),
    ("a restitution of 5", "SC505", "physics/restitution.yaml", "restitution: 5"),
    ("a plain triangle mesh on a dynamic body", "SC508", "physics/triangle_meshes.yaml", "crate:"),
    ("a signed distance field over a plane", "SC509", "physics/fields_over_planes.yaml", "falls:"),
    ("a negative contact offset", "SC104", "language/out_of_range.yaml", "contact_offset: -0.01"),
    ("a contact offset below the rest offset", "SC507", "physics/offsets.yaml", "both:"),
    ("an inertia that no body has", "SC506", "physics/inertia.yaml", "inertia: [1, 1, 5]"),
]
"""What SAPIEN takes without a word and builds otherwise than written: the code, the file, and the line in it.

Two more have a meaning instead, compared with the engine in `tests/fidelity/`: a mass, which SAPIEN sets without
the inertia, scales both; what is only seen is left out where nothing can be rendered.
"""


@pytest.mark.parametrize(("what", "code", "name", "snippet"), SILENT, ids=[row[0] for row in SILENT])
def test_what_sapien_takes_in_silence_is_refused(what: str, code: str, name: str, snippet: str) -> None:
    lines = (BAD / name).read_text(encoding="utf-8").split("\n")
    stated = [lines[line - 1] for line, _, stated in expectations(BAD / name) if stated == code]
    assert any(snippet in line for line in stated), f"{name} does not refuse {what}"


def test_the_trees_are_there() -> None:
    """A test over an empty tree would pass."""
    assert len(GOOD_FILES) > 20
    assert len(BAD_FILES) > 40
    assert len(CHECKED_FILES) > 60


def test_an_expectation_without_a_column_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    for comment in ("# expect: SC101", "# expect: SC101 @ 3, SC102 @ 4", "# expect SC101 @ 3", "# expect at 3: SC101"):
        file.write_text(f"scenecc: 1  {comment}\n", encoding="utf-8")
        with pytest.raises(ValueError, match="expectation"):
            expectations(file)
