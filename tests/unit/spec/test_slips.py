"""Slips that people make: what is written, and what the first line says to write instead, which can be pasted."""

from __future__ import annotations

import importlib
import io
import json
import shutil
from importlib.util import find_spec
from pathlib import Path

import pytest
from plugins.pasting import changed_lines, pasted, snippet
from plugins.slips import SLIPS, Slip
from pydantic import BaseModel

from scenecc import spec, validate
from scenecc.diagnostics import Diagnostic
from scenecc.diagnostics.formats import render
from scenecc.spec.hints import MISPLACED_KEYS
from scenecc.spec.key_hints import MAKERS

ASSETS = Path(__file__).resolve().parents[3] / "scenes"


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the scenes."""
    made = tmp_path_factory.mktemp("slips")
    shutil.copy(ASSETS / "robots/arm.urdf", made / "a.urdf")
    shutil.copy(ASSETS / "assets/mug.obj", made / "a.obj")
    for name in ("a.png", "t.png"):
        shutil.copy(ASSETS / "assets/checker.png", made / name)
    return made


@pytest.mark.parametrize("slip", SLIPS.values(), ids=SLIPS)
def test_the_first_line_says_what_to_write_and_it_can_be_pasted(slip: Slip, folder: Path) -> None:
    file = folder / "scene.yaml"

    def findings(text: str) -> list[Diagnostic]:
        file.write_text(text, encoding="utf-8")
        return validate(file)

    text = f"scenecc: 1\n{slip.text}"
    first = next(one for one in findings(text) if one.severity == "error")
    assert (f"{first.line}:{first.column}", first.code, first.hint) == (slip.place, slip.code, slip.hint)
    line = render([first]).splitlines()[0]
    assert line.endswith(f"; {slip.hint}") or len(first.message) + len(slip.hint) > 140
    (told,) = json.loads(render([first], "json"))["diagnostics"]
    assert told["hint"] == slip.hint
    if "robot: panda" in (slip.fixed or "") and find_spec("mani_skill") is None:
        pytest.skip("the robot's files are in ManiSkill's package")
    result = pasted(text, findings)
    if result is not None:
        assert changed_lines(text, result) == slip.fixed
    elif slip.fixed is not None:
        assert [one for one in findings(f"scenecc: 1\n{slip.fixed}") if one.severity == "error"] == []
        assert (snippet(slip.hint) or "") in slip.fixed


def test_most_slips_of_the_table_are_mended_by_pasting_their_hints() -> None:
    assert sum(slip.fixed is not None for slip in SLIPS.values()) >= 0.7 * len(SLIPS)


@pytest.mark.parametrize("version", ['"1"', "1.0", "2", "v1", "true"])
def test_the_version_of_the_language_is_a_whole_number(version: str) -> None:
    (found,) = validate(io.StringIO(f"scenecc: {version}\nentities: {{}}\n"))
    assert (found.code, found.hint) == ("SC100", "write `scenecc: 1`")


def test_a_misplaced_key_is_in_a_mapping_that_the_language_has() -> None:
    for file in (Path(spec.__file__).parent).glob("*.py"):
        importlib.import_module(f"scenecc.spec.{file.stem}")
    models, todo = set[str](), [BaseModel]
    while todo:
        todo += (new := todo.pop().__subclasses__())
        models |= {one.__name__ for one in new}
    assert {name for places, *_ in (*MISPLACED_KEYS, *MAKERS) for name in places.split()} <= models
