"""Any scene of any document is built again from its passport, at the start of the build and of a reset."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plugins.nightly import examples
from plugins.scene_strategy import FOLDER, documents
from property.test_scenes import quick

from scenecc import SceneBatch, load_scene, replay


@pytest.fixture(autouse=True, scope="module")
def _beside_the_assets() -> Iterator[None]:
    """A dict names its files from the current folder."""
    before = Path.cwd()
    os.chdir(FOLDER)
    yield
    os.chdir(before)


def assert_same_again(batch: SceneBatch, index: int, scene: dict[str, Any]) -> None:
    text = batch.passport(index)
    with replay(text, file=scene, render=False) as again:
        assert again.passport(index) == text
        assert again.state() == batch.state([index])
        again.step(3)
        batch.step(3)
        assert again.state() == batch.state([index])


@given(documents().map(quick), st.data())
@settings(max_examples=examples(25), suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
def test_a_scene_is_built_again_from_its_passport(scene: dict[str, Any], data: st.DataObject) -> None:
    with load_scene(scene, render=False) as batch:
        index = data.draw(st.sampled_from(batch.scene_idxs))
        seed = data.draw(st.integers(0, 2**70))
        assert_same_again(batch, index, scene)
        try:
            batch.reset(seed, [index], exact=True)
        except ValueError:  # what it draws with this seed has no value
            return
        assert_same_again(batch, index, scene)
