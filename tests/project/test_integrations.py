"""The commit hook and the GitHub Action, run as pre-commit and GitHub's runner run them."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

import pytest
import yaml

from scenecc.starter import starter_files
from scenecc.version import VERSION

ROOT = Path(__file__).parents[2]
GOOD = "scenecc: 1\nentities:\n  cube: {shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}\n"
BAD = GOOD.replace("half_size", "half_sizes")
WARNED = GOOD + "materials: {oak: {physical: {density: 700}}}\n"


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """Somebody else's repository, with scenes among its YAML files."""
    folder = tmp_path / "theirs"
    (folder / "scenes").mkdir(parents=True)
    (folder / "scenes" / "good.yaml").write_text(GOOD)
    (folder / "compose.yaml").write_text("services: {web: {image: web}}\n")
    subprocess.run(["git", "init", "--quiet"], cwd=folder, check=True)
    return folder


def pre_commit(
    repository: Path, environment: dict[str, str], name: str = "scenecc-validate"
) -> subprocess.CompletedProcess[str]:
    """Runs a hook as its manifest describes it, with the command under test in place of a fresh installation."""
    hooks = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    (hook,) = [one for one in hooks if one["id"] == name]
    assert hook["language"] == "python"
    local = {"repo": "local", "hooks": [{**hook, "language": "system"}]}
    (repository / ".pre-commit-config.yaml").write_text(yaml.safe_dump({"repos": [local]}))
    return run_hooks(repository, environment)


