"""The command line run as a process, as people run it."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from cli.running import CUBE, plain_environment
from plugins.command import scenecc

Result = subprocess.CompletedProcess[str]
Run = Callable[..., Result]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Runs `scenecc` in an empty folder."""

    def run(*arguments: str | Path, stdin: str | bytes = "", **changes: str) -> Result:
        done = scenecc(
            [str(argument) for argument in arguments],
            cwd=tmp_path,
            stdin=stdin.encode() if isinstance(stdin, str) else stdin,
            env=plain_environment(**changes),
        )
        out, err = (text.decode("utf-8", "surrogateescape") for text in (done.stdout, done.stderr))
        assert "Traceback" not in err
        return subprocess.CompletedProcess(done.args, done.returncode, out, err)

    return run


@pytest.fixture
def cube(tmp_path: Path) -> Path:
    """The smallest scene."""
    path = tmp_path / "cube.yaml"
    path.write_text(CUBE)
    return path
