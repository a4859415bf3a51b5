"""How the process behaves whatever the command: help, wrong usage, pipes, interruption."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from scenecc.cli import app
from scenecc.cli.app import COMMANDS
from scenecc.version import VERSION

COMMAND_NAMES = list(COMMANDS)


def test_the_version_is_printed(run) -> None:
    done = run("--version")
    assert (done.returncode, done.stdout) == (0, f"scenecc {VERSION}\n")


def test_help_lists_every_command(run) -> None:
    done = run("--help")
    assert done.returncode == 0
    for name in COMMAND_NAMES:
        assert f"\n  {name} " in done.stdout
    assert "..." not in done.stdout.partition("Commands:")[2], "a command's first line is too long for the list"


@pytest.mark.parametrize("name", COMMAND_NAMES)
def test_every_command_has_help_with_examples(run, name: str) -> None:
    done = run(name, "--help")
    assert done.returncode == 0
    assert f"Examples:\n    scenecc {name}" in done.stdout.replace("cat scene.yaml | ", "")


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("frobnicate",),
        ("build",),
        ("build", "x.yaml", "--num-scenes", "0"),
        ("build", "x.yaml", "--num-scenes", "many"),
        ("build", "x.yaml", "--steps", "-1"),
        ("build", "x.yaml", "--audit", "full"),
        ("build", "x.yaml", "--audit=off"),
        ("build", "x.yaml", "y.yaml"),
        ("validate",),
        ("validate", "x.yaml", "--format", "xml"),
        ("emit", "x.yaml"),
        ("emit", "x.yaml", "--to", "fortran"),
        ("explain", "SC999"),
        ("explain", "SC101", "SC102"),
        ("schema", "x"),
        ("diff",),
        ("diff", "x.yaml", "y.yaml"),
        ("diff", "x.yaml", "y.yaml", "z.yaml"),
        ("params",),
        ("params", "x.yaml"),
        ("params", "-", "--format", "sarif"),
        ("prefabs", "x"),
        ("prefabs", "table", "cube"),
        ("build", "x.yaml", "--set"),
        ("build", "x.yaml", "--set", "size"),
    ],
)
def test_wrong_usage_gives_status_2_and_a_message(run, arguments: tuple[str, ...]) -> None:
    done = run(*arguments)
    assert done.returncode == 2
    assert done.stderr.strip()


def test_an_unknown_code_suggests_one(run) -> None:
    done = run("explain", "SC901l")
    assert done.returncode == 2
    assert "did you mean SC901?" in done.stderr
    assert done.stdout == ""


def test_explain_prints_one_code_or_lists_all(run) -> None:
    one = run("explain", "sc901")
    assert one.returncode == 0
    assert one.stdout.startswith("SC901")
    everything = run("explain")
    assert everything.returncode == 0
    assert "SC901" in everything.stdout
    assert "SC9: usage" in everything.stdout


def test_a_closed_pipe_ends_the_process_quietly() -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "scenecc", "explain"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None
    process.stdout.close()
    _, errors = process.communicate(timeout=60)
    assert errors == b""
    assert process.returncode == -signal.SIGPIPE


@pytest.mark.parametrize(
    ("argument", "told"), [("explain", b"standard output cannot be written"), ("--help", b"No space left on device")]
)
def test_a_full_disk_is_reported_by_every_command(argument: str, told: bytes) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "scenecc", argument], stdout=full, stderr=subprocess.PIPE, check=False, timeout=60
        )
    assert done.returncode == 3
    assert told in done.stderr
    assert b"Traceback" not in done.stderr


def test_ctrl_c_gives_status_130_without_a_traceback() -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "scenecc", "validate", "-"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    _wait_until_signals_are_set_up(process.pid)
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate(timeout=60)
    assert (process.returncode, out, errors) == (130, b"", b"")


@pytest.mark.parametrize(
    ("error", "message"), [(MemoryError(), "out of memory"), (ZeroDivisionError("here"), "ZeroDivisionError: here")]
)
def test_an_error_of_the_machine_or_scenecc_gives_status_3(
    error: Exception, message: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail() -> None:
        raise error

    monkeypatch.setattr(app, "application", fail)
    monkeypatch.setattr(app.signal, "signal", lambda *_: None)
    with pytest.raises(SystemExit) as ended:
        app.main()
    assert ended.value.code == 3
    assert message in capsys.readouterr().err


def _wait_until_signals_are_set_up(pid: int) -> None:
    """Until SIGINT is caught, as Python does at its start, and SIGPIPE no longer ignored, as `main` sees to last."""
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        status = dict(line.split(":\t") for line in Path(f"/proc/{pid}/status").read_text().splitlines())
        caught, ignored = int(status["SigCgt"], 16), int(status["SigIgn"], 16)
        if caught & 1 << signal.SIGINT - 1 and not ignored & 1 << signal.SIGPIPE - 1:
            return
        time.sleep(0.01)
    pytest.fail("the process never set its signals up")


def test_without_a_standard_output_there_is_no_traceback() -> None:
    ran = subprocess.run(
        ["sh", "-c", '"$0" -m scenecc explain >&-', sys.executable], capture_output=True, text=True, check=False
    )
    assert (ran.returncode, ran.stderr) == (0, "")


def test_non_ascii_names_work_in_an_ascii_locale(tmp_path: Path) -> None:
    """Also names of files that a scene names, and in the processes that the command starts."""
    folder = tmp_path / "größe 日本"
    folder.mkdir()
    (folder / "mäsh.stl").write_bytes((Path(__file__).parents[2] / "scenes/assets/gem.stl").read_bytes())
    (folder / "szene.yaml").write_text(
        "scenecc: 1\nentities: {gem: {shapes: [{type: convex_mesh, file: mäsh.stl}]}}\n", encoding="utf-8"
    )
    command = [sys.executable, "-m", "scenecc", "build", "größe 日本/szene.yaml", "--no-render", "-o", "plän.json"]
    environment = {**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0"}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, check=False, timeout=60)
    assert (done.returncode, done.stderr.decode()) == (0, "plän.json needs `größe 日本/mäsh.stl`\n")
    assert "mäsh.stl" in (tmp_path / "plän.json").read_text(encoding="utf-8")
