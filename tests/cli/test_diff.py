"""`scenecc diff`: what differs between two scenes, and the exit status that follows."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cli.running import CUBE

SCENE = """\
scenecc: 1
num_scenes: 2
entities:
  floor: {body_type: static, shapes: [{type: plane}]}
  cube: {pose: [0, 0, 0.5], mass: 0.25, shapes: [{type: box, half_size: [0.1, 0.2, 0.3]}]}
  post: {body_type: kinematic, shapes: [{type: sphere, radius: 0.05}]}
"""
SAME = """\
scenecc: 1
num_scenes: 2
x-shapes: &ball [{radius: 5e-2, type: sphere}]
entities:
  floor: {body_type: static, shapes: [{type: plane}]}
  cube:
    mass: 0.25
    pose: {p: [0, 0, 0.5], rpy_deg: [0, 0, 0]}
    shapes:
      - {type: box, half_size: [0.1, 0.2, 0.3]}
  post: {body_type: kinematic, shapes: *ball}
"""


@pytest.fixture
def scenes(tmp_path: Path) -> Path:
    (tmp_path / "a.yaml").write_text(SCENE)
    (tmp_path / "same.yaml").write_text(SAME)
    (tmp_path / "bad.yaml").write_text(SCENE.replace("radius", "radios"))
    return tmp_path


def test_a_scene_equals_itself_and_another_notation(run, scenes: Path) -> None:
    for other in ("a.yaml", "same.yaml"):
        done = run("diff", "a.yaml", other)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize(
    ("old", "new", "lines"),
    [
        ("mass: 0.25", "mass: 0.5", ["~ entities.cube", "~     mass: 0.25 → 0.5 (in 2 scenes)"]),
        (
            "  post:",
            "  pole:",
            ["- entities.post: kinematic in every scene", "+ entities.pole: kinematic in every scene"],
        ),
        (
            "num_scenes: 2\n",
            "num_scenes: 2\nphysics: {timestep: 0.005}\n",
            ["~ physics", "~     timestep: unset → 0.005"],
        ),
        ("num_scenes: 2\n", "num_scenes: 2\nseed: 3\n", ["~ seed: 0 → 3"]),
    ],
)
def test_a_change_is_listed_by_object_and_field(run, scenes: Path, old: str, new: str, lines: list[str]) -> None:
    (scenes / "b.yaml").write_text(SCENE.replace(old, new))
    done = run("diff", "a.yaml", "b.yaml")
    count = sum("→" in line or line[0] in "+-" or "timestep" in line for line in lines)
    assert done.returncode == 1
    assert done.stdout.splitlines() == [*lines, f"{count} difference{'s' * (count != 1)}"]


def test_swapping_the_scenes_swaps_added_and_removed(run, scenes: Path) -> None:
    (scenes / "b.yaml").write_text(SCENE.replace("  post:", "  pole:"))
    assert run("diff", "b.yaml", "a.yaml").stdout.splitlines()[0] == "- entities.pole: kinematic in every scene"


def test_a_different_order_is_a_difference(run, scenes: Path) -> None:
    *head, floor, cube, post = SCENE.splitlines(keepends=True)
    (scenes / "b.yaml").write_text("".join([*head, floor, post, cube]))
    done = run("diff", "a.yaml", "b.yaml")
    assert done.returncode == 1
    assert done.stdout.startswith("> entities.")


def test_diff_prints_json(run, scenes: Path) -> None:
    (scenes / "b.yaml").write_text(SCENE.replace("0.25", "0.5"))
    done = run("diff", "a.yaml", "b.yaml", "--format", "json")
    assert done.returncode == 1
    assert json.loads(done.stdout) == {
        "differences": [
            {
                "kind": "changed",
                "section": "entities",
                "name": "cube",
                "path": "mass",
                "a": "0.25",
                "b": "0.5",
                "scene_count": 2,
            }
        ],
        "diagnostics": [],
    }
    same = run("diff", "a.yaml", "same.yaml", "--format", "json")
    assert (same.returncode, json.loads(same.stdout)) == (0, {"differences": [], "diagnostics": []})


def test_a_plan_equals_its_scene(run, scenes: Path) -> None:
    assert run("emit", "a.yaml", "--to", "json", "-o", "plan.json").returncode == 0
    assert run("diff", "plan.json", "same.yaml").stdout == "~ name: a → same\n1 difference\n"
    assert run("diff", "plan.json", "a.yaml").returncode == 0


def test_options_apply_to_both_scenes(run, scenes: Path) -> None:
    (scenes / "b.yaml").write_text(SCENE.replace("num_scenes: 2", "num_scenes: 8"))
    assert run("diff", "a.yaml", "b.yaml").returncode == 1
    assert run("diff", "a.yaml", "b.yaml", "--num-scenes", "4").returncode == 0


def test_diff_reads_a_scene_from_standard_input(run, scenes: Path) -> None:
    assert run("diff", "-", "a.yaml", stdin=SAME).returncode == 0
    assert run("diff", "a.yaml", "-", stdin=CUBE).returncode == 1


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("a.yaml", "bad.yaml"), "SC101"),
        (("bad.yaml", "bad.yaml"), "SC101"),
        (("a.yaml", "gone.yaml"), "SC901"),
        ((".", "a.yaml"), "SC901"),
        (("-", "-"), "standard input"),
        (("a.yaml",), "B"),
        (("a.yaml", "same.yaml", "--set", "x"), "name=value"),
    ],
)
def test_scenes_that_cannot_be_compared_give_status_2(run, scenes: Path, arguments: tuple[str, ...], code: str) -> None:
    done = run("diff", *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert code in done.stderr


def test_colour_marks_additions_and_removals(run, scenes: Path) -> None:
    (scenes / "b.yaml").write_text(SCENE.replace("  post:", "  pole:"))
    shown = run("diff", "a.yaml", "b.yaml", FORCE_COLOR="1").stdout
    assert "\x1b[31m- entities.post" in shown
    assert "\x1b[32m+ entities.pole" in shown


def test_a_name_cannot_steer_the_terminal(run, scenes: Path) -> None:
    (scenes / "b.yaml").write_text(SCENE.replace("scenecc: 1\n", 'scenecc: 1\nname: "x\\e[2J\\n::error::x"\n'))
    done = run("diff", "a.yaml", "b.yaml")
    assert done.returncode == 1
    assert "\x1b" not in done.stdout
    assert not any(line.startswith("::") for line in done.stdout.splitlines())


DRAWN = """\
scenecc: 1
num_scenes: 4
draws: {z: {uniform: [0, 2]}}
entities:
  ball: {pose: POSE, shapes: [{type: sphere, radius: 0.05}]}
