"""What is selected on a page: its outline, hidden and locked bodies, and moves that are written into the file."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra `view`")

import viser
from plugins.shown import Shown

import scenecc

SCENE = """\
scenecc: 1
params: {height: 1}
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  box: {pose: [1, 0, 0.5], shapes: [{type: box, half_size: [0.1, 0.2, 0.5]}]}  # the box
  tall: {pose: [2, 0, "${height}"], shapes: [{type: box, half_size: [0.1, 0.2, 0.5]}]}
  arm:
    pose: [0, 3, 0.1]
    root:
      name: base
      shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
      children:
        - {name: tip, joint: {type: revolute, origin: [0, 0, 1]}, shapes: [{type: sphere, radius: 0.1}]}
"""
BOX, TALL, TIP = (0, "box", 0), (0, "tall", 0), (0, "arm", 1)
UNTURNED = (1.0, 0.0, 0.0, 0.0)


@pytest.fixture
def scene_text() -> str:
    return SCENE


def place(handle: Any) -> tuple[float, ...]:
    return tuple(handle.position.tolist())


def test_the_selected_body_is_outlined_and_marked_in_the_tree(shown: Shown) -> None:
    shown.session.select(BOX)
    outline = shown.node("/selected")
    assert place(outline) == pytest.approx((1, 0, 0.5))
    assert outline.points.reshape(-1, 3).max(axis=0) == pytest.approx((0.1, 0.2, 0.5))
    assert len(outline.points) == 12
    tree = shown.session._panel.tree
    assert [key for key, button in tree._rows.items() if button.color == "orange"] == [BOX]
    shown.session.step(1)
    assert place(shown.node("/selected"))[2] == pytest.approx(shown.node("/scene 0/box").position[2])
    shown.session.select((0, "ground", 0))
    assert shown.node("/selected") is None, "what has no end has no box"


def test_a_hidden_body_leaves_the_view_but_not_the_tree(shown: Shown) -> None:
    shown.session.select(BOX)
    shown.session.hide(hidden=True)
    assert shown.node("/scene 0/box") is None
    assert shown.node("/selected") is None
    assert BOX in shown.session._panel.tree._rows
    # Other ways to look at it, and a save, leave it hidden.
    shown.session.look_at(scenecc.ViewOptions(names=True))
    assert shown.node("/scene 0/box/visual 0") is None
    shown.path.write_text(SCENE + "# saved\n")
    shown.session.reload()
    assert shown.node("/scene 0/box/visual 0") is None
    assert shown.node("/scene 0/tall/visual 0") is not None
    shown.session.show_all()
    assert shown.node("/scene 0/box/visual 0") is not None


def test_a_locked_body_ignores_clicks_and_moves(shown: Shown) -> None:
    shown.session.select(BOX)
    shown.session.move(on=True)
    assert shown.node("/gizmo") is not None
    shown.session.lock(locked=True)
    assert shown.node("/gizmo") is None
    shown.session.move(on=True)
    assert shown.node("/gizmo") is None
    shown.session.pick(TALL)
    shown.session.pick(BOX)
    assert shown.session._selected == TALL
    shown.session.select(BOX)
    assert shown.session._selected == BOX, "the tree selects what is locked"


def test_a_drag_is_written_to_the_file_and_can_be_undone(shown: Shown) -> None:
    shown.session.select(BOX)
    shown.session.move(on=True)
    assert place(shown.node("/gizmo")) == pytest.approx((1, 0, 0.5))
    shown.session.drag(BOX, (1.25, 0.5, 0.5, *UNTURNED))
    assert place(shown.node("/scene 0/box")) == pytest.approx((1.25, 0.5, 0.5))
    assert shown.path.read_text() == SCENE, "it is not let go yet"
    shown.session.drop(BOX, (1.25, 0.5, 0.5, *UNTURNED))
    assert shown.path.read_text() == SCENE.replace("[1, 0, 0.5]", "[1.25, 0.5, 0.5]")
    shown.session.reload()
    assert place(shown.node("/scene 0/box")) == pytest.approx((1.25, 0.5, 0.5))
    assert place(shown.node("/gizmo")) == pytest.approx((1.25, 0.5, 0.5))
    shown.session.undo()
    assert shown.path.read_bytes() == SCENE.encode()
    shown.session.reload()
    assert place(shown.node("/scene 0/box")) == pytest.approx((1, 0, 0.5))


def test_a_pose_from_an_expression_has_no_gizmo_but_a_reason(shown: Shown) -> None:
    shown.session.select(TALL)
    shown.session.move(on=True)
    assert shown.node("/gizmo") is None
    assert "`pose` is an expression or a form" in shown.texts()
    shown.session.drop(TALL, (9.0, 9.0, 9.0, *UNTURNED))
    assert shown.path.read_text() == SCENE


def test_a_refused_drop_puts_the_body_back(shown: Shown) -> None:
    shown.session.select(BOX)
    shown.session.move(on=True)
    shown.session.drag(BOX, (5.0, 0.5, 0.5, *UNTURNED))
    shown.path.write_text(SCENE + "# saved meanwhile\n")
    shown.session.drop(BOX, (5.0, 0.5, 0.5, *UNTURNED))
    assert place(shown.node("/scene 0/box")) == pytest.approx((1, 0, 0.5))
    assert "the file has changed since it was loaded" in shown.texts()
    assert shown.path.read_text() == SCENE + "# saved meanwhile\n"


def test_dragging_a_removed_body_does_nothing(shown: Shown) -> None:
    shown.session.select(BOX)
    shown.session.move(on=True)
    for gone in ((0, "no", 0), (9, "box", 0)):
        shown.session.drag(gone, (5.0, 0.5, 0.5, *UNTURNED))
        shown.session.drop(gone, (5.0, 0.5, 0.5, *UNTURNED))
    assert shown.path.read_text() == SCENE


def test_dragging_a_link_moves_the_root_of_its_robot(shown: Shown) -> None:
    shown.session.select(TIP)
    shown.session.move(on=True)
    assert place(shown.node("/gizmo")) == pytest.approx((0, 3, 0.1))
    before = shown.node("/scene 0/arm/tip").position.copy()
    shown.session.drag((0, "arm", 0), (1.0, 3.0, 0.1, *UNTURNED))
    assert shown.node("/scene 0/arm/tip").position - before == pytest.approx(np.array([1, 0, 0]))
    shown.session.drop((0, "arm", 0), (1.0, 3.0, 0.1, *UNTURNED))
    assert shown.path.read_text() == SCENE.replace("[0, 3, 0.1]", "[1, 3, 0.1]")


def test_starting_the_simulation_ends_a_move(shown: Shown) -> None:
    shown.session.select(BOX)
    shown.session.move(on=True)
    shown.session.step(1)
    assert shown.node("/gizmo") is None
    shown.session.move(on=True)
    assert shown.node("/gizmo") is None
    assert "press Reset first" in shown.texts()
    shown.session.reset(0)
    shown.session.move(on=True)
    assert shown.node("/gizmo") is not None


def test_a_joint_slider_does_not_change_the_file(shown: Shown) -> None:
    shown.session.select(TIP)
    (slider,) = shown.session._panel.selected._joints
    assert (slider.label, slider.min, slider.max) == ("joint 0", pytest.approx(-np.pi), pytest.approx(np.pi))
    before = shown.node("/scene 0/arm/tip").wxyz.copy()
    for sent in (np.nan, 1.0):
        shown.session.set_joint(0, sent)
    shown.session.set_joint(7, 1.0)
    # By 1 rad about x, which is the axis of a joint without one.
    assert 2 * np.arccos(abs(before @ shown.node("/scene 0/arm/tip").wxyz)) == pytest.approx(1, abs=1e-3)
    assert slider.value == pytest.approx(1, abs=1e-3)
    assert shown.path.read_text() == SCENE
    shown.session.select(BOX)
    assert shown.session._panel.selected._joints == []
    shown.session.set_joint(0, 1.0)


def test_contacts_are_shown_as_force_arrows(shown: Shown) -> None:
    shown.session.look_at(scenecc.ViewOptions(contacts=True))
    assert shown.node("/contacts") is None
    shown.session.step(20)
    arrows = shown.node("/contacts").points
    assert (arrows[:, 1, 2] > arrows[:, 0, 2]).all(), "the ground pushes up"
    assert np.linalg.norm(arrows[:, 1] - arrows[:, 0], axis=1).max() == pytest.approx(0.3 * shown.session._page._radius)
    shown.session.look_at(scenecc.ViewOptions())
    assert shown.node("/contacts") is None


def test_the_check_button_outlines_overlaps_and_links_to_lines(shown: Shown) -> None:
    shown.session.check()
    assert "No findings." in shown.texts()
    shown.path.write_text(SCENE.replace("pose: [1, 0, 0.5]", "pose: [1, 0, 0.45]"))
    shown.session.reload()
    shown.session.check()
    assert "SC850" in shown.texts()
    line = SCENE.splitlines().index(next(one for one in SCENE.splitlines() if one.startswith("  box:"))) + 1
    assert f'href="vscode://file{shown.path}:{line}:3"' in shown.texts()
    assert place(shown.node("/overlap 0")) == pytest.approx((1, 0, 0.45))
    shown.path.write_text(SCENE)
    shown.session.reload()
    assert shown.node("/overlap 0") is None
    assert "SC850" not in shown.texts()


class Browser:
    """Takes pictures and videos, and keeps what it is given."""

    def __init__(self) -> None:
        self.camera = self
        self.image_height, self.image_width = 48, 65
        self.taken, self.files = 0, dict[str, bytes]()

    def get_render(self, height: int, width: int, **_: object) -> Any:
        self.taken += 1
        return np.full((height, width, 3), self.taken, np.uint8)

    def send_file_download(self, name: str, content: bytes, *, save_immediately: bool) -> None:
        assert save_immediately
        self.files[name] = content


def test_a_recording_plays_at_the_speed_of_the_simulation(shown: Shown) -> None:
    pytest.importorskip("imageio_ffmpeg", reason="needs the extra `pictures`")
    browser: Any = Browser()
    shown.session.record(browser, 0.5)
    assert browser.files["scene.mp4"][4:8] == b"ftyp"
    assert browser.taken == 15
    assert "50 steps" in shown.texts()
    shown.session._panel.stop.set()
    shown.session.record(browser, 0.1)
    assert browser.taken == 18, "a stop before it begins stops nothing"


def test_a_disconnected_browser_ends_the_recording(shown: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(self: Browser, *_: object, **__: object) -> Any:
        raise RuntimeError("the client disconnected")

    monkeypatch.setattr(Browser, "get_render", gone)
    browser: Any = Browser()
    shown.session._try(lambda: shown.session.record(browser, 0.5))
    assert "the client disconnected" in shown.texts()
    assert shown.session._panel._record.label == "Record"


@pytest.mark.parametrize(
    "pose", [(np.nan, 0, 0, *UNTURNED), (0, 0, np.inf, *UNTURNED), (1e9, 0, 0, *UNTURNED), (0, 0, 0, 0, 0, 0, 0)]
)
def test_invalid_poses_from_a_browser_are_ignored(shown: Shown, pose: tuple[float, ...]) -> None:
    shown.session.select(BOX)
    shown.session.move(on=True)
    gizmo = shown.node("/gizmo")
    gizmo._impl.position, gizmo._impl.wxyz = np.array(pose[:3]), np.array(pose[3:])
    (update,) = gizmo._impl_aux.update_cb
    coroutine = update(viser.TransformControlsEvent(None, None, gizmo, "end"))
    with pytest.raises(StopIteration):
        coroutine.send(None)
    assert shown.session._mail.take(0) is None


MANY = """\
scenecc: 1
entities:
  ball: {repeat: {i: {count: 40}}, pose: ["${i}", 0, 0.5], shapes: [{type: sphere, radius: 0.1}]}
  odd: {pose: [0, 5, 0.5], shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
"""


def test_many_copies_are_one_node_with_one_message_per_move(
    shown: Shown, server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown.path.write_text(MANY)
    shown.session.reload()
    nodes = set(server.scene._handle_from_node_name)
    (copies,) = [name for name in nodes if name.startswith("/copies/")]
    assert {"/scene 0/odd/visual 0", "/scene 0"} <= nodes
    assert not any(name.startswith("/scene 0/ball") for name in nodes)
    handle = shown.node(copies)
    assert handle.batched_positions[:, 0] == pytest.approx(np.arange(40))
    sent: list[Any] = []
    queue = type(server.scene)._queue_scene_message
    monkeypatch.setattr(
        type(server.scene), "_queue_scene_message", lambda scene, it: (sent.append(it), queue(scene, it))
    )
    shown.session.step(30)
    assert handle.batched_positions[:, 2].max() < 0.1
    told = [one for one in sent if getattr(one, "name", "") == copies]
    # Their places; they do not turn.
    assert [one.updates.keys() for one in told] == [{"batched_positions"}]


def test_a_click_on_a_copy_selects_its_body(shown: Shown, server: viser.ViserServer) -> None:
    shown.path.write_text(MANY)
    shown.session.reload()
    (copies,) = [name for name in server.scene._handle_from_node_name if name.startswith("/copies/")]
    clicked: list[Any] = []
    shown.session._page._clicked = clicked.append
    for number in (7, None, -1, 40, 10**9):
        shown.session._page._click_instance(copies, number)
    assert clicked == [(0, "ball_7", 0)]
    shown.session.pick(clicked[0])
    assert place(shown.node("/selected")) == pytest.approx((7, 0, 0.5))


def test_a_hidden_copy_is_removed_from_the_node(shown: Shown, server: viser.ViserServer) -> None:
    shown.path.write_text(MANY)
    shown.session.reload()
    shown.session.select((0, "ball_3", 0))
    shown.session.hide(hidden=True)
    (copies,) = [name for name in server.scene._handle_from_node_name if name.startswith("/copies/")]
    assert 3 not in shown.node(copies).batched_positions[:, 0].round()
    assert len(shown.node(copies).batched_positions) == 39


COLORED = """\
scenecc: 1
entities:
  box:
    repeat: {i: {count: 120}}
    pose: ["${i}", 0, 0.5]
    color: ["${i / 119}", 0, 1]
    shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
  glowing:
    pose: [0, 9, 0.5]
    shapes: [{type: box, half_size: [0.1, 0.1, 0.1], material: {visual: {emission: [1, 0, 0]}}}]
"""


def test_copies_of_many_colours_are_one_node_too(shown: Shown, server: viser.ViserServer) -> None:
    shown.path.write_text(COLORED)
    shown.session.reload()
    paths = set(server.scene._handle_from_node_name)
    (copies,) = [path for path in paths if path.startswith("/copies/")]
    assert {path for path in paths if path.endswith("visual 0")} == {"/scene 0/glowing/visual 0"}
    handle = shown.node(copies)
    assert handle.batched_colors[[0, 119]].tolist() == [[0, 0, 255], [255, 0, 255]]
    assert handle.batched_colors[60, 0] == round(255 * 60 / 119), "linear, as in the file"
    clicked: list[Any] = []
    shown.session._page._clicked = clicked.append
    shown.session._page._click_instance(copies, 7)
    assert clicked == [(0, "box_7", 0)]
    shown.path.write_text(COLORED.replace("0, 1]\n", "1, 1]\n"))
    shown.session.reload()
    assert shown.node(copies) is handle
    assert handle.batched_colors[0].tolist() == [0, 255, 255]
    # Half transparent, over what is inside.
    shown.session.look_at(scenecc.ViewOptions(contacts=True))
    (copies,) = [path for path in server.scene._handle_from_node_name if path.startswith("/copies/")]
    assert shown.node(copies).opacity == 0.5
