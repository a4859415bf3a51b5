"""The repository as its users meet it."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest
from plugins.command import write_starter

ROOT = Path(__file__).parents[2]


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """An environment in which `scenecc` is the one under test, installed or not."""
    folder = tmp_path / "bin"
    folder.mkdir()
    command = folder / "scenecc"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m scenecc "$@"\n')
    command.chmod(0o755)
    search = os.pathsep.join([str(folder), str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    modules = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    return {**os.environ, "PATH": search, "PYTHONPATH": modules}


@pytest.fixture
def forking_environment(environment: dict[str, str]) -> dict[str, str]:
    """`environment`, with a `scenecc` that is forked from a process which has imported it: many commands are run."""
    write_starter(Path(environment["PATH"].partition(os.pathsep)[0]) / "scenecc")
    return environment


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """What a command in the documentation finds around it: the scenes and what they name."""
    folder = tmp_path / "scenecc-clone"
    folder.mkdir()
    for name in ("scenes", "assets", "schemas"):
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name)
    return folder
