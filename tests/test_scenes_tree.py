"""The trees of scenes: good files give nothing, bad ones exactly what they state, and dicts the same as files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from plugins.expectations import BAD, GOOD, ROOT, expectations, file_id, scene_files
from plugins.slow import mostly_slow

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

MOVING_FILES = scene_files(ROOT / "tests/scenes/moving")
"""Scenes in which much moves, as it should."""

_NO_FILE = """
    001 015 016 019 250 318 354 356 357 358 407 422 428 429 430 431 432 433 434 435 436 437 438 439 440 442 443
    452 457 458 473 477
"""
NO_FILE = {f"SC{number}" for number in _NO_FILE.split()}
"""Codes that no file in a repository can give: the file is missing or unreadable, changes meanwhile, is a Python
object, is no scene, is a mesh that a test makes, holds a thousand errors or links, or is given what it does not have.
Unit tests give them."""


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


@pytest.mark.parametrize("file", mostly_slow(MOVING_FILES, 3), ids=file_id)
def test_a_check_of_a_moving_scene_finds_no_fault(file: Path) -> None:
    found = check_scene(file, settle=2)
    assert not found, shown(found)


def silences(file: Path) -> bool:
    """Whether a file has comments that silence findings, as a dict cannot."""
    return MARKER.encode() in file.read_bytes()


@pytest.mark.parametrize("file", mostly_slow([*BAD_FILES, *GOOD_FILES], 20), ids=file_id)
def test_a_dict_gives_what_its_file_gives(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = data_of(file)
    if data is None or silences(file):
        pytest.skip("a dict cannot say what this file says")
    # A scene that comes as a dict names its files from the current folder.
    monkeypatch.chdir(file.parent)
    by_file, by_dict = validate(file), validate(data)
    of_file = [(d.code, d.path, d.message.replace(file.name, "<dict>")) for d in by_file]
    assert sorted(of_file) == sorted((d.code, d.path, d.message) for d in by_dict)
    # What a scene uses are files in any case.
    assert [d.file for d in by_dict].count(None) == [d.file for d in by_file].count(str(file))
    assert all((d.line, d.column) == (None, None) for d in by_dict if d.file is None)


@pytest.mark.parametrize("file", mostly_slow(GOOD_FILES, 8), ids=file_id)
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
    assert compiler - stated == NO_FILE


def test_the_trees_are_there() -> None:
    """A test over an empty tree would pass."""
    assert len(GOOD_FILES) > 20
    assert len(BAD_FILES) > 40
    assert len(CHECKED_FILES) > 60
    assert len(MOVING_FILES) > 15


def test_an_expectation_without_a_column_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    for comment in ("# expect: SC101", "# expect: SC101 @ 3, SC102 @ 4", "# expect SC101 @ 3", "# expect at 3: SC101"):
        file.write_text(f"scenecc: 1  {comment}\n", encoding="utf-8")
        with pytest.raises(ValueError, match="expectation"):
            expectations(file)
