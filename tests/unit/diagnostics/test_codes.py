"""The table of codes against itself, the code that reports, and its own examples."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml

import scenecc
from scenecc.diagnostics import Sink
from scenecc.diagnostics.codes import BANDS, CODES, Code, is_of_check
from scenecc.plan.json_codec import plan_from_json

PACKAGE = Path(scenecc.__file__).parent
TABLE = PACKAGE / "diagnostics" / "codes.yaml"


def reported() -> dict[str, set[str]]:
    """Every code that is written as a literal outside of the table, and the files that write it."""
    found: dict[str, set[str]] = {}
    for file in PACKAGE.rglob("*.py"):
        for code in re.findall(r"""["'](SC\d{3})["']""", file.read_text(encoding="utf-8")):
            found.setdefault(code, set()).add(str(file.relative_to(PACKAGE)))
    return found


def test_each_code_entry_is_well_formed() -> None:
    for row in CODES.values():
        assert re.fullmatch(r"SC\d{3}", row.code)
        assert row.code[2] in BANDS, row.code
        assert row.severity in {"error", "warning", "note"}, row.code
        assert 0 < len(row.title) <= 80, row.code
        assert "\n" not in row.title, row.code
        assert not row.title.endswith("."), row.code
        assert len(row.cause) > 20, f"{row.code}: say why"
        assert row.example.strip(), row.code
        assert row.cure.strip(), row.code


def test_each_code_example_is_a_scene_or_a_command() -> None:
    for row in CODES.values():
        band = row.code[2]
        assert "\t" not in row.example.replace("\\t", "") or band == "0", f"{row.code}: a tab is YAML's own mistake"
        if not row.example.startswith("$ "):
            assert "scenecc" in row.example or band in {"0", "1"}, f"{row.code}: a scene file says `scenecc: 1`"


def test_every_code_entry_has_only_known_keys() -> None:
    written = [line[:-1] for line in TABLE.read_text(encoding="utf-8").splitlines() if re.match(r"SC", line)]
    assert written == sorted(set(written)) == list(CODES)
    entries = yaml.safe_load(TABLE.read_text(encoding="utf-8"))
    for code, entry in entries.items():
        row = CODES[code]
        assert (row.severity, row.title) == (entry.get("severity", "error"), entry["title"])
        assert set(entry) - {"severity", "at_fault"} == {"title", "cause", "example", "cure"}
        assert entry.get("at_fault", row.at_fault) == row.at_fault


def test_every_reported_code_has_an_entry() -> None:
    unknown = {code: files for code, files in reported().items() if code not in CODES}
    assert not unknown


def test_every_code_entry_is_reported_somewhere() -> None:
    dead = sorted(set(CODES) - set(reported()))
    assert not dead


PLANS = [row for row in CODES.values() if row.example.startswith("{")]
SCENES = [row for row in CODES.values() if not row.example.startswith(("$ ", "{"))]


@pytest.mark.parametrize("row", PLANS, ids=lambda row: row.code)
def test_each_example_plan_gives_its_code(row: Code, tmp_path: Path) -> None:
    sink = Sink()
    assert plan_from_json(row.example, base=tmp_path, sink=sink, file="plan.json") is None
    assert {diagnostic.code for diagnostic in sink.diagnostics()} == {row.code}


@pytest.mark.parametrize("row", SCENES, ids=lambda row: row.code)
def test_each_example_scene_gives_its_code(row: Code, tmp_path: Path) -> None:
    from scenecc import check_scene, validate

    # A folder below the temporary one: an example may name a file outside of its own folder.
    folder = tmp_path / "outer" / "scene"
    folder.mkdir(parents=True)
    file = folder / "scene.yaml"
    file.write_bytes(row.example.encode("utf-8"))
    found = check_scene(file, settle=0) if is_of_check(row.code) else validate(file)
    shown = [str(diagnostic) for diagnostic in found]
    assert row.code in {diagnostic.code for diagnostic in found}, shown
    assert {diagnostic.code for diagnostic in found if diagnostic.severity == "error"} <= {row.code}, shown
