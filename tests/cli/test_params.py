"""`scenecc params` and `scenecc prefabs`: what can be given, as tables and as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cli.running import CUBE

SCENE = """\
scenecc: 1
params:
  size: {type: number, default: 1.5, min: 0.1, max: 2, description: "edge [m]"}
  kind: {type: choice, options: [a, b], default: b}
  corner: {type: vector, default: [0, "${size}", 1]}
  mesh: {type: file, description: must be given}
  flag: true
entities:
  cube: {shapes: [{type: box, half_size: ["${size}", 1, 1]}]}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def test_parameters_are_listed_as_a_table(run, scene: Path) -> None:
    done = run("params", scene)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == (
        "name    type     default            range     description\n"
        "size    number   1.5                0.1 to 2  edge [m]\n"
        "kind    choice   b                  a, b\n"
        'corner  vector   [0, "${size}", 1]\n'
        "mesh    file     –                            must be given\n"
        "flag    boolean  true\n"
    )


def test_parameters_as_json_keep_their_types(run, scene: Path) -> None:
    done = run("params", scene, "--format", "json")
    assert json.loads(done.stdout)["parameters"] == [
        {"name": "size", "type": "number", "default": 1.5, "min": 0.1, "max": 2, "description": "edge [m]"},
        {"name": "kind", "type": "choice", "default": "b", "options": ["a", "b"], "description": ""},
        {"name": "corner", "type": "vector", "default": [0, "${size}", 1], "description": ""},
        {"name": "mesh", "type": "file", "description": "must be given"},
        {"name": "flag", "type": "boolean", "default": True, "description": ""},
    ]


def test_parameters_of_included_files_are_listed(run, tmp_path: Path) -> None:
    (tmp_path / "parts.yaml").write_text("scenecc: 1\nparams: {n: 3}\n")
    (tmp_path / "scene.yaml").write_text("include: [parts.yaml]\n" + SCENE)
    assert run("params", "scene.yaml").stdout.splitlines()[1].startswith("n       number   3")


def test_params_of_a_scene_without_parameters_says_so(run, cube: Path) -> None:
    done = run("params", cube)
    assert (done.returncode, done.stdout) == (0, "no parameters\n")
    assert json.loads(run("params", cube, "--format", "json").stdout) == {"parameters": [], "diagnostics": []}
    assert run("params", "-", stdin=CUBE).stdout == "no parameters\n"
    assert run("params", "-", stdin='{"scenecc_plan": 1}').stdout == "no parameters\n", "a plan has none any more"


@pytest.mark.parametrize(
    ("text", "code", "status"),
    [
        (SCENE.replace("max: 2", "mux: 2"), "SC214", 1),
        (SCENE.replace("entities", "entitys"), "SC101", 1),
        ("a: [", "SC003", 1),
        (None, "SC901", 2),
    ],
)
def test_params_of_a_bad_scene_lists_nothing(run, tmp_path: Path, text: str | None, code: str, status: int) -> None:
    if text is not None:
        (tmp_path / "scene.yaml").write_text(text)
    done = run("params", "scene.yaml")
    assert (done.returncode, done.stdout) == (status, "")
    assert code in done.stderr


def test_params_escapes_descriptions(run, tmp_path: Path) -> None:
    text = 'scenecc: 1\nparams:\n  n: {type: number, default: 1, description: "\\e[2J\\n::error::x"}\n'
    (tmp_path / "scene.yaml").write_text(text)
    done = run("params", "scene.yaml")
    assert done.returncode == 0
    assert "\x1b" not in done.stdout
    assert len(done.stdout.splitlines()) == 2


def test_every_shipped_prefab_is_listed_with_its_parameters(run) -> None:
    done = run("prefabs")
    assert (done.returncode, done.stderr) == (0, "")
    lines = {line.split("  ")[0]: line for line in done.stdout.splitlines()}
    folder = Path(__file__).parents[2] / "scenecc" / "prefabs"
    assert lines.keys() == {"name", *(f"scenecc:{file.stem}" for file in folder.glob("*.yaml") if "." not in file.stem)}
    assert lines["scenecc:table"].endswith("size, height, thickness, color, body_type")
    assert "A square table" in lines["scenecc:table"]


@pytest.mark.parametrize("name", ["table", "scenecc:table"])
def test_parameters_of_a_prefab_are_listed_like_those_of_a_file(run, name: str) -> None:
    done = run("prefabs", name)
    assert done.returncode == 0
    head, _, rows = done.stdout.partition("\n\n")
    assert head.startswith("scenecc:table: A square table")
    assert [line.split()[0] for line in rows.splitlines()] == [
        "name",
        "size",
        "height",
        "thickness",
        "color",
        "body_type",
    ]


def test_prefabs_prints_json(run) -> None:
    everything = json.loads(run("prefabs", "--format", "json").stdout)["prefabs"]
    (table,) = json.loads(run("prefabs", "table", "--format", "json").stdout)["prefabs"]
    assert table in everything
    assert table["parameters"][0]["name"] == "size"
    assert (table["editions"], table["edition"]) == ([], None)
    (workspace,) = (row for row in everything if row["name"] == "scenecc:table_workspace")
    assert workspace["editions"] == ["mani_skill"]


def test_an_unknown_prefab_is_wrong_usage(run) -> None:
    done = run("prefabs", "tabel\x1b")
    assert (done.returncode, done.stdout) == (2, "")
    assert "SC909" in done.stderr
    assert "did you mean `scenecc:table`" in done.stderr
    assert "\x1b" not in done.stderr


def test_a_dissimilar_prefab_name_names_what_lists_all_prefabs(run) -> None:
    error = run("prefabs", "nosuch").stderr
    assert "did you mean" not in error
    assert "14 others (`scenecc prefabs` lists all)" in error
