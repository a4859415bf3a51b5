"""The examples of the codes about use of the tool give these codes."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from scenecc.diagnostics.codes import CODES, Code

SCENE = "scenecc: 1\nentities:\n  cube: {shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}\n"
NEEDS_PERMISSIONS = {"SC903"}


@pytest.mark.parametrize("row", [row for row in CODES.values() if row.code[2] == "9"], ids=lambda row: row.code)
def test_the_command_gives_its_code_and_status(row: Code, tmp_path: Path, forking_environment: dict[str, str]) -> None:
    if row.code in NEEDS_PERMISSIONS and os.geteuid() == 0:
        pytest.skip("root may read everything")
    folder = tmp_path / "here"
    folder.mkdir()
    (folder / "scene.yaml").write_text(SCENE)
    assert row.example.startswith("$ ")
    done = subprocess.run(
        ["bash", "-c", row.example.removeprefix("$ ")],
        cwd=folder,
        env=forking_environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    for locked in folder.glob("locked"):
        locked.chmod(0o700)
    assert done.returncode == (1 if row.at_fault == "scene" else 2), done.stderr
    assert row.code in done.stdout + done.stderr
