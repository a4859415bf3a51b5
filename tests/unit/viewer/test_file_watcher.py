"""Files that are watched.

Surfaces as files: what viser makes of them is what SAPIEN draws.
"""

from __future__ import annotations

import io
import queue
import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from scenecc.meshes import MeshPart, SurfaceMaterial, primitives
from scenecc.viewer.surfaces import SurfaceFiles
from scenecc.viewer.tasks import FileWatcher

pytest.importorskip("watchfiles", reason="needs the extra `view`")


class Looker:
    """A watch without its thread, whose looks are asked for: whether one finds a change."""

    def __init__(self) -> None:
        self._changes = 0
        self.watch = FileWatcher(self._count)

    def _count(self) -> None:
        self._changes += 1

    def finds_a_change(self) -> bool:
        before = self._changes
        self.watch._look()
        assert self._changes - before in {0, 1}
        return self._changes > before


@pytest.fixture
def looker(monkeypatch: pytest.MonkeyPatch) -> Looker:
    monkeypatch.setattr(FileWatcher, "_run", lambda *_: None)
    return Looker()


def test_a_file_change_is_reported_once(looker: Looker, tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text("a")
    looker.watch.see([file])
    file.write_text("bc")
    assert looker.finds_a_change()
    assert not looker.finds_a_change()


def test_replaced_and_removed_files_are_reported(looker: Looker, tmp_path: Path) -> None:
    file, other = tmp_path / "scene.yaml", tmp_path / "part"
    file.write_text("a")
    looker.watch.see([file])
    other.write_text("b")
    other.replace(file)
    assert looker.finds_a_change()
    file.unlink()
    assert looker.finds_a_change()


def test_a_new_file_in_a_new_folder_is_reported(looker: Looker, tmp_path: Path) -> None:
    file = tmp_path / "parts" / "deep" / "mesh.obj"
    looker.watch.see([file])
    assert not looker.finds_a_change()
    file.parent.mkdir(parents=True)
    file.write_text("v")
    assert looker.finds_a_change()


def test_changes_of_other_files_are_ignored(looker: Looker, tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text("a")
    looker.watch.see([file])
    (tmp_path / "other.yaml").write_text("b")
    assert not looker.finds_a_change()


def test_the_watched_files_can_be_replaced(looker: Looker, tmp_path: Path) -> None:
    before, after = tmp_path / "a" / "scene.yaml", tmp_path / "b" / "scene.yaml"
    for file in (before, after):
        file.parent.mkdir()
        file.write_text("a")
    looker.watch.see([before])
    looker.watch.see([after])
    before.write_text("bc")
    assert not looker.finds_a_change()
    after.write_text("bc")
    assert looker.finds_a_change()


def test_a_change_since_a_given_time_is_reported(looker: Looker, tmp_path: Path) -> None:
    old, new = tmp_path / "old.yaml", tmp_path / "new.yaml"
    for file in (old, new):
        file.write_text("a")
    changed, second = new.stat().st_ctime_ns, 10**9
    looker.watch.see([old], changed + second)
    assert not looker.finds_a_change()
    # The new one was read before it changed, by a scene that was compiled and that uses it.
    looker.watch.see([old, new], changed)
    assert looker.finds_a_change()
    assert not looker.finds_a_change()


def test_a_change_between_two_calls_is_reported(looker: Looker, tmp_path: Path) -> None:
    file, other = tmp_path / "scene.yaml", tmp_path / "other" / "mesh.obj"
    file.write_text("a")
    looker.watch.see([file])
    # A scene is compiled meanwhile, and is found to use another file.
    file.write_text("bc")
    looker.watch.see([file, other])
    assert looker.finds_a_change()


class Told:
    """A watch with its thread, which tells of changes."""

    def __init__(self) -> None:
        self._changes: queue.Queue[None] = queue.Queue()
        self.watch = FileWatcher(lambda: self._changes.put(None))

    def tells(self) -> bool:
        """Whether it has told of a change that was not asked about."""
        with suppress(queue.Empty):
            return self._changes.get(timeout=0.1) is None
        return False


@pytest.fixture
def told() -> Iterator[Told]:
    made = Told()
    yield made
    made.watch.close()


def test_notifications_of_the_system_are_used(told: Told, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.viewer.tasks._ASK", 10_000_000)  # nobody asks: the next time is hours away
    file = tmp_path / "scene.yaml"
    file.write_text("a")
    told.watch.see([file])
    # The thread may not have told the system yet what to watch.
    text = "b"
    while not told.tells():
        file.write_text(text := text + "c")
    assert len(text) < 1000


def test_a_recreated_folder_is_watched_again(told: Told, tmp_path: Path) -> None:
    file = tmp_path / "folder" / "scene.yaml"
    file.parent.mkdir()
    file.write_text("a")
    told.watch.see([file])
    shutil.rmtree(file.parent)
    while not told.tells():
        assert not file.exists()
    file.parent.mkdir()
    file.write_text("bc")
    while not told.tells():
        assert file.exists()


def test_files_are_polled_without_notifications(told: Told, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*folders: object, **options: object) -> None:
        raise OSError("OS file watch limit reached")

    monkeypatch.setattr("scenecc.viewer.tasks.watch", refused)
    file = tmp_path / "scene.yaml"
    file.write_text("a")
    told.watch.see([file])
    file.write_text("bc")
    while not told.tells():
        assert file.read_text() == "bc"


def mesh_of(part: MeshPart) -> Any:
    files = SurfaceFiles()
    files.write(name := files.name(part, turned=False))
    content = files.contents[name]
    scene: Any = trimesh.load_scene(io.BytesIO(content), file_type="glb", process=False)
    assert b"NORMAL" not in content, "viser would write over what shares its numbers"
    (mesh,) = scene.geometry.values()
    return mesh


@pytest.mark.parametrize("name", ["box", "sphere", "cylinder", "plane"])
def test_a_primitive_keeps_its_vertices(name: str) -> None:
    surface = getattr(primitives, name)()
    mesh = mesh_of(MeshPart(surface, SurfaceMaterial()))
    assert np.array_equal(mesh.vertices, surface.vertices)
    assert np.array_equal(mesh.faces, surface.faces)


def test_flat_triangles_share_no_vertex() -> None:
    ball = primitives.sphere()
    surface = primitives.make_surface(ball.vertices, ball.faces, None, ball.uvs)
    mesh = mesh_of(MeshPart(surface, SurfaceMaterial()))
    assert len(mesh.vertices) == 3 * len(ball.faces)
    assert np.array_equal(mesh.triangles, ball.vertices[ball.faces])
