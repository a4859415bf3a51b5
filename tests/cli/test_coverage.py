"""`scenecc cover` and `scenecc coverage` as processes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import scenecc

SCENE = """\
scenecc: 1
draws:
  a: {choice: [1, 2, 3, 4]}
  b: {choice: [1, 2, 3, 4]}
  c: {integers: [1, 4]}
entities:
  cube:
    pose: [{choice: [0.0, 0.1, 0.2, 0.3]}, {uniform: [-1, 1]}, 1]
    mass: {choice: [1, 2, 3, 4]}
    shapes: [{type: box, half_size: "${[a/10, b/10, c/10]}", color: {choice: ["#ff0000", "#00ff00", "#0000ff", "#ffffff"]}}]
"""  # noqa: E501


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def test_six_factors_of_four_values_are_covered_by_few_scenes(run, scene: Path, tmp_path: Path) -> None:
    starts = tmp_path / "starts.json"
    done = run("cover", scene, "--pairwise", "-o", starts)
    assert (done.returncode, done.stderr) == (0, "")
    count = int(done.stdout.split()[0])
    assert done.stdout == f"{count} scenes meet 240 of 240 pairs and fill 1 range\n"
    assert count <= 28
    assert run("cover", scene, "-o", tmp_path / "again.json").returncode == 0
    assert (tmp_path / "again.json").read_bytes() == starts.read_bytes()

    draws = tmp_path / "draws.json"
    assert run("draws", scene, "-n", str(count), "--starts", starts, "-o", draws).returncode == 0
    whole = run("coverage", scene, draws, "--require", "100")
    assert whole.returncode == 0
    assert whole.stdout.startswith(f"{count} episodes met 240 of 240 pairs (100.0 %)\n")
    with scenecc.load_scene(scene, num_scenes=count, starts=starts, render=False) as batch:
        drawn, begin = batch.drawn(), batch.state()
        assert {*zip(drawn["a"].tolist(), drawn["cube.mass"].tolist(), strict=True)} == {
            (a, m) for a in range(1, 5) for m in range(1, 5)
        }
        batch.step(5)
        batch.reset(seed=7)
        assert batch.state() == begin
    wrong = run("build", scene, "-n", "3", "--starts", starts, "--dry-run")
    assert wrong.returncode == 1
    assert f"SC937: `{starts}` was made with {count} scenes, and 3 are built" in wrong.stderr
    scene.write_text(SCENE.replace("[-1, 1]", "[-2, 1]"))
    changed = run("build", scene, "-n", str(count), "--starts", starts, "--dry-run")
    assert "SC936" in changed.stderr
    assert "cover the scene again" in changed.stderr


def test_a_cover_does_not_depend_on_the_hash_seed(run, tmp_path: Path) -> None:
    scene = {
        "scenecc": 1,
        "draws": {name: {"integers": [0, 3]} for name in "abcde"},
        "entities": {
            "ball": {
                "mass": "${1 if a + b + c + d + e == 8 else -1}",
                "linear_damping": {"choice": [0, "${1 / (2 - d)}"]},
                "shapes": [{"type": "sphere", "radius": 0.1}],
            }
        },
    }
    path = tmp_path / "scene.yaml"
    path.write_text(json.dumps(scene))
    assert len({run("cover", path, PYTHONHASHSEED=seed).stdout for seed in "01"}) == 1


def test_the_rows_are_printed_without_an_output(run, scene: Path) -> None:
    lines = run("cover", scene).stdout.splitlines()
    assert lines[0].split() == ["scene", "a", "b", "c", "cube.shapes[0].color", "cube.mass", "cube.pose.p[0]"]
    data = json.loads(run("cover", scene, "--format", "json").stdout)
    assert lines[1].split()[1:5:3] == [str(data["rows"][0]["a"]), data["rows"][0]["cube.shapes[0].color"]]
    assert (data["met"], data["total"], data["missed"]) == (240, 240, [])


def test_sobol_makes_as_many_scenes_as_asked(run, scene: Path, tmp_path: Path) -> None:
    done = run("cover", scene, "--sobol", "10", "-o", tmp_path / "starts.json")
    assert done.stdout.startswith("10 scenes meet ")
    assert "10 is not a power of two" in done.stdout
    assert len(json.loads((tmp_path / "starts.json").read_text())["rows"]) == 10


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--pairwise", "--sobol", "4"], "either --pairwise or --sobol"),
        (["-o", "starts.txt"], "it must be a file NAME.json"),
        (["--sobol", "0"], "must be an integer of at least 1"),
    ],
)
def test_wrong_options_are_refused(run, scene: Path, arguments: list[str], message: str) -> None:
    done = run("cover", scene, *arguments)
    assert done.returncode == 2
    assert message in done.stderr


def test_less_coverage_than_required_is_an_error(run, scene: Path, tmp_path: Path) -> None:
    draws = tmp_path / "draws.csv"
    run("draws", scene, "--seeds", "0:20", "-o", draws)
    done = run("coverage", scene, draws, "--require", "90", "--format", "json")
    data = json.loads(done.stdout)
    assert done.returncode == 1
    assert data["diagnostics"][0]["code"] == "SC947"
    assert data["met"] + len(data["missed"]) == data["total"] == 240
    text = run("coverage", scene, draws).stdout
    assert f"… {len(data['missed']) - 10} more" in text
    assert run("coverage", scene, tmp_path / "none.json").returncode == 2


@pytest.mark.parametrize("suffix", ["json", "csv", "parquet", "jsonl"])
def test_all_formats_give_the_same(suffix: str, run, scene: Path, tmp_path: Path) -> None:
    path = tmp_path / f"draws.{suffix}"
    (found,) = scenecc.scene_draws(scene, num_scenes=8)
    rows = [{name: np.asarray(values[index]).tolist() for name, values in found.values.items()} for index in range(8)]
    if suffix == "jsonl":
        path.write_text("\n".join(map(json.dumps, rows)))
    else:
        assert run("draws", scene, "-n", "8", "-o", path).returncode == 0
    one, other = scenecc.scene_coverage(scene, path), scenecc.scene_coverage(scene, rows)
    assert (one.missed, one.factors, one.episodes) == (other.missed, other.factors, 8)
