"""The scenes of this folder hold what their files say, and build as batches."""

from pathlib import Path

import pytest
import scenecc

SCENES = ["scene.yaml"]  # add yours; `robot.yaml` is a part of them


@pytest.mark.parametrize("name", SCENES)
def test_nothing_is_found_in_a_scene(name: str) -> None:
    # All of `scenecc check`: mistakes, overlaps, what falls or topples, and `expect`, with two seeds.
    found = scenecc.check_scene(Path(__file__).parent / name, seeds=[0, 1])
    assert not found, "\n".join(map(str, found))


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_runs_as_a_batch(name: str) -> None:
    with scenecc.load_scene(Path(__file__).parent / name, num_scenes=2) as batch:
        batch.step(10, check=True)  # raises if a number is no longer finite
        batch.reset(seed=1)  # the next episode
