from __future__ import annotations

import os
from pathlib import Path

import pytest

from scenecc.cli.paths import find_files

SCENE = "scenecc: 1\nentities: {}\n"
OTHER = "services:\n  scenecc: 1\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def put(name: str, text: str | bytes = SCENE) -> None:
    path = Path(name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text if isinstance(text, bytes) else text.encode())


def test_scenes_in_a_folder_are_found_and_sorted() -> None:
    for name in ("s/b.yml", "s/a.yaml", "s/deep/er/c.YAML", "s/notes.txt", "s/.hidden/d.yaml", "s/.e.yaml"):
        put(name)
    put("s/compose.yaml", OTHER)
    found = find_files(["s"])
    assert found.files == ["s/a.yaml", "s/b.yml", "s/deep/er/c.YAML"]
    assert found.skipped == ["s/compose.yaml"]


@pytest.mark.parametrize(
    "text",
    [
        "# first\n\nname: x\nscenecc: 1\n",
        '"scenecc": 1\n',
        "'scenecc' : 1\n",
        "{scenecc: 1, entities: {}}\n",
        "\ufeffscenecc: 1\n",
        "scenecc: 1\n".encode("utf-16"),
        "scenecc: 99\nentities: [broken\n",
        b"scenecc: 1\nname: \xff\xfe\n",
    ],
)
def test_a_broken_scene_is_recognised_by_its_key(text: str | bytes) -> None:
    put("s/x.yaml", text)
    assert find_files(["s"]).files == ["s/x.yaml"]


@pytest.mark.parametrize("text", ["", "a: 1\n", "  scenecc: 1\n", "scenecc_version: 1\n", "- scenecc: 1\n", OTHER])
def test_a_yaml_file_without_the_key_is_not_a_scene(text: str) -> None:
    put("s/x.yaml", text)
    found = find_files(["s"])
    assert (found.files, found.skipped, found.empty) == ([], ["s/x.yaml"], ["s"])


def test_a_named_file_is_checked_unless_scenes_only_is_given() -> None:
    put("compose.yaml", OTHER)
    put("scene.txt")
    assert find_files(["compose.yaml", "scene.txt"]).files == ["compose.yaml", "scene.txt"]
    found = find_files(["compose.yaml", "scene.txt"], scenes_only=True)
    assert (found.files, found.skipped) == (["scene.txt"], ["compose.yaml"])


def test_every_file_is_checked_once() -> None:
    put("s/a.yaml")
    found = find_files(["s/a.yaml", "s", "-", "gone.yaml", "s/a.yaml"])
    assert found.files == ["s/a.yaml", "-"]
    assert found.missing == ["gone.yaml"]


def test_dangling_and_circular_links_are_handled() -> None:
    put("s/a.yaml")
    Path("s/dangling.yaml").symlink_to("nowhere.yaml")
    Path("s/loop").symlink_to("..")
    os.mkfifo("s/pipe.yaml")
    assert find_files(["s"]).files == ["s/a.yaml"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_unreadable_files_and_folders_are_reported() -> None:
    put("s/a.yaml")
    put("s/locked/b.yaml")
    put("s/c.yaml")
    Path("s/locked").chmod(0)
    Path("s/c.yaml").chmod(0)
    assert sorted(path for path, _ in find_files(["s"]).unreadable) == ["s/c.yaml", "s/locked"]
    Path("s/locked").chmod(0o700)
