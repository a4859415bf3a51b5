"""Every scene of `scenes/` and its pack: the same to the bit, and a passport of one is replayed from the other."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenecc import load_scene, pack_scene, replay

SCENES = Path(__file__).parents[2] / "scenes"
FILES = sorted(file for folder in (".", "recipes", "parts") for file in (SCENES / folder).glob("*.yaml"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(SCENES)))
def test_a_pack_is_as_good_as_its_scene(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    pack = tmp_path / "scene.scn"
    pack_scene(file, pack)
    with load_scene(file, render=False) as scene, load_scene(pack, render=False) as packed:
        assert packed.state() == scene.state()
        last = scene.scene_idxs[-1]
        passports = scene.passport(last), packed.passport(last)
        for batch in (scene, packed):
            batch.step(10)
        expected = scene.state([last])
        assert packed.state([last]) == expected
    for passport, other in zip(passports, (pack, file), strict=True):
        with replay(passport, file=other, render=False) as batch:
            batch.step(10)
            assert batch.state() == expected
