"""`scenecc decompile` as a process."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def test_an_unwritable_output_is_reported_before_any_work(run: Any, tmp_path: Path) -> None:
    done = run("decompile", "PickCube-v1", "-o", tmp_path / "none" / "pick.yaml")
    assert done.returncode == 2
    assert "SC904" in done.stdout + done.stderr


def test_the_help_of_decompile_has_an_example(run: Any) -> None:
    done = run("decompile", "--help")
    assert done.returncode == 0
    assert "scenecc decompile PickCube-v1 -o pick.yaml" in done.stdout
