"""`scenecc draws`: the values of `batch.drawn`, bit for bit."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

import scenecc
from scenecc.cli.app import application

SCENE = """\
scenecc: 1
num_scenes: 3
draws: {edge: {uniform: [0.05, 0.1]}, word: {choice: [a, b]}, list: {choice: [[1], [1, 2]]}}
entities:
  cube: {mass: {uniform: [1, 2]}, gravity: {choice: [true, false]}, shapes: [{type: box, half_size: ["${edge}", 0.1, 0.1]}]}
  odd: {scene_idxs: [1], body_type: static, shapes: [{type: sphere, radius: {uniform: [0.1, 0.2]}}]}
"""  # noqa: E501
SEEDS = (2, 3)


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def drawn(scene: Path) -> list[dict[str, Any]]:
    """What batches draw: a dict for each seed and scene."""
    rows: list[dict[str, Any]] = []
    for seed in SEEDS:
        with scenecc.load_scene(scene, seed=seed, render=False) as batch:
            values = batch.drawn()
            rows += [{name: values[name][index] for name in values} for index in batch.scene_idxs]
    return rows


def missing(value: Any) -> bool:
    return isinstance(value, float) and math.isnan(value)


def test_json_equals_the_drawn_values_of_a_batch(run, scene: Path) -> None:
    done = run("draws", scene, "--seeds", "2:4", "--format", "json")
    rows = json.loads(done.stdout)["draws"]
    assert [(row["seed"], row["scene"]) for row in rows] == [(seed, index) for seed in SEEDS for index in range(3)]
    for row, wanted in zip(rows, drawn(scene), strict=True):
        assert row["values"].keys() == wanted.keys()
        for name, value in row["values"].items():
            assert value is None if missing(wanted[name]) else np.array_equal(value, wanted[name])


def test_csv_has_a_column_for_each_number(run, scene: Path) -> None:
    done = run("draws", scene, "--seeds", "2:4", "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    wanted = drawn(scene)
    assert [float(row["cube.mass"]) for row in rows] == [one["cube.mass"] for one in wanted]
    assert [float(row["cube.shapes[0].half_size[0]"]) for row in rows] == [one["edge"] for one in wanted]
    assert [row["odd.shapes[0].radius"] == "" for row in rows] == [True, False, True] * 2
    assert [row["cube.disable_gravity"] for row in rows] == [str(one["cube.disable_gravity"]).lower() for one in wanted]
    assert [row["word"] for row in rows] == [one["word"] for one in wanted]


def test_the_suffix_of_the_output_chooses_the_format(run, scene: Path) -> None:
    for name, start in {"x.csv": "seed,scene,", "x.json": "{", "x.txt": "seed  scene  name"}.items():
        assert run("draws", scene, "-o", name).returncode == 0
        assert (scene.parent / name).read_text().startswith(start)


def test_parquet_has_lists(run, scene: Path) -> None:
    done = run("draws", scene, "--seeds", "2:4", "--format", "parquet", "-o", "draws.parquet")
    assert (done.returncode, done.stdout) == (0, "")
    rows = pq.read_table(scene.parent / "draws.parquet").to_pylist()
    for row, wanted in zip(rows, drawn(scene), strict=True):
        for name, value in wanted.items():
            assert missing(row[name]) if missing(value) else np.array_equal(row[name], value)


def test_text_has_a_line_for_each_value(run, scene: Path) -> None:
    done = run("draws", scene, "--scene", "1")
    lines = done.stdout.splitlines()
    (found,) = scenecc.scene_draws(scene, scenes="1")
    assert [line.split()[2] for line in lines] == ["name", *found.values]
    mass = next(line for line in lines if "cube.mass" in line)
    assert mass.split() == ["0", "1", "cube.mass", f"{found.values['cube.mass'][0]:.5g}"]


@pytest.mark.parametrize(
    ("given", "status", "words"),
    [
        (("--seeds", "3"), 2, "'3' must be A:B with A below B, as in 0:20"),
        (("--seeds", "0:2", "--seed", "1"), 2, "cannot be combined with --seed"),
        (("--scene", "3"), 2, "--scene: error SC908: there is no scene 3: scenes are 0 to 2"),
        (
            ("--set", "edge=1"),
            2,
            'there is no parameter `edge`; it is a draw: give values in Python, `draws={"edge": …}`',
        ),
        (("--format", "xml"), 2, "'xml' is not one of 'text', 'json', 'csv', 'parquet'"),
        (("--format", "parquet"), 2, "Parquet is written to a file: -o FILE.parquet"),
        (("-o", "missing/draws.csv", "--format", "csv"), 2, "SC904"),
    ],
)
def test_wrong_arguments(run, scene: Path, given: tuple[str, ...], status: int, words: str) -> None:
    done = run("draws", scene, *given)
    assert done.returncode == status
    assert words in done.stderr


def test_parquet_needs_pyarrow(
    scene: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("scenecc.cli.draws.find_spec", lambda _: None)
    monkeypatch.setattr("sys.argv", ["scenecc", "draws", str(scene), "--format", "parquet", "-o", "x.parquet"])
    with pytest.raises(SystemExit) as ended:
        application()(prog_name="scenecc")
    assert "SC828: Parquet needs pyarrow, not installed here" in capsys.readouterr().err
    assert ended.value.code == 3
