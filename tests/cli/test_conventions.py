"""What holds for every command: its help, the names of its options, and one meaning of `--format`."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from cli.running import CUBE
from plugins.cli_page import commands

BAD = CUBE.replace("half_size", "half_sizes")
HELP = {name: command.get_help(command.context_class(command, info_name=name)) for name, command in commands().items()}
OPTIONS = {
    name: {option: param for param in command.params for option in param.opts} for name, command in commands().items()
}
IN_ALL = ("-h", "-q", "--quiet")

ASKED: dict[str, tuple[str, ...]] = {
    "build": ("build", "SCENE", "--dry-run"),
    "validate": ("validate", "SCENE"),
    "check": ("check", "SCENE", "--settle", "0"),
    "settle": ("settle", "SCENE", "--seconds", "0.1", "-o", "starts.json"),
    "inspect": ("inspect", "SCENE", "--no-build"),
    "describe": ("describe", "SCENE"),
    "patch": ("patch", "SCENE", "[]"),
    "draws": ("draws", "SCENE"),
    "emit": ("emit", "SCENE", "-o", "out.py"),
    "import": ("import", "SOURCE", "-o", "made.yaml"),
    "diff": ("diff", "SCENE", "SCENE"),
    "pack": ("pack", "SCENE", "-o", "out.scn"),
    "params": ("params", "SCENE"),
    "replay": ("replay", "SCENE"),
    "render": ("render", "SCENE", "-o", "out.png"),
    "sweep": ("sweep", "SCENE", "-o", "swept", "--do", "state"),
    "prefabs": ("prefabs", "NAME"),
    "explain": ("explain", "CODE"),
}
"""A call of each command with `--format`, but `doctor` and `decompile`, which take no file."""

GOOD = {"SCENE": "cube.yaml", "SOURCE": "robot.urdf", "NAME": "table", "CODE": "SC101"}
WRONG = {"SCENE": "bad.yaml", "SOURCE": "cube.yaml", "NAME": "tabel", "CODE": "SC999"}
RESULTS = {
    "build": "objects",
    "inspect": "entities",
    "describe": "objects",
    "patch": "written",
    "draws": "draws",
    "emit": "files",
    "import": "files",
    "diff": "differences",
    "params": "parameters",
    "prefabs": "prefabs",
    "explain": "codes",
    "settle": "kept",
    "pack": "files",
}


@pytest.mark.parametrize("name", HELP)
def test_the_help_of_a_command_is_readable(name: str) -> None:
    usage, *lines = HELP[name].splitlines()
    assert re.fullmatch(rf"Usage: {name} \[OPTIONS\]( [A-Z]+(\.\.\.)?| \[[A-Z]+\])*", usage)
    assert max(map(len, lines)) <= 80
    assert "Examples:" in HELP[name]
    assert "default: (" not in HELP[name]
    assert OPTIONS[name].keys() >= {"-q", "--quiet"}


def test_options_have_one_name_in_all_commands() -> None:
    names = {option for options in OPTIONS.values() for option in options}
    assert names.isdisjoint({"--scenes", "--num-envs", "--export", "--video", "--backend", "--out"})
    for short, long in {"-o": "--output", "-n": "--num-scenes", "-j": "--jobs"}.items():
        assert all((short in options) == (long in options) for options in OPTIONS.values())
    formats = {name for name, options in OPTIONS.items() if "--format" in options}
    assert formats >= {*ASKED, "doctor", "decompile"}


@pytest.mark.parametrize(
    ("asked", "nearest"),
    [
        (("build", "cub.yaml"), "cube.yaml"),
        (("build", "cube.yaml", "--format", "jsn"), "json"),
        (("check", "cube.yaml", "--ignore", "SC85x"), "SC85"),
        (("render", "cube.yaml", "-o", "x.png", "--what", "dept"), "depth"),
        (("sweep", "cube.yaml", "-o", "x", "--do", "state,chek"), "check"),
        (("import", "x.urdf", "-o", "x.yaml", "--allow", "tendon"), "tendons"),
        (("build", "cube.yaml", "--limit", "dept=3"), "depth"),
    ],
)
def test_a_wrong_value_is_reported_with_the_nearest_one(
    asked: tuple[str, ...], nearest: str, run: Any, cube: Path
) -> None:
    done = run(*asked)
    assert done.returncode == 2
    assert re.search(rf"did you mean ['`]?{re.escape(nearest)}", done.stderr)
    assert "Value error" not in done.stderr


@pytest.mark.parametrize("name", ASKED)
def test_json_is_one_document_after_an_error_too(name: str, run: Any, tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text(BAD)
    done = run(*(WRONG.get(word, word) for word in ASKED[name]), "--format", "json")
    assert done.returncode in {1, 2}
    assert done.stderr == ""
    assert "error" in {one["severity"] for one in json.loads(done.stdout)["diagnostics"]}


@pytest.mark.parametrize("name", RESULTS)
def test_json_has_the_result_and_its_diagnostics(name: str, run: Any, cube: Path, tmp_path: Path) -> None:
    cube.write_text(f"{CUBE}materials: {{unused: {{physical: {{density: 700}}}}}}\n")
    (tmp_path / "robot.urdf").write_text("<robot name='r'><link name='base'/></robot>")
    done = run(*(GOOD.get(word, word) for word in ASKED[name]), "--format", "json")
    found = json.loads(done.stdout)
    assert RESULTS[name] in found
    assert isinstance(found["diagnostics"], list)
