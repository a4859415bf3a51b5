"""SDF files of other packages against Drake, which reads them too.

Skipped unless `SCENECC_WHEELS` names a folder with `drake`: `pip install --target FOLDER --no-deps drake`.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from scenecc.importers.import_scene import import_scene

WHEELS = Path(os.environ.get("SCENECC_WHEELS", "nowhere"))
FILES = sorted(file for suffix in ("sdf", "world") for file in (WHEELS / "pydrake").rglob(f"*.{suffix}"))


@pytest.mark.skipif(not FILES, reason="SCENECC_WHEELS names no folder with drake")
def test_wheels_contain_files_to_compare() -> None:
    assert len(FILES) >= 8


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_poses_and_masses_are_those_of_drake(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # For the process that asks Drake, and after what the tests themselves import.
    monkeypatch.setattr(sys, "path", [*sys.path, str(WHEELS)])
    monkeypatch.setenv("PYTHONPATH", str(WHEELS))
    made = import_scene(file, tmp_path / "scene.yaml").certificate
    assert made.engine == "Drake"
    assert made.compared >= 1
    assert max(made.position, made.angle, made.relative_mass) < 1e-6
