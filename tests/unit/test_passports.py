"""A passport builds its scene again in another process, to the bit, or names what differs."""

from __future__ import annotations

import json
import pickle
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plugins.mesh_files import plan_of

import scenecc
from scenecc import SceneError, compile_scene, load_scene, replay
from scenecc.backends.sapien.passport import build_versions

SCENES = Path(__file__).parents[2] / "scenes"
FILES = sorted(file for folder in (".", "recipes", "parts") for file in (SCENES / folder).glob("*.yaml"))

OTHER_PROCESS = """
import pickle, sys, scenecc
out = open(sys.argv[2], "wb")
for line in open(sys.argv[1]):
    with scenecc.replay(line, render=False) as batch:
        start = batch.state()
        batch.step(30)
        pickle.dump((start, batch.state(), batch.passport(batch.scene_idxs[0])), out)
"""


def _built(file: Path) -> scenecc.SceneBatch:
    """Seven scenes of a file, or as many as it has values for."""
    try:
        return load_scene(file, num_scenes=7, render=False)
    except SceneError:
        return load_scene(file, render=False)


def test_passports_rebuild_scenes_in_another_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One scene of each file, at the start of the build or of a reset, and 30 steps later."""
    monkeypatch.chdir(SCENES.parent)
    random, expected, passports = Random(15), [], []
    assert len(FILES) >= 40
    for number, file in enumerate(FILES):
        with _built(file) as batch:
            index = random.choice(batch.scene_idxs)
            if number % 3:
                batch.reset(seed=random.randrange(1000), scene_idxs=[index], exact=True)
            start = batch.state([index])
            batch.step(30)
            passport = batch.passport(index)
            expected.append((start, batch.state([index]), passport))
            passports.append(passport)
    lines = tmp_path / "passports.txt"
    lines.write_text("\n".join(passports))
    subprocess.run([sys.executable, "-c", OTHER_PROCESS, lines, tmp_path / "states"], check=True)
    with (tmp_path / "states").open("rb") as states:
        for file, wanted in zip(FILES, expected, strict=True):
            assert pickle.load(states) == wanted, file


SCENE = """scenecc: 1
include: [parts/base.yaml]
num_scenes: 6
params:
  half: {type: number, default: 0.02}
draws:
  heap: {uniform: [0.1, 0.3]}
entities:
  ball:
    mass: {uniform: [0.5, 0.9]}
    pose: {p: [{uniform: [-1, 1]}, 0, "${heap}"]}
    shapes: [{type: sphere, radius: {once: {uniform: [0.01, 0.02]}}}]
  cube: {pose: [0, 2, 0.02], shapes: [{type: sphere, radius: "${half}"}]}
"""
BASE = """scenecc: 1
entities:
  bowl: {body_type: static, visuals: [{type: mesh, file: ../bowl.obj}]}
