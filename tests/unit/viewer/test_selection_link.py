"""What a page and an editor tell each other, without a browser: the editor's end is the test's."""

from __future__ import annotations

import os
import queue
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="needs the extra `view`")

import viser
from plugins.shown import Shown

from scenecc import ViewOptions
from scenecc.selection_link import Place, SelectionLink

BALL = "shapes: [{type: sphere, radius: 0.1}]"

DESK = f"""\
scenecc: 1
entities:
  top: {{pose: [0, 0, 0.5], {BALL}}}
  leg: {{repeat: {{i: {{count: 3}}}}, pose: [0, "${{1 + i}}", 0.5], {BALL}}}
"""
PART = f"""\
scenecc: 1
entities:
  lamp: {{pose: [3, 0, 0.5], {BALL}}}
"""
SCENE = f"""\
scenecc: 1
num_scenes: 2
include: [part.yaml]
entities:
  desk: {{use: desk.yaml, pose: [0, 0, 1]}}
  cube: {{pose: [5, 0, 0.5], {BALL}}}
"""


class Linked:
    """A page, and an editor beside it."""

    def __init__(self, server: viser.ViserServer, folder: Path) -> None:
        for name, text in {"scene.yaml": SCENE, "part.yaml": PART, "desk.yaml": DESK}.items():
            (folder / name).write_text(text)
        self.folder = folder
        self.session = Shown(server, folder / "scene.yaml").session
        self.session.start()
        self.session._link = self.link = SelectionLink("page", self.session._hear)
        self.heard: queue.Queue[list[Place]] = queue.Queue()
        self.editor = SelectionLink("editor", self.heard.put)

    def close(self) -> None:
        self.editor.close()
        self.link.close()
        self.session.close()

    def place(self, name: str, entity: str) -> Place:
        return Place(os.path.realpath(self.folder / name), ("entities", entity))

    def selects(self, place: Place) -> tuple[int, str, int] | None:
        """The body that is selected once the editor has said where its cursor is."""
        self.editor.send([place])
        task = self.session._mail.take(20)
        assert task is not None
        task()
        return self.session._selected


@pytest.fixture
def runtime(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    above = tmp_path_factory.mktemp("run")  # the path of a socket is short
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(above))
    return above


@pytest.fixture
def linked(server: viser.ViserServer, tmp_path: Path, runtime: Path) -> Iterator[Linked]:
    made = Linked(server, tmp_path)
    yield made
    made.close()


def test_the_entity_at_the_cursor_is_selected(linked: Linked) -> None:
    assert linked.selects(linked.place("scene.yaml", "cube")) == (0, "cube", 0)
    outline = linked.session._page._server.scene.get_handle_by_name("/selected")
    assert outline is not None
    assert tuple(outline.position) == pytest.approx((5, 0, 0.5))
    assert linked.selects(linked.place("part.yaml", "lamp")) == (0, "lamp", 0)
    assert linked.selects(linked.place("desk.yaml", "leg")) == (0, "desk/leg_0", 0)
    assert linked.selects(linked.place("scene.yaml", "desk")) == (0, "desk/leg_0", 0), "a part of it is selected"
    assert linked.selects(linked.place("scene.yaml", "cube")) == (0, "cube", 0)
    assert linked.selects(linked.place("scene.yaml", "desk")) == (0, "desk/top", 0)
    assert linked.heard.empty(), "what an editor has selected is not told to it"


def test_a_place_outside_the_scenes_files_changes_no_selection(linked: Linked) -> None:
    linked.selects(linked.place("scene.yaml", "cube"))
    for name, entity in (("scene.yaml", "cubes"), ("desk.yaml", "cube"), ("other.yaml", "cube")):
        assert linked.selects(linked.place(name, entity)) == (0, "cube", 0)
    assert linked.selects(Place("/\0", ("", -1))) == (0, "cube", 0)


def test_a_body_of_another_scene_or_copy_stays_selected(linked: Linked) -> None:
    linked.session.look_at(ViewOptions(grid=True))
    linked.session.select((1, "desk/leg_2", 0))
    assert linked.selects(linked.place("desk.yaml", "leg")) == (1, "desk/leg_2", 0)


def test_a_click_sends_the_place_of_the_entity_and_its_users(linked: Linked) -> None:
    linked.session.pick((0, "cube", 0))
    assert linked.heard.get(timeout=20) == [linked.place("scene.yaml", "cube")]
    linked.session.select((0, "desk/leg_1", 0))
    assert linked.heard.get(timeout=20) == [linked.place("desk.yaml", "leg"), linked.place("scene.yaml", "desk")]
    linked.session.select((0, "lamp", 0))
    assert linked.heard.get(timeout=20) == [linked.place("part.yaml", "lamp")]


def test_a_page_is_linked_as_long_as_it_is_served(server: viser.ViserServer, tmp_path: Path, runtime: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(PART)
    session = Shown(server, path).session

    class Interrupted(Exception):
        """As Ctrl-C is."""

    def interrupt() -> None:
        assert len([*(runtime / "scenecc").glob("page-*")]) == 1
        raise Interrupted

    with pytest.raises(Interrupted):
        session.serve(interrupt)
    session.close()
    assert [*(runtime / "scenecc").iterdir()] == []
