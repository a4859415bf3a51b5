"""Every scene of the repository, decompiled and built again, is equal."""

from __future__ import annotations

from pathlib import Path

import pytest

import scenecc

ROOT = Path(__file__).parents[3]

SCENES = sorted([*(ROOT / "scenes").glob("*.yaml"), *(ROOT / "scenes" / "recipes").glob("*.yaml")])


OF_NO_FILE = {"assembling_kits", "cones", "rings", "terrain"}
"""Scenes with collision meshes that scenecc itself makes of numbers: no file has them."""


@pytest.mark.timeout(300)
@pytest.mark.parametrize("file", SCENES, ids=lambda file: file.stem)
def test_a_decompiled_scene_equals_the_live_scene(file: Path) -> None:
    with scenecc.record() as recording:
        batch = scenecc.load_scene(file, render=False)
    with batch:
        known = file.stem not in OF_NO_FILE
        found = scenecc.decompile(batch.scenes, recording=recording, base=file.parent, check=known)
    told = [problem for problem in found.problems if "whose file is unknown" in problem]
    assert bool(told) is not known
    assert not known or found.is_equal, "\n".join(found.differences or ())[:3000]


@pytest.mark.render
@pytest.mark.parametrize("name", ["cameras", "materials", "parameters", "robot_door", "tutorial"])
def test_visuals_of_a_decompiled_scene_equal_the_live_scene(name: str) -> None:
    file = ROOT / "scenes" / f"{name}.yaml"
    with scenecc.record() as recording:
        batch = scenecc.load_scene(file, render=True)
    with batch:
        found = scenecc.decompile(batch.scenes, recording=recording, base=file.parent)
    assert found.is_equal, "\n".join(found.differences or ())[:3000]
