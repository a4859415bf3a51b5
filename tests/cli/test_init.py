"""`scenecc init`."""

from __future__ import annotations

from pathlib import Path

import pytest
import typer

from scenecc.cli import init
from scenecc.cli.output import folder_refusal
from scenecc.starter import repository_address, starter_files


def test_init_writes_a_folder_and_prints_the_next_commands(run, tmp_path: Path) -> None:
    done = run("init", "demo")
    assert (done.returncode, done.stderr) == (0, "")
    files = starter_files("pick_place", "arm", repository_address())
    for name, content in files.items():
        assert (tmp_path / "demo" / name).read_bytes() == content
    commands = ["cd demo", "scenecc check scene.yaml", "scenecc view scene.yaml", "pytest"]
    assert [line.strip() for line in done.stdout.splitlines()[3:7]] == commands


def test_init_without_a_name_fills_the_current_folder(run, tmp_path: Path) -> None:
    done = run("init", "--template", "empty")
    assert done.returncode == 0
    assert {path.name for path in tmp_path.iterdir()} == {name.split("/")[0] for name in starter_files("empty", None)}
    again = run("init", "--template", "empty")
    assert (again.returncode, again.stdout) == (2, "")
    assert "error SC904: the folder `.` is not empty" in again.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--template", "kichen"], "did you mean `kitchen`?"),
        (["--robot", "pnada"], "did you mean `panda`?"),
        (["--robot", "x"], "known here: arm, panda"),
        (["--template", "locomotion", "--robot", "arm"], "it supports quadruped"),
    ],
    ids=str,
)
def test_init_refuses_unknown_templates_and_robots(arguments: list[str], words: str, run, tmp_path: Path) -> None:
    done = run("init", "demo", *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert words in " ".join(done.stderr.split())
    assert not (tmp_path / "demo").exists()


def test_hidden_names_may_exist_where_init_writes(tmp_path: Path) -> None:
    (tmp_path / ".git").mkdir()
    files = ["scene.yaml", ".pre-commit-config.yaml"]
    assert folder_refusal(str(tmp_path), files) is None
    assert folder_refusal(str(tmp_path)) == f"the folder `{tmp_path}` is not empty"
    assert folder_refusal("") == "the name of the folder is empty"
    (tmp_path / files[1]).touch()
    assert folder_refusal(str(tmp_path), files) == f"the folder `{tmp_path}` already has `.pre-commit-config.yaml`"


def test_a_robot_with_a_missing_extra_gives_an_install_hint(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(init, "find_spec", lambda name: None)
    with pytest.raises(typer.Exit):
        init.init("demo", template="pick_place", robot="panda")
    (line,) = capsys.readouterr().err.splitlines()
    assert "run `pip install --no-deps mani_skill" in line


def test_init_leaves_no_folder_that_it_cannot_write(run, tmp_path: Path) -> None:
    assert "there is no folder `no`" in run("init", "no/demo").stderr
    assert list(tmp_path.iterdir()) == []


def test_init_refuses_an_invalid_folder_name(run) -> None:
    done = run("init", "x" * 300)
    assert (done.returncode, done.stdout) == (2, "")
    assert "error SC904" in done.stderr
    assert "File name too long" in done.stderr
