"""`scenecc sweep`: its output, statuses and errors, what ends it, and whose findings are in its table."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from cli.running import CUBE, plain_environment
from plugins.struck import sessions_processes

SCENE = """\
scenecc: 1
num_scenes: 3
params: {height: 0.1}
entities:
  floor: {body_type: static, shapes: [{type: plane}]}
  cube: {pose: [{uniform: [-0.1, 0.1]}, 0, "${height}"], shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
expect:
  holds: [{after: 0.05, that: "${position('cube')[2] < 1}"}]
"""
SMALL = ("--seeds", "0:2", "--settle", "0.1")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def rows(folder: Path) -> list[dict[str, Any]]:
    return pq.read_table(folder / "table.parquet").to_pylist()


def codes(folder: Path) -> list[list[str]]:
    return [[one["code"] for one in row["findings"]] for row in rows(folder)]


def test_sweep_prints_the_path_of_the_table(run, scene: Path, tmp_path: Path) -> None:
    done = run("sweep", "scene.yaml", *SMALL, "-o", "out")
    assert (done.returncode, done.stdout) == (0, "")
    assert done.stderr == "2 of 2 units done; table in out/table.parquet\n"
    assert [(row["seed"], row["scene"]) for row in rows(tmp_path / "out")] == [(s, k) for s in (0, 1) for k in range(3)]
    part = run("sweep", "scene.yaml", *SMALL, "-o", "part", "--shard", "2/2", "--format", "json")
    assert json.loads(part.stdout) == {"table": None, "units": 2, "done": 1, "statistics": [], "diagnostics": []}


def test_sweep_has_the_exit_status_of_check(run, scene: Path, tmp_path: Path) -> None:
    scene.write_text(SCENE.replace("height: 0.1", "height: 0.05"))
    done = run("sweep", "scene.yaml", *SMALL, "-o", "out")
    assert done.returncode == run("check", "scene.yaml").returncode == 1
    assert "6  SC850  error    bodies overlap at the start\n" in done.stdout
    assert all("SC850" in here for here in codes(tmp_path / "out"))
    # The same from a folder in which all is done.
    assert run("sweep", "scene.yaml", *SMALL, "-o", "out").returncode == 1
    good = run("sweep", "scene.yaml", *SMALL, "--set", "height=0.1", "-o", "good")
    assert good.returncode == 0
    assert rows(tmp_path / "good")[0]["parameters"] == '{"height": 0.1}'


def test_a_failed_expectation_is_in_the_row_of_its_scene(run, scene: Path, tmp_path: Path) -> None:
    scene.write_text(SCENE.replace('"${height}"', "{choice: [0.1, 3]}"))
    done = run("sweep", "scene.yaml", "--seeds", "0:3", "--settle", "0", "-o", "out")
    assert done.returncode == 1
    found = rows(tmp_path / "out")
    high = [json.loads(row["draws"])["cube.pose"][2] == 3 for row in found]
    assert 0 < sum(high) < len(high)
    assert [any(code in {"SC860", "SC861", "SC862"} for code in here) for here in codes(tmp_path / "out")] == high
    for row in (row for row, is_high in zip(found, high, strict=True) if is_high):
        (one,) = (one for one in row["findings"] if one["code"] in {"SC860", "SC861", "SC862"})
        assert f"scenecc view scene.yaml --seed {row['seed']} --scene {row['scene']}" in one["hint"], one


def test_sweep_applies_settings_and_comments_like_check(run, scene: Path, tmp_path: Path) -> None:
    heavy = "mass: 90000"
    scene.write_text(SCENE.replace("  cube: {", f"  cube: {{{heavy}, "))
    found = {one["code"] for one in json.loads(run("check", "scene.yaml", "--format", "json").stdout)["diagnostics"]}
    (code,) = found
    tool = tmp_path / "pyproject.toml"
    assert run("sweep", "scene.yaml", *SMALL, "-o", "0").returncode == 0
    assert codes(tmp_path / "0") == [[code]] * 6
    tool.write_text(f'[tool.scenecc]\nseverity = {{{code} = "error"}}\n')
    assert run("sweep", "scene.yaml", *SMALL, "-o", "0").returncode == 2, "these settings make another sweep"
    assert run("sweep", "scene.yaml", *SMALL, "-o", "1").returncode == 1
    assert rows(tmp_path / "1")[0]["findings"][0]["severity"] == "error"
    tool.write_text("[tool.scenecc]\nstrict = true\n")
    assert run("sweep", "scene.yaml", *SMALL, "-o", "2").returncode == 1
    tool.write_text(f'[tool.scenecc]\nignore = ["{code}"]\n')
    assert run("sweep", "scene.yaml", *SMALL, "-o", "3").returncode == 0
    assert codes(tmp_path / "3") == [[]] * 6
    tool.write_text('[tool.scenecc]\nselect = ["SC9999"]\n')
    assert "SC916" in run("sweep", "scene.yaml", *SMALL, "-o", "4").stderr
    tool.unlink()
    scene.write_text(scene.read_text().replace("  cube: {", f"  # scenecc: ignore {code} -- heavy\n  cube: {{"))
    assert run("sweep", "scene.yaml", *SMALL, "-o", "5").returncode == 0
    assert codes(tmp_path / "5") == [[]] * 6


def test_a_part_swept_with_its_users_has_no_findings_of_a_part(run, tmp_path: Path) -> None:
    folder = tmp_path / "scenes"
    folder.mkdir()
    (folder / "scene.yaml").write_text(f"include: [part.yaml]\n{SCENE}")
    part = folder / "part.yaml"
    part.write_text("scenecc: 1\nentities: {ball: {pose: [1, 1, 0.1], shapes: [{type: sphere, radius: 0.1}]}}\n")
    assert run("sweep", "scenes", *SMALL, "-o", "out").returncode == 0
    assert not any(codes(tmp_path / "out"))
    assert run("sweep", "scenes/part.yaml", *SMALL, "-o", "alone").returncode == 1


def test_a_swept_pack_gives_the_rows_of_its_scene(run, scene: Path, tmp_path: Path) -> None:
    assert run("pack", "scene.yaml", "-o", "scene.scn").returncode == 0
    assert run("sweep", "scene.yaml", *SMALL, "-o", "plain").returncode == 0
    scene.unlink()
    assert run("sweep", "scene.scn", *SMALL, "-o", "packed", "--jobs", "2").returncode == 0
    plain = [{**row, "file": "scene.scn"} for row in rows(tmp_path / "plain")]
    assert rows(tmp_path / "packed") == plain
    assert next(iter(json.loads((tmp_path / "packed/sweep.json").read_text())["entries"][0]["files"])) == "scene.scn"


@pytest.mark.parametrize(
    ("arguments", "status", "told"),
    [
        ((), 2, "Missing option '--output'"),
        (("-o", "out", "--do", "check,view"), 2, "'view' is not one of 'check', 'render', 'state'"),
        (("-o", "out", "--seeds", "3"), 2, "'3' must be A:B"),
        (("-o", "out", "--shard", "3/2"), 2, "'3/2' must be I/N"),
        (("-o", "out", "--jobs", "0"), 2, "--jobs"),
        (("-o", "out", "--size", "640"), 2, "'640' must be WIDTHxHEIGHT"),
        (("-o", "out", "--set", "weight=1"), 2, "weight"),
        (("-o", "no/out"), 2, "SC904"),
        (("-o", "full"), 2, "SC940"),
        (("-o", "scene.yaml"), 2, "SC904"),
        (("-o", "out", "-"), 2, "SC901"),
        (("-o", "out", "none.yaml"), 2, "SC901"),
        (("-o", "out", "bad.yaml"), 1, "SC101"),
        (("-o", "out", "--ray-address", "127.0.0.1:1"), 3, "SC828"),
    ],
)
def test_wrong_usage_of_sweep_is_reported(
    run, scene: Path, tmp_path: Path, arguments: tuple[str, ...], status: int, told: str
) -> None:
    (tmp_path / "bad.yaml").write_text(CUBE.replace("half_size", "half_sizes"))
    (tmp_path / "full").mkdir()
    (tmp_path / "full/file").touch()
    done = run("sweep", "scene.yaml", *arguments)
    assert (done.returncode, done.stdout) == (status, "")
    assert told in done.stderr
    assert not (tmp_path / "out/table.parquet").exists()


@pytest.mark.parametrize(
    ("how", "number"),
    [
        (("--jobs", "2"), signal.SIGINT),
        (("--jobs", "2"), signal.SIGTERM),
        (("--jobs", "2"), signal.SIGKILL),
        (("--ray",), signal.SIGINT),
        (("--ray",), signal.SIGTERM),
    ],
)
def test_a_sweep_resumes_after_a_signal(
    run, scene: Path, tmp_path: Path, how: tuple[str, ...], number: signal.Signals
) -> None:
    if "--ray" in how:
        pytest.importorskip("ray")
    command = ("sweep", "scene.yaml", "--seeds", "0:60", "--settle", "0.5")
    process = subprocess.Popen(
        [sys.executable, "-m", "scenecc", *command, "-o", "out", *how],
        cwd=tmp_path, env=plain_environment(), stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip
    log = tmp_path / "out/log.jsonl"
    while not log.exists() or log.stat().st_size == 0:
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(number)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == (-number if number == signal.SIGKILL else 128 + number)
    assert errors == b""
    ends = time.monotonic() + 30
    while left := sessions_processes(process.pid):
        assert time.monotonic() < ends, left
        time.sleep(0.1)
    assert not (tmp_path / "out/table.parquet").exists()
    before = len(log.read_text().splitlines())
    assert run(*command, "-o", "out", "--jobs", "2").returncode == 0
    assert before < 60
    # What was done is not done again, but for what had a line in the log and no result yet.
    assert 60 <= len(log.read_text().splitlines()) <= 61
    assert run(*command, "-o", "alone").returncode == 0
    assert (tmp_path / "out/table.parquet").read_bytes() == (tmp_path / "alone/table.parquet").read_bytes()


def test_a_sweep_resumes_after_a_full_disk(run, scene: Path, tmp_path: Path) -> None:
    # A limit for the size of files stands for the disk.
    limited = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (6000, 6000)); import signal; "
    limited += "signal.signal(signal.SIGXFSZ, signal.SIG_IGN); from scenecc.cli import main; main()"
    command = ["sweep", "scene.yaml", "--seeds", "0:12", "--settle", "0"]
    done = subprocess.run(
        [sys.executable, "-c", limited, *command, "-o", "out"],
        cwd=tmp_path, env=plain_environment(), capture_output=True, text=True, check=False, timeout=100,
    )  # fmt: skip
    assert done.returncode == 3, done.stderr
    assert "SC818" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out/table.parquet").exists()
    assert run(*command, "-o", "out").returncode == run(*command, "-o", "alone").returncode == 0
    assert (tmp_path / "out/table.parquet").read_bytes() == (tmp_path / "alone/table.parquet").read_bytes()
    assert not [*(tmp_path / "out").glob(".*")]
