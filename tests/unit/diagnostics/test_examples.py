"""Every example of the table is true: the scene file gives the code that it stands for."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenecc.diagnostics import Sink
from scenecc.diagnostics.codes import CODES, Code
from scenecc.plan.from_json import plan_from_json

PLANS = [row for row in CODES.values() if row.example.startswith("{")]
SCENES = [row for row in CODES.values() if not row.example.startswith(("$ ", "{"))]


@pytest.mark.parametrize("row", PLANS, ids=lambda row: row.code)
def test_the_plan_gives_its_code(row: Code, tmp_path: Path) -> None:
    sink = Sink()
    assert plan_from_json(row.example, base=tmp_path, sink=sink, file="plan.json") is None
    assert {diagnostic.code for diagnostic in sink.diagnostics()} == {row.code}


@pytest.mark.parametrize("row", SCENES, ids=lambda row: row.code)
def test_the_scene_gives_its_code(row: Code, tmp_path: Path) -> None:
    from scenecc import validate

    # A folder below the temporary one: an example may name a file outside of its own folder.
    folder = tmp_path / "outer" / "scene"
    folder.mkdir(parents=True)
    file = folder / "scene.yaml"
    file.write_bytes(row.example.encode("utf-8"))
    found = validate(file)
    shown = [str(diagnostic) for diagnostic in found]
    assert row.code in {diagnostic.code for diagnostic in found}, shown
    assert {diagnostic.code for diagnostic in found if diagnostic.severity == "error"} <= {row.code}, shown
