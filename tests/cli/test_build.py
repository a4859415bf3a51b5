from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from cli.running import CUBE

from scenecc.cli.options import at_least, parse_limits

SCENES = """\
scenecc: 1
num_scenes: 4
entities:
  floor: {body_type: static, shapes: [{type: plane}]}
  cube: {pose: [0, 0, 0.5], mass: 0.25, shapes: [{type: box, half_size: [0.1, 0.2, 0.3]}]}
  post: {body_type: kinematic, scene_idxs: [0, 2], shapes: [{type: sphere, radius: 0.05}]}
"""
TYPO = SCENES.replace("radius", "radios")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENES)
    return path


def rows(text: str) -> dict[str, list[str]]:
    """The table's lines by name, columns apart."""
    lines = text.partition("\n\n")[0].splitlines()
    return {parts[0]: parts[1:] for parts in ([part for part in line.split("  ") if part] for line in lines)}


def test_the_table_lists_entities_and_their_scenes(run, scene: Path) -> None:
    done = run("build", scene)
    assert done.returncode == 0
    table = {name: [cell.strip() for cell in cells] for name, cells in rows(done.stdout).items()}
    assert table["name"] == ["body", "shapes", "mass [kg]", "size [m]", "scenes"]
    assert table["cube"] == ["dynamic", "1", "0.25", "0.2 × 0.4 × 0.6", "0–3"]
    assert table["post"][-1] == "0, 2"
    assert list(table) == ["name", "floor", "cube", "post"], "build order"
    assert done.stdout.splitlines()[-1] == "scene: built 4 scenes, 10 objects in all"


def test_num_scenes_overrides_the_file(run, scene: Path) -> None:
    assert "built 8 scenes" in run("build", scene, "--num-scenes", "8").stdout
    assert run("build", scene, "--num-scenes", "2").returncode == 1, "scene 2 does not exist then"


def test_scenes_builds_only_the_selected_scenes(run, scene: Path) -> None:
    done = run("build", scene, "--scene", "1:3,3")
    assert done.returncode == 0
    assert "built 3 of 4 scenes" in done.stdout
    assert {name: cells[-1].strip() for name, cells in rows(done.stdout).items()} == {
        "name": "scenes",
        "floor": "1–3",
        "cube": "1–3",
        "post": "2",
    }
    assert "post" not in rows(run("build", scene, "--scene", "1").stdout)


@pytest.mark.parametrize("scenes", ["4", "2:9", "1,1", "0:0", "some", "", "-1", "9" * 5000, "²", "١"])
def test_missing_scene_indices_are_wrong_usage(run, scene: Path, scenes: str) -> None:
    done = run("build", scene, f"--scene={scenes}", "--dry-run")
    assert (done.returncode, done.stdout) == (2, "")
    assert "SC908" in done.stderr


def test_steps_are_timed(run, scene: Path) -> None:
    assert run("build", scene, "--steps", "5", "--no-render").stderr == ""
    done = run("build", scene, "--steps", "5", "--no-render", "--timings")
    assert done.returncode == 0
    assert ", step " in done.stderr.splitlines()[-1]


def test_a_dry_run_starts_no_engine(run, scene: Path) -> None:
    done = run("build", scene, "--dry-run")
    assert done.returncode == 0
    assert "planned 4 scenes" in done.stdout
    script = (
        "import sys\n"
        "from scenecc.cli.app import main\n"
        f"sys.argv = ['scenecc', 'build', '--dry-run', {str(scene)!r}]\n"
        "try:\n"
        "    main()\n"
        "finally:\n"
        "    assert 'sapien' not in sys.modules\n"
    )
    checked = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=60)
    assert checked.returncode == 0, checked.stderr


def test_the_plan_is_written_and_builds_again(run, scene: Path, tmp_path: Path) -> None:
    first = run("build", scene, "-o", "plan.json")
    assert first.returncode == 0
    again = run("build", "plan.json", "-o", "again.json")
    assert again.returncode == 0
    assert (tmp_path / "plan.json").read_text() == (tmp_path / "again.json").read_text()
    assert rows(first.stdout) == rows(again.stdout)


