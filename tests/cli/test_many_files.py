"""Many files: several processes, one that dies, parts of the files, what changed, and what was found before."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from cli.running import plain_environment
from plugins.command import scenecc

from scenecc.cli.many_files import run_each
from scenecc.jobs import Died

GOOD = "scenecc: 1\nentities:\n  a: {shapes: [{type: sphere, radius: 0.1}]}\n"
BAD = GOOD.replace("radius", "radios")


@pytest.fixture
def scenes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    folder = tmp_path / "scenes"
    folder.mkdir()
    for number in range(12):
        (folder / f"s{number:02}.yaml").write_text(BAD if number % 5 == 0 else GOOD)
    return folder


def findings(text: str) -> list[str]:
    return [line for line in text.splitlines() if ": error SC" in line]


def test_results_of_processes_are_in_item_order() -> None:
    import time

    def work(item: int) -> int:
        time.sleep(0.05 if item == 0 else 0)
        return item * item

    assert list(run_each(work, range(250), 3, "work")) == [item * item for item in range(250)]


@pytest.mark.parametrize("jobs", [1, 2, 4])
def test_a_crash_is_reported_at_its_item_only(jobs: int) -> None:
    def work(item: int) -> int:
        if item % 7 == 3:
            os.kill(os.getpid(), 9)
        return item

    found = list(run_each(work, range(30), jobs, "work"))
    assert found == [Died(-9) if item % 7 == 3 else item for item in range(30)]


def test_several_processes_give_the_same_findings(run, scenes: Path) -> None:
    alone = run("validate", "scenes", "--no-cache")
    several = run("validate", "scenes", "--no-cache", "--jobs", "3")
    assert (several.returncode, several.stdout, several.stderr) == (1, alone.stdout, alone.stderr)
    assert len(findings(alone.stdout)) == 3


def test_shards_cover_all_files(run, scenes: Path) -> None:
    parts = [run("validate", "scenes", "--shard", f"{part}/3") for part in (1, 2, 3)]
    whole = run("validate", "scenes")
    assert sorted(line for part in parts for line in findings(part.stdout)) == findings(whole.stdout)
    assert [part.stderr for part in parts] == ["4 files checked, 8 in other parts\n"] * 3
    assert run("validate", "scenes", "--shard", "0/3").returncode == 2


def test_findings_are_cached_until_a_file_changes(run, scenes: Path) -> None:
    part, file = scenes / "part.txt", scenes / "s00.yaml"
    part.write_text("scenecc: 1\nmaterials: {oak: {physical: {density: 700}}}\n")
    file.write_text(
        f"scenecc: 1\ninclude: [{part.name}]\nentities: {{a: {{shapes: [{{type: sphere, radius: 0.1}}]}}}}\n"
    )
    first = run("validate", "scenes/s00.yaml")
    assert "SC" in first.stdout
    assert run("validate", "scenes/s00.yaml").stdout == first.stdout
    part.write_text("scenecc: 1\n")
    assert run("validate", "scenes/s00.yaml").stdout == ""
    file.write_text(BAD)
    assert len(findings(run("validate", "scenes/s00.yaml").stdout)) == 1
    file.write_text(GOOD)
    assert run("validate", "scenes/s00.yaml").stdout == ""


def test_missing_files_are_not_cached(run, scenes: Path) -> None:
    file = scenes / "s01.yaml"
    file.write_text("scenecc: 1\nentities: {a: {shapes: [{type: triangle_mesh, file: a.ply}], body_type: static}}\n")
    assert "SC401" in run("validate", "scenes/s01.yaml").stdout
    (scenes / "a.ply").write_text("ply\n")
    assert "SC401" not in run("validate", "scenes/s01.yaml").stdout


def test_the_cache_depends_on_the_options(run, scenes: Path) -> None:
    (scenes / "s01.yaml").write_text(
        "scenecc: 1\nparams: {r: 0.1}\nentities: {a: {shapes: [{type: sphere, radius: '${r}'}]}}\n"
    )
    assert run("validate", "scenes/s01.yaml").returncode == 0
    assert run("validate", "scenes/s01.yaml", "--set", "r=-1").returncode == 1
    assert run("validate", "scenes/s01.yaml").returncode == 0


def test_an_unwritable_cache_is_ignored(run, scenes: Path, tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("")
    assert len(findings(run("validate", "scenes").stdout)) == 3


def run_in(folder: Path, *arguments: str) -> tuple[str, int]:
    """What a command says on standard error in a folder, and its status."""
    done = scenecc(list(arguments), cwd=folder, stdin=b"", env=plain_environment())
    return done.stderr.decode(), done.returncode


def git(folder: Path, *arguments: str) -> None:
    who = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
    subprocess.run(["git", *who, *arguments], cwd=folder, check=True, capture_output=True)


def test_changed_since_checks_only_changed_scenes(run, scenes: Path, tmp_path: Path) -> None:
    (scenes / "part.txt").write_text("scenecc: 1\n")
    (scenes / "s01.yaml").write_text(f"scenecc: 1\ninclude: [part.txt]\n{GOOD.removeprefix('scenecc: 1')}")
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", "scenes")
    git(tmp_path, "commit", "-qm", "one")
    assert (
        run("validate", "scenes", "--changed-since", "HEAD").stderr == "12 files checked\n"
    )  # what they use is not known
    assert run("validate", "scenes", "--changed-since", "HEAD").stderr == "0 files checked, 12 unchanged\n"
    (scenes / "part.txt").write_text("scenecc: 1\n# other\n")
    (scenes / "s07.yaml").write_text(BAD)
    (scenes / "new.yaml").write_text(BAD)
    done = run("validate", "scenes", "--changed-since", "HEAD")
    assert done.stderr == "3 files checked, 10 unchanged\n"
    assert [line.split(":")[0] for line in findings(done.stdout)] == ["scenes/new.yaml", "scenes/s07.yaml"]


def test_changed_since_works_with_relative_git_paths(scenes: Path, tmp_path: Path) -> None:
    git(tmp_path, "init", "-q")
    git(tmp_path, "config", "diff.relative", "true")
    git(tmp_path, "add", "scenes")
    git(tmp_path, "commit", "-qm", "one")
    run_in(scenes, "validate", ".")  # so that it is known what they use
    (scenes / "s07.yaml").write_text(BAD)
    assert run_in(scenes, "validate", ".", "--changed-since", "HEAD") == ("1 file checked, 11 unchanged\n", 1)


def test_changed_since_checks_untracked_files(scenes: Path, tmp_path: Path) -> None:
    (tmp_path / "clone").mkdir()
    git(tmp_path / "clone", "init", "-q")
    git(tmp_path / "clone", "commit", "-qm", "one", "--allow-empty")
    for _ in range(2):
        said, _ = run_in(tmp_path / "clone", "validate", str(scenes), "--changed-since", "HEAD")
        assert said == "12 files checked\n"


def test_an_unknown_git_revision_is_wrong_usage(run, scenes: Path, tmp_path: Path) -> None:
    git(tmp_path, "init", "-q")
    done = run("validate", "scenes", "--changed-since", "--output=x")
    assert done.returncode == 2
    assert "SC918" in done.stdout
    assert not (tmp_path / "x").exists()


def test_an_included_part_is_not_checked_as_a_scene(run, tmp_path: Path) -> None:
    part = "scenecc: 1\nentities: {ball: {pose: [0, 0, 1], shapes: [{type: sphere, radius: 0.1}]}}\n"
    (tmp_path / "ball.yaml").write_text(part)
    assert "SC852" in run("check", "ball.yaml", "--settle", "0").stdout
    whole = "scenecc: 1\nentities: {ground: {use: scenecc:ground}, ball: {use: ball.yaml}}\n"
    (tmp_path / "whole.yaml").write_text(f"# See ball.yaml.\n{whole}")
    assert run("check", ".", "--settle", "0").returncode == 0
    (tmp_path / "whole.yaml").write_text(f"# See ball.yaml.\n{whole.replace('use: ball.yaml', 'use: scenecc:sphere')}")
    assert "SC852" in run("check", ".", "--settle", "0").stdout
