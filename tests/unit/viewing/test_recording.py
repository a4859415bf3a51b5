"""A page as a file."""

from __future__ import annotations

import base64
import re
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="needs the extra `view`")

import msgspec
import zstandard

import scenecc
from scenecc.viewing import Look, Place, export_page, view_scene

SCENE = """\
scenecc: 1
name: <b>balls</b>
num_scenes: 2
entities:
  ball: {pose: [0, 0, 1], shapes: [{type: sphere, radius: 0.1}]}
  still: {pose: [3, 0, 0], body_type: static, shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
"""


def recorded(page: str) -> tuple[float, list[tuple[float, dict[str, object]]]]:
    """How long a page plays [s], and its messages with their times."""
    found = re.search(r'__VISER_EMBED_DATA__="([^"]*)"', page)
    assert found
    data = zstandard.ZstdDecompressor().decompress(base64.b64decode(found[1])[8:])
    held = msgspec.msgpack.decode(data[8 : 8 + int.from_bytes(data[:8], "little")])
    return held["durationSeconds"], held["messages"]


def test_a_page_holds_a_scene(tmp_path: Path) -> None:
    path = tmp_path / "balls.yaml"
    path.write_text(SCENE)
    page = export_page(path)
    duration, messages = recorded(page)
    assert "<title>&lt;b&gt;balls&lt;/b&gt;</title>" in page
    assert duration == 0
    names = {message.get("name") for _, message in messages}
    assert {"/scene 0/ball/visual 0", "/scene 0/still/visual 0"} <= names
    assert not any(str(name).startswith("/scene 1") for name in names)


def test_it_plays_the_simulation_in_its_own_time(tmp_path: Path) -> None:
    path = tmp_path / "balls.yaml"
    path.write_text(SCENE)
    duration, messages = recorded(export_page(path, steps=50, look=Look(scene=1)))
    assert duration == pytest.approx(0.5)
    falls = [
        (time, message["position"])
        for time, message in messages
        if message.get("name") == "/scene 1/ball" and message["type"] == "SetPositionMessage"
    ]
    heights = [position[2] for _, position in falls]  # pyright: ignore[reportIndexIssue] - a list of numbers
    assert heights == sorted(heights, reverse=True)
    with scenecc.load_scene(path, scene_idxs=[1], render=False) as batch:
        batch.step(50)
        assert heights[-1] == float(batch.entities["ball"].pose[0, 2])
    moved = {message["name"] for time, message in messages if time > 0}
    assert moved == {"/scene 1/ball"}, "what stands still is not told again"


def test_a_scene_at_fault_gives_no_page(tmp_path: Path) -> None:
    path = tmp_path / "balls.yaml"
    path.write_text(SCENE.replace("sphere", "spere"))
    with pytest.raises(scenecc.SceneError) as caught:
        export_page(path)
    assert caught.value.at_fault == "scene"
    path.write_text(SCENE)
    with pytest.raises(scenecc.SceneError) as caught:
        export_page(path, look=Look(scene=2))
    assert caught.value.diagnostics[0].code == "SC908"
    with pytest.raises(ValueError, match="scene must be at least 0, not -1"):
        export_page(path, look=Look(scene=-1))
    for port in (-1, 65536):
        with pytest.raises(ValueError, match=f"a port is 0 to 65535, not {port}"):
            Place(port=port)
    with pytest.raises(ValueError, match="steps must be at least 0"):
        export_page(path, steps=-1)


def test_missing_packages_are_named_with_the_way_to_get_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.viewing.view.find_spec", lambda name: None)
    for call in (export_page, view_scene):
        with pytest.raises(scenecc.SceneError) as caught:
            call({"scenecc": 1})
        (told,) = caught.value.diagnostics
        assert told.file == "scenecc", "it is no fault of a scene's"
        assert (told.code, told.hint) == ("SC816", 'run `pip install "scenecc[view]"`')
        assert told.message == "a page needs viser and watchfiles, not installed here"
        assert caught.value.at_fault == "machine"


def test_a_simulation_that_diverges_gives_no_page(tmp_path: Path) -> None:
    path = tmp_path / "balls.yaml"
    path.write_text(f"physics: {{gravity: [0, 0, -1.0e+6], timestep: 1}}\n{SCENE}")
    export_page(path)
    with pytest.raises(scenecc.SceneError) as caught:
        export_page(path, steps=20)
    assert ([found.code for found in caught.value.diagnostics], caught.value.at_fault) == (["SC820"], "scene")
