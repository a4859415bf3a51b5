"""The files of a plan: what they held when it was made is what is built."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from plugins.mesh_files import TETRA, write

from scenecc import SceneError, compare_scenes, compile_scene, load_scene, plan_text, validate
from scenecc.backends.sapien import build

SCENE = """scenecc: 1
entities:
  thing:
    mass: 1
    collisions: [{type: convex_mesh, file: thing.obj}]
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    folder = tmp_path / "scene"
    folder.mkdir()
    write(folder, "thing.obj", "mtllib thing.mtl\n" + TETRA)
    write(folder, "thing.mtl", "newmtl a\n")
    return write(folder, "scene.yaml", SCENE)


def saved(scene: Path) -> Path:
    return write(scene.parent, "plan.json", plan_text(compile_scene(scene), base=scene.parent))


def codes(source: object) -> list[str]:
    return [one.code for one in validate(source)]  # pyright: ignore[reportArgumentType]


def test_a_plan_has_the_hashes_of_its_files(scene: Path) -> None:
    plan = saved(scene)
    (file,) = json.loads(plan.read_text())["files"]
    assert (file["uri"], len(file["sha256"]), [one["uri"] for one in file["names"]]) == ("thing.obj", 64, ["thing.mtl"])
    assert codes(plan) == []
    assert compile_scene(plan) == compile_scene(scene)


@pytest.mark.parametrize("name", ["thing.obj", "thing.mtl"])
@pytest.mark.parametrize("kept", ["as JSON", "as an object"])
def test_a_file_that_has_changed_is_not_built(name: str, kept: str, scene: Path) -> None:
    plan = saved(scene) if kept == "as JSON" else compile_scene(scene)
    changed = scene.parent / name
    changed.write_text(changed.read_text() + "# more\n")
    for built in (compile_scene, load_scene):
        with pytest.raises(SceneError) as error:
            built(plan)
        (told,) = error.value.diagnostics
        assert told.code == "SC716"
        assert name in told.message
        assert told.message.count("SHA-256") == 2
    assert codes(compile_scene(scene)) == []


def test_a_removed_or_new_file_counts_as_changed(scene: Path) -> None:
    plan = saved(scene)
    (scene.parent / "thing.mtl").unlink()
    assert codes(plan) == ["SC716"]
    without = saved(scene)
    assert codes(without) == []
    write(scene.parent, "thing.mtl", "newmtl a\n")
    assert codes(without) == ["SC716"]


@pytest.mark.parametrize("version", [1, 2])
def test_a_plan_without_hashes_is_built_with_a_warning(version: int, scene: Path) -> None:
    plan = json.loads(saved(scene).read_text()) | {"scenecc_plan": version, "files": [{"uri": "thing.obj"}]}
    (told,) = validate(write(scene.parent, "old.json", json.dumps(plan)))
    assert (told.code, told.severity, told.path) == ("SC717", "warning", "files[0]")


def test_a_plan_cannot_read_outside_files_or_pipes(scene: Path) -> None:
    plan = saved(scene)
    file = scene.parent / "thing.obj"
    file.rename(scene.parent.parent / "thing.obj")
    file.symlink_to(scene.parent.parent / "thing.obj")
    assert codes(plan) == ["SC402"]
    file.unlink()
    os.mkfifo(file)
    assert codes(plan) == ["SC404"]
    plan.write_text(plan.read_text().replace('"thing.obj"', '"nowhere/../thing.obj"'))
    assert codes(plan) == ["SC401"]


def test_a_file_that_changes_between_check_and_engine_is_not_built(
    scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = build.build_scenes

    def late(*args: object, **options: object) -> object:
        write(scene.parent, "thing.obj", TETRA.replace("0.1", "0.7"))
        return real(*args, **options)  # pyright: ignore[reportArgumentType]

    monkeypatch.setattr(build, "build_scenes", late)
    with pytest.raises(SceneError) as error:
        load_scene(scene, render=False)
    assert [one.code for one in error.value.diagnostics] == ["SC422"]


def test_a_file_changed_after_reading_stops_the_build(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = build.audit_scenes

    def late(*args: object, **options: object) -> object:
        write(scene.parent, "thing.mtl", "newmtl b\n")
        return real(*args, **options)  # pyright: ignore[reportArgumentType]

    monkeypatch.setattr(build, "audit_scenes", late)
    with pytest.raises(SceneError) as error:
        load_scene(scene, render=False)
    assert [one.code for one in error.value.diagnostics] == ["SC422"]


def test_another_mesh_of_the_same_name_is_a_difference(scene: Path) -> None:
    before = compile_scene(scene)
    assert compare_scenes(before, scene) == []
    other = scene.parent.parent / "other"
    other.mkdir()
    write(other, "thing.obj", TETRA.replace("0.1", "0.2"))
    write(other, "scene.yaml", SCENE)
    (found,) = compare_scenes(before, other / "scene.yaml")
    assert (found.name, found.kind) == ("thing", "changed")
    assert found.a is not None
    assert found.b is not None
    assert found.a != found.b
    assert found.a.startswith("thing.obj (SHA-256 ")
