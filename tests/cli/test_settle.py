"""`scenecc settle` and `--starts`: output, statuses and errors."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from cli.running import plain_environment

SCENE = """\
scenecc: 1
num_scenes: 2
params: {height: 0.1}
starts: starts.json
entities:
  floor: {body_type: static, shapes: [{type: plane}]}
  cube: {pose: [{uniform: [0, 1]}, 0, "${height}"], shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
expect:
  holds:
    - {that: "${position('cube')[0] < 0.5}"}
"""


def run(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "scenecc", *arguments]
    environment = plain_environment(COLUMNS="200")
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def test_settle_counts_and_names_what_it_drops(scene: Path) -> None:
    done = run("settle", "scene.yaml", "--seeds", "0:4", "-o", "starts.json", folder=scene.parent)
    rows = json.loads((scene.parent / "starts.json").read_text())["rows"]
    first = f"kept {len(rows)} of 8; dropped: {8 - len(rows)} break `expect` scene.yaml:10 (seed "
    assert (done.returncode, done.stdout.startswith(first), done.stderr) == (0, True, ""), done
    assert done.stdout.endswith(": ${position('cube')[0] < 0.5})\n")
    build = run("build", "scene.yaml", "--set", "height=0.2", folder=scene.parent)
    assert (build.returncode, "the parameter `height` was 0.1 and is 0.2" in build.stderr) == (1, True)


def test_a_scene_in_which_nothing_rests_gives_no_file(scene: Path) -> None:
    scene.write_text(SCENE.replace("  floor: {body_type: static, shapes: [{type: plane}]}\n", ""))
    done = run("settle", "scene.yaml", "--seconds", "0.1", "-o", "starts.json", folder=scene.parent)
    message = "no scene has a start: kept 0 of 2; dropped: 2 never rest (seed 0 scene 0, …: cube)"
    assert (done.returncode, message in done.stderr) == (1, True), done
    assert not (scene.parent / "starts.json").exists()


@pytest.mark.parametrize("command", ["build", "check", "validate", "inspect"])
def test_starts_that_do_not_exist_are_wrong_usage(scene: Path, command: str) -> None:
    done = run(command, "scene.yaml", "--starts", "nothere.json", folder=scene.parent)
    assert (done.returncode, "'--starts': `nothere.json` does not exist" in done.stderr) == (2, True), done


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("-o", "starts.yaml"), "'--output': it must be a file NAME.json"),
        (("-o", "a.json", "--seed", "1", "--seeds", "0:2"), "'--seeds': it cannot be combined with --seed"),
        (("-o", "a.json", "--seconds", "0"), "'--seconds': it must be above 0"),
    ],
)
def test_wrong_options_are_wrong_usage(scene: Path, arguments: tuple[str, ...], message: str) -> None:
    done = run("settle", "scene.yaml", *arguments, folder=scene.parent)
    assert (done.returncode, message in done.stderr) == (2, True), done
