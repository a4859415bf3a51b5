"""What a shell completes, asked as bash and zsh ask."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from scenecc.cli import completion
from scenecc.cli.app import COMMANDS
from scenecc.diagnostics.codes import CODES

SCENE = """\
scenecc: 1
include: [parts/lights.yaml, ../outside.yaml]
params: {size: {type: number, default: 0.5}, kind: {type: choice, options: [oak, steel]}, on: true, note: "a b"}
entities:
  cube: {shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
  desk: {use: scenecc:table}
  arm: {use: arm.yaml, prefix: ""}
  row: {repeat: {i: [0, 1]}, shapes: [{type: sphere, radius: 0.1}]}
cameras: {front: {pose: [0, 0, 1]}}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "parts").mkdir()
    (tmp_path / "scene.yaml").write_text(SCENE)
    (tmp_path / "arm.yaml").write_text("scenecc: 1\nentities: {link: {}}\ncameras: {wrist: {}}\n")
    (tmp_path / "parts" / "lights.yaml").write_text("scenecc: 1\nparams: {lux: 3}\ncameras: {top: {}}\n")
    (tmp_path.parent / "outside.yaml").write_text("scenecc: 1\nparams: {secret: 1}\n")
    (tmp_path / "notes.txt").touch()
    (tmp_path / ".hidden.yaml").touch()
    (tmp_path / "loop.yaml").write_text("scenecc: 1\ninclude: [loop.yaml]\nparams: {a: 1}\n")
    (tmp_path / "bad.yaml").write_text("scenecc: [1\n")
    return tmp_path


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("ins", ["inspect"]),
        ("build ", ["arm.yaml", "bad.yaml", "loop.yaml", "parts/", "scene.yaml"]),
        ("build sc", ["scene.yaml"]),
        ("validate pa", ["parts/lights.yaml"]),
        ("build nothing", []),
        ("build scene.yaml --set ", ["lux=3", "size=0.5", "kind=oak", "kind=steel", "on=true", "note="]),
        ("build --set k", []),
        ("build scene.yaml --set k", ["kind=oak", "kind=steel"]),
        ("build loop.yaml --set ", ["a=1"]),
        ("build bad.yaml --set ", []),
        ("inspect scene.yaml --entity ", ["cube", "desk/table", "link"]),
        ("render scene.yaml --camera ", ["top", "front", "wrist"]),
        ("prefabs table_w", ["table_workspace"]),
        ("prefabs scenecc:table_w", ["scenecc:table_workspace"]),
        ("init --template k", ["kitchen"]),
        ("render --preset s", ["studio"]),
        ("emit --to u", ["urdf", "usd"]),
        ("check --format s", ["sarif"]),
        ("build --limit dep", ["depth=100"]),
        ("import --allow tend", ["tendons"]),
        ("sweep --do s", ["state"]),
        ("init --robot ", ["arm", "panda", "quadruped"]),
        ("explain SC10", [code for code in sorted(CODES) if code.startswith("SC10")]),
        ("check --ignore SC101,SC85", [f"SC101,{code}" for code in sorted(CODES) if code.startswith("SC85")]),
    ],
)
def test_bash_completes_commands_and_options(line: str, found: list[str], run, folder: Path) -> None:
    words = f"scenecc {line}"
    done = run(_SCENECC_COMPLETE="complete_bash", COMP_WORDS=words, COMP_CWORD=str(words.count(" ")))
    assert (done.returncode, done.stderr) == (0, "")
    assert sorted(done.stdout.split()) == sorted(found)


def test_zsh_shows_the_titles_of_codes(run) -> None:
    done = run(_SCENECC_COMPLETE="complete_zsh", _TYPER_COMPLETE_ARGS="scenecc explain SC101")
    assert f'"SC101":"{CODES["SC101"].title}"' in done.stdout


def test_every_command_is_completed(run) -> None:
    done = run(_SCENECC_COMPLETE="complete_bash", COMP_WORDS="scenecc ", COMP_CWORD="1")
    assert set(done.stdout.split()) == set(COMMANDS)


def test_completion_loads_neither_models_nor_an_engine(folder: Path) -> None:
    code = (
        "import sys\nfrom scenecc.cli.app import application\n"
        "try: application()(prog_name='scenecc')\nexcept SystemExit: pass\n"
        "print(sorted({'scenecc.spec', 'numpy', 'sapien', 'trimesh', 'rich'} & set(sys.modules)))"
    )
    line = {"_SCENECC_COMPLETE": "complete_bash", "COMP_WORDS": "scenecc build scene.yaml --set s", "COMP_CWORD": "4"}
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env={**os.environ, **line},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert done.stdout.split("\n")[:2] == ["size=0.5", "[]"], done.stderr


def test_text_that_a_shell_would_execute_is_not_offered(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    for name in ("a$(id).yaml", "b;id.yaml", "c d.yaml", "e`id`.yaml", "f\nid.yaml", "g\\$(id).yaml", "h'.yaml"):
        (folder / name).touch()
    (folder / "größe.yaml").touch()
    (folder / os.fsdecode(b"i\xff.yaml")).touch()
    (folder / "$(id)").mkdir()
    (folder / "x.yaml").write_text(
        'scenecc: 1\nparams: {$(id): 1}\nentities: {"`id`": {}, cube: {}, use: {use: "a\\0.yaml"}, n: {use: 1}}\n'
    )
    monkeypatch.chdir(folder)
    plain = ["arm.yaml", "bad.yaml", "größe.yaml", "loop.yaml", "parts/", "scene.yaml", "x.yaml"]
    assert completion.complete_scene("") == plain
    monkeypatch.setenv("COMP_WORDS", "scenecc inspect x.yaml")
    assert (completion.complete_entity(), completion.complete_setting()) == (["cube"], [])


def test_long_names_and_circular_links_give_no_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / ("x" * 250)).symlink_to(".")
    monkeypatch.chdir(tmp_path)
    assert all(len(found) > 4000 for found in completion.complete_scene("i"))
    monkeypatch.setenv("COMP_WORDS", f"scenecc build {'x' * 300}.yaml")
    assert completion.complete_entity() == []


def test_completion_stops_for_scenes_with_a_million_uses(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    uses = "".join(f"  u{number}: {{use: many.yaml}}\n" for number in range(1000))
    (tmp_path / "many.yaml").write_text(f"scenecc: 1\nentities:\n  cube: {{}}\n{uses}")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COMP_WORDS", "scenecc inspect many.yaml")
    assert "u0/u0/cube" in completion.complete_entity()
