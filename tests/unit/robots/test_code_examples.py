"""The examples of the table of codes that are files of robots: each gives the code that it stands for, and no other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from scenecc.diagnostics import Sink
from scenecc.diagnostics.codes import CODES
from scenecc.robots.urdf import read_urdf
from scenecc.source.paths import AssetScope, ResolvedFile

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics.codes import Code

URDFS = [row for row in CODES.values() if "# robot.urdf: " in row.example]


@pytest.mark.parametrize("row", URDFS, ids=lambda row: row.code)
def test_each_example_of_a_code_reports_the_code(row: Code, tmp_path: Path) -> None:
    _, *files = row.example.split("   # ")
    repair: frozenset[str] = frozenset()
    for file in files:
        name, content = file.split(": ", 1)
        if name == "repair":
            repair = frozenset(content.strip("[]").split(", "))
        else:
            (tmp_path / name).write_text(content)
    sink = Sink()
    path = tmp_path / "robot.urdf"
    description = read_urdf(ResolvedFile(path, path.name), scope=AssetScope(tmp_path), sink=sink, repair=repair)
    assert [(found.code, found.severity) for found in sink.diagnostics()] == [(row.code, row.severity)]
    assert (description is None) == (row.severity == "error")


def test_most_codes_of_urdf_files_have_an_example() -> None:
    assert len(URDFS) >= 23
