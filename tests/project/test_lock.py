"""constraints.txt locks what pyproject.toml asks for."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # pytest brings it there

ROOT = Path(__file__).parents[2]
PYTHONS = ("3.10", "3.11", "3.12", "3.13")

LOCKED = [
    Requirement(line)
    for line in (ROOT / "constraints.txt").read_text().splitlines()
    if line and not line.lstrip().startswith("#")
]


def requirements() -> list[Requirement]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    extras = project["project"]["optional-dependencies"]
    extra_lines = [line for name in extras for line in extras[name]]
    more = [re.sub(r"#.*", "", line).strip() for line in (ROOT / ".ci/constraints.in").read_text().splitlines()]
    lines = [*project["project"]["dependencies"], *project["build-system"]["requires"], *extra_lines, *more]
    return [Requirement(line) for line in lines if line and not line.startswith("scenecc[")]


@pytest.mark.parametrize("python", PYTHONS)
def test_each_dependency_is_locked_once_within_its_bounds(python: str) -> None:
    environment = {"python_version": python, "python_full_version": f"{python}.0", "sys_platform": sys.platform}
    versions: dict[str, list[str]] = {}
    for one in LOCKED:
        if one.marker is None or one.marker.evaluate(environment):
            versions.setdefault(canonicalize_name(one.name), []).append(next(iter(one.specifier)).version)
    wrong = {
        str(one): versions.get(canonicalize_name(one.name))
        for one in requirements()
        if len(found := versions.get(canonicalize_name(one.name), [])) != 1 or found[0] not in one.specifier
    }
    assert not wrong, "make constraints.txt again with the command of CONTRIBUTING.md"


@pytest.mark.parametrize("name", ["build", "test"])
def test_the_readmes_commands_install_what_is_locked(name: str) -> None:
    """`.ci/run` would not notice: it sets PIP_CONSTRAINT for whatever these install."""
    done = subprocess.run([ROOT / ".ci/readme-command", name], capture_output=True, text=True, check=True)
    assert "pip install -c constraints.txt " in done.stdout
