"""`scenecc replay` as a process."""

from __future__ import annotations

import json
import signal
import subprocess
from pathlib import Path
from urllib.request import urlopen

import pytest
from cli.running import plain_environment

from scenecc import load_scene

SCENE = """scenecc: 1
num_scenes: 4
entities:
  ball: {pose: {p: [{uniform: [0, 1]}, 0, 1]}, shapes: [{type: sphere, radius: 0.1}]}
"""


def run(folder: Path, *arguments: str, stdin: str = "") -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["scenecc", "replay", *arguments],
        cwd=folder,
        env=plain_environment(),
        input=stdin,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


@pytest.fixture
def passport(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Of a scene that was reset, in a file `passport.json`."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.yaml").write_text(SCENE)
    with load_scene("scene.yaml", render=False) as batch:
        batch.reset(seed=4)
        text = batch.passport(3)
    (tmp_path / "passport.json").write_text(text + "\n")
    return text


def test_replay_reads_a_passport_from_file_text_and_standard_input(passport: str, tmp_path: Path) -> None:
    said = "scene 3 of 4: the initial state equals the passport's, bit for bit\n"
    for arguments, stdin in ((["passport.json"], ""), ([passport], ""), (["-"], passport)):
        done = run(tmp_path, *arguments, stdin=stdin)
        assert (done.returncode, done.stdout, done.stderr) == (0, said, "")
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    assert run(folder, passport, "--file", "../scene.yaml").stdout == said
    done = run(folder, passport)
    assert done.returncode == 1
    assert "scene.yaml: error SC931: there is no file `scene.yaml` here; name it with --file" in done.stderr


def test_replay_reports_differences_with_status_1(passport: str, tmp_path: Path) -> None:
    content = json.loads(passport)
    content["versions"]["numpy"] = "1.0"
    content["reset"]["seed"] = 5
    done = run(tmp_path, json.dumps(content))
    assert done.returncode == 1
    assert "error SC933: the version of numpy was 1.0, but is " in done.stderr
    assert "SC934" not in done.stderr
    done = run(tmp_path, json.dumps(content), "--any-version", "--format", "json")
    assert done.returncode == 1
    assert [(one["code"], one["severity"]) for one in json.loads(done.stdout)["diagnostics"]] == [
        ("SC933", "warning"),
        ("SC934", "error"),
    ]
    (tmp_path / "scene.yaml").write_text(SCENE.replace("0.1}", "0.2}"))
    done = run(tmp_path, "passport.json")
    assert done.returncode == 1
    assert "scene.yaml: error SC931: the scene file differs: its SHA-256 was " in done.stderr


def test_wrong_usage_of_replay_is_refused(passport: str, tmp_path: Path) -> None:
    assert run(tmp_path, "no.json").returncode == 2
    assert "SC901" in run(tmp_path, "no.json").stderr
    assert run(tmp_path, passport, "-o", "start.jpg").returncode == 2
    assert "SC930" in run(tmp_path, "scene.yaml").stderr
    assert run(tmp_path, ".").returncode == 1


def test_replay_view_runs_until_interrupted(passport: str, tmp_path: Path) -> None:
    pytest.importorskip("viser")
    pipe = subprocess.PIPE
    command = ["scenecc", "replay", "passport.json", "--view"]
    with subprocess.Popen(
        command, cwd=tmp_path, env=plain_environment(), stdout=pipe, stderr=pipe, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        said, url = (process.stdout.readline().strip() for _ in range(2))
        assert said == "scene 3 of 4: the initial state equals the passport's, bit for bit"
        with urlopen(url, timeout=20) as page:
            assert b"<html" in page.read()[:500]
        process.send_signal(signal.SIGINT)
        assert (process.wait(30), process.stderr.read()) == (130, "Press Ctrl-C to stop.\n")


@pytest.mark.render
def test_replay_renders_the_initial_state(passport: str, tmp_path: Path) -> None:
    assert run(tmp_path, passport, "-o", "start.png").stdout.endswith("start.png: scene 3\n")
    content = json.loads(passport)
    del content["reset"]
    with load_scene("scene.yaml", render=False) as batch:
        assert run(tmp_path, batch.passport(3), "-o", "built.png").returncode == 0
    assert (tmp_path / "start.png").read_bytes() != (tmp_path / "built.png").read_bytes()
