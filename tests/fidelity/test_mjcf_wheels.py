"""The MJCF files of other packages, built, and judged by MuJoCo.

Skipped unless `SCENECC_WHEELS` names a folder with them:
`pip install --target FOLDER --no-deps dm_control robosuite metaworld newton`.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plugins.mujoco_judge import assert_same_machine

import scenecc

mujoco: Any = pytest.importorskip("mujoco")

WHEELS = Path(os.environ.get("SCENECC_WHEELS", "nowhere"))
PACKAGES = ("dm_control", "robosuite", "metaworld", "newton")
FILES = sorted(file for package in PACKAGES for file in (WHEELS / package).rglob("*.xml"))

REFUSED = {"SC480", "SC483"}
"""Nothing in the file, and what cannot be built."""

STEPS = 100

pytestmark = pytest.mark.skipif(not FILES, reason="SCENECC_WHEELS names no folder with MJCF files")


def test_wheels_contain_mjcf_files_to_compare() -> None:
    assert len(FILES) >= 100


@pytest.mark.parametrize("file", FILES, ids=lambda file: "-".join(file.parts[-3:]))
def test_kinematics_and_masses_of_mjcf_files_in_wheels_equal_mujocos(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    try:
        model = mujoco.MjModel.from_xml_path(str(file))
    except ValueError:
        pytest.skip("MuJoCo does not compile it: it is a part of another file")
    scene = {"scenecc": 1, "entities": {"robot": {"mjcf": str(file)}}}
    try:
        batch = scenecc.load_scene(scene, render=False, asset_roots=[WHEELS])
    except scenecc.SceneError as error:
        # Files of materials alone have nothing in them, and one fly has more links than bits.
        assert {one.code for one in error.diagnostics if one.severity == "error"} <= REFUSED  # noqa: PT017 - a good end
        assert model.ngeom == 0 or "drosophila" in file.stem
        return
    with batch:
        assert_same_machine(mujoco, model, batch)
        for _ in range(STEPS):
            batch.step()
        for held in batch.articulations.values():
            assert np.isfinite(held.objs[0].qpos).all()
            assert all(np.isfinite(link.entity_pose.p).all() for link in held.objs[0].links)