def test_standard_output_contains_only_the_plan(run, scene: Path) -> None:
    done = run("build", scene, "--dry-run", "-o", "-")
    assert done.returncode == 0
    assert json.loads(done.stdout)
    assert "planned 4 scenes" in done.stderr


def test_json_has_the_summary_and_the_diagnostics(run, scene: Path, tmp_path: Path) -> None:
    good = run("build", scene, "--format", "json")
    summary = json.loads(good.stdout)
    assert (good.returncode, summary["diagnostics"], summary["built"], summary["num_scenes"]) == (0, [], True, 4)
    assert {row["name"]: row["scene_idxs"] for row in summary["objects"]}["post"] == [0, 2]
    (tmp_path / "bad.yaml").write_text(TYPO)
    bad = run("build", "bad.yaml", "--format", "json")
    assert bad.returncode == 1
    assert "SC101" in {d["code"] for d in json.loads(bad.stdout)["diagnostics"]}
    both = run("build", scene, "--format", "json", "-o", "-")
    assert both.returncode == 2
    (fault,) = json.loads(both.stdout)["diagnostics"]
    assert (fault["code"], fault["message"].split()[-2:]) == ("SC906", ["as", "json"])


def test_a_bad_scene_is_reported_on_standard_error_and_writes_nothing(run, tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text(TYPO)
    (tmp_path / "plan.json").write_text("old")
    done = run("build", "bad.yaml", "-o", "plan.json")
    assert (done.returncode, done.stdout) == (1, "")
    assert "SC101" in done.stderr
    assert (tmp_path / "plan.json").read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.yaml", "plan.json"]


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("gone.yaml",), "SC901"),
        ((".",), "SC901"),
        (("scene.yaml", "-o", "."), "SC904"),
        (("scene.yaml", "-o", "no/plan.json"), "SC904"),
        (("scene.yaml", "-o", "p" * 300), "SC904"),
        (("scene.yaml", "-o", "scene.yaml/plan.json"), "SC904"),
    ],
)
def test_impossible_paths_are_wrong_usage(run, scene: Path, arguments: tuple[str, ...], code: str) -> None:
    done = run("build", *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert code in done.stderr


def test_a_full_device_is_reported(run, scene: Path) -> None:
    """Be it named or standard output, or where a fault would be told."""
    done = run("build", scene, "--dry-run", "-o", "/dev/full")
    assert done.returncode == 3
    assert "error SC818: `/dev/full` cannot be written: No space left on device" in done.stderr
    for arguments, status in (("build --dry-run -o - $1 >/dev/full", 3), ("build no.yaml 2>/dev/full", 2)):
        shell = ["sh", "-c", f"$0 -m scenecc {arguments}", sys.executable, str(scene)]
        assert subprocess.run(shell, capture_output=True, check=False, timeout=60).returncode == status


def test_there_is_no_option_for_the_physx_device(run, scene: Path) -> None:
    done = run("build", scene, "--dry-run", "--backend", "cpu")
    assert done.returncode == 2
    assert "No such option: --backend" in done.stderr
    assert "a GPU run through scenecc.maniskill" in " ".join(run("build", "--help").stdout.split())


def test_a_scene_is_read_from_standard_input(run) -> None:
    done = run("build", "-", "--dry-run", stdin=CUBE)
    assert done.returncode == 0
    assert "cube" in rows(done.stdout)


@pytest.mark.parametrize("option", ["--num-scenes", "--seed", "--steps", "--limit=depth"])
def test_a_number_of_thousands_of_digits_is_wrong_usage(run, scene: Path, option: str) -> None:
    done = run("build", scene, "--dry-run", f"{option}={'9' * 5000}")
    assert (done.returncode, done.stdout) == (2, "")
    assert "Invalid value for" in done.stderr
    assert len(done.stderr) < 1000


@pytest.mark.parametrize("value", ["9" * 19, "١", "²", "1__0", "-1", "1.5", "", "0x1", "x\x1b[2J"])
def test_option_integers_must_be_short_and_ascii(value: str) -> None:
    for read in (at_least(0), lambda text: parse_limits([f"depth={text}"])):
        with pytest.raises(typer.BadParameter) as caught:
            read(value)
        assert caught.value.message.isprintable()


def test_num_scenes_must_be_positive_and_a_seed_may_be_long(run, scene: Path) -> None:
    assert run("build", scene, "--dry-run", "--num-scenes", "0").returncode == 2
    done = run("build", scene, "--dry-run", "--seed", "9" * 100, "--steps", "0", "--limit", "text_bytes=1_000_000")
    assert done.returncode == 0, done.stderr


def test_a_plan_is_not_compiled_twice(cube: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenecc import pipeline
    from scenecc.cli.build import build

    compiled: list[object] = []
    once = pipeline.compile_source
    monkeypatch.setattr(pipeline, "compile_source", lambda *given: compiled.append(given[0]) or once(*given))
    with pytest.raises(typer.Exit):
        build(str(cube), dry_run=True, output=str(tmp_path / "plan.json"), limits=["asset_bytes=1"])
    assert compiled == [str(cube)]


def test_names_in_a_scene_are_escaped(run, tmp_path: Path) -> None:
    plan = json.loads(run("build", "-", "--dry-run", "-o", "-", stdin=CUBE).stdout)
    plan["name"] = plan["entities"][0]["name"] = "::error::\x1b[2J\n::error::x\u202e"
    plan["description"] = "\x9b2J\u202e"
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    for command in (("build", "--dry-run"), ("build", "--dry-run", "-o", "-"), ("emit", "--to", "python")):
        done = run(*command, "plan.json")
        assert done.returncode == 0, done.stderr
        for text in (done.stdout, done.stderr):
            assert not set(text) & {"\x1b", "\x9b", "\u202e"}
            assert not any(line.strip().startswith("::") for line in text.splitlines())


@pytest.mark.parametrize("steps", ["9", "25"])
def test_a_diverging_simulation_is_an_error_of_the_scene(run, tmp_path: Path, steps: str) -> None:
    scene = tmp_path / "scene.yaml"
    scene.write_text(f"physics: {{gravity: [0, 0, -1.0e+6], timestep: 1}}\n{CUBE}")
    assert run("build", scene, "--no-render").returncode == 0
    done = run("build", scene, "--no-render", "--steps", steps)
    assert (done.returncode, done.stdout) == (1, "")
    assert "scene.yaml:4:" in done.stderr
    assert (
        f"error SC820: `cube` is beyond 1e6 m, m/s, rad or rad/s in scene 0 by step {min(int(steps), 10)}"
        in done.stderr
    )


def test_all_prints_every_row_of_a_long_table(run, tmp_path: Path) -> None:
    bodies = "".join(f"  b{i}: {{shapes: [{{type: sphere, radius: {i + 1}}}]}}\n" for i in range(35))
    (tmp_path / "many.yaml").write_text(f"scenecc: 1\nentities:\n{bodies}")
    short = run("build", "many.yaml", "--dry-run").stdout
    assert short.splitlines()[1].startswith("b0 … b34 (35)  dynamic")
    whole = run("build", "many.yaml", "--dry-run", "--all").stdout
    assert {f"b{i}" for i in range(35)} <= set(whole.split())


def test_an_error_of_an_option_has_no_file(run, scene: Path) -> None:
    for arguments, option in ((("--scene", "9"), "--scene"), (("--set", "nothing=1"), "--set nothing")):
        command = ("build", scene, "--dry-run", *arguments)
        assert run(*command).stderr.startswith(f"{option}: error SC")
        assert run(*command, "--format", "github").stdout.startswith("::error title=SC")
        (record,) = json.loads(run(*command, "--format", "json").stdout)["diagnostics"]
        assert (record["file"], record["path"]) == (None, option)


@pytest.mark.parametrize("option", [("--steps", "3"), ("--audit",), ("--no-audit",), ("--render",), ("--no-render",)])
def test_a_dry_run_rejects_engine_options(run, scene: Path, option: tuple[str, ...]) -> None:
    done = run("build", scene, "--dry-run", *option)
    assert done.returncode == 2
    assert f"Invalid value for '{option[0]}': it concerns the engine, which --dry-run does not start" in done.stderr
