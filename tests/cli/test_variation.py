"""Scenes that differ, from the command line: parameters, dry runs, and a part of a batch."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

SCENE = """\
scenecc: 1
num_scenes: 6
seed: 3
params:
  size: {type: number, default: 0.1, min: 0.01, max: 1}
  with_post: false
draws:
  height: {uniform: [0.2, 0.4]}
entities:
  floor: {body_type: static, shapes: [{type: plane}]}
  cube:
    pose: [{uniform: [-1, 1]}, 0, "${height}"]
    mass: {choice: [1, 2]}
    shapes: [{type: box, half_size: ["${size}", "${size}", "${height / 2}"]}]
  post:
    if: "${with_post}"
    body_type: static
    scene_idxs: "1::2"
    pose: {per_scene: [[0, 0, 1], [0, 0, 2], [0, 0, 3]]}
    shapes: [{type: sphere, radius: 0.05, color: {cycle: ["#ff0000", "#00ff00", "#0000ff"]}}]
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def plan(run, *options: str) -> dict:
    done = run("build", "scene.yaml", "--dry-run", "-o", "-", *options)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def entity(plan: dict, name: str) -> dict:
    return {item["name"]: item for item in plan["entities"]}[name]


@pytest.mark.parametrize("command", [("validate",), ("build", "--dry-run"), ("emit", "--to", "json"), ("diff",)])
def test_every_command_that_reads_a_scene_accepts_set(run, scene: Path, command: tuple[str, ...]) -> None:
    name, *options = command
    files = ["scene.yaml", "scene.yaml"] if name == "diff" else ["scene.yaml"]
    good = run(name, *files, *options, "--set", "size=0.3", "--set", "with_post=true")
    assert good.returncode == 0, good.stderr
    for setting, code in (("size=9", "SC212"), ("size=[1]", "SC211"), ("sise=1", "SC210")):
        bad = run(name, *files, *options, "--set", setting)
        assert bad.returncode == 2, "the command line is wrong, and not the file"
        assert code in bad.stdout + bad.stderr
        assert f"--set {setting.partition('=')[0]}" in bad.stdout + bad.stderr


def test_a_parameter_changes_the_built_scene(run, scene: Path) -> None:
    assert [item["name"] for item in plan(run)["entities"]] == ["floor", "cube"]
    with_post = plan(run, "--set", "with_post=true")
    assert entity(with_post, "post")["scene_idxs"] == "1:6:2"
    assert entity(with_post, "cube") == entity(plan(run), "cube"), "draws of one entity do not depend on another"


def test_a_dry_run_lists_the_varying_fields(run, scene: Path) -> None:
    done = run("build", scene, "--dry-run", "--set", "with_post=true")
    assert done.returncode == 0
    objects, fields, totals = done.stdout.split("\n\n")
    assert [line.split()[0] for line in objects.splitlines()] == ["name", "floor", "cube", "post"]
    assert objects.splitlines()[2].endswith("3 of 4")
    assert [re.sub("  +", "  ", line.strip()) for line in fields.splitlines()] == [
        "differs  values",
        "cube  pose.p  at reset  about [-1 … 1, 0, 0.2 … 0.4]",
        "mass  at reset  1 | 2",
        "shapes[0].half_size  about [0.1, 0.1, 0.10052 … 0.19989]",
        "post  pose.p  [0, 0, 1] | [0, 0, 2] | [0, 0, 3]",
        "shapes[0].material.base_color  #00ff00 | #ff0000 | #0000ff",
    ]
    assert totals.startswith("scene: planned 6 scenes, 15 objects in all; 5 fields differ, 2 drawn again at a reset\n")


def test_selected_scenes_equal_those_of_the_full_batch(run, scene: Path) -> None:
    few = run("build", scene, "--scene", "2:4", "--no-render", "--set", "with_post=true")
    assert few.returncode == 0, few.stderr
    assert "built 2 of 6 scenes, 5 objects in all" in few.stdout
    dry = run("build", scene, "--scene", "2:4", "--dry-run")
    assert "planned 2 of 6 scenes, 4 objects in all" in dry.stdout


def test_draws_do_not_depend_on_num_scenes(run, scene: Path) -> None:
    six, two = (entity(plan(run, "--num-scenes", count), "cube")["pose"]["per_scene"] for count in ("6", "2"))
    assert (len(six), len(two)) == (6, 2)
    assert six[:2] == two


def test_another_seed_changes_the_draws(run, scene: Path, tmp_path: Path) -> None:
    (tmp_path / "other.yaml").write_text(SCENE.replace("seed: 3", "seed: 4"))
    done = run("diff", "scene.yaml", "other.yaml")
    assert done.returncode == 1
    assert "~ seed: 3 → 4" in done.stdout
    assert "mass" in done.stdout
    assert run("diff", "scene.yaml", "other.yaml", "--seed", "5").returncode == 0


def test_repeat_equals_entities_that_are_written_out(run, tmp_path: Path) -> None:
    """A refactoring is told from a change."""
    written = "".join(
        f"  leg_{i}_{j}: {{pose: [{x}, {y}, 0], shapes: [{{type: sphere, radius: 0.1}}]}}\n"
        for i, x in enumerate((-1, 1))
        for j, y in enumerate((-1, 1))
    )
    repeated = (
        "  leg:\n    repeat: {i: [0, 1], j: [0, 1]}\n"
        '    name: "leg_${i}_${j}"\n    pose: ["${2 * i - 1}", "${2 * j - 1}", 0]\n'
        "    shapes: [{type: sphere, radius: 0.1}]\n"
    )
    (tmp_path / "a.yaml").write_text("scenecc: 1\nentities:\n" + written)
    (tmp_path / "b.yaml").write_text("scenecc: 1\nentities:\n" + repeated)
    done = run("diff", "a.yaml", "b.yaml")
    assert (done.returncode, done.stdout) == (0, "")


def test_an_error_in_any_scene_stops_a_partial_build(run, tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    text = 'entities: {c: {mass: "${1 / (6 - scene)}", shapes: [{type: sphere, radius: 0.1}]}}'
    scene.write_text(f"scenecc: 1\nnum_scenes: 8\n{text}\n")
    done = run("build", scene, "--scene", "0:4", "--dry-run")
    assert done.returncode == 1
    assert "error SC202: in scene 6: division by zero" in done.stdout + done.stderr
