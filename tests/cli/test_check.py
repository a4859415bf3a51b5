from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

OVERLAP = """\
scenecc: 1
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  a: {pose: [0, 0, 0.1], shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
  b: {pose: [0.1, 0, 0.1], shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
"""
TOPPLES = """\
scenecc: 1
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  pole: {pose: {p: [0, 0, 0.201], rpy_deg: [4, 0, 0]}, shapes: [{type: box, half_size: [0.01, 0.01, 0.2]}]}
"""


def test_a_finding_has_its_line_and_the_command_that_shows_it(run, tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(OVERLAP)
    done = run("check", "scene.yaml", "--settle", "0")
    assert done.returncode == 1
    assert "scene.yaml:4:3: error SC850: `a` and `b` overlap by 100 mm at the start, in scene 0" in done.stdout
    assert "`scenecc view scene.yaml --seed 0 --scene 0` shows it" in done.stdout
    assert done.stderr == "1 file checked; 1 scene, seed 0, 1 step simulated\n"


def test_the_summary_says_what_was_simulated(run, tmp_path: Path) -> None:
    entities = "entities: {ball: {gravity: false, shapes: [{type: sphere, radius: 0.1}]}}\n"
    (tmp_path / "a.yaml").write_text(f"scenecc: 1\nnum_scenes: 4\nseed: 7\n{entities}")
    (tmp_path / "b.yaml").write_text(f"scenecc: 1\n{entities}expect: {{settled: {{seconds: 2.5}}}}\n")
    (tmp_path / "c.yaml").write_text("scenecc: 2\n")
    for origins in (("", ", 1 of 3 files from the cache"), (", from the cache",) * 2):
        assert run("check", "a.yaml").stderr == f"1 file checked; 4 scenes, seed 7, 1 s simulated{origins[0]}\n"
        done = run("check", "a.yaml", "b.yaml", "c.yaml")
        assert done.stderr == f"3 files checked; 5 scenes, seeds 0, 7, 1 to 2.5 s simulated{origins[1]}\n"
        report = json.loads(run("check", "a.yaml", "c.yaml", "--seeds", "1:3", "--format", "json").stdout)
        assert report["simulated"] == {
            "a.yaml": {"scenes": 4, "seeds": [1, 2], "seconds": 1.0, "permuted": False, "cached": bool(origins[0])},
            "c.yaml": None,
        }
    assert run("check", "c.yaml", "--no-cache").stderr == "1 file checked; nothing simulated\n"
    assert run("check", "a.yaml", "--scene", "1,3").stderr == "1 file checked; 2 scenes, seed 7, 1 s simulated\n"
    assert "there is no scene 4" in run("check", "a.yaml", "--scene", "4").stdout
    assert "simulated" not in json.loads(run("validate", "a.yaml", "--format", "json").stdout)


def test_a_finding_in_a_prefab_is_placed_at_its_use(run, tmp_path: Path) -> None:
    (tmp_path / "part.yaml").write_text(OVERLAP.replace("a: {", "a: {repeat: {once: {count: 1}}, name: a, "))
    (tmp_path / "scene.yaml").write_text("scenecc: 1\nentities:\n  stack: {use: part.yaml}\n")
    command = ("check", "scene.yaml", "--settle", "0", "--format")
    (one,) = json.loads(run(*command, "json").stdout)["diagnostics"]
    assert (one["file"], one["line"], one["column"], one["path"]) == ("scene.yaml", 3, 16, "entities.stack.use")
    assert [(place["file"], place["line"]) for place in one["related"]] == [("part.yaml", 4), ("part.yaml", 5)]
    assert one["message"] == "`stack/a` and `stack/b` overlap by 100 mm at the start, in scene 0"  # no `(once=0)`
    assert run(*command, "github").stdout.startswith("::error file=scene.yaml,line=3,")
    assert '"uri": "scene.yaml"' in run(*command, "sarif").stdout
    assert run(*command, "junit").stdout.count("<testcase") == 1


def test_a_comment_in_a_prefab_or_at_its_use_silences_a_finding(run, tmp_path: Path) -> None:
    comment = "  # scenecc: ignore SC854 -- it shall fall"
    for in_prefab, at_use in (("", ""), (comment, ""), ("", comment)):
        (tmp_path / "part.yaml").write_text(TOPPLES.removesuffix("\n") + f"{in_prefab}\n")
        (tmp_path / "scene.yaml").write_text(f"scenecc: 1\nentities:\n  pole: {{use: part.yaml}}{at_use}\n")
        assert ("SC854" in run("check", "scene.yaml").stdout) == (in_prefab == at_use)


def test_a_finding_of_an_included_file_fails_the_checked_file_in_junit(run, tmp_path: Path) -> None:
    (tmp_path / "part.yaml").write_text(OVERLAP)
    (tmp_path / "scene.yaml").write_text("scenecc: 1\ninclude: [part.yaml]\n")
    text = run("check", "scene.yaml", "--settle", "0", "--format", "junit").stdout
    assert 'tests="1" failures="1"' in text
    assert "part.yaml:4:3: error SC850" in text


def test_scenes_only_skips_other_files(run, tmp_path: Path) -> None:
    (tmp_path / "compose.yaml").write_text("services: {}\n")
    done = run("check", "--scenes-only", "compose.yaml")
    assert (done.returncode, done.stderr) == (0, "0 files checked, 1 other file skipped\n")


def test_a_permuted_check_says_so(run, tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(OVERLAP)
    done = run("check", "scene.yaml", "--settle", "0", "--permute", "--num-scenes", "2")
    assert "SC867" not in done.stdout
    assert done.stderr == "1 file checked; 2 scenes, seed 0, 1 step simulated and permuted\n"


def test_the_command_of_a_finding_shows_that_scene(run, tmp_path: Path) -> None:
    expect = "expect: {holds: [{that: \"${x < 0 or position('a')[0] < h or name == 'b'}\"}]}\n"
    params = "params: {h: {default: 9}, name: {type: string, default: b}}\ndraws: {x: {uniform: [-1, 1]}}\n"
    body = 'entities: {a: {body_type: static, pose: ["${x}", 0, 0], shapes: [{type: sphere, radius: 1}]}}\n'
    (tmp_path / "my scene.yaml").write_text(f"scenecc: 1\n{params}{body}{expect}")
    given = ["--set", "h=1e-6", "--set", "name=it's", "--num-scenes", "5", "--limit", "scenes=5", "--settle", "0"]
    assert run("check", "my scene.yaml").returncode == 0
    (line,) = re.findall(r"hint: `(.*)` shows it", run("check", "my scene.yaml", *given, "--seeds", "2:6").stdout)
    scenecc, view, *arguments = shlex.split(line)
    assert (scenecc, view) == ("scenecc", "view")
    assert run(view, *arguments, "-o", "page.html").returncode == 0
    where = arguments.index("--seed")
    seed, scene = arguments[where + 1], int(arguments[where + 3])
    told = run("check", *arguments[:where], "--seed", seed).stdout
    assert re.search(rf"in (scene {scene}|scenes .*in scene {scene})\n", told)


def test_a_warning_fails_only_a_strict_check(run, tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(TOPPLES)
    assert run("check", "scene.yaml").returncode == 0
    assert run("check", "scene.yaml", "--strict").returncode == 1
    assert run("check", "scene.yaml", "--strict", "--settle", "0").returncode == 0


def test_files_of_a_folder_are_checked_with_each_seed(run, tmp_path: Path) -> None:
    (tmp_path / "scenes").mkdir()
    for name in ("a.yaml", "b.yaml"):
        (tmp_path / "scenes" / name).write_text(OVERLAP)
    done = run("check", "scenes", "--settle", "0", "--seeds", "3:5", "--format", "json")
    found = json.loads(done.stdout)["diagnostics"]
    assert [one["file"] for one in found] == ["scenes/a.yaml", "scenes/b.yaml"]
    assert found[0]["message"].endswith("in 2 scenes; such as in scene 0 with seed 3")


@pytest.mark.parametrize(
    "options",
    [["--seeds", "5"], ["--seeds", "5:5"], ["--settle", "-1"], ["--settle", "nan"], ["--seeds", "0:2", "--seed", "1"]],
)
def test_wrong_options_give_status_2(run, tmp_path: Path, options: list[str]) -> None:
    (tmp_path / "scene.yaml").write_text(OVERLAP)
    assert run("check", "scene.yaml", *options).returncode == 2


def test_a_scene_from_standard_input_is_checked(run) -> None:
    done = run("check", "-", "--settle", "0", stdin=OVERLAP)
    assert done.returncode == 1
    assert "SC850" in done.stdout
    assert "scenecc view" not in done.stdout
