"""`scenecc patch` as a process."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from cli.running import CUBE

import scenecc
from scenecc import patch_scene

WITH_COMMENTS = CUBE.replace("\n  cube", "  # all of them\n  cube")
MASS = '[{"op": "add", "path": "/entities/cube/mass", "value": 0.2}]'
WRONG = '[{"op": "add", "path": "/entities/cube/masss", "value": 0.2}]'
PATCHED = WITH_COMMENTS.replace("0.3]}]}", "0.3]}], mass: 0.2}")


@pytest.fixture
def scene(cube: Path) -> Path:
    cube.write_text(WITH_COMMENTS)
    return cube


def test_a_patch_is_an_argument_a_file_or_standard_input(run: Any, scene: Path, tmp_path: Path) -> None:
    (tmp_path / "edits.json").write_text(MASS)
    for arguments, stdin in (((MASS,), ""), (("edits.json",), ""), (("-",), MASS)):
        scene.write_text(WITH_COMMENTS)
        done = run("patch", "cube.yaml", *arguments, stdin=stdin)
        assert (done.returncode, done.stderr) == (0, "cube.yaml: written\n")
        assert scene.read_text() == PATCHED
        assert "+  cube: {shapes: [{type: box, half_size: [0.1, 0.2, 0.3]}], mass: 0.2}" in done.stdout.splitlines()


def test_new_errors_prevent_writing_unless_allowed(run: Any, scene: Path) -> None:
    done = run("patch", "cube.yaml", WRONG)
    assert done.returncode == 1
    assert "cube.yaml: not written: it would have new errors" in done.stderr
    assert "cube.yaml:3:61: error SC101: unknown key `masss`" in done.stderr
    assert scene.read_text() == WITH_COMMENTS
    found = json.loads(run("patch", "cube.yaml", WRONG, "--allow-errors", "--format", "json").stdout)
    assert found["written"]
    assert [one["code"] for one in found["diagnostics"]] == ["SC101"]
    # An old error does not prevent a further patch, whose result then has none.
    assert json.loads(run("patch", "cube.yaml", MASS, "--format", "json").stdout)["written"]
    done = run("patch", "cube.yaml", '[{"op": "remove", "path": "/entities/cube/masss"}]')
    assert (done.returncode, scene.read_text()) == (0, PATCHED)


def test_errors_of_stages_that_did_not_run_before_are_not_new(scene: Path) -> None:
    scene.write_text(CUBE.replace("half_size", "half_sizes").replace("type: box", "material: gone, type: box"))
    renamed = {"op": "move", "from": "/entities/cube/shapes/0/half_sizes", "path": "/entities/cube/shapes/0/half_size"}
    mended = patch_scene(scene, [renamed])
    assert mended.written
    assert [one.stage for one in mended.diagnostics if one.severity == "error"] == ["names and poses"]
    back = {**renamed, "from": renamed["path"], "path": renamed["from"]}
    with pytest.raises(scenecc.SceneError, match="half_sizes"):
        patch_scene(scene, [back])


def test_an_old_error_that_moves_is_not_new(scene: Path) -> None:
    scene.write_text(CUBE.replace("half_size", "half_sizes"))
    assert patch_scene(scene, [{"op": "move", "from": "/entities/cube", "path": "/entities/box"}]).written
    first = {"op": "add", "path": "/entities/box/shapes/0", "value": {"type": "sphere", "radius": 0.1}}
    assert patch_scene(scene, [first]).written


def test_a_dry_run_writes_nothing(run: Any, scene: Path) -> None:
    found = json.loads(run("patch", "cube.yaml", MASS, "--dry-run", "--format", "json").stdout)
    assert (found["written"], found["diff"].count("\n"), found["diagnostics"]) == (False, 7, [])
    assert scene.read_text() == WITH_COMMENTS


def test_a_patch_that_cannot_be_applied_is_wrong_usage(run: Any, scene: Path) -> None:
    done = run("patch", "cube.yaml", '[{"op": "remove", "path": "/entities/cub"}]', "--format", "json")
    found = json.loads(done.stdout)
    assert (done.returncode, found["written"], found["diff"]) == (2, False, "")
    (one,) = found["diagnostics"]
    assert (one["code"], one["line"], one["hint"]) == ("SC941", 2, "did you mean `cube`?")
    for arguments in (("gone.yaml", MASS), ("cube.yaml", "gone.json"), ("-", MASS), ("cube.yaml", "[")):
        assert run("patch", *arguments).returncode == 2
    assert scene.read_text() == WITH_COMMENTS


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_encoding_and_line_ends_are_kept(scene: Path, encoding: str) -> None:
    scene.write_bytes(WITH_COMMENTS.replace("\n", "\r\n").replace("all", "é").encode(encoding))
    assert patch_scene(scene, json.loads(MASS)).written
    assert scene.read_bytes() == PATCHED.replace("\n", "\r\n").replace("all", "é").encode(encoding)


def test_a_link_stays_a_link(scene: Path, tmp_path: Path) -> None:
    link = tmp_path / "link.yaml"
    link.symlink_to(scene)
    assert patch_scene(link, json.loads(MASS)).written
    assert link.is_symlink()
    assert scene.read_text() == PATCHED


def test_patch_scene_raises_for_new_errors(scene: Path) -> None:
    with pytest.raises(scenecc.SceneError, match="SC101"):
        patch_scene(scene, json.loads(WRONG))
    tried = patch_scene(scene, json.loads(WRONG), dry_run=True)
    assert (tried.written, tried.refused, [one.code for one in tried.diagnostics]) == (False, True, ["SC101"])
    assert not patch_scene(scene, []).written
    with pytest.raises(TypeError, match="operations"):
        patch_scene(scene, 3)  # pyright: ignore[reportArgumentType]
    assert scene.read_text() == WITH_COMMENTS


def test_a_file_that_is_read_only_or_changes_meanwhile_is_not_written(
    scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patches:
        patches.setattr("os.access", lambda *_: False)  # root may write everything
        with pytest.raises(PermissionError, match="Permission denied"):
            patch_scene(scene, json.loads(MASS))
    assert scene.read_text() == WITH_COMMENTS

    def compile_and_change(*_: Any) -> list[Any]:
        scene.write_text(CUBE)
        return []

    monkeypatch.setattr("scenecc.scene_file.patch._compile", compile_and_change)
    with pytest.raises(OSError, match="it has changed meanwhile"):
        patch_scene(scene, json.loads(MASS))
    assert scene.read_text() == CUBE