def run_hooks(repository: Path, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """Runs the hooks of a repository."""
    subprocess.run(["git", "add", "--all"], cwd=repository, check=True)
    return subprocess.run(
        [sys.executable, "-m", "pre_commit", "run", "--all-files", "--color", "never"],
        cwd=repository,
        env={**environment, "PRE_COMMIT_HOME": str(repository.parent / "cache")},
        capture_output=True,
        text=True,
        check=False,
        timeout=100,
    )


def test_the_hook_passes_good_scenes_and_other_yaml(repository: Path, environment: dict[str, str]) -> None:
    done = pre_commit(repository, environment)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Passed" in done.stdout


@pytest.mark.quick
def test_the_hook_stops_a_bad_scene(repository: Path, environment: dict[str, str]) -> None:
    (repository / "scenes" / "bad.yaml").write_text(BAD)
    done = pre_commit(repository, environment)
    assert done.returncode == 1
    assert "scenes/bad.yaml:3:31: error SC101" in done.stdout
    assert "compose.yaml" not in done.stdout


def test_the_hook_that_checks_stops_a_scene_that_falls(repository: Path, environment: dict[str, str]) -> None:
    done = pre_commit(repository, environment, "scenecc-check")
    assert done.returncode == 1
    assert "scenes/good.yaml:3:3: error SC852" in done.stdout
    assert "compose.yaml" not in done.stdout


def test_the_hook_of_a_starter_stops_a_scene_with_a_warning(repository: Path, environment: dict[str, str]) -> None:
    (repository / ".pre-commit-config.yaml").write_bytes(starter_files("empty", None)[".pre-commit-config.yaml"])
    (repository / "scenes" / "warned.yaml").write_text(WARNED)
    done = run_hooks(repository, environment)
    assert done.returncode == 1
    assert "scenes/warned.yaml" in done.stdout
    assert "good.yaml" not in done.stdout


def action() -> dict[str, Any]:
    return yaml.safe_load((ROOT / "action.yml").read_text())


class Runner:
    """The part of GitHub's runner that a composite action of shell steps needs."""

    def __init__(self, workspace: Path, environment: dict[str, str]) -> None:
        self.workspace = workspace
        self.output = workspace.parent / "output"
        self.output.touch()
        temporary = workspace.parent / "runner"
        temporary.mkdir()
        self.environment = {
            **environment,
            "GITHUB_ACTION_PATH": str(ROOT),
            "GITHUB_OUTPUT": str(self.output),
            "GITHUB_WORKSPACE": str(workspace),
            "RUNNER_TEMP": str(temporary),
        }

    def step(self, name: str, **inputs: str) -> subprocess.CompletedProcess[str]:
        """Runs a step as `shell: bash` is run, with the inputs where the action asks for them."""
        (step,) = [step for step in action()["runs"]["steps"] if step.get("name") == name]
        assert step["shell"] == "bash"
        values = {key: given["default"] for key, given in action()["inputs"].items()} | inputs
        asked = {
            key: re.sub(r"\$\{\{ inputs\.([\w-]+) \}\}", lambda match: values[match[1]], text)
            for key, text in step.get("env", {}).items()
        }
        assert "${{" not in step["run"], "an input in a script would be run as a part of it"
        script = self.workspace.parent / "step.sh"
        script.write_text(step["run"])
        return subprocess.run(
            ["bash", "--noprofile", "--norc", "-eo", "pipefail", str(script)],
            cwd=self.workspace,
            env={**self.environment, **asked},
            capture_output=True,
            text=True,
            check=False,
            timeout=110,
        )


@pytest.fixture
def runner(repository: Path, environment: dict[str, str]) -> Runner:
    """A runner on which the command under test is installed where the action installs it."""
    runner = Runner(repository, environment)
    folder = Path(runner.environment["RUNNER_TEMP"]) / "scenecc" / "bin"
    folder.mkdir(parents=True)
    (folder / "scenecc").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m scenecc "$@"\n')
    (folder / "scenecc").chmod(0o755)
    return runner


def test_the_action_passes_good_scenes(runner: Runner) -> None:
    done = runner.step("Check scenes")
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert runner.output.read_text() == ""


def test_the_action_marks_the_line_and_writes_sarif(runner: Runner) -> None:
    (runner.workspace / "scenes" / "bad.yaml").write_text(BAD)
    done = runner.step("Check scenes", **{"paths": "scenes\n  compose dir \n", "sarif-file": "out/scenes.sarif"})
    assert done.returncode == 2, "`compose dir` does not exist"
    done = runner.step("Check scenes", **{"paths": "scenes\n", "sarif-file": "out/scenes.sarif"})
    assert done.returncode == 1
    assert "::error file=scenes/bad.yaml,line=3,col=31" in done.stdout
    sarif = json.loads((runner.workspace / "out" / "scenes.sarif").read_text())
    assert "SC101" in {result["ruleId"] for result in sarif["runs"][0]["results"]}
    assert runner.output.read_text().splitlines()[-1] == "sarif-file=out/scenes.sarif"
    assert [path.name for path in (runner.workspace / "out").iterdir()] == ["scenes.sarif"]


def test_the_action_is_strict_when_told(runner: Runner) -> None:
    (runner.workspace / "scenes" / "warned.yaml").write_text(WARNED)
    assert runner.step("Check scenes").returncode == 0
    assert runner.step("Check scenes", strict="true").returncode == 1


def test_the_action_can_simulate(runner: Runner) -> None:
    done = runner.step("Check scenes", command="check")
    assert done.returncode == 1
    assert "::error file=scenes/good.yaml,line=3,col=3" in done.stdout
    assert runner.step("Check scenes", command="build").returncode == 2


def test_an_input_is_never_a_command(runner: Runner) -> None:
    done = runner.step("Check scenes", paths="$(touch pwned)\n`touch pwned`\n--help\n; touch pwned")
    assert done.returncode == 2
    assert not (runner.workspace / "pwned").exists()


@pytest.mark.parametrize(("extras", "package"), [("", str(ROOT)), ("mjcf,view", f"{ROOT}[mjcf,view]")])
def test_the_action_installs_the_extras_that_are_asked_for(
    extras: str, package: str, repository: Path, environment: dict[str, str]
) -> None:
    runner = Runner(repository, environment)
    python = repository.parent / "bin" / "python"  # makes the environment, and is its interpreter
    python.write_text('#!/bin/sh\nmkdir -p "$3/bin"; cp "$0" "$3/bin/python"; echo "$@"\n')
    python.chmod(0o755)
    done = runner.step("Install scenecc", extras=extras)
    assert done.stdout.splitlines()[-1] == f"-m pip install --quiet {package}"


def test_the_action_installs_itself(repository: Path, environment: dict[str, str]) -> None:
    runner = Runner(repository, environment)
    # pip takes what is here for installed, so only the package itself is built and installed.
    packages = os.pathsep.join([sysconfig.get_path("purelib"), sysconfig.get_path("platlib")])
    runner.environment["PYTHONPATH"] = packages
    done = runner.step("Install scenecc")
    if done.returncode != 0 and re.search(r"No matching distribution|NewConnectionError", done.stdout + done.stderr):
        pytest.skip("pip cannot fetch the build backend here")
    assert done.returncode == 0, done.stderr
    assert runner.step("Check scenes").returncode == 0


def test_a_version_without_a_tag_is_released_with_its_notes(tmp_path: Path, environment: dict[str, str]) -> None:
    jobs = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text())["jobs"]
    scripts = {step["name"]: step["run"] for job in jobs.values() for step in job.get("steps", ()) if "run" in step}
    (tmp_path / "scenecc").mkdir()
    for name in ("CHANGELOG.md", "scenecc/version.py"):
        shutil.copy(ROOT / name, tmp_path / name)
    gh = tmp_path / "bin" / "gh"
    gh.write_text('#!/bin/sh\necho "$@"\n')
    gh.chmod(0o755)
    given = {"GITHUB_OUTPUT": "output", "GITHUB_SHA": "f0", "TAG": f"v{VERSION}"}

    def run(script: str) -> str:
        command = ["bash", "-eo", "pipefail", "-c", script]
        return subprocess.run(
            command, cwd=tmp_path, env={**environment, **given}, capture_output=True, text=True, check=True
        ).stdout

    run("git init -q . && git remote add origin . && git -c user.name=a -c user.email=a@b commit -q --allow-empty -m a")
    run(scripts["Read the version"])
    run(f"git tag v{VERSION}")
    run(scripts["Read the version"])
    assert (tmp_path / "output").read_text() == f"tag=v{VERSION}\ntag=\n"
    assert run(scripts["Release"]).startswith(f"release create v{VERSION} dist/* --target f0 ")
    assert (tmp_path / "notes.md").read_text().strip() in (tmp_path / "CHANGELOG.md").read_text()
    assert "### Breaking changes" in (tmp_path / "notes.md").read_text()
