"""What happens on a page, without a browser: what a server shows is asked of the server."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser", reason="needs the extra `view`")

import viser
from plugins.shown import BALL, MORE, SCENE, Shown

import scenecc
from scenecc import ViewOptions
from scenecc.diagnostics import Diagnostic
from scenecc.diagnostics.diagnostic import Location
from scenecc.viewer.controls import AS_WRITTEN


def test_a_save_updates_only_what_has_changed(shown: Shown) -> None:
    ball = shown.node(f"{BALL}/visual 0")
    shown.path.write_text(SCENE + MORE)
    shown.session.reload()
    assert shown.node("/scene 0/more/visual 0") is not None
    assert shown.node(f"{BALL}/visual 0") is ball, "nothing of it changed"
    shown.path.write_text(SCENE)
    shown.session.reload()
    assert shown.node("/scene 0/more") is None
    assert shown.node("/scene 0/more/visual 0") is None
    assert shown.told == [[], [], []]


def test_an_error_is_shown_above_the_last_valid_scene(shown: Shown) -> None:
    shown.path.write_text(SCENE.replace("sphere", "spere") + MORE)
    shown.session.reload()
    assert "scene.yaml:6:" in shown.texts()
    assert "SC105" in shown.texts()
    assert shown.node(f"{BALL}/visual 0") is not None
    assert shown.node("/scene 0/more") is None
    # What is done with the last good scene hides no mistake.
    shown.session.step(3)
    shown.session.reset(5)
    shown.session.look_at(ViewOptions(scene=1))
    assert "SC105" in shown.texts()
    assert shown.node("/scene 1/ball") is not None
    shown.path.write_text(SCENE + MORE)
    shown.session.reload()
    assert "SC105" not in shown.texts()
    assert shown.node("/scene 1/more") is not None
    assert shown.told == [[], ["SC105"], []]


def test_a_file_with_errors_at_first_is_shown_once_fixed(server: viser.ViserServer, tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text("scenecc: [")
    shown = Shown(server, path)
    shown.session.start()
    for action in (shown.session.play, lambda: shown.session.step(1), lambda: shown.session.reset(0)):
        action()
    shown.session.look_at(ViewOptions(grid=True))
    shown.session.select((0, "ball", 0))
    assert "SC00" in shown.texts()
    path.write_text(SCENE)
    shown.session.reload()
    assert shown.node(BALL) is not None
    assert shown.node("/scene 1/ball") is not None
    shown.session.close()


def test_changing_a_parameter_rebuilds_the_scene(shown: Shown) -> None:
    assert shown.node(f"{BALL}/visual 0").scale == (0.1, 0.1, 0.1)
    shown.session.give("size", 0.3)
    assert shown.node(f"{BALL}/visual 0").scale == (0.3, 0.3, 0.3)
    # A save leaves what was given.
    shown.path.write_text(SCENE + MORE)
    shown.session.reload()
    assert shown.node(f"{BALL}/visual 0").scale == (0.3, 0.3, 0.3)
    # It no longer fits to what the file says: the file counts.
    shown.path.write_text(SCENE.replace("max: 0.5", "max: 0.2"))
    shown.session.reload()
    assert shown.node(f"{BALL}/visual 0").scale == (0.1, 0.1, 0.1)
    shown.session.give("size", 0.4)
    assert "must be at most 0.2, not 0.4" in shown.texts()
    shown.session.give("size", 0.2)
    assert shown.node(f"{BALL}/visual 0").scale == (0.2, 0.2, 0.2)
    shown.session.give("size", AS_WRITTEN)
    assert shown.node(f"{BALL}/visual 0").scale == (0.1, 0.1, 0.1)
    shown.session.give("size", 0.15)
    shown.session.give_nothing()
    assert shown.node(f"{BALL}/visual 0").scale == (0.1, 0.1, 0.1)


def test_as_in_the_file_drops_values_given_at_the_start(server: viser.ViserServer, tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    for give in (lambda it: it.give_nothing(), lambda it: it.give("size", AS_WRITTEN)):
        shown = Shown(server, path, params={"size": 0.4})
        shown.session.start()
        assert shown.node(f"{BALL}/visual 0").scale == (0.4, 0.4, 0.4)
        give(shown.session)
        assert shown.node(f"{BALL}/visual 0").scale == (0.1, 0.1, 0.1)
        shown.session.reload()
        assert shown.node(f"{BALL}/visual 0").scale == (0.1, 0.1, 0.1)
        shown.session.close()


def test_steps_and_resets_move_the_shown_bodies(shown: Shown) -> None:
    start = shown.node(BALL).position[2]
    shown.session.step(20)
    fallen = shown.node(BALL).position[2]
    assert fallen < start - 0.1
    assert "20 steps" in shown.texts()
    shown.session.reset(0)
    assert shown.node(BALL).position[2] == pytest.approx(start)
    assert "0 steps" in shown.texts()
    shown.session.reset(1)
    other = shown.node(BALL).position[2]
    assert other != pytest.approx(start)
    with scenecc.load_scene(str(shown.path), scene_idxs=[0], render=False) as batch:
        batch.reset(1)
        assert other == pytest.approx(float(batch.entities["ball"].pose[0, 2]), abs=0)


def test_view_options_do_not_change_the_simulation(shown: Shown) -> None:
    shown.session.step(20)
    place = shown.node(BALL).position.copy()
    shown.session.look_at(ViewOptions(frames=True, names=True, collision=True))
    assert shown.node(BALL).show_axes
    assert shown.node(f"{BALL}/name").text == "ball"
    assert shown.node(f"{BALL}/collision 0") is not None
    assert (shown.node(BALL).position == place).all()
    shown.session.look_at(ViewOptions(visual=False))
    # What shows nothing has no node.
    assert shown.node(BALL) is None
    assert shown.node(f"{BALL}/name") is None
    assert shown.node(f"{BALL}/visual 0") is None


def test_properties_of_a_body_are_updated_after_a_save(shown: Shown) -> None:
    shown.session.select((0, "ball", 0))
    assert "ball" in shown.texts()
    before = shown.texts()
    shown.path.write_text(SCENE.replace("ball: {", "ball: {mass: 12.5, "))
    shown.session.reload()
    assert "12.5 kg" in shown.texts()
    assert "12.5 kg" not in before


def test_a_removed_body_is_no_longer_selected(shown: Shown) -> None:
    shown.session.select((0, "ball", 0))
    shown.path.write_text(SCENE.replace("ball", "other"))
    shown.session.reload()
    assert "Click a body" in shown.texts()


def test_values_set_on_the_page_are_kept_if_the_file_accepts_them(shown: Shown) -> None:
    two = SCENE.replace("entities:", "  height: 1\nentities:").replace("{uniform: [1, 2]}", '"${height}"')
    shown.path.write_text(two)
    shown.session.reload()
    shown.session.give("size", 0.3)
    shown.session.give("height", 3)
    shown.path.write_text(two.replace("max: 0.5", "max: 0.2"))
    shown.session.reload()
    assert shown.node(f"{BALL}/visual 0").scale == (0.1, 0.1, 0.1)
    assert shown.node(BALL).position[2] == 3


def test_another_seed_rebuilds_everything(shown: Shown) -> None:
    start = shown.node(BALL).position[2]
    shown.session.rebuild(7)
    assert shown.node(BALL).position[2] != pytest.approx(start)
    with scenecc.load_scene(str(shown.path), seed=7, scene_idxs=[0], render=False) as batch:
        assert shown.node(BALL).position[2] == pytest.approx(float(batch.entities["ball"].pose[0, 2]), abs=0)


def test_a_failed_reset_is_reported_and_changes_nothing(server: viser.ViserServer, tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    text = SCENE.replace("{uniform: [1, 2]}", '"${1 / u}"').replace("num_scenes: 2", "num_scenes: 1")
    path.write_text(text.replace("entities:", "draws: {u: {integers: [0, 3]}}\nentities:"))
    shown = Shown(server, path)
    shown.session.start()
    for seed in range(40):
        if shown.session._world is None:
            shown.session.rebuild(seed)  # the file's own seed has no value either
        else:
            place = shown.node(BALL).position.copy()
            shown.session._try(lambda seed=seed: shown.session.reset(seed))
            if "SC817" in shown.texts():
                break
    assert "scene.yaml:1:" in shown.texts()
    assert "its pose has no value" in shown.texts()
    assert (shown.node(BALL).position == place).all()
    shown.session.close()


def test_a_seed_too_large_for_a_browser_is_kept(shown: Shown) -> None:
    large = 2**64 - 1
    shown.path.write_text(SCENE.replace("num_scenes: 2", f"num_scenes: 2\nseed: {large}"))
    shown.session.reload()
    panel = shown.session._panel
    assert panel._seed.value == 2**53 - 1
    assert panel._asked_seed() == large
    for sent, read in ((5, 5), (-3, 0), (0, 0)):
        panel._seed.value = sent
        assert panel._asked_seed() == read


def test_invalid_values_from_a_browser_are_handled(shown: Shown) -> None:
    panel = shown.session._panel
    slider, *_ = panel._made["scenes"]
    for sent, index in ((-7, 0), (10**9, 1), (1, 1)):
        slider.value = sent
        panel._look_at()
        assert shown.node(f"/scene {index}/ball") is not None


def test_changing_view_options_moves_no_body(shown: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    shown.session.step(20)
    sent: list[Any] = []
    queue = type(shown.server.scene)._queue_scene_message

    def note(scene: Any, message: Any) -> None:
        sent.append(message)
        queue(scene, message)

    monkeypatch.setattr(type(shown.server.scene), "_queue_scene_message", note)
    shown.session.look_at(ViewOptions(names=True))
    assert [one for one in sent if getattr(one, "name", "") == BALL] == []
    assert [type(one).__name__ for one in sent if getattr(one, "name", "") == f"{BALL}/name"]


@pytest.mark.parametrize("timestep", [0.01, 0.025, 0.1, 0.3])
def test_the_simulation_runs_in_real_time(
    server: viser.ViserServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, timestep: float
) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE.replace("entities:", f"physics: {{timestep: {timestep}}}\nentities:"))
    shown = Shown(server, path)
    shown.session.start()
    clock = [100.0]
    monkeypatch.setattr("scenecc.viewer.session.time.monotonic", lambda: clock[0])
    shown.session.play()
    for _ in range(300):
        clock[0] += 1 / 30
        shown.session._advance()
    world = shown.session._world
    assert world is not None
    assert world.time == pytest.approx(10, abs=timestep)
    shown.session.close()


def test_a_failed_build_is_tried_again(shown: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    class Broken:
        def __init__(self, *given: object) -> None:
            raise scenecc.SceneError([Diagnostic("SC808", "error", "no such thing", Location(None))])

    with monkeypatch.context() as patch:
        patch.setattr("scenecc.viewer.session.World", Broken)
        shown.session._try(lambda: shown.session.look_at(ViewOptions(scene=1)))
        assert "SC808" in shown.texts()
        assert shown.node(BALL) is not None
    shown.session.look_at(ViewOptions(scene=1, names=True))
    assert shown.node("/scene 1/ball/name") is not None
    assert "SC808" not in shown.texts()


def test_a_session_refuses_a_missing_scene_index(server: viser.ViserServer, tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    shown = Shown(server, path, ViewOptions(scene=2))
    with pytest.raises(scenecc.SceneError):
        shown.session.start()
    shown.session.close()


def test_a_session_runs_until_interrupted_and_follows_the_file(shown: Shown) -> None:
    class Interrupted(Exception):
        """As Ctrl-C does, in the thread that runs."""

    def interrupt() -> None:
        raise Interrupted

    ended: list[bool] = []

    def run() -> None:
        try:
            shown.session.run()
        except Interrupted:
            ended.append(True)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    mail = shown.session._mail
    mail.post("play", shown.session.play)
    soon(lambda: shown.node(BALL).position[2] < 0)
    mail.post("play", shown.session.play)
    shown.path.write_text(SCENE + MORE)
    soon(lambda: shown.node("/scene 0/more") is not None)
    mail.post("look", lambda: shown.session.look_at(replace(ViewOptions(), grid=True)))
    soon(lambda: shown.node("/scene 1/more") is not None)
    mail.post("interrupt", interrupt)
    thread.join(10)
    assert ended == [True]


def test_of_many_scenes_side_by_side_one_is_shown_first(
    server: viser.ViserServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("scenecc.viewer.session._MANY", 1)
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    shown, counted = Shown(server, path, ViewOptions(grid=True)), list[tuple[int, int, bool]]()
    progress = shown.session._progress
    progress._told = lambda done, total: counted.append((done, total, progress._bar.visible))
    shown.session.start()
    assert shown.node(BALL) is not None
    assert shown.node("/scene 1/ball") is None
    rest = shown.session._mail.take(0)
    assert rest is not None
    rest()
    assert shown.node("/scene 1/ball") is not None
    assert counted == [(1, 1, False), (1, 2, True), (2, 2, True)]
    assert not progress._bar.visible
    shown.session.close()


def soon(ask: Callable[[], bool], within: float = 20) -> None:
    end = time.monotonic() + within
    while not ask():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_the_seed_is_that_of_the_file_until_it_is_changed(shown: Shown) -> None:
    field = shown.session._panel._seed
    assert field.value == 0
    shown.path.write_text(SCENE.replace("num_scenes: 2", "num_scenes: 2\nseed: 12"))
    shown.session.reload()
    assert field.value == 12
    shown.session.rebuild(7)
    assert field.value == 7
    shown.session.reload()
    assert field.value == 7


def test_a_diverging_simulation_pauses_until_a_reset(shown: Shown) -> None:
    shown.path.write_text(SCENE.replace("entities:", "physics: {gravity: [0, 0, -1.0e+6], timestep: 1}\nentities:"))
    shown.session.reload()
    shown.session.play()
    for told in (False, True):
        shown.session._shown_at -= 60
        shown.session._try(shown.session._advance)
        assert ("SC820" in shown.texts()) == told
    assert not shown.session._playing
    shown.session._try(lambda: shown.session.step(20))
    assert "SC820" in shown.texts()
    assert shown.node(BALL).position[2] == pytest.approx(-1e6, abs=2), "it is shown where it last meant something"
    shown.session.reset(0)
    assert "SC820" not in shown.texts()
    shown.session.step(1)
    assert shown.node(BALL).position[2] == pytest.approx(-1e6, abs=2)
