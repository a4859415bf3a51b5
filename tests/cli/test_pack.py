"""`scenecc pack`, and every command on what it makes."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from cli.running import plain_environment
from PIL import Image
from plugins.command import scenecc

from scenecc.diagnostics.codes import CODES

SCENES = Path(__file__).parents[2] / "scenes"
LISTED = """\
d194e7c0ec46f80e4b344d10385d600dd4426db917cd3b800e73d5d6dd7b4d40  tray.yaml
c08c8259aa8171669323672cf7e8d437ab1ca2cd22c43bdd6b04c5e46c2073ee  assets/mug.obj
"""


@pytest.fixture(scope="module")
def made_pack(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The pack of a scene, made once."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "assets").mkdir()
    for name in ("tray.yaml", "assets/mug.obj"):
        shutil.copy(SCENES / name, folder / name)
    environment = plain_environment(XDG_CACHE_HOME=str(folder / "cache"))
    done = scenecc(["pack", "tray.yaml", "-o", "tray.scn"], cwd=folder, stdin=b"", env=environment)
    size = (folder / "tray.scn").stat().st_size
    assert (done.returncode, done.stdout) == (0, b"")
    assert done.stderr.decode().startswith(f"tray.scn: 2 files, {size} bytes\n")
    assert done.stderr.decode().endswith("0 errors, 1 warning\n")
    return folder / "tray.scn"


@pytest.fixture
def tray(made_pack: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A pack whose scene is not beside it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return Path(shutil.copy(made_pack, tmp_path))


def test_pack_list_prints_the_content(run, tray: Path) -> None:
    done = run("pack", "--list", tray)
    assert (done.returncode, done.stdout, done.stderr) == (0, LISTED, "")
    manifest = json.loads(run("pack", "--list", tray, "--format", "json").stdout)
    assert (manifest["scenecc_pack"], manifest["entry"]) == (1, "tray.yaml")
    assert {f"{digest}  {name}" for name, digest in manifest["files"].items()} == {*LISTED.splitlines()}


COMMANDS = {
    "validate": ["validate", "tray.scn"],
    "check": ["check", "--settle", "0.1", "tray.scn"],
    "build": ["build", "tray.scn", "--steps", "3"],
    "inspect": ["inspect", "tray.scn"],
    "params": ["params", "tray.scn"],
    "emit": ["emit", "tray.scn", "--to", "mjcf", "-o", "tray.xml"],
    "emit python": ["emit", "tray.scn", "--to", "python", "-o", "tray.py"],
    "plan": ["build", "tray.scn", "--dry-run", "-o", "plan.json"],
    "view": ["view", "tray.scn", "-o", "tray.html"],
    "fix": ["validate", "--fix", "tray.scn"],
    "sweep": ["sweep", "tray.scn", "--seeds", "0:3", "--do", "check,state", "--settle", "0.1", "-o", "swept"],
}


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_commands_accept_a_pack(command: list[str], run, tray: Path) -> None:
    before = tray.read_bytes()
    done = run(*command)
    assert done.returncode == 0, done.stderr
    assert tray.read_bytes() == before


@pytest.mark.render
def test_a_pack_renders_like_its_scene(run, tray: Path) -> None:
    for scene, picture in ((tray, "packed.png"), (SCENES / "tray.yaml", "scene.png")):
        assert run("render", scene, "-o", tray.parent / picture).returncode == 0
    packed, scene = (np.asarray(Image.open(tray.parent / name)) for name in ("packed.png", "scene.png"))
    assert (packed == scene).all()


def test_validate_finds_packs_in_a_folder(run, tray: Path) -> None:
    folder = tray.parent / "scenes"
    folder.mkdir()
    shutil.move(tray, folder / "tray.scn")
    (folder / "notes.scn").write_text("no scene\n")
    assert run("validate", folder).stderr == "1 file checked, 1 other file skipped\n"


def test_a_pack_equals_its_scene(run, tray: Path) -> None:
    assert run("diff", tray, SCENES / "tray.yaml", "--set", "gap=0.01").returncode == 0
    assert run("diff", tray, SCENES / "trays.yaml").returncode == 1


def test_findings_of_packs_are_cached_until_one_changes(run, tray: Path) -> None:
    text = "1 file checked\n"
    assert [run("validate", tray).stderr for _ in range(2)] == [text, text]
    tray.write_bytes(tray.read_bytes()[:-9])
    done = run("validate", tray)
    assert (done.returncode, "error SC019" in done.stdout) == (1, True)


def test_a_pack_can_be_written_to_standard_output(run, tray: Path, tmp_path: Path) -> None:
    shutil.copytree(SCENES / "parts", tmp_path / "parts")
    done = run("pack", "parts/chair.yaml", "-o", "-")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("PK")


WRONG = {
    "no output": ["pack", "a.yaml"],
    "both": ["pack", "--list", "a.scn", "-o", "b.scn"],
    "another name": ["pack", "tray.scn", "-o", "b.zip"],
    "standard input": ["pack", "-", "-o", "b.scn"],
    "nothing": ["pack", "none.yaml", "-o", "b.scn"],
    "nothing to add": ["pack", "tray.scn", "--add", "none", "-o", "b.scn"],
    "itself": ["pack", "tray.scn", "-o", "tray.scn"],
}


@pytest.mark.parametrize("command", WRONG.values(), ids=WRONG)
def test_wrong_usage_of_pack_is_reported(command: list[str], run, tray: Path) -> None:
    assert run(*command).returncode == 2


@pytest.mark.parametrize("code", ["SC019", "SC428", "SC429"])
def test_the_examples_of_pack_codes_give_their_codes(code: str, run, tmp_path: Path) -> None:
    command = ["bash", "-c", CODES[code].example.removeprefix("$ ")]
    done = subprocess.run(
        command, cwd=tmp_path, env=plain_environment(), capture_output=True, text=True, check=False, timeout=60
    )
    assert code in done.stdout + done.stderr