"""


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scene with an include and a mesh, in the current folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/base.yaml").write_text(BASE)
    for name in ("bowl.obj", "bowl.mtl", "checker.png"):
        shutil.copy(SCENES / "assets" / name, tmp_path)
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def _told(passport: str, **arguments: Any) -> list[str]:
    with pytest.raises(SceneError) as failure:
        replay(passport, render=False, **arguments)
    return [f"{found.code} {found.message}" for found in failure.value.diagnostics]


def test_a_passport_is_one_short_line(scene: Path) -> None:
    """It survives as a string of JSON, names all files, and is the same for a scene in a batch of any size."""
    with load_scene(scene, render=False, params={"half": 0.03}) as batch:
        text = batch.passport(4)
        assert text.isascii()
        assert "\n" not in text
        content = json.loads(json.loads(json.dumps(text)))
        assert {key: content[key] for key in ("file", "params", "scene", "num_scenes", "seed")} == {
            "file": "scene.yaml",
            "params": {"half": 0.03},
            "scene": 4,
            "num_scenes": 6,
            "seed": 0,
        }
        assert [*content["files"]] == ["bowl.mtl", "bowl.obj", "checker.png", "parts/base.yaml"]
        assert "reset" not in content
        for number in (2, 3):
            batch.step(number)
            assert batch.passport(4) == text, "it is of the start"
    with replay(text, render=False) as again:
        assert (again.scene_idxs, again.passport(4)) == ((4,), text)
        assert again.entities["ball"].pose[0, 2] == batch.plan.entities[1].pose.row(4)[2].astype(np.float32)


def test_a_passport_describes_the_last_reset(scene: Path) -> None:
    """Each scene has its own seed, and draws that it was given; sizes are of the seed of the build."""
    with load_scene(scene, render=False, seed=3) as batch:
        before = batch.passport(5)
        batch.reset(seed=[8, 9], scene_idxs=[2, 4], draws={"heap": [0.5, 0.75]}, exact=True)
        assert batch.passport(5) == before
        text = batch.passport(4)
        content = json.loads(text)
        assert (content["seed"], content["reset"]) == (3, {"seed": 9, "draws": {"heap": 0.75}})
        with replay(text, render=False) as again:
            assert again.state() == batch.state([4])
            assert again.entities["ball"].pose[0, 2] == np.float32(0.75)
            again.step(50)
            batch.step(50)
            assert again.state() == batch.state([4])
        kept = batch.passports([4])[0]
        batch.reset(scene_idxs=[4])
        assert json.loads(batch.passport(4))["reset"] == {"seed": 9, "draws": {}}
        assert str(kept) == text, "made later, and of the start at which it was taken"
        batch.reset(seed=3)
        assert batch.passport(5) == before


def test_given_draws_are_in_the_passport(scene: Path) -> None:
    """Those of a build, one row a scene; and a dict is its own file."""
    document = {
        "scenecc": 1,
        "num_scenes": 3,
        "draws": {"high": {"uniform": [0, 1]}},
        "entities": {"ball": {"pose": [0, 0, "${high}"], "shapes": [{"type": "sphere", "radius": 0.1}]}},
    }
    with load_scene(document, render=False, draws={"high": [0.25, 0.5, 0.75]}) as batch:
        text = batch.passport(1)
        with replay(text, file=document, render=False) as again:
            assert again.state() == batch.state([1])
            assert again.passport(1) == text
    assert _told(text) == ["SC931 the scene of this passport was not a file"]
    assert "SC931 the scene file differs" in _told(text, file=scene)[0]
    with (
        load_scene(compile_scene(scene), render=False) as batch,
        pytest.raises(ValueError, match="built from a plan object"),
    ):
        batch.passport(0)


CHANGES: dict[str, tuple[Callable[[Path], object], list[str]]] = {
    "mesh": (
        lambda folder: (folder / "bowl.obj").write_text((folder / "bowl.obj").read_text() + "# new\n"),
        ["SC931 `bowl.obj` differs: its SHA-256 was"],
    ),
    "texture": (
        lambda folder: shutil.copy(SCENES / "assets/wear.png", folder / "checker.png"),
        ["SC931 `checker.png` differs: its SHA-256 was"],
    ),
    "include": (
        lambda folder: (folder / "parts/base.yaml").write_text(BASE + "# new\n"),
        ["SC931 `parts/base.yaml` differs: its SHA-256 was"],
    ),
    "broken include": (
        lambda folder: (folder / "parts/base.yaml").write_text(BASE + "seed: 3\n"),
        ["SC931 `parts/base.yaml` differs: its SHA-256 was", "SC230 an included file cannot have `seed`"],
    ),
    "lost mesh": (
        lambda folder: (folder / "bowl.obj").unlink(),
        [
            "SC931 `bowl.obj` is missing, or the scene no longer uses it: its SHA-256 was",
            "SC401 there is no file `../bowl.obj`",
        ],
    ),
    "default": (
        lambda folder: (folder / "scene.yaml").write_text(SCENE.replace("0.02}", "0.025}")),
        [
            "SC931 the scene file differs: its SHA-256 was",
            "SC932 the default of the parameter `half` was 0.02, but is 0.025",
        ],
    ),
    "no mesh": (
        lambda folder: (folder / "parts/base.yaml").write_text("scenecc: 1\n"),
        [
            "SC931 `bowl.mtl` is missing, or the scene no longer uses it: its SHA-256 was",
            "SC931 `bowl.obj` is missing, or the scene no longer uses it: its SHA-256 was",
            "SC931 `checker.png` is missing, or the scene no longer uses it: its SHA-256 was",
            "SC931 `parts/base.yaml` differs: its SHA-256 was",
        ],
    ),
    "broken": (
        lambda folder: (folder / "scene.yaml").write_text(SCENE + "nonsense: 1\n"),
        ["SC931 the scene file differs: its SHA-256 was", "SC101 unknown key `nonsense`"],
    ),
    "gone": (lambda folder: (folder / "scene.yaml").unlink(), ["SC931 there is no file `scene.yaml` here"]),
}


@pytest.mark.parametrize("name", CHANGES)
def test_replay_names_the_changed_files(scene: Path, name: str) -> None:
    """Every file and default that differs, with what it was and is."""
    with load_scene(scene, render=False) as batch:
        passport = batch.passport(2)
        change, expected = CHANGES[name]
        change(scene.parent)
        assert batch.passport(3) != passport, "hashes are known since the first passport"
    told = _told(passport)
    assert len(told) == len(expected)
    assert all(found.startswith(wanted) for found, wanted in zip(told, expected, strict=True)), told


def test_files_changed_before_the_first_passport_are_noticed(scene: Path) -> None:
    """A passport never has the hash of what was not built."""
    with load_scene(scene, render=False) as batch:
        (scene.parent / "bowl.obj").touch()
        with pytest.raises(OSError, match="changed since the scene was compiled"):
            batch.passport(2)


def test_replay_names_a_different_version_or_state(scene: Path) -> None:
    """Versions alone can be let pass."""
    with load_scene(scene, render=False) as batch:
        content = json.loads(batch.passport(2))
    content["versions"] |= {"sapien": "3.0.1", "mujoco": "3.2.0"}
    text = json.dumps(content)
    assert _told(text) == [
        "SC933 the version of sapien was 3.0.1, but is 3.0.3",
        "SC933 the version of mujoco was 3.2.0, but no longer exists",
    ]
    replay(text, any_version=True, render=False).close()
    content["seed"] = 1
    told = _told(json.dumps(content), any_version=True)
    assert told[-1].startswith("SC934 the initial state of scene 2 has the hash ")
    assert told[-1].endswith(f", but had {content['state']}")


@pytest.mark.parametrize(
    ("name", "use", "packages"),
    [("a.dae", "hull", {"pycollada"}), ("a.obj", "decomposed", {"coacd", "trimesh"}), ("a.obj", "hull", set[str]())],
)
def test_a_passport_has_the_versions_of_mesh_libraries(name: str, use: str, packages: set[str]) -> None:
    found = set(build_versions(plan_of([Path(name)], use)))
    assert found - {"scenecc", "sapien", "numpy", "python", "platform"} == packages


def test_replay_finds_the_scene_from_another_folder(scene: Path, tmp_path: Path) -> None:
    """By `file`; the names of its files do not depend on the folder."""
    with load_scene(scene, render=False) as batch:
        passport = batch.passport(2)
    shutil.copytree(tmp_path, tmp_path / "copy")
    with load_scene("copy/scene.yaml", render=False) as batch:
        assert json.loads(batch.passport(2)) == json.loads(passport) | {"file": "copy/scene.yaml"}
    replay(passport, file=tmp_path / "copy/scene.yaml", render=False).close()


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=9), inner, max_size=3),
    max_leaves=5,
)
PASSPORT = {
    "scenecc_passport": 1,
    "file": "no-such-file.yaml",
    "sha256": "0" * 32,
    "files": {"bowl.obj": "0" * 32},
    "num_scenes": 4,
    "scene": 2,
    "seed": 0,
    "reset": {"seed": 1, "draws": {}},
    "versions": {"scenecc": "0.1.0"},
    "state": "0" * 32,
}


@given(st.sampled_from([*PASSPORT, "params", "draws", "other"]), VALUES)
def test_a_hostile_passport_is_refused(key: str, value: Any) -> None:
    """Any value at any key is a diagnostic and no other exception; of the right type, the file is missed."""
    assert all(found[:5] in {"SC930", "SC931"} for found in _told(json.dumps({**PASSPORT, key: value})))


@pytest.mark.parametrize(
    "text",
    [
        "{",
        '{"scenecc_passport": 2}',
        '{"scenecc_passport": 1, "scenecc_passport": 1}',
        '{"a": ' * 100_000,
        '{"scenecc_passport": ' + "1" * 10_000 + "}",
        json.dumps({**PASSPORT, "file": "../scene.yaml"}),
        json.dumps({**PASSPORT, "file": "/etc/passwd"}),
        json.dumps({**PASSPORT, "num_scenes": 10**18}),
        json.dumps({**PASSPORT, "num_scenes": 4.0}),
    ],
)
def test_an_invalid_passport_is_reported(text: str) -> None:
    """With one code, whatever is wrong."""
    assert [found[:5] for found in _told(text)] == ["SC930"]