"""


def compared(run, folder: Path, *poses: str):
    for name, pose in zip("ab", poses, strict=True):
        (folder / f"{name}.yaml").write_text(DRAWN.replace("POSE", pose))
    return run("diff", "a.yaml", "b.yaml")


def test_what_is_drawn_is_compared_as_it_is_written(run, tmp_path: Path) -> None:
    done = compared(run, tmp_path, '[0, 0, "${z}"]', '{p: [0, 0, "${z}"], q: [1, 0, 0, 0]}')
    assert (done.returncode, done.stdout) == (0, "")
    done = compared(run, tmp_path, '[0, 0, "${z}"]', '[0, 0, "${z * 1}"]')
    assert done.returncode == 1
    assert done.stdout.splitlines() == [
        "~ entities.ball",
        "~     pose.p: about [0, 0, 0 … 2] at reset → about [0, 0, 0.0077719 … 1.98] at reset (in 4 scenes)",
        "1 difference",
    ]


def test_a_changed_field_is_listed_once_under_its_key(run, scenes: Path) -> None:
    (scenes / "b.yaml").write_text(
        SCENE.replace("0.2, 0.3", "0.2, 0.4").replace("sphere, radius: 0.05", "box, half_size: [1, 1, 1]")
    )
    assert run("diff", "a.yaml", "b.yaml").stdout.splitlines() == [
        "~ entities.cube",
        "~     shapes[0].half_size: [0.1, 0.2, 0.3] → [0.1, 0.2, 0.4] (in 2 scenes)",
        "~ entities.post",
        "~     shapes[0].type: sphere → box",
        "2 differences",
    ]
