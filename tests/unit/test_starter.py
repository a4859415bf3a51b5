"""The folders that `scenecc init` writes: each template with each robot that it takes."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest
import yaml

from scenecc import starter, validate
from scenecc.diagnostics import Sink
from scenecc.extras import EXTRAS
from scenecc.source.read import read_file
from scenecc.starter import ADDRESS, ROBOTS, TEMPLATES, starter_files
from scenecc.version import VERSION

FOLDER = Path(__file__).parents[2] / "scenecc" / "templates"
PAIRS = [(name, robot) for name, row in TEMPLATES.items() for robot in row.robots]
ALL = [
    pytest.param(name, robot, id=f"{name}-{robot}", marks=pytest.mark.maniskill if ROBOTS[robot] else ())
    for name, robot in PAIRS
] + [pytest.param(name, None, id=name) for name, row in TEMPLATES.items() if not row.needs_robot]


@pytest.fixture
def folder(template: str, robot: str | None, tmp_path: Path) -> Path:
    for name, content in starter_files(template, robot).items():
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    return tmp_path


@pytest.mark.parametrize(("template", "robot"), ALL)
def test_the_test_of_a_starter_passes(folder: Path) -> None:
    spec = importlib.util.spec_from_file_location("starter_test", folder / "test_scenes.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for name in module.SCENES:
        module.test_nothing_is_found_in_a_scene(name)
        module.test_a_scene_runs_as_a_batch(name)


@pytest.mark.parametrize(("template", "robot"), ALL)
def test_every_starter_file_is_valid_for_scenecc_and_its_schema(folder: Path) -> None:
    schema = json.loads((folder / "scene.schema.json").read_text())
    scenes = sorted(folder.glob("[!.]*.yaml"))
    for file in scenes:
        assert validate(file) == []
        first, *_ = file.read_text().splitlines()
        assert first == "# yaml-language-server: $schema=scene.schema.json"
        document = read_file(file, Sink())
        assert document is not None
        jsonschema.validate(document.data, schema)
    assert [file.name for file in scenes if file.name != "robot.yaml"] == ["scene.yaml"]


def test_pytest_ignores_the_settings_of_folders_above_a_starter(tmp_path: Path) -> None:
    files = starter_files("empty", None)
    (tmp_path / "pyproject.toml").write_text('[tool.pytest.ini_options]\naddopts = ["--strict-config"]\nno_such = 1\n')
    (tmp_path / "demo").mkdir()
    for name in ("pytest.ini", "test_scenes.py"):
        (tmp_path / "demo" / name).write_bytes(files[name])
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider"]
    done = subprocess.run(command, cwd=tmp_path / "demo", capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "2 tests collected" in done.stdout


def test_the_test_of_a_starter_fails_with_its_scene(tmp_path: Path) -> None:
    files = starter_files("empty", None)
    (tmp_path / "test_scenes.py").write_bytes(files["test_scenes.py"])
    (tmp_path / "scene.yaml").write_bytes(files["scene.yaml"].replace(b"[0.5, 0, 0.02]", b"[0.5, 0, 0.001]"))
    spec = importlib.util.spec_from_file_location("failing_starter_test", tmp_path / "test_scenes.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    with pytest.raises(AssertionError, match="SC850"):
        module.test_nothing_is_found_in_a_scene("scene.yaml")


def test_every_template_file_is_listed() -> None:
    assert {file.stem for file in (FOLDER / "scenes").iterdir()} == set(TEMPLATES)
    assert {file.stem for file in (FOLDER / "robots").iterdir()} == set(ROBOTS)
    assert {robot for _, robot in PAIRS} == set(ROBOTS)
    assert {extra for extra in ROBOTS.values() if extra} <= set(EXTRAS)


@pytest.mark.parametrize(("robot", "package"), [("arm", "scenecc"), ("panda", "scenecc[maniskill]")])
def test_the_workflow_of_a_starter_installs_the_extra_of_the_robot(robot: str, package: str) -> None:
    files = starter_files("pick_place", robot, "https://github.com/us/scenecc")
    workflow = yaml.safe_load(files[".github/workflows/scenes.yml"])
    assert workflow["env"] == {"SCENECC": f"{package} @ git+https://github.com/us/scenecc@v{VERSION}"}
    commands = [step["run"] for step in workflow["jobs"]["scenes"]["steps"] if "run" in step]
    assert commands[0] == 'python -m pip install "$SCENECC" pytest'


@pytest.mark.parametrize(
    ("remote", "address"),
    [
        ("https://token@github.com/us/scenecc.git", "https://github.com/us/scenecc"),
        ("git@github.com:us/scenecc.git", "https://github.com/us/scenecc"),
        ("ssh://git@host.org/a/b/scenecc", "https://host.org/a/b/scenecc"),
        ("ssh://git@host.org:22/us/scenecc", ADDRESS),
        ("/home/us/scenecc", ADDRESS),
        ("", ADDRESS),
    ],
)
def test_the_address_of_a_starter_is_that_of_the_clone(
    remote: str, address: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    subprocess.run(["git", "init", "--quiet", str(tmp_path)], check=True)
    if remote:
        subprocess.run(["git", "-C", str(tmp_path), "remote", "add", "origin", remote], check=True)
    monkeypatch.setattr(starter, "install_origin", lambda: {"url": tmp_path.as_uri(), "dir_info": {}})
    assert starter.repository_address() == address


def test_the_commit_hook_of_a_starter_is_that_of_scenecc() -> None:
    config = yaml.safe_load(starter_files("empty", None)[".pre-commit-config.yaml"])
    ((hook,),) = [repo["hooks"] for repo in config["repos"]]
    hooks = yaml.safe_load((FOLDER.parents[1] / ".pre-commit-hooks.yaml").read_text())
    (ours,) = [one for one in hooks if one["id"] == hook["id"]]
    assert {hook[key] == ours[key] for key in ("id", "name", "types")} == {True}
    assert re.fullmatch(rf"{ours['entry']} --strict", hook["entry"])
