from __future__ import annotations

import json
import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest
from cli.running import CUBE, plain_environment

TYPO = CUBE.replace("half_size", "half_sizes")
UNUSED_MATERIAL = CUBE + "materials: {oak: {physical: {density: 700}}}\n"


def test_a_valid_file_gives_status_0_and_no_output(run, cube: Path) -> None:
    done = run("validate", cube)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "1 file checked\n")


def test_a_bad_file_gives_status_1_with_line_column_and_hint(run, tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text(TYPO)
    done = run("validate", "bad.yaml")
    assert done.returncode == 1
    assert "bad.yaml:3:31: error SC101" in done.stdout
    assert "did you mean `half_size`?" in done.stdout


def test_validate_reads_standard_input(run) -> None:
    assert run("validate", "-", stdin=CUBE).returncode == 0
    bad = run("validate", "-", stdin=TYPO)
    assert bad.returncode == 1
    assert "<stdin>:3:31: error SC101" in bad.stdout


@pytest.mark.parametrize("junk", [b"", b"\x00\xff\xfe\x80", b"[" * 5000, b"a: &a [*a]\n", b"!!python/name:os.system\n"])
def test_junk_gives_a_diagnostic(run, junk: bytes) -> None:
    done = run("validate", "-", "--format", "json", stdin=junk)
    assert done.returncode == 1
    assert json.loads(done.stdout)["diagnostics"]


def test_a_warning_fails_only_a_strict_check(run, tmp_path: Path) -> None:
    (tmp_path / "warn.yaml").write_text(UNUSED_MATERIAL)
    lenient, strict = run("validate", "warn.yaml"), run("validate", "--strict", "warn.yaml")
    assert (lenient.returncode, strict.returncode) == (0, 1)
    assert ": warning SC" in lenient.stdout
    assert lenient.stdout == strict.stdout


def test_several_paths_give_one_json_document(run, tmp_path: Path, cube: Path) -> None:
    folder = tmp_path / "scenes"
    folder.mkdir()
    for name in ("b.yaml", "a.yaml"):
        (folder / name).write_text(TYPO)
    (folder / "compose.yaml").write_text("services: {}\n")
    done = run("validate", "--format", "json", "scenes", cube, "gone.yaml")
    found = json.loads(done.stdout)["diagnostics"]
    assert done.returncode == 2
    assert [d["file"] for d in found if d["code"] == "SC101"] == ["scenes/a.yaml", "scenes/b.yaml"]
    assert [d["file"] for d in found if d["code"] == "SC901"] == ["gone.yaml"]
    assert done.stderr == ""
    text = run("validate", "scenes", cube)
    assert text.stderr == "3 files checked, 1 other file skipped\n"


def test_a_folder_without_scenes_is_an_error(run, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    done = run("validate", "empty")
    assert done.returncode == 2
    assert "SC902" in done.stdout


def test_scenes_only_skips_other_files(run, tmp_path: Path, cube: Path) -> None:
    (tmp_path / "compose.yaml").write_text("services: {}\n")
    assert run("validate", "compose.yaml").returncode == 1
    done = run("validate", "--scenes-only", "compose.yaml", cube)
    assert (done.returncode, done.stdout) == (0, "")
    assert done.stderr == "1 file checked, 1 other file skipped\n"
    assert run("validate", "--scenes-only", "compose.yaml").returncode == 0


def test_validate_prints_sarif_and_github(run, tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text(TYPO)
    sarif = json.loads(run("validate", "--format", "sarif", "bad.yaml").stdout)
    assert {result["ruleId"] for result in sarif["runs"][0]["results"]} >= {"SC101"}
    github = run("validate", "--format", "github", "bad.yaml")
    assert re.search(r"^::error file=bad\.yaml,line=3,col=31", github.stdout, re.MULTILINE)


def test_limit_raises_a_limit_and_refuses_unknown_names(run, tmp_path: Path) -> None:
    (tmp_path / "deep.yaml").write_text(CUBE + "x-deep: " + "[" * 150 + "]" * 150 + "\n")
    assert run("validate", "deep.yaml").returncode == 1
    assert run("validate", "deep.yaml", "--limit", "depth=200").returncode == 0
    for wrong in ("dept=200", "depth=many", "depth", "depth=0", "depth=-1", "depth=" + "9" * 5000):
        done = run("validate", "deep.yaml", "--limit", wrong)
        assert done.returncode == 2
        assert "--limit" in done.stderr


def test_an_outside_asset_needs_permission(run, tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    (tmp_path / "part.obj").write_text(obj)
    shape = "{type: convex_mesh, file: ../part.obj}"
    (tmp_path / "in" / "scene.yaml").write_text(CUBE.replace("{type: box, half_size: [0.1, 0.2, 0.3]}", shape))
    assert run("validate", "in/scene.yaml").returncode == 1
    assert run("validate", "in/scene.yaml", "--allow-outside-assets").returncode == 0
    assert run("validate", "in/scene.yaml", "--asset-root", ".").returncode == 0
    done = run("validate", "in/scene.yaml", "--asset-root", "nodir")
    assert done.returncode == 2
    assert "'--asset-root': there is no folder `nodir`" in done.stderr


def test_colour_is_used_only_on_terminals(run, tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text(TYPO)
    assert "\x1b[" not in run("validate", "bad.yaml").stdout
    assert "\x1b[" in on_terminal(tmp_path, "validate", "bad.yaml")
    assert "\x1b[" not in on_terminal(tmp_path, "validate", "bad.yaml", NO_COLOR="1").replace("\r\x1b[K", "")


def on_terminal(folder: Path, *arguments: str, **changes: str) -> str:
    """What `scenecc` writes to a terminal."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "scenecc", *arguments],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=theirs,
        stderr=theirs,
        env=plain_environment(**changes),
    )
    os.close(theirs)
    shown = bytearray()
    while True:
        try:
            part = os.read(ours, 4096)
        except OSError:  # Linux says so when the last writer has gone
            break
        shown += part
    os.close(ours)
    process.wait(timeout=60)
    return shown.decode()


def test_validating_a_scene_without_meshes_loads_no_engine(run, cube: Path) -> None:
    script = (
        "import sys\n"
        "from scenecc.cli.app import main\n"
        f"sys.argv = ['scenecc', 'validate', {str(cube)!r}]\n"
        "try:\n"
        "    main()\n"
        "finally:\n"
        "    loaded = {'sapien', 'trimesh', 'rich', 'coacd', 'jsonschema'} & set(sys.modules)\n"
        "    print(sorted(loaded))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout) == (0, "[]\n"), done.stderr
